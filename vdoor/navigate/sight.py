"""Whether the robot can go straight from one point to another: the exact distance from segments to squares."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from vdoor.navigate.space import Space
from vdoor.raster.strips import near_segments

Cell = tuple[int, int]
Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]

SLACK = 1e-9
"""Cells that are exactly as far away as the radius are not too near, whatever the rounding, in cells."""


class Sight:
    """Straight lines in a space; built once a map, since it counts the blocked cells before each cell."""

    def __init__(self, space: Space) -> None:
        self._radius = max(space.radius_m / space.frame.resolution_m - SLACK, SLACK)
        self._margin = math.ceil(self._radius) + 2
        self._allowed = space.allowed
        self._shape = np.array(space.blocked.shape)
        padded = np.pad(space.blocked, self._margin, constant_values=True)
        by_row, by_column = _counts(padded), _counts(padded.T)
        self._counts = np.concatenate([by_row.reshape(-1), by_column.reshape(-1)])
        self._begins = np.array([0, by_row.size])[:, None]
        self._widths = np.array([by_row.shape[1], by_column.shape[1]])[:, None]
        self._rows = np.array([len(by_row), len(by_column)])[:, None]

    def clear(self, start: Cell, end: Cell) -> bool:
        """Whether the straight way between two points on the map keeps the clearance."""
        return bool(self.all_clear(np.array([start], np.float64), np.array([end], np.float64))[0])

    def all_clear(self, start: Floats, end: Floats) -> Mask:
        """Whether each of the straight ways (k,) between points (k, 2) on the map keeps the clearance."""
        span = np.abs(end - start)
        steep = (span[:, 0] > span[:, 1]).astype(np.intp)  # these are seen along columns, which are fewer
        turned = steep[:, None] > 0
        first, begin, stop = near_segments(
            np.where(turned, start[:, ::-1], start), np.where(turned, end[:, ::-1], end), self._radius
        )
        row = np.minimum(first + self._margin + np.arange(begin.shape[1]), self._rows[steep] - 1)
        at = self._begins[steep] + row * self._widths[steep] + self._margin
        return np.asarray((self._counts[at + stop] == self._counts[at + begin]).all(axis=1))

    def fits(self, places: Floats) -> Mask:
        """Whether each of some cells (..., 2) is on the map and keeps the clearance."""
        cell = np.clip(places.astype(np.intp), 0, self._shape - 1)
        return np.asarray(self._allowed[cell[..., 0], cell[..., 1]] & (cell == places).all(axis=-1))


def _counts(blocked: Mask) -> NDArray[np.uint16]:
    """The number of blocked cells before each cell in its row, and at its end (h, w + 1), modulo 65,536."""
    counts = np.zeros((blocked.shape[0], blocked.shape[1] + 1), np.uint16)
    np.cumsum(blocked, axis=1, out=counts[:, 1:], dtype=np.uint16)
    return counts


def least_clearance(space: Space, points: Floats, *, most_m: float = 2.0) -> float:
    """The distance in metres from a path through points (k, 2), as row, col, to the nearest edge of a blocked cell.

    Exact up to `most_m`, which is what a path far from everything gets. One point is a path, too.
    """
    most = most_m / space.frame.resolution_m
    starts, ends = (points[:-1], points[1:]) if len(points) > 1 else (points, points)
    near = min(max(1.1 * space.radius_m / space.frame.resolution_m, 1.0), most)
    while True:  # as a rule a path comes as near to something as it may, so that few cells have to be looked at
        found = _least(space.blocked, starts, ends, near)
        if found < near or near >= most:
            return found * space.frame.resolution_m
        near = min(2 * near, most)


def _least(blocked: Mask, start: Floats, end: Floats, most: float) -> float:
    """The least distance of segments (k, 2) to blocked cells (h, w), in cells, `most` if none is nearer."""
    margin = math.ceil(most) + 2
    padded = np.pad(blocked, margin, constant_values=True)
    first, begin, stop = near_segments(start, end, most)
    count = (stop - begin).reshape(-1)
    run = np.repeat(np.arange(len(count)), count)
    of, down = np.divmod(run, begin.shape[1])
    col = np.arange(len(run)) - np.repeat(np.cumsum(count) - count - begin.reshape(-1), count)
    cell = np.stack([first[of, 0] + down, col], axis=1)
    held = np.flatnonzero(padded[tuple((cell + margin).T)])
    return float(_to_squares(cell[held], start[of[held]], end[of[held]]).min(initial=most))


CORNERS = np.array([(-0.5, -0.5), (-0.5, 0.5), (0.5, -0.5), (0.5, 0.5)])


def _to_squares(cells: NDArray[np.int64], start: Floats, end: Floats) -> Floats:
    """The distances from segments (k, 2) to squares that they do not cross: least at one of the ends or a corner."""
    along = end - start
    apart = cells[:, None] + CORNERS - start[:, None]
    share = (apart * along[:, None]).sum(axis=2) / np.maximum((along**2).sum(axis=1), SLACK**2)[:, None]
    beside = apart - np.clip(share, 0, 1)[..., None] * along[:, None]
    to_corners = np.sqrt((beside**2).sum(axis=2)).min(axis=1)
    to_ends = [np.hypot(*np.maximum(np.abs(cells - point) - 0.5, 0).T) for point in (start, end)]
    found: Floats = np.minimum(to_corners, np.minimum(*to_ends))
    return found
