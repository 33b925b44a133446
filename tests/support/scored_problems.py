"""Runs of the default preset on maps in cells of 5 cm, and the problems of choice that their doors pose."""

from __future__ import annotations

import dataclasses
import itertools
from typing import Any

import numpy as np
from maps import Cells

from vdoor.grid import FREE, OccupancyGrid
from vdoor.method.doors import PROPOSED, VirtualDoors
from vdoor.method.initial_map import InitialMap
from vdoor.method.scoring.score import DoorScores, ScoreDoors
from vdoor.method.search.costs import DoorEnergy
from vdoor.method.search.problem import MergeProblem
from vdoor.pipeline import PRESETS, Pipeline
from vdoor.record import Record
from vdoor.topology import KINDS

CELL_M = 0.05
DEFAULT = PRESETS["default"]
assert isinstance(DEFAULT, Pipeline)


def two_rooms(*, door: int = 18, side: int = 80, wall: int = 4) -> Cells:
    """Two square rooms with an opening in the middle of the wall between them, in cells of 5 cm."""
    cells = np.full((side + 2 * wall, 2 * side + 3 * wall), 100, np.int8)
    cells[wall:-wall, wall : wall + side] = FREE
    cells[wall:-wall, 2 * wall + side : -wall] = FREE
    low = wall + (side - door) // 2
    cells[low : low + door, wall + side : 2 * wall + side] = FREE
    return cells


def records_of(cells: Cells, pipeline: Pipeline = DEFAULT) -> dict[type[Record], Any]:
    """The last record of each kind of a run."""
    found: dict[type[Record], Any] = {}

    def keep(record: Any) -> Any:
        found[type(record)] = record
        return record

    pipeline(OccupancyGrid.from_array(cells, CELL_M), np.random.default_rng(0), keep)
    return found


def problem_of(cells: Cells, cost: DoorEnergy | None = None) -> MergeProblem:
    """The choice among all proposed doors, likely or not, however narrow, so that there is something to search."""
    pipeline = Pipeline(
        simplify=dataclasses.replace(DEFAULT.simplify, gap_m=0.0),
        doors=dataclasses.replace(DEFAULT.doors, least_m=0.0),  # type: ignore[type-var]  # of the wide kind
        score=ScoreDoors(least_log_odds=-100),
        cost=DoorEnergy(),
    )
    found = records_of(cells, pipeline)
    return MergeProblem(found[InitialMap], cost or DoorEnergy(), found[DoorScores])


def all_choices(count: int) -> np.ndarray[Any, np.dtype[np.bool_]]:
    """Every string (2^r, r)."""
    return np.array(list(itertools.product([False, True], repeat=count)), np.bool_).reshape(2**count, count)


def segments(doors: VirtualDoors) -> set[frozenset[tuple[int, int]]]:
    """The proposed doors as pairs of cells, but for extensions, which depend on a fitted direction."""
    own = (doors.verdict == PROPOSED) & (doors.kind != KINDS.index("extension"))
    return {
        frozenset({(a, b), (c, d)})
        for (a, b), (c, d) in zip(doors.start[own].tolist(), doors.end[own].tolist(), strict=True)
    }
