"""Features of a virtual door measured with the surest doors around it closed, so that no ray passes through them.

Otherwise a corridor would seem to widen beside the door of a room, as rays pass into the room.
"""

from __future__ import annotations

import copy

import numpy as np
import scipy
from numpy.typing import NDArray

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
    closed = np.full(free.shape, NONE, np.min_scalar_type(-len(sure) - 1))
    np.maximum.at(closed, (cell[:, 0], cell[:, 1]), owner)
    thicken(closed, cell)
    own = np.full(len(rows), OPEN, np.int32)
    if len(sure):
        away, nearest = scipy.spatial.cKDTree(door.middle[sure]).query(door.middle)
        own = np.where(away * door.cell_m < OWN_M, nearest, OPEN).astype(np.int32)
    space = ClosedSpace(free, closed, own)
    found = space_beside(space, door) | clearance(distance, space, door)
    return np.stack([found[name] for name in (*BESIDE, *CLEARANCE)], axis=1)


def thicken(closed: NDArray[np.signedinteger], cell: NDArray[np.int32]) -> None:
    """Give open cells beside those of closed doors (k, 2) the greatest number of these, in place.

    Otherwise a ray could pass between cells that touch only at their corners.
    """
    own = closed[cell[:, 0], cell[:, 1]]
    edge: list[tuple[NDArray[np.signedinteger], ...]] = []
    for down, right in ((0, 1), (1, 0), (0, -1), (-1, 0)):
        row, col = cell.T + np.array([[down], [right]], np.int32)
        inside = (row >= 0) & (col >= 0) & (row < closed.shape[0]) & (col < closed.shape[1])
        row, col, number = row[inside], col[inside], own[inside]
        beside = closed[row, col] == NONE
        edge.append((row[beside], col[beside], number[beside]))
    for row, col, number in edge:  # after all were found, so that no new cell counts as a door's own
        np.maximum.at(closed, (row, col), number)


class ClosedSpace(Padded):
    """Free space with numbered doors closed, except for each ray (k,) the door in its own opening."""

    def __init__(self, free: Mask, closed: NDArray[np.signedinteger], own: NDArray[np.int32]) -> None:
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
