"""The cells near a straight segment, as one run of columns a row: exact, since cells are squares."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

Ints = NDArray[np.int64]
Floats = NDArray[np.float64]

EPSILON = 1e-9
"""Rounding errors of positions, in cells."""


def near_segment(start: tuple[float, float], end: tuple[float, float], radius: float) -> tuple[int, Ints, Ints]:
    """The first row, and in each row from there on the first column and the one after the last, of the cells.

    Cells are the squares nearer than `radius` cells to the segment between two points (row, col); rows without any
    have equal columns. Rows and columns may lie outside any map.
    """
    (row, col), (end_row, end_col) = start, end
    reach = 0.5 + radius
    first = math.floor(min(row, end_row) - reach) + 1
    rows = np.arange(first, math.ceil(max(row, end_row) + reach))
    begin = -_farthest(rows, (row, -col), (end_row, -end_col), radius)
    last = _farthest(rows, (row, col), (end_row, end_col), radius)
    from_col = np.floor(begin + EPSILON).astype(np.int64) + 1
    to_col = np.ceil(last - EPSILON).astype(np.int64)
    return first, from_col, np.maximum(to_col, from_col)


def _farthest(rows: Ints, start: tuple[float, float], end: tuple[float, float], radius: float) -> Floats:
    """The column (k,) at which cells of each row stop being near, to the right.

    A square is near if its centre lies in the segment widened by a square with rounded corners. At a height of `aside`
    above a point of the segment that shape is `_half_width(aside)` wide; the sum is concave along the segment.
    """
    (row, col), (end_row, end_col) = start, end
    if end_row == row:
        return np.asarray(max(col, end_col) + _half_width(rows - row, radius))
    slope = (end_col - col) / (end_row - row)
    best = math.copysign(0.5 + radius * abs(slope) / math.hypot(1, slope), -slope) if slope else 0.0
    low, high = rows - max(row, end_row), rows - min(row, end_row)
    aside = np.clip(best, low, high)
    return np.asarray(col + slope * (rows - aside - row) + _half_width(aside, radius))


def _half_width(aside: NDArray[Any], radius: float) -> Floats:
    """Half the width, at some heights, of a square of one cell widened by `radius`."""
    beyond = np.maximum(np.abs(aside) - 0.5, 0.0)
    return np.asarray(0.5 + np.sqrt(np.maximum(radius**2 - beyond**2, 0.0)))
