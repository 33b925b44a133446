"""Why there is a door at a point, or none: the decision of each stage about the nearest elements."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vdoor.errors import SettingError
from vdoor.explain.corners import CornerFate, Sample, corner_fates, sample_fates
from vdoor.explain.distances import Point
from vdoor.explain.doors import DoorFate, Passage, door_fates, passages
from vdoor.history import History
from vdoor.method.corners import Candidates, Corners
from vdoor.method.curvature import Curvature
from vdoor.method.doors import VirtualDoors
from vdoor.method.simplify import REASONS, SimplifiedGrid
from vdoor.topology import TopologicalMap

STATES = {-1: "unknown", 0: "free", 100: "occupied"}


@dataclass(frozen=True, kw_only=True)
class Place:
    """The queried point and the map at that point."""

    point_m: Point
    col_row: tuple[int, int]
    """Cell of the input grid."""
    value: int
    """Value of that cell: -1 unknown, 0 free to 100 occupied."""
    working_col_row: tuple[int, int] | None = None
    """Cell of the simplified grid; None if that was not recorded."""
    state: str = ""
    """State of the simplified cell: unknown, free or occupied."""
    reason: str = ""
    """Why simplification changed the cell after resampling."""
    room: int = 0
    """Room of the final map, 0 if none."""


@dataclass(frozen=True, kw_only=True)
class Answer:
    """Explanation of a place: the nearest elements of each stage, nearest first."""

    place: Place
    samples: tuple[Sample, ...] = ()
    candidates: tuple[Sample, ...] = ()
    corners: tuple[CornerFate, ...] = ()
    doors: tuple[DoorFate, ...] = ()
    passages: tuple[Passage, ...] = ()
    recorded: tuple[str, ...] = ()
    """Topics of the recorded stages; the results of others are unknown."""


def explain(run: History, point_m: Point, *, count: int = 3) -> Answer:
    """Decisions about the `count` samples, candidates, corners and doors nearest to x, y in the map frame.

    Doors are the `count` nearest proposed and the `count` nearest rejected ones. `SettingError` for a point off the
    map.
    """
    place = _place(run, point_m)
    has = run.has
    return Answer(
        place=place,
        samples=sample_fates(run, point_m, np.arange(len(run.path.cell), dtype=np.int32), count)
        if has(Curvature)
        else (),
        candidates=sample_fates(run, point_m, run.candidates.sample, count) if has(Candidates) else (),
        corners=corner_fates(run, point_m, count) if has(Corners) else (),
        doors=door_fates(run, point_m, count) if has(VirtualDoors) and has(Corners) else (),
        passages=passages(run, point_m, count) if has(TopologicalMap) else (),
        recorded=run.stages,
    )


def _place(run: History, point_m: Point) -> Place:
    frame = run.input.frame
    row, col = np.rint(frame.cell_from_world(np.array([point_m]))[0]).astype(int).tolist()
    if not (0 <= row < frame.height and 0 <= col < frame.width):
        x_m, y_m = point_m
        size = f"{frame.width} x {frame.height} cells"
        raise SettingError(f"--at: wanted a point on the map ({size}), found {x_m:g},{y_m:g} m, cell {col},{row}")
    place = Place(point_m=point_m, col_row=(col, row), value=int(run.input.cells[row, col]))
    if not run.has(SimplifiedGrid):
        return place
    at = row // run.simplified.factor, col // run.simplified.factor
    return Place(
        point_m=point_m,
        col_row=(col, row),
        value=place.value,
        working_col_row=(at[1], at[0]),
        state=STATES[int(run.simplified.cells[at])],
        reason=REASONS[run.simplified.reason[at]],
        room=int(run.topology.labels[row, col]) if run.has(TopologicalMap) else 0,
    )
