"""The floor of one room for a roadmap: where the robot may stand, and what it can reach straight."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
import scipy
from numpy.typing import NDArray

from vdoor.frame import Frame
from vdoor.navigate.sight import Sight, least_clearance
from vdoor.navigate.space import Space

Ints = NDArray[np.int32]
Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]
Point = tuple[float, float]
Box = tuple[slice, ...]

TOUCH = 1e-3
"""Lines stay so far off the cells that are not the room's, in cells."""
POCKET_M2 = 0.5
"""Smaller pieces of floor behind places that are too narrow for the robot get no nodes."""


class Spots(NamedTuple):
    """Places on a floor."""

    point: Floats
    """Row, col (k, 2)."""
    eye: Floats
    """The same, but just within the room for a place in a door, on the border to another room."""

    @classmethod
    def at_cells(cls, cells: NDArray[np.integer]) -> Spots:
        """The centres of cells (k, 2)."""
        point = cells.astype(np.float64)
        return cls(point, point)

    def of(self, chosen: NDArray[np.integer]) -> Spots:
        """Some of the places (k,)."""
        return Spots(self.point[chosen], self.eye[chosen])


@dataclass(frozen=True, eq=False)
class Floor:
    """A crop of the map around one room; points are row, col of the crop."""

    frame: Frame
    """The map's frame: its resolution counts, its place does not."""
    corner: Ints
    """Row, col (2,) of the crop's upper left cell in the map."""
    blocked: Mask
    """What the robot must not touch (h, w): walls, and not other rooms."""
    own: Mask
    """The cells of the room (h, w) that are not blocked."""
    clear: Space
    """Where the robot keeps the clearance from what is blocked."""
    allowed: Mask
    """The cells of the room (h, w) that keep the clearance and are worth nodes."""

    @classmethod
    def of(cls, blocked: Mask, room: Mask, box: Box, frame: Frame, clearance_m: float) -> Floor:
        """The floor of a room's cells (h, w), which lie in a box of the map."""
        margin = math.ceil(clearance_m / frame.resolution_m) + 2
        part = tuple(slice(max(side.start - margin, 0), side.stop + margin) for side in box)
        walls, own = blocked[part], room[part] & ~blocked[part]
        clear = Space.of(walls, frame, clearance_m)
        corner = np.array([side.start for side in part], np.int32)
        return cls(frame, corner, walls, own, clear, clear.allowed & own)

    def without_pockets(self, seeds: Sequence[Point]) -> Floor:
        """The floor whose allowed cells are those in pieces of some size, and in those that hold a seed."""
        label, count = scipy.ndimage.label(self.allowed, np.ones((3, 3)))
        kept = np.bincount(label.ravel(), minlength=count + 1) >= POCKET_M2 / self.frame.resolution_m**2
        for seed in seeds:
            kept[label[cell_of(seed)]] = True
        kept[0] = False
        return replace(self, allowed=kept[label])

    def seen_from_map(self, place: Point) -> Point:
        """The point of the floor at a place of the map."""
        row, col = (np.array(place) - self.corner).tolist()
        return row, col

    def holds(self, point: Point) -> bool:
        """Whether the cell of a point is allowed."""
        return bool(self.allowed[cell_of(point)])

    @cached_property
    def clearance(self) -> Floats:
        """The distance (h, w) in cells from each cell's centre to the nearest blocked one, or to the map's edge."""
        inside: Floats = scipy.ndimage.distance_transform_edt(np.pad(~self.blocked, 1))
        return inside[1:-1, 1:-1] - 0.5

    @cached_property
    def within(self) -> Space:
        """The room's own cells, without clearance."""
        return Space.of(~self.own, self.frame, TOUCH * self.frame.resolution_m)

    @cached_property
    def _sights(self) -> tuple[Sight, Sight]:
        return Sight(self.clear), Sight(self._around)

    @cached_property
    def _around(self) -> Space:
        """The room and the next cells of other rooms: a door askew is a border of teeth, along which one can see."""
        cells = scipy.ndimage.binary_dilation(self.own, np.ones((3, 3), np.bool_)) & ~self.blocked
        return Space.of(~cells, self.frame, self.within.radius_m)

    def stays(self, start: Floats, end: Floats) -> Mask:
        """Whether each of the straight ways (k,) between points (k, 2) stays in the room, to a cell."""
        return self._sights[1].all_clear(start, end)

    def sees(self, start: Spots, end: Spots) -> Mask:
        """Whether each of the straight ways (k,) between spots stays in the room and keeps the clearance."""
        found = self._sights[0].all_clear(start.point, end.point)
        found[found] = self.stays(start.eye[found], end.eye[found])
        return found

    def clearance_m(self, points: Floats) -> float:
        """What a path through points (k, 2) keeps, at most the clearance asked for."""
        margin = math.ceil(self.clear.radius_m / self.frame.resolution_m) + 2
        low = np.maximum(np.floor(points.min(axis=0)).astype(int) - margin, 0)
        high = np.ceil(points.max(axis=0)).astype(int) + margin + 1
        part = Space.of(self.blocked[low[0] : high[0], low[1] : high[1]], self.frame, 0.0)
        return least_clearance(part, points - low, most_m=self.clear.radius_m)


def cell_of(point: Point) -> tuple[int, int]:
    """The cell that contains a point given as row, col."""
    return math.floor(point[0] + 0.5), math.floor(point[1] + 0.5)
