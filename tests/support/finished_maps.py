"""Finished maps to export: drawn so that each has something that formats stumble over."""

from __future__ import annotations

import functools
from pathlib import Path

import numpy as np
from maps import CELL_M, Cells
from project import HOME

import vdoor
from vdoor.emit import RunInfo
from vdoor.grid import FREE, OCCUPIED, UNKNOWN, OccupancyGrid
from vdoor.results.writing import document_of, write_result
from vdoor.topology import TopologicalMap

ROOM = 16
"""Cells across a room: less would be merged."""


def house(rooms: int, *gaps: tuple[int, int, int]) -> Cells:
    """Rooms in a row, a wall of two cells after each, with gaps: after which room, from which row, how wide."""
    cells = np.full((ROOM + 4, rooms * (ROOM + 2) + 2), OCCUPIED, np.int8)
    for room in range(rooms):
        left = 2 + room * (ROOM + 2)
        cells[2:-2, left : left + ROOM] = FREE
    for room, row, wide in gaps:
        left = room * (ROOM + 2)
        cells[2 + row : 2 + row + wide, left : left + 2] = FREE
    return cells


def _pillars() -> OccupancyGrid:
    """Three rooms with pillars, two doors between the first two, in a map that lies askew."""
    cells = house(3, (1, 1, 4), (1, 11, 4), (2, 6, 4))
    cells[8:11, 9:12] = OCCUPIED
    cells[5, 42] = cells[6, 43] = UNKNOWN
    return OccupancyGrid.from_array(cells, CELL_M, x_m=-12.3, y_m=4.56, yaw_rad=0.7)


def _slit() -> OccupancyGrid:
    """Two rooms with a slit of one fine cell, which the working resolution does not see, and a door elsewhere."""
    cells = house(3, (1, 6, 4), (2, 10, 4)).repeat(2, axis=0).repeat(2, axis=1)
    cells[8, 36:40] = FREE
    return OccupancyGrid.from_array(cells, CELL_M / 2)


GRIDS = {
    "flat": lambda: vdoor.read_map(HOME / "recordings" / "flat.yaml"),
    "pillars": _pillars,
    "one room": lambda: OccupancyGrid.from_array(house(1), CELL_M),
    "slit": _slit,
}
NAMES = tuple(GRIDS)


@functools.cache
def grid(name: str) -> OccupancyGrid:
    return GRIDS[name]()


@functools.cache
def topology(name: str) -> TopologicalMap:
    return vdoor.run(grid(name), "paper")


def result(name: str, folder: Path) -> Path:
    """The result folder of an example."""
    info = RunInfo(version="0.1.0", preset="paper", seed=0, settings={}, source=grid(name).source)
    write_result(folder, grid(name), topology(name), document_of(topology(name), info, {}))
    return folder


def cell_centres(finished: TopologicalMap) -> np.ndarray[tuple[int, int], np.dtype[np.float64]]:
    """Map coordinates (h * w, 2) of the middles of all cells, row by row."""
    height, width = finished.labels.shape
    return finished.frame.world_from_cell(np.indices((height, width)).reshape(2, -1).T)
