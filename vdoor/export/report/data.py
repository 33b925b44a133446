"""What the page of the report shows: facts, rooms, doors, layers, drives, the search, numbers and settings."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import asdict, fields
from typing import Any

import numpy as np

from vdoor.errors import printable
from vdoor.export.geometry import line_m
from vdoor.export.report.doors import Tip, door_tips, lives_of
from vdoor.export.report.drives import drives
from vdoor.export.report.layers import layers
from vdoor.export.report.left_out import left_out
from vdoor.export.report.sheet import Sheet, colour_text, polygon, polyline
from vdoor.grid import Annotations
from vdoor.history.provenance import Provenance, value_text
from vdoor.history.records import ConvergenceHistory
from vdoor.pipeline import Pipeline
from vdoor.record import SCALARS, specs
from vdoor.topology import TopologicalMap
from vdoor.viz.rerun import style

MARGIN = 0.02
"""Margin around the rooms, as a fraction of their longer side."""
MOST_POINTS = 1000
"""Maximum number of generations in the curve; those that improved the best cost are included if they fit."""


def page_data(
    topology: TopologicalMap, provenance: Provenance | None = None, annotations: Annotations | None = None
) -> dict[str, Any]:
    """Data of the page, by name."""
    sheet, frame = Sheet(topology.frame), topology.frame
    (x_m, y_m), (to_right_x_m, to_right_y_m), (down_x_m, down_y_m) = frame.world_from_cell(
        np.array([(-0.5, -0.5), (-0.5, 0.5), (0.5, -0.5)])
    ).tolist()
    axes = [to_right_x_m - x_m, to_right_y_m - y_m, down_x_m - x_m, down_y_m - y_m]
    lost, lost_layer = left_out(sheet, topology, provenance)
    return {
        **result_data(topology, provenance),
        "view": _view(topology),
        "size": [frame.width, frame.height],
        "resolution_m": frame.resolution_m,
        "world_m": [x_m, y_m, *axes],
        "layers": [asdict(layer) for layer in [*layers(sheet, provenance, annotations), *lost_layer]],
        "left_out": lost,
        "drives": list(drives(sheet, provenance)),
        "lives": lives_of(topology, provenance),
        "door_colour": colour_text(style.KEPT),
        "curve": _curve(provenance.run.search) if provenance and len(provenance.run.search) else None,
        "colours": [colour_text(colour) for colour in (style.KEPT, style.REMOVED)],
        "numbers": list(_numbers(provenance)) if provenance else [],
        "settings": list(_settings(provenance)) if provenance else [],
    }


def result_data(topology: TopologicalMap, provenance: Provenance | None = None) -> dict[str, Any]:
    """What changes when rooms and doors are edited."""
    sheet = Sheet(topology.frame)
    return {
        "facts": _facts(topology, provenance),
        "rooms": _rooms(topology, sheet),
        "doors": _doors(topology, sheet, door_tips(topology, provenance)),
    }


def _facts(topology: TopologicalMap, provenance: Provenance | None) -> list[tuple[str, str]]:
    frame = topology.frame
    rooms, doors = len(topology.area_m2), len(topology.kind)
    facts = [
        ("rooms", str(rooms)),
        ("doors", str(doors)),
        ("area", f"{topology.total_m2:.1f} m²"),
        ("map", f"{frame.width} x {frame.height} cells of {frame.resolution_m:g} m"),
    ]
    if provenance is None:
        return facts
    files = [(f"SHA-256 of {name}", digest) for name, digest in provenance.files]
    return [(printable(name), printable(value)) for name, value in [*facts, *provenance.facts.items(), *files]]


def _view(topology: TopologicalMap) -> list[float]:
    """Left, top, width and height of the bounding box of all rooms, in cells, with a margin."""
    cells = np.argwhere(topology.labels)
    (top, left), (height, width) = cells.min(axis=0).tolist(), (np.ptp(cells, axis=0) + 1).tolist()
    margin = max(MARGIN * max(height, width), 1.0)
    return [left - margin, top - margin, width + 2 * margin, height + 2 * margin]


def _rooms(topology: TopologicalMap, sheet: Sheet) -> list[dict[str, Any]]:
    centre = sheet.points(topology.centre, topology.frame).tolist()
    doors = topology.doors
    return [
        {
            "id": room.id,
            "name": room.name,
            "area_m2": room.area_m2,
            "centre_m": room.centre_m,
            "doors": [door.id for door in doors if room.id in door.rooms],
            "neighbours": room.neighbours,
            "at": at,
            "d": polygon(sheet.world_points(np.array(ring)) for ring in room.polygon_m),
            "colour": colour_text(style.room(room.id)),
        }
        for room, at in zip(topology.rooms, centre, strict=True)
    ]


def _doors(topology: TopologicalMap, sheet: Sheet, tips: Mapping[int, Tip]) -> list[dict[str, Any]]:
    rows = []
    none = Tip(-1, ())
    for door in topology.doors:
        ends = sheet.world_points(np.array(line_m(topology, door)))
        middle_m = np.mean([door.start_m, door.end_m], axis=0).round(3)
        rows.append(
            {
                "id": door.id,
                "rooms": door.rooms,
                "kind": door.kind,
                "width_m": door.width_m,
                "length_m": door.length_m,
                "tilt_deg": door.tilt_deg,
                "middle_m": middle_m.tolist(),
                "at": ends.mean(axis=0).tolist(),
                "d": polyline(ends),
                "candidate": tips.get(door.id, none).candidate,
                "why": list(tips.get(door.id, none).lines),
            }
        )
    return rows


def _curve(search: ConvergenceHistory) -> dict[str, Any]:
    """Costs of the generations shown, and the edges that each flips relative to the one shown before it."""
    best = search.numbers("best_cost")
    better = np.flatnonzero(np.diff(best, prepend=np.inf) < 0)
    shown = np.linspace(0, len(search) - 1, min(len(search), MOST_POINTS)).astype(int)
    if len(better) <= MOST_POINTS:
        shown = np.union1d(shown, better)
    removed = np.stack([search.choices(edge)[shown] for edge in range(search.edges)], axis=1) if search.edges else None
    flips: list[list[int]] = [[] for _ in shown]
    if removed is not None:
        for row, edge in np.argwhere(removed ^ np.roll(removed, 1, axis=0)).tolist():
            flips[row].append(edge)
        flips[0] = np.flatnonzero(removed[0]).tolist()
    costs = {name: _finite(search.numbers(f"{name}_cost")[shown]) for name in ("best", "mean", "worst")}
    counts = {name: search.numbers(name)[shown].astype(int).tolist() for name in ("number", "evaluations")}
    return {**costs, **counts, "edges": search.edges, "flips": flips}


def _finite(values: np.ndarray[Any, np.dtype[np.float64]]) -> list[float | None]:
    """Numbers for JSON: None if not finite."""
    return [value if np.isfinite(value) else None for value in values.tolist()]


def _numbers(provenance: Provenance) -> Iterator[tuple[str, str, str]]:
    """Scalars of the stages' records: stage, name, and value with its unit."""
    last = [provenance.run.search[-1]] if len(provenance.run.search) else []
    for record in [*provenance.records, *last]:
        for name, (spec, _) in specs(type(record)).items():
            if spec.kind in SCALARS:
                yield record.topic, name, f"{getattr(record, name):.9g} {spec.unit}".rstrip()


def _settings(provenance: Provenance) -> Iterator[tuple[str, str, str]]:
    """Every setting, in the order of the method's stages: stage, name, value."""
    order = [field.name for field in fields(Pipeline)]
    stages = sorted(provenance.settings, key=lambda name: (order.index(name) if name in order else len(order), name))
    for stage in stages:
        table = provenance.settings[stage]
        for name, value in sorted(table.items()) if isinstance(table, dict) else [("", table)]:
            yield printable(stage), printable(name), printable(value_text(value))
