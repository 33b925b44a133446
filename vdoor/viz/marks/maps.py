"""Marks of topological maps: the initial one, the search among its doors, and the result."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from vdoor.editing.apply import VERDICTS as EDIT_VERDICTS
from vdoor.editing.edits import FORMS
from vdoor.explain import coverage as coverage_text
from vdoor.explain.routes import described, obstacle_text
from vdoor.history.records import RunRecords
from vdoor.navigate.coverage.path import KINDS as PURPOSES
from vdoor.topology import TopologicalMap
from vdoor.viz.marks.boundary import OCCUPIED, STATES, states
from vdoor.viz.marks.kinds import MOST_CODES, Cells, Colour, Dots, Lines, Mark, segments, wrapped
from vdoor.viz.rerun import style

MOST_AREAS = 24
"""With more rooms than that, their labels leave the areas out."""
FAR = 1e6
"""Cells beyond any map: damaged records may hold any place."""


def initial_map(run: RunRecords) -> Iterator[Mark]:
    """Regions between all doors, and the graph of regions and the doors that they border."""
    found, frame = run.initial, run.initial.frame
    regions = len(found.area_m2)
    colours = {region: (style.room(region), f"region {region - 1}") for region in range(1, regions + 1)}
    codes = wrapped(np.where(found.piece <= regions, found.piece, 0))
    yield Cells(name="regions", frame=frame, codes=codes, colours=_coded(colours), opacity=0.75, listed=False)
    middle = (found.start + found.end) / 2
    links = segments(found.centre[found.border_region], middle[found.border_edge])
    yield Lines(
        name="links",
        frame=frame,
        strips=links,
        colour=style.LINK,
        meaning="joins a region with a door on its border",
        wide_px=1,
    )
    tips = [f"virtual door {door}: {width_m:.2f} m" for door, width_m in zip(found.door, found.width_m, strict=True)]
    strips, meaning = segments(found.start, found.end), f"virtual door ({len(found.door)})"
    yield Lines(name="doors", frame=frame, strips=strips, colour=style.DOOR, meaning=meaning, tips=tips, wide_px=2.5)
    yield Dots(name="edges", frame=frame, cell=middle, colour=style.EDGE_MIDDLE, meaning="middle of a door", wide_px=4)
    areas = [f"region {region}: {area_m2:.2f} m²" for region, area_m2 in enumerate(found.area_m2)]
    nodes = f"region ({regions})"
    yield Dots(name="nodes", frame=frame, cell=found.centre, colour=style.NODE, meaning=nodes, tips=areas, wide_px=9)


def choice(run: RunRecords) -> Iterator[Mark]:
    """Doors that the best choice of the last recorded generation keeps and removes."""
    initial, removed = run.initial, run.search[-1].removed
    for name, own, colour, wide_px in (
        ("removed", removed, style.REMOVED, 2.0),
        ("kept", ~removed, style.KEPT, 4.0),
    ):
        rows = np.flatnonzero(own)
        yield Lines(
            name=name,
            frame=initial.frame,
            strips=segments(initial.start[rows], initial.end[rows]),
            colour=colour,
            meaning=f"{name} ({len(rows)})",
            tips=[f"virtual door {initial.door[row]}, {name}" for row in rows],
            wide_px=wide_px,
        )


def final_map(run: RunRecords) -> Iterator[Mark]:
    """Rooms in colour with the walls over them, doors, and the graph."""
    found = run.topology
    yield rooms(found)
    yield from _walls(run)
    start, end = (found.frame.cell_from_world(points_m) for points_m in (found.start_m, found.end_m))
    middle = (start + end) / 2
    ends = np.searchsorted(found.room_ids, np.concatenate([found.room_a, found.room_b]))
    links = segments(found.centre[ends], np.concatenate([middle, middle]))
    yield Lines(
        name="links",
        frame=found.frame,
        strips=links,
        colour=style.LINK,
        meaning="joins a room with its door",
        wide_px=1.2,
    )
    yield Lines(
        name="doors",
        frame=found.frame,
        strips=segments(start, end),
        colour=style.KEPT,
        meaning=f"door, with its number ({len(found.kind)})",
        labels=[str(row + 1) for row in range(len(found.kind))],
        tips=[f"door {row + 1}: {width_m:.2f} m" for row, width_m in enumerate(found.width_m)],
        wide_px=4,
    )
    yield nodes(found)


def nodes(found: TopologicalMap) -> Dots:
    """The rooms' nodes, with their names or numbers and, if they are few, their areas."""
    own = [(room.name or str(room.id), f"{room.title}: {room.area_m2:.1f} m²", room.area_m2) for room in found.rooms]
    few = len(own) <= MOST_AREAS
    return Dots(
        name="nodes",
        frame=found.frame,
        cell=found.centre,
        colour=style.NODE,
        meaning=f"room, with its {'name' if any(found.name) else 'number'}{' and area' if few else ''} ({len(own)})",
        labels=[f"{name}: {area_m2:.1f} m²" if few else name for name, _, area_m2 in own],
        tips=[tip for _, tip, _ in own],
        wide_px=10,
    )


def rooms(found: TopologicalMap) -> Cells:
    """The rooms in colour."""
    titles = {room.id: (style.room(room.id), room.title) for room in found.rooms}
    return Cells(
        name="rooms",
        frame=found.frame,
        codes=wrapped(found.labels),
        colours=_coded(titles),
        opacity=0.85,
        listed=False,
    )


def _coded(colours: Mapping[int, tuple[Colour, str]]) -> dict[int, tuple[Colour, str]]:
    """Colours of labels by the codes that `wrapped` makes of them."""
    return {(label - 1) % (MOST_CODES - 1) + 1: colour for label, colour in colours.items()}


def _walls(run: RunRecords) -> Iterator[Mark]:
    """The walls alone, over the rooms: reduced, thin ones would be lost under them."""
    if "input" in run.records:
        codes = states(run.input.cells)
        yield Cells(
            name="walls", frame=run.input.frame, codes=codes, colours={OCCUPIED: STATES[OCCUPIED]}, listed=False
        )


def edits(run: RunRecords) -> Iterator[Mark]:
    """Places of edits, and what became of them."""
    found = run.edits
    if "input" not in run.records:  # lost from a damaged recording
        return
    frame, kinds = run.input.frame, tuple(FORMS)
    tips = [
        f"{kinds[kind]}: {EDIT_VERDICTS[verdict]}"
        for kind, verdict in zip(found.kind.tolist(), found.verdict.tolist(), strict=True)
    ]
    start, end = frame.cell_from_world(found.start_m), frame.cell_from_world(found.end_m)
    common: dict[str, Any] = {"frame": frame, "colour": style.EDIT}
    near = np.flatnonzero(np.abs(start).max(axis=1, initial=0) < FAR)
    both = near[np.abs(end[near]).max(axis=1, initial=0) < FAR]  # false for nan
    strips = segments(start[both], end[both])
    yield Lines(name="lines", strips=strips, tips=[tips[row] for row in both], wide_px=3, **common)
    meaning = f"edit ({len(tips)})"
    yield Dots(name="places", cell=start[near], meaning=meaning, tips=[tips[row] for row in near], wide_px=10, **common)


def route(run: RunRecords) -> Iterator[Mark]:
    """The path through its stops, or what is in the way."""
    found, frame = run.route, run.route.frame
    if found.found:
        path = [frame.cell_from_world(found.point_m)]
        tips = [described(found)]
        yield Lines(name="path", frame=frame, strips=path, colour=style.ROUTE, meaning="route", tips=tips, wide_px=4)
    stops = frame.cell_from_world(found.stop_m)
    stops = stops[np.isfinite(stops).all(axis=1)]
    yield Dots(name="stops", frame=frame, cell=stops, colour=style.STOP, meaning="start, stops and goal", wide_px=12)
    if len(found.obstacle):
        yield Dots(
            name="in_the_way",
            frame=frame,
            cell=frame.cell_from_world(found.obstacle_m),
            colour=style.IN_THE_WAY,
            meaning="in the way",
            tips=[obstacle_text(found, row) for row in range(len(found.obstacle))],
            wide_px=14,
        )


def coverage(run: RunRecords) -> Iterator[Mark]:
    """The floor that is swept, and the path by what the robot drives for."""
    found, frame = run.coverage, run.coverage.frame
    swept = (found.swept > 0).astype(np.uint8)
    meaning = f"swept, {found.covered:.1%} of what the tool can reach"
    yield Cells(name="swept", frame=frame, codes=swept, colours={1: (style.SWEPT, meaning)})
    cell = frame.cell_from_world(found.point_m)
    for code, purpose in enumerate(PURPOSES):
        own = np.flatnonzero(found.purpose[1:] == code)
        yield Lines(
            name=f"path/{purpose}",
            frame=frame,
            strips=segments(cell[own], cell[own + 1]),
            colour=style.OF_PURPOSE[purpose],
            meaning=coverage_text.PURPOSES[purpose],
            wide_px=1.5,
        )
