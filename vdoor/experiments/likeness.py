"""How alike maps are, synthetic and real: what lies beside walls, how long they run, and how cluttered floors are."""

from __future__ import annotations

import contextlib
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass, fields
from typing import Any

import numpy as np
import scipy
from numpy.typing import NDArray

from vdoor.errors import MapError
from vdoor.grid import OccupancyGrid
from vdoor.method.scoring.score import corners_per_m
from vdoor.pipeline import PRESETS, Pipeline
from vdoor.raster.morphology import counted, with_neighbours
from vdoor.raster.runs import runs_of
from vdoor.synth import synthesize

EIGHT = np.ones((3, 3), np.int64)
LONG_RUN = 0.9
"""Quantile of the lengths of runs: most are the few cells that a wall is thick."""
QUARTILES = (0.25, 0.5, 0.75)
Quartiles = tuple[float, float, float]


@dataclass(frozen=True)
class Statistics:
    """What a map looks like in figures."""

    free_m2: float
    free_beside_walls: float
    """Share of free cells among the eight neighbours of occupied cells."""
    unknown_beside_walls: float
    """The same of unknown cells; outside the map there are none."""
    wall_cells_thick: float
    """Median, over occupied cells, of the shorter of the two runs (along row and column) that each lies in."""
    wall_run_m: float
    """Nine in ten occupied cells have a longer run of at most this length."""
    islands_per_m2: float
    """Groups of occupied cells of less than 1 m2 with free cells all around."""
    corners_per_m: float
    """Corners of the simplified map, by length of its boundary."""


def statistics(grid: OccupancyGrid, pipeline: Pipeline) -> Statistics:
    """The statistics of a map; `MapError` as by the pipeline."""
    cell_m, occupied, unknown = grid.frame.resolution_m, grid.occupied, ~(grid.free | grid.occupied)
    free_m2 = np.count_nonzero(grid.free) * cell_m**2
    beside = [scipy.ndimage.convolve(state.astype(np.int64), EIGHT, mode="constant") for state in (grid.free, unknown)]
    runs = (
        np.stack([_run_cells(occupied), _run_cells(occupied.T).T])[:, occupied] if occupied.any() else np.zeros((2, 1))
    )
    count = max(int(occupied.sum()), 1)
    _, path, corners, _ = pipeline.propose(grid)
    return Statistics(
        free_m2=free_m2,
        free_beside_walls=float(beside[0][occupied].sum()) / (8 * count),
        unknown_beside_walls=float(beside[1][occupied].sum()) / (8 * count),
        wall_cells_thick=float(np.median(runs.min(axis=0))),
        wall_run_m=float(np.quantile(runs.max(axis=0), LONG_RUN)) * cell_m,
        islands_per_m2=_islands(grid) / max(free_m2, cell_m**2),
        corners_per_m=corners_per_m(path, corners),
    )


def _run_cells(occupied: NDArray[np.bool_]) -> NDArray[np.int32]:
    """For each cell (h, w) the length of the run of occupied cells along its row that it lies in, 0 outside."""
    runs = runs_of(occupied)
    return runs.labelled(runs.length.astype(np.int32)).image()


def _islands(grid: OccupancyGrid) -> int:
    """The number of groups of occupied cells of less than 1 m2 with free cells all around."""
    part, count = counted(grid.occupied, 2)
    area_m2 = np.bincount(part.ravel(), minlength=count + 1) * grid.frame.resolution_m**2
    unknown = np.pad(~(grid.free | grid.occupied), 1, constant_values=True)
    bounded = np.unique(part[with_neighbours(unknown)[1:-1, 1:-1]])
    alone = area_m2 < 1
    alone[0] = False
    alone[bounded] = False
    return int(alone.sum())


def drawn(kind: Any, count: int, seed: int) -> list[OccupancyGrid]:
    """Synthetic maps by the settings of one kind."""
    return [synthesize(kind, np.random.default_rng([seed, index])).grid for index in range(count)]


def measured(groups: Mapping[str, Iterable[OccupancyGrid]]) -> dict[str, dict[str, Quartiles]]:
    """Quartiles of each statistic over each group of maps, without those that have no rooms; `MapError` if none has."""
    pipeline = PRESETS["default"]
    assert isinstance(pipeline, Pipeline)
    return {name: _quartiles(name, grids, pipeline) for name, grids in groups.items()}


def _quartiles(name: str, grids: Iterable[OccupancyGrid], pipeline: Pipeline) -> dict[str, Quartiles]:
    rows = []
    for grid in grids:
        with contextlib.suppress(MapError):
            rows.append(asdict(statistics(grid, pipeline)))
    if not rows:
        raise MapError(f"{name}: wanted a map with rooms, found none")
    found = {}
    for field in fields(Statistics):
        low, middle, high = np.quantile([row[field.name] for row in rows], QUARTILES).tolist()
        found[field.name] = (low, middle, high)
    return found


def to_text(found: Mapping[str, Mapping[str, Quartiles]]) -> str:
    """A table: a row a statistic, a column a group, with first quartile, median and third quartile."""
    wide = max(len(field.name) for field in fields(Statistics))
    lines = [" ".join([" " * wide, *(f"{name:>22}" for name in found)])]
    for field in fields(Statistics):
        cells = ["{:6.2f} {:7.2f} {:7.2f}".format(*columns[field.name]) for columns in found.values()]
        lines.append(" ".join([f"{field.name:{wide}}", *cells]))
    return "\n".join(lines)
