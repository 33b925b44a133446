"""The same place seen otherwise: turned, in larger cells, or with ragged walls and specks.

A changed map's frame says where it lies, so that points of the map frame stay what they are; truth is moved from
frame to frame (see `robustness`) and never drawn.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from vdoor.grid import FREE, OCCUPIED, OccupancyGrid
from vdoor.stages.simplify import any_in_block, resampled, working_frame
from vdoor.trials.turn import turned

Mask = NDArray[np.bool_]

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
    return Sheet(grid, any_in_block(sheet.free, factor) & grid.free)


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
