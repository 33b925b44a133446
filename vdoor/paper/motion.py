"""The introduction's claims about motion: paths from room to room, and covering room by room."""

from __future__ import annotations

import functools
from dataclasses import dataclass

from vdoor.experiments import cover_benchmark, route_benchmark
from vdoor.navigate.cover_floor import CoverFloor
from vdoor.paper.door_counts import ENVIRONMENTS, METHODS, PROPOSED, Environment, for_map
from vdoor.paper.walkthrough import paper_apartment

CELL_M = 0.05
"""Of the maps: at 20 cm furniture is too coarse to drive around."""
STARTS = 20
"""Places on each map that paths start from, to a few goals each."""


@dataclass(frozen=True, kw_only=True)
class Sweep:
    """A path that covers a map and returns to its start."""

    covered: float
    """Share of the floor in reach."""
    length_m: float
    turns_per_m2: float
    room_changes: int


@dataclass(frozen=True, kw_only=True)
class Motion:
    """What moving about one furnished environment takes, with the topological map and without it."""

    environment: Environment
    rooms: int
    doors: int
    cells: int
    """Of the occupancy grid."""
    paths: int
    longer_mean: float
    """Length of the paths over rooms and doors, over that of the shortest on the whole grid."""
    longer_worst: float
    by_room: Sweep
    at_once: Sweep


@functools.cache
def study_motion() -> tuple[Motion, ...]:
    """Paths and coverage of the environments of Table I, furnished, for a robot of 0.17 m radius."""
    return tuple(map(_motion, ENVIRONMENTS))


def _motion(environment: Environment) -> Motion:
    made = paper_apartment(environment.seed, rooms=environment.rooms, rooms_spread=0, furniture=True, cell_m=CELL_M)
    pipeline, grids, cover = for_map(made, METHODS[PROPOSED]), {environment.name: made.grid}, CoverFloor()
    (routes,) = route_benchmark.measured(grids, pipeline, tile=1, starts=STARTS, radius_m=cover.radius_m)
    by_room, at_once = map(_sweep, cover_benchmark.measured(grids, pipeline, cover))
    return Motion(
        environment=environment,
        rooms=routes.rooms,
        doors=routes.doors,
        cells=made.grid.frame.height * made.grid.frame.width,
        paths=routes.paths,
        longer_mean=routes.over_mean,
        longer_worst=routes.over_worst,
        by_room=by_room,
        at_once=at_once,
    )


def _sweep(report: cover_benchmark.CoverReport) -> Sweep:
    return Sweep(
        covered=report.covered,
        length_m=report.length_m,
        turns_per_m2=report.turns_per_m2,
        room_changes=round(report.room_changes),
    )
