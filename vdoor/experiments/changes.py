"""The same place seen otherwise: turned, in larger cells, or with ragged walls and specks.

A changed map's frame says where it lies, so that points of the map frame stay what they are; truth is moved from
frame to frame (see `robustness`) and never drawn.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from skimage.measure import block_reduce

from vdoor.frame import Frame
from vdoor.grid import FREE, FREE_TO, OCCUPIED, UNKNOWN, OccupancyGrid
from vdoor.method.simplify import resampled, working_frame

Mask = NDArray[np.bool_]
Ints = NDArray[np.intp]

COARSE_M = 0.10
NOISE, SPECKS = 0.15, 0.002
"""Shares of the cells on walls' faces, and of the free cells."""
AROUND = ((0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1), (1, 0), (1, 1))
"""The eight neighbours, one after the other around a cell, the first beside it."""


class Sheet(NamedTuple):
    """A map and its cells that are measured (h, w)."""

    grid: OccupancyGrid
    free: Mask


class Change(NamedTuple):
    """A name, and what is made of a map."""

    name: str
    make: Callable[[Sheet, np.random.Generator], Sheet]


def as_is(sheet: Sheet, _: np.random.Generator) -> Sheet:
    """The map itself."""
    return sheet


def turn(sheet: Sheet, _: np.random.Generator, *, angle_deg: float) -> Sheet:
    """The map turned to the left."""
    return Sheet(*turned(sheet.grid, sheet.free, angle_deg))


def coarsen(sheet: Sheet, _: np.random.Generator, *, cell_m: float = COARSE_M) -> Sheet:
    """The map in cells of about that size: occupied where any of the finer ones is, else free if any is."""
    factor = max(1, round(cell_m / sheet.grid.frame.resolution_m))
    frame = working_frame(sheet.grid.frame, factor)
    grid = OccupancyGrid(cells=resampled(sheet.grid, factor), frame=frame, source=sheet.grid.source)
    return Sheet(grid, block_reduce(sheet.free, factor, np.any) & grid.free)


def roughen(sheet: Sheet, rng: np.random.Generator, *, noise: float = NOISE, specks: float = SPECKS) -> Sheet:
    """The map with cells on walls' faces flipped, as many grown as dented, and specks in the open.

    A dent never goes through a wall.
    """
    grid = sheet.grid
    free, occupied = grid.free, grid.occupied
    flips = rng.random(free.shape) < noise / 2
    grown = free & _beside(occupied) & flips
    dented = occupied & flips & keeps_walls_closed(free)
    dented &= ~_beside(dented)  # two dents side by side could go through together
    grown |= free & (rng.random(free.shape) < specks)
    cells = np.where(grown, OCCUPIED, np.where(dented, FREE, grid.cells)).astype(np.int8)
    rough = OccupancyGrid(cells=cells, frame=grid.frame, source=grid.source)
    return Sheet(rough, (sheet.free | dented) & rough.free)


def keeps_walls_closed(free: Mask) -> Mask:
    """Cells (h, w) that could be freed alone without joining free cells that are apart around them.

    Those around which free cells beside it form one 4-connected piece: Yokoi's connectivity number is 1.
    """
    padded = np.pad(free, 1).astype(np.int8)
    height, width = free.shape
    ring = [padded[1 + down : 1 + down + height, 1 + right : 1 + right + width] for down, right in AROUND]
    pieces = sum(ring[k] - ring[k] * ring[k + 1] * ring[(k + 2) % 8] for k in (0, 2, 4, 6))
    return np.asarray(pieces == 1)


def _beside(mask: Mask) -> Mask:
    """Cells with one of the mask's among their four neighbours."""
    padded = np.pad(mask, 1)
    return padded[2:, 1:-1] | padded[:-2, 1:-1] | padded[1:-1, 2:] | padded[1:-1, :-2]


CHANGES = (
    Change("as it is", as_is),
    Change("turned by 5 degrees", functools.partial(turn, angle_deg=5.0)),
    Change("turned by 15 degrees", functools.partial(turn, angle_deg=15.0)),
    Change("turned by 30 degrees", functools.partial(turn, angle_deg=30.0)),
    Change("turned by 45 degrees", functools.partial(turn, angle_deg=45.0)),
    Change("cells of 10 cm", coarsen),
    Change("wall noise and specks", roughen),
)
"""The first is what the others are compared with."""


def turned(grid: OccupancyGrid, measured: Mask, angle_deg: float) -> tuple[OccupancyGrid, Mask]:
    """The map turned to the left about its middle, on a canvas that holds all of it, and its measured free cells.

    Each cell is as the nearest one was, unknown outside. Where a wall hangs together at corners of cells alone, those
    cells are marked once more where they come to lie, so that no wall opens.
    """
    frame = turned_frame(grid.frame, math.radians(angle_deg))
    shape = frame.height, frame.width
    source = _cells(grid.frame.cell_from_world(frame.world_from_cell(np.argwhere(np.ones(shape, np.bool_)))))
    inside = ((source >= 0) & (source < grid.cells.shape)).all(axis=1)
    at = tuple(source[inside].T)
    cells = np.full(frame.height * frame.width, UNKNOWN, np.int8)
    cells[inside] = grid.cells[at]
    free = np.zeros(cells.shape, np.bool_)
    free[inside] = measured[at]
    _mark_pinches(cells.reshape(shape), frame, grid)
    result = OccupancyGrid(cells=cells.reshape(shape), frame=frame, source=grid.source)
    return result, free.reshape(shape) & result.free


def turned_frame(frame: Frame, angle_rad: float) -> Frame:
    """A frame of the same cells, turned about the middle, as large as it must be; map points keep their places.

    The map frame stays: what turns to the left in the image is the map, so the image turns to the right in the map.
    """
    cos, sin = abs(math.cos(angle_rad)), abs(math.sin(angle_rad))
    # Rounding alone makes no further row.
    height = math.ceil(frame.height * cos + frame.width * sin - 1e-6)
    width = math.ceil(frame.width * cos + frame.height * sin - 1e-6)
    yaw_rad = frame.yaw_rad - angle_rad
    at_zero = Frame(height, width, frame.resolution_m, 0.0, 0.0, yaw_rad)
    middle_m = frame.world_from_cell(np.array([[frame.height - 1, frame.width - 1]]) / 2)
    x_m, y_m = (middle_m - at_zero.world_from_cell(np.array([[height - 1, width - 1]]) / 2))[0].tolist()
    return Frame(height, width, frame.resolution_m, x_m, y_m, yaw_rad)


def _mark_pinches(cells: NDArray[np.int8], frame: Frame, grid: OccupancyGrid) -> None:
    """Mark obstacle cells that touch at a corner only, in cells (h, w) of another frame, as neighbours again.

    A wall is nowhere else thinner than a cell, and free neighbours are not farther apart than that. Where the marks of
    both cells are apart the corner is marked as well: it is less than a cell from both.
    """
    one, other = _pinches(~grid.free)

    def marks(place: NDArray[Any]) -> Ints:
        at = _cells(frame.cell_from_world(grid.frame.world_from_cell(place)))
        return np.clip(at, 0, np.array(cells.shape) - 1)

    apart = np.abs(marks(one) - marks(other)).max(axis=1, initial=0) > 1
    of_one, of_other = grid.cells[tuple(one.T)], grid.cells[tuple(other.T)]
    # A corner is unknown if either cell is.
    values = np.concatenate([of_one, of_other, np.minimum(of_one, of_other)[apart]])
    row, col = np.concatenate([marks(one), marks(other), marks((one + other)[apart] / 2)]).T
    unknown = (values == UNKNOWN) & (cells[row, col] >= FREE) & (cells[row, col] <= FREE_TO)
    cells[row[unknown], col[unknown]] = UNKNOWN
    known = values != UNKNOWN
    np.maximum.at(cells, (row[known], col[known]), values[known])


def _pinches(solid: Mask) -> tuple[Ints, Ints]:
    """Pairs of solid cells, as (k, 2) and (k, 2), that share a corner only and whose common neighbours are free."""
    upper_left, upper_right, lower_left, lower_right = solid[:-1, :-1], solid[:-1, 1:], solid[1:, :-1], solid[1:, 1:]
    falling = np.argwhere(upper_left & lower_right & ~upper_right & ~lower_left)
    rising = np.argwhere(upper_right & lower_left & ~upper_left & ~lower_right)
    right, down = np.array([0, 1]), np.array([1, 0])
    return np.concatenate([falling, rising + right]), np.concatenate([falling + right + down, rising + down])


def _cells(points: NDArray[np.float64]) -> Ints:
    """The cells (k, 2) in which points (k, 2) lie; halves go up, so that points a cell apart are never two cells."""
    return np.floor(points + (0.5 + 1e-9)).astype(np.intp)
