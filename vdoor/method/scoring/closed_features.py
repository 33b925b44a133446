"""Features of a virtual door measured with the surest doors around it closed, so that no ray passes through them.

Otherwise a corridor would seem to widen beside the door of a room, as rays pass into the room.
"""

from __future__ import annotations

import copy

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage
from scipy.spatial import cKDTree

from vdoor.method.doors import VirtualDoors
from vdoor.method.scoring.segments import Segments
from vdoor.method.scoring.space_features import BESIDE, CLEARANCE, clearance, space_beside
from vdoor.raster.raycast import Padded

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Index = NDArray[np.intp]
Mask = NDArray[np.bool_]

SHUT = tuple(f"shut_{name}" for name in (*BESIDE, *CLEARANCE))
OWN_M = 0.6
"""A sure door whose middle is within this distance is in the same opening, and stays open for this door's rays."""
NONE, OPEN = -1, -2
"""Numbers for no closed door in a cell, and for no own door of a ray."""


def closed_features(
    free: Mask, door: Segments, doors: VirtualDoors, rows: Ints, sure: Index, *, distance: Padded
) -> Floats:
    """The values (k, features) of `SHUT` for segments (k,), which are `rows` of `doors`; `sure` (m,) are closed.

    `distance` is the result of `room_around`: closed doors do not reduce the distance to walls, they only stop rays.
    """
    number = np.full(len(doors.verdict), NONE, np.int32)
    number[rows[sure]] = np.arange(len(sure))
    on = number[doors.line_door] >= 0
    cell, owner = doors.line_cell[on], number[doors.line_door[on]]
    closed = np.full(free.shape, NONE, np.int32)
    np.maximum.at(closed, (cell[:, 0], cell[:, 1]), owner)
    # Thicken the lines: a ray could pass between cells that touch only at their corners.
    beside = ndimage.maximum_filter(closed, footprint=ndimage.generate_binary_structure(2, 1), mode="nearest")
    closed = np.where(closed >= 0, closed, beside)
    own = np.full(len(rows), OPEN, np.int32)
    if len(sure):
        away, nearest = cKDTree(door.middle[sure]).query(door.middle)
        own = np.where(away * door.cell_m < OWN_M, nearest, OPEN).astype(np.int32)
    space = ClosedSpace(free, closed, own)
    found = space_beside(space, door) | clearance(distance, space, door)
    return np.stack([found[name] for name in (*BESIDE, *CLEARANCE)], axis=1)


class ClosedSpace(Padded):
    """Free space with numbered doors closed, except for each ray (k,) the door in its own opening."""

    def __init__(self, free: Mask, closed: NDArray[np.int32], own: NDArray[np.int32]) -> None:
        super().__init__(free, False)
        self._closed = Padded(closed, NONE)
        self._own = own

    def at(self, row: NDArray[np.floating], col: NDArray[np.floating]) -> NDArray[np.generic]:
        """Whether points (k, ...) are free and not on a closed door."""
        closed = self._closed.at(row, col)
        own = self._own.reshape(-1, *[1] * (closed.ndim - 1))
        return np.asarray(super().at(row, col).astype(np.bool_) & ((closed == NONE) | (closed == own)))

    def of(self, part: slice) -> ClosedSpace:
        """The space for some of the rays."""
        some = copy.copy(self)
        some._own = self._own[part]  # noqa: SLF001  # same class
        return some
