"""Figures 3 and 5: what the stages of a run find."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TypeVar

import numpy as np

from vdoor.grid import OccupancyGrid
from vdoor.method.boundary import BoundaryPath
from vdoor.method.corners import Candidates, Corners
from vdoor.method.doors import PROPOSED, VirtualDoors
from vdoor.method.initial_map import InitialMap
from vdoor.method.simplify import REASONS, SimplifiedGrid
from vdoor.paper.pictures_.plan import OCCUPIED, Plan, key, window_of
from vdoor.record import Record
from vdoor.topology import TopologicalMap
from vdoor.viz.charts import drawing, to_png
from vdoor.viz.rerun import style

R = TypeVar("R", bound=Record)
Records = Mapping[str, Record]
"""Of one run, by topic."""
Panel = Callable[[Plan, Records], None]

REMOVED = {
    "unreachable": style.UNREACHABLE,
    "jut": style.JUT,
    "notch": style.NOTCH,
    "island": style.ISLAND,
}
CORNER_KEY = (("o", style.CONCAVE, "concave"), ("o", style.CONVEX, "convex"))
MAP_KEY = (
    ("-", style.BOUNDARY, "boundary"),
    ("-", style.DOOR, "virtual door"),
    ("o", style.NODE, "node"),
    ("o", style.EDGE_MIDDLE, "edge"),
)
LIGHT = 0.55
"""How far rooms' colours go towards white."""


def given(plan: Plan, run: Records) -> None:
    """The map."""
    plan.cells(_get(run, OccupancyGrid).cells)


def simplified(plan: Plan, run: Records) -> None:
    """The simplified map, with the boundary walked."""
    plan.cells(_get(run, SimplifiedGrid).cells)
    boundary(plan, run)


def removed(plan: Plan, run: Records) -> None:
    """The simplified map, cells that it removed or flattened in colours of their own."""
    found = _get(run, SimplifiedGrid)
    plan.cells(found.cells)
    for name, colour in REMOVED.items():
        plan.marked(found.reason == REASONS.index(name), colour)
    boundary(plan, run)


def candidates(plan: Plan, run: Records) -> None:
    """The samples of the boundary, and those that bend."""
    simplified(plan, run)
    found = _get(run, Candidates)
    for convex, colour in ((False, style.CONCAVE), (True, style.CONVEX)):
        plan.circles(found.cell[found.convex == convex], colour)


def corners(plan: Plan, run: Records) -> None:
    """The corner features."""
    simplified(plan, run)
    found = _get(run, Corners)
    for convex, colour in ((False, style.CONCAVE), (True, style.CONVEX)):
        plan.circles(found.quarter[found.convex == convex] / 4 - 0.5, colour)


def virtual_doors(plan: Plan, run: Records) -> None:
    """Corners and the virtual doors between them."""
    corners(plan, run)
    doors = _get(run, VirtualDoors)
    proposed = doors.verdict == PROPOSED
    plan.lines(doors.start[proposed], doors.end[proposed], style.DOOR)


def initial_map(plan: Plan, run: Records) -> None:
    """All virtual doors as edges, and the nodes that they part."""
    simplified(plan, run)
    found = _get(run, InitialMap)
    middle = (found.start + found.end) / 2
    plan.lines(middle[found.border_edge], found.centre[found.border_region], style.LINK, wide=1.0)
    plan.lines(found.start, found.end, style.DOOR)
    plan.circles(found.centre, style.NODE, size=1.2)
    plan.circles(middle, style.EDGE_MIDDLE)


def final_map(plan: Plan, run: Records) -> None:
    """The rooms that are left, and the doors between them."""
    grid, before, found = _get(run, OccupancyGrid), _get(run, SimplifiedGrid), _get(run, TopologicalMap)
    plan.cells(before.cells)
    plan.marked(before.reason == REASONS.index("jut"), OCCUPIED)  # labels are of the map as it was given
    for room in range(1, len(found.area_m2) + 1):
        light = [round(part + LIGHT * (255 - part)) for part in style.room(room)]
        plan.marked(found.labels == room, light)
    boundary(plan, run)
    start, end = (grid.frame.cell_from_world(ends) for ends in (found.start_m, found.end_m))
    middle = (start + end) / 2
    for rooms in (found.room_a, found.room_b):
        plan.lines(middle, found.centre[rooms - 1], style.LINK, wide=1.0)
    plan.lines(start, end, style.DOOR)
    plan.circles(found.centre, style.NODE, size=1.2)
    plan.circles(middle, style.EDGE_MIDDLE)


def boundary(plan: Plan, run: Records) -> None:
    """The path along the walls, closed around the free space and around each island."""
    path = _get(run, BoundaryPath)
    for ring in np.split(path.cell, path.first[1:]):
        plan.ring(ring, style.BOUNDARY)


SUB_CASES: dict[str, tuple[tuple[str, Panel], tuple[str, Panel]]] = {
    "3a": (("map", given), ("simplified: what cannot be reached is gone", removed)),
    "3b": (("not flattened: corners at the jut", corners), ("flattened", corners)),
    "3c, 3d": (("c: candidates", candidates), ("d: corners", corners)),
    "3e": (("virtual door of a pair", virtual_doors), ("final map", final_map)),
    "3f": (("virtual door of a single corner", virtual_doors), ("final map", final_map)),
    "3g": (("virtual doors", virtual_doors), ("final map: one is left", final_map)),
}
"""Two pictures for each part of figure 3, with their titles."""
WALK_THROUGH: tuple[tuple[str, Panel], ...] = (
    ("a: occupancy grid", given),
    ("b: simplified", removed),
    ("c: samples that bend: candidates", candidates),
    ("d: corner features", corners),
    ("e: initial topological map", initial_map),
    ("f: final topological map", final_map),
)
"""The parts of figure 5."""


def sub_case(part: str, before: Records, after: Records) -> bytes:
    """One part of figure 3 as a PNG, side by side; `before` is a run without the step in question, or the same."""
    cells = _get(after, OccupancyGrid).cells
    window = window_of(cells, 0)
    height, width = window[1] - window[0] + 1, window[3] - window[2] + 1
    px = 14.0
    with drawing(2 * (width * px / 72 + 0.25), height * px / 72 + 0.8) as figure:
        axes = figure.subplots(1, 2)
        for place, (title, panel), run in zip(axes, SUB_CASES[part], (before, after), strict=True):
            panel(Plan(place, title, window, px=px), run)
        gone = _gone(after) if part == "3a" else ()
        ways = MAP_KEY[1:] if _get(after, TopologicalMap).kind.size else ()
        key(axes[0], [*(gone or CORNER_KEY), MAP_KEY[0], *ways], columns=6)
        return to_png(figure)


def walk_through(run: Records) -> bytes:
    """Figure 5 as a PNG: six stages."""
    window = window_of(_get(run, SimplifiedGrid).cells, 2)
    height, width = window[1] - window[0] + 1, window[3] - window[2] + 1
    px = 5.4
    with drawing(3 * (width * px / 72 + 0.15), 2 * (height * px / 72 + 0.3) + 0.45) as figure:
        axes = figure.subplots(2, 3).ravel()
        for place, (title, panel) in zip(axes, WALK_THROUGH, strict=True):
            panel(Plan(place, title, window, px=px), run)
        key(axes[0], [*_gone(run), *CORNER_KEY, *MAP_KEY], columns=8)
        return to_png(figure)


def _gone(run: Records) -> list[tuple[str, style.Colour, str]]:
    """The key of cells that were removed, as far as there are any."""
    reason = _get(run, SimplifiedGrid).reason
    return [
        ("s", colour[:3], {"unreachable": "unreachable, removed"}.get(name, f"{name}, flattened"))
        for name, colour in REMOVED.items()
        if (reason == REASONS.index(name)).any()
    ]


def _get(run: Records, kind: type[R]) -> R:
    record = run[kind.topic]
    assert isinstance(record, kind)
    return record
