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
