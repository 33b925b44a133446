"""The cells near straight segments, as one run of columns a row: exact, since cells are squares."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Ints = NDArray[np.int64]
Floats = NDArray[np.float64]

EPSILON = 1e-9
"""Rounding errors of positions, in cells."""


def near_segments(start: Floats, end: Floats, radius: float) -> tuple[Ints, Ints, Ints]:
    """The first rows (k, 1), and in each row (k, n) from there on the first column and the one after the last.

    Cells are the squares nearer than `radius` cells to a segment between two points (k, 2) as row, col. Rows without
    any have equal columns. Rows and columns may lie outside any map.
    """
    upper = (start[:, 0] <= end[:, 0])[:, None]
    low, high = np.where(upper, start, end), np.where(upper, end, start)
    first = np.floor(low[:, :1] - 0.5 - radius).astype(np.int64) + 1
    count = int((np.ceil(high[:, 0] + 0.5 + radius) - first[:, 0]).max(initial=0))
    rows = first + np.arange(count)
    to_left, to_right = _farthest(rows, low, high, radius)
    begin = np.floor(EPSILON - to_left).astype(np.int64) + 1
    stop = np.ceil(to_right - EPSILON).astype(np.int64)
    none = rows >= high[:, :1] + 0.5 + radius
    return first, begin, np.where(none, begin, np.maximum(stop, begin))


def _farthest(rows: Ints, low: Floats, high: Floats, radius: float) -> Floats:
    """The columns (2, k, n) at which cells of each row stop being near: to the left, sign changed, and to the right.

    A square is near if its centre lies in the segment widened by a square with rounded corners. At a height of `aside`
    above a point of the segment that shape is `_half_width(aside)` wide; the sum is concave along the segment.
    """
    down, across = (high - low).T[:, :, None]
    level = down == 0
    slope = np.where(level, 0.0, across / np.where(level, 1.0, down))
    best = np.sign(slope) * (0.5 + radius * np.abs(slope) / np.hypot(1.0, slope))
    above = rows - low[:, :1]
    aside = np.minimum(np.maximum(np.stack([best, -best]), above - down), above)
    beyond = np.stack([np.where(level, np.minimum(across, 0), 0), np.where(level, np.maximum(across, 0), 0)])
    column = low[:, 1:] + beyond + slope * (above - aside)
    found: Floats = column * np.array([-1.0, 1.0])[:, None, None] + _half_width(aside, radius)
    return found


def _half_width(aside: Floats, radius: float) -> Floats:
    """Half the width, at some heights, of a square of one cell widened by `radius`."""
    beyond = np.maximum(np.abs(aside) - 0.5, 0.0)
    found: Floats = 0.5 + np.sqrt(np.maximum(radius**2 - beyond**2, 0.0))
    return found
