"""Changed versions of a map: rotated, in larger cells, or with rough walls and specks.

The frame of a changed map is such that points of the map frame stay valid; the truth is transformed from frame to
frame (see `robustness`), not drawn.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from vdoor.frame import Frame
from vdoor.grid import FREE, FREE_TO, OCCUPIED, UNKNOWN, OccupancyGrid
from vdoor.method.simplify import any_of_block, resampled, working_frame

Mask = NDArray[np.bool_]
Ints = NDArray[np.intp]

COARSE_M = 0.10
NOISE, SPECKS = 0.15, 0.002
"""Fractions of the cells on walls' faces and of the free cells that are changed."""
AROUND = ((0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1), (1, 0), (1, 1))
"""Offsets of the eight neighbours in order around a cell, beginning with a 4-neighbour."""


class Sheet(NamedTuple):
    """A map, and its cells (h, w) that count as free in the measurement."""

    grid: OccupancyGrid
    free: Mask


class Change(NamedTuple):
    """A change of a map, with its name."""

    name: str
    make: Callable[[Sheet, np.random.Generator], Sheet]


def as_is(sheet: Sheet, _: np.random.Generator) -> Sheet:
    """The unchanged map."""
    return sheet


def turn(sheet: Sheet, _: np.random.Generator, *, angle_deg: float) -> Sheet:
    """The map rotated counter-clockwise."""
    return Sheet(*turned(sheet.grid, sheet.free, angle_deg))


def coarsen(sheet: Sheet, _: np.random.Generator, *, cell_m: float = COARSE_M) -> Sheet:
    """The map in cells of about `cell_m`: occupied if any finer cell is, else free if any finer cell is."""
    factor = max(1, round(cell_m / sheet.grid.frame.resolution_m))
    frame = working_frame(sheet.grid.frame, factor)
    grid = OccupancyGrid(cells=resampled(sheet.grid, factor), frame=frame, source=sheet.grid.source)
    return Sheet(grid, any_of_block(sheet.free, factor) & grid.free)


def roughen(sheet: Sheet, rng: np.random.Generator, *, noise: float = NOISE, specks: float = SPECKS) -> Sheet:
    """The map with cells on walls' faces flipped at random in both directions, and specks in free space.

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
    """Cells (h, w) that could each be freed without connecting separate free cells around it.

    The free cells around such a cell form one 4-connected piece: Yokoi's connectivity number is 1.
    """
    padded = np.pad(free, 1).astype(np.int8)
    height, width = free.shape
    ring = [padded[1 + down : 1 + down + height, 1 + right : 1 + right + width] for down, right in AROUND]
    pieces = sum(ring[k] - ring[k] * ring[k + 1] * ring[(k + 2) % 8] for k in (0, 2, 4, 6))
    return np.asarray(pieces == 1)


def _beside(mask: Mask) -> Mask:
    """Cells with a cell of the mask among their four neighbours."""
    padded = np.pad(mask, 1)
    return padded[2:, 1:-1] | padded[:-2, 1:-1] | padded[1:-1, 2:] | padded[1:-1, :-2]


CHANGES = (
    Change("unchanged", as_is),
    Change("rotated by 5 degrees", functools.partial(turn, angle_deg=5.0)),
    Change("rotated by 15 degrees", functools.partial(turn, angle_deg=15.0)),
    Change("rotated by 30 degrees", functools.partial(turn, angle_deg=30.0)),
    Change("rotated by 45 degrees", functools.partial(turn, angle_deg=45.0)),
    Change("cells of 10 cm", coarsen),
    Change("wall noise and specks", roughen),
)
"""All changes; the first one is the baseline of the comparison."""


def turned(grid: OccupancyGrid, measured: Mask, angle_deg: float) -> tuple[OccupancyGrid, Mask]:
    """The map rotated counter-clockwise about its middle, on a canvas large enough for it, and its measured free cells.

    Each cell has the value of the nearest original cell, unknown outside. Cells of a wall that only touch at a corner
    are marked again at their new positions, so that no wall opens.
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
    """A frame with cells of the same size, rotated about the middle and large enough for the whole map.

    Points of the map frame stay valid: the map turns counter-clockwise in the image, so the image turns clockwise in
    the map frame.
    """
    cos, sin = abs(math.cos(angle_rad)), abs(math.sin(angle_rad))
    # No additional row from rounding errors.
    height = math.ceil(frame.height * cos + frame.width * sin - 1e-6)
    width = math.ceil(frame.width * cos + frame.height * sin - 1e-6)
    yaw_rad = frame.yaw_rad - angle_rad
    at_zero = Frame(height, width, frame.resolution_m, 0.0, 0.0, yaw_rad)
    middle_m = frame.world_from_cell(np.array([[frame.height - 1, frame.width - 1]]) / 2)
    x_m, y_m = (middle_m - at_zero.world_from_cell(np.array([[height - 1, width - 1]]) / 2))[0].tolist()
    return Frame(height, width, frame.resolution_m, x_m, y_m, yaw_rad)


def _mark_pinches(cells: NDArray[np.int8], frame: Frame, grid: OccupancyGrid) -> None:
    """Mark pairs of obstacle cells that touch only at a corner, in cells (h, w) of another frame, as neighbours again.

    Elsewhere a wall is at least one cell thick, so it stays closed. If the marks of both cells are not adjacent, the
    corner is marked as well: it is less than a cell from both.
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
    """Pairs of solid cells, as (k, 2) and (k, 2), that only share a corner and whose common neighbours are free."""
    upper_left, upper_right, lower_left, lower_right = solid[:-1, :-1], solid[:-1, 1:], solid[1:, :-1], solid[1:, 1:]
    falling = np.argwhere(upper_left & lower_right & ~upper_right & ~lower_left)
    rising = np.argwhere(upper_right & lower_left & ~upper_left & ~lower_right)
    right, down = np.array([0, 1]), np.array([1, 0])
    return np.concatenate([falling, rising + right]), np.concatenate([falling + right + down, rising + down])


def _cells(points: NDArray[np.float64]) -> Ints:
    """Cells (k, 2) that contain points (k, 2); halves round up, so that points one cell apart never skip a cell."""
    return np.floor(points + (0.5 + 1e-9)).astype(np.intp)
