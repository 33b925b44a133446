"""Rays through a raster, many at once, and values of a raster at arbitrary points."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Mask = NDArray[np.bool_]

STEP = 0.6180339887
"""Distance between samples of a ray in cells: irrational, so that none falls exactly between two cells on an axis."""
CHUNK = 4_000_000  # samples processed at a time, to limit memory


class Padded:
    """A raster that can be read at any point (row, col); points outside it have the value `outside`."""

    def __init__(self, raster: NDArray[np.generic], outside: float | bool) -> None:
        self._hold(np.pad(raster, 1, constant_values=outside))

    def _hold(self, padded: NDArray[np.generic]) -> None:
        """Take a raster that has a margin of one cell."""
        self.raster = padded
        self.height, self.width = self.raster.shape
        self.flat = self.raster.reshape(-1)

    def at(self, row: NDArray[np.floating], col: NDArray[np.floating]) -> NDArray[np.generic]:
        """The values of the cells that contain the points, or `outside`."""
        # Halves are rounded up, not to even: otherwise the result would change if the map is shifted by one cell.
        r = np.clip(np.floor(row + 0.5).astype(np.int32) + 1, 0, self.height - 1)
        c = np.clip(np.floor(col + 0.5).astype(np.int32) + 1, 0, self.width - 1)
        return np.asarray(self.flat[r * self.width + c])

    def of(self, part: slice) -> Padded:  # noqa: ARG002  # all rays see the same raster here
        """The raster as seen by some of the rays that are cast together."""
        return self


def ray_lengths(inside: Padded, start: Floats, direction: Floats, reach: float) -> Floats:
    """Lengths (k,) in cells of rays from points (k, 2) along unit vectors (k, 2) through set cells, at most `reach`.

    The start cell need not be set. Lengths are multiples of half a cell.
    """
    steps = max(1, math.ceil(2 * reach))
    far = np.arange(1, steps + 1) / 2
    out = np.empty(len(start))
    at_once = max(1, CHUNK // steps)
    for begin in range(0, len(start), at_once):
        part = slice(begin, begin + at_once)
        row = start[part, 0, None] + direction[part, 0, None] * far
        col = start[part, 1, None] + direction[part, 1, None] * far
        blocked = ~inside.of(part).at(row, col).astype(np.bool_)
        first = np.where(blocked.any(axis=1), blocked.argmax(axis=1), steps)
        out[part] = first / 2
    return out
