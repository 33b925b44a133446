"""Routes by rooms and doors against the whole grid: lengths, times, and the clearance that is kept."""

from __future__ import annotations

import resource
import time
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from vdoor.api import prepared
from vdoor.experiments.benchmark import tiled
from vdoor.formats import read_annotations
from vdoor.grid import OccupancyGrid
from vdoor.navigate.blocked import Restrictions, blocked_cells
from vdoor.navigate.room_graph import FAR, STRAIGHT, RoomGraph
from vdoor.navigate.routes import Cell, Routes
from vdoor.navigate.sight import least_clearance
from vdoor.navigate.space import Space
from vdoor.pipeline import AnyPipeline
from vdoor.topology import TopologicalMap

GOALS = 5
"""Goals of each start: the whole grid is searched once a start."""


@dataclass(frozen=True, kw_only=True)
class RouteReport:
    """Figures of one map."""

    name: str
    cells: tuple[int, int]
    rooms: int
    doors: int
    paths: int
    table_s: float
    """CPU time until all distances between rooms are there."""
    table_mb: float
    """By how much the process grew for that."""
    path_ms: float
    """CPU time of a path in the mean."""
    grid_ms: float
    """CPU time of a search of the whole grid in the mean."""
    distance_us: float
    """CPU time of a distance between rooms."""
    over_mean: float
    over_worst: float
    """Length over cells by the optimum over cells at the same clearance."""
    pulled: float
    """Length of the pulled paths by the optimum over cells."""
    clear_m: float
    """Least clearance of all paths."""

    def to_text(self) -> str:
        """One line of a table."""
        return (
            f"{self.name[:36]:36s} {self.cells[1]:5d} x {self.cells[0]:<5d} {self.rooms:4d} {self.doors:5d} "
            f"{self.table_s:8.2f} {self.table_mb:6.0f} {self.path_ms:7.2f} {self.grid_ms:8.1f} {self.distance_us:7.1f} "
            f"{self.over_mean:8.4f} {self.over_worst:8.4f} {self.pulled:7.4f} {self.clear_m:8.4f}"
        )


HEADING = (
    f"{'map':36s} {'cells':>13s} {'rooms':>4s} {'doors':>5s} {'table s':>7s} {'MB':>6s} {'path ms':>7s} "
    f"{'grid ms':>8s} {'dist us':>7s} {'mean':>8s} {'worst':>8s} {'pulled':>7s} {'clear m':>8s}"
)


def measured(
    grids: Mapping[str, OccupancyGrid], pipeline: AnyPipeline, *, tile: int, starts: int, radius_m: float
) -> Iterator[RouteReport]:
    """Reports of each map, on pairs of cells drawn from a fixed seed in its largest part."""
    for name, single in grids.items():
        grid = tiled(single, tile)
        topology = prepared(pipeline, grid).pipeline(grid, np.random.default_rng(0))
        restrictions = Restrictions(annotations=read_annotations(grid.source))
        space = Space.of(blocked_cells(grid, topology, restrictions), grid.frame, radius_m)
        yield _report(name, space, topology, starts)


def _report(name: str, space: Space, topology: TopologicalMap, starts: int) -> RouteReport:
    since_mb, since_s = _peak_mb(), time.process_time()
    routes = Routes(space, topology)
    routes.fill()
    table_s, table_mb = time.process_time() - since_s, _peak_mb() - since_mb
    graph = RoomGraph.of(space, (slice(0, space.frame.height), slice(0, space.frame.width)), space.allowed)
    over, pulled, path_s, grid_s, clear_m = [], [], [], [], []
    _ = routes.sight
    for start, goals in _pairs(space, topology, starts):
        since_s = time.process_time()
        distance = graph.distances(start)
        grid_s.append(time.process_time() - since_s)
        for goal in goals:
            since_s = time.process_time()
            path = routes.path(start, goal)
            path_s.append(time.process_time() - since_s)
            plan, best = routes.plan(start, goal), int(distance[graph.number(goal)])
            assert path is not None
            assert plan is not None
            assert best < FAR
            over.append(plan.length / max(best, 1))
            pulled.append(_length(path) * STRAIGHT / max(best, 1))
            clear_m.append(least_clearance(space, np.array(path, np.float64)))
    return RouteReport(
        name=name,
        cells=(space.frame.height, space.frame.width),
        rooms=len(topology.area_m2),
        doors=len(topology.kind),
        paths=len(over),
        table_s=table_s,
        table_mb=table_mb,
        path_ms=1e3 * float(np.mean(path_s)),
        grid_ms=1e3 * float(np.mean(grid_s)),
        distance_us=1e6 * _distance_s(routes),
        over_mean=float(np.mean(over)),
        over_worst=float(np.max(over)),
        pulled=float(np.mean(pulled)),
        clear_m=float(np.min(clear_m)),
    )


def _pairs(space: Space, topology: TopologicalMap, starts: int) -> Iterator[tuple[Cell, list[Cell]]]:
    """Starts and goals in the largest part of the space that lies in rooms."""
    rng = np.random.default_rng(0)
    part = np.where(topology.labels > 0, space.parts, 0)
    cells = np.argwhere(part == np.argmax(np.bincount(part.ravel())[1:]) + 1)
    for _ in range(starts):
        start, *goals = (_cell(cells[at]) for at in rng.choice(len(cells), GOALS + 1, replace=len(cells) <= GOALS))
        yield start, goals


def _cell(row: NDArray[np.intp]) -> Cell:
    return int(row[0]), int(row[1])


def _length(path: list[Cell]) -> float:
    return float(sum(np.hypot(end[0] - start[0], end[1] - start[1]) for start, end in pairwise(path)))


def _distance_s(routes: Routes) -> float:
    """CPU time of one of many distances between rooms."""
    rooms = list(routes.standing)
    since_s = time.process_time()
    for one in rooms:
        for other in rooms:
            routes.distance_m(one, other)
    return (time.process_time() - since_s) / len(rooms) ** 2


def _peak_mb() -> float:
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
