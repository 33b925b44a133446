"""Features of a virtual door with the surest doors around it closed, so that no ray escapes through them.

Across a corridor, at the jamb of a room's door, the space seems to widen: a ray passes into the room.
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
"""A sure door with its middle this near stands in the same opening, and is open for the rays from there."""
NONE, OPEN = -1, -2


def shut_features(
    free: Mask, door: Segments, doors: VirtualDoors, rows: Ints, sure: Index, *, distance: Padded
) -> Floats:
    """The values (k, features) of `SHUT` for segments (k,), which are `rows` of `doors`; `sure` (m,) are closed.

    `distance` is that of `room_around`: closed doors make no room narrower, they only end rays.
    """
    number = np.full(len(doors.verdict), NONE, np.int32)
    number[rows[sure]] = np.arange(len(sure))
    on = number[doors.line_door] >= 0
    cell, owner = doors.line_cell[on], number[doors.line_door[on]]
    shut = np.full(free.shape, NONE, np.int32)
    np.maximum.at(shut, (cell[:, 0], cell[:, 1]), owner)
    # A line of cells that touch at their corners alone does not end a ray that passes between them.
    beside = ndimage.maximum_filter(shut, footprint=ndimage.generate_binary_structure(2, 1), mode="nearest")
    shut = np.where(shut >= 0, shut, beside)
    own = np.full(len(rows), OPEN, np.int32)
    if len(sure):
        away, nearest = cKDTree(door.middle[sure]).query(door.middle)
        own = np.where(away * door.cell_m < OWN_M, nearest, OPEN).astype(np.int32)
    space = ShutSpace(free, shut, own)
    found = space_beside(space, door) | clearance(distance, space, door)
    return np.stack([found[name] for name in (*BESIDE, *CLEARANCE)], axis=1)


class ShutSpace(Padded):
    """Free space in which numbered doors are closed, but for each ray (k,) its own one."""

    def __init__(self, free: Mask, shut: NDArray[np.int32], own: NDArray[np.int32]) -> None:
        super().__init__(free, False)
        self._shut = Padded(shut, NONE)
        self._own = own

    def at(self, row: NDArray[np.floating], col: NDArray[np.floating]) -> NDArray[np.generic]:
        """Whether places (k, ...) are free, and of no closed door."""
        shut = self._shut.at(row, col)
        own = self._own.reshape(-1, *[1] * (shut.ndim - 1))
        return np.asarray(super().at(row, col).astype(np.bool_) & ((shut == NONE) | (shut == own)))

    def of(self, part: slice) -> ShutSpace:
        """The same for some of the rays."""
        some = copy.copy(self)
        some._own = self._own[part]  # noqa: SLF001  # its own class
        return some
