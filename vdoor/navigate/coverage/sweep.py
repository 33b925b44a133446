"""The cells that a tool sweeps while its centre moves along straight segments."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import scipy
from numpy.typing import NDArray

Mask = NDArray[np.bool_]
Ints = NDArray[np.intp]
Floats = NDArray[np.float64]

EPSILON = 1e-9
"""Rounding errors of distances, in cells."""
SIGHT_STEP = 0.5
"""Distance between the points at which a line of sight is checked, in cells."""


class Swept(NamedTuple):
    """Pairs of a segment and a cell that it sweeps, sorted by segment, each once."""

    segment: Ints
    cell: Ints
    """Flat index into the map."""


class Interval(NamedTuple):
    """An interval of columns for each row looked at; empty where low > high."""

    low: Floats
    high: Floats


@dataclass(frozen=True, eq=False)
class Tool:
    """A round tool: it sweeps the free cells whose centres come within `reach` of its own centre."""

    reach: float
    """Half of its width, in cells."""
    blocked: Mask
    """Cells that stop it (h, w)."""
    hidden: bool
    """Whether it is wider than the robot: then it sweeps nothing that lies behind a blocked cell."""

    def swept(self, start: Floats, end: Floats) -> Swept:
        """The cells swept along segments, given their ends (k, 2) as row, col."""
        segment, row, columns = self._rows(start, end)
        first = np.maximum(np.ceil(columns.low - EPSILON), 0).astype(np.intp)
        last = np.minimum(np.floor(columns.high + EPSILON), self.blocked.shape[1] - 1).astype(np.intp)
        count = np.maximum(last - first + 1, 0)
        found = Swept(np.repeat(segment, count), consecutive(row * self.blocked.shape[1] + first, count))
        seen = ~self.blocked.reshape(-1)[found.cell]
        if self.hidden:
            seen &= self._seen(start, end, found)
        return Swept(found.segment[seen], found.cell[seen])

    def reachable(self, centres: Mask) -> Mask:
        """The cells (h, w) that the tool sweeps if its centre visits all of `centres` (h, w)."""
        near: Mask = scipy.ndimage.distance_transform_edt(~centres) <= self.reach + EPSILON
        if not self.hidden:
            return near & ~self.blocked
        found = np.zeros(self.blocked.size, np.bool_)
        at = np.argwhere(centres & scipy.ndimage.binary_dilation(self.blocked, iterations=int(self.reach) + 2)).astype(
            float
        )
        found[self.swept(at, at).cell] = True
        clear: Mask = scipy.ndimage.distance_transform_edt(~self.blocked) > self.reach + 2
        return found.reshape(near.shape) | (near & clear)

    def _rows(self, start: Floats, end: Floats) -> tuple[Ints, Ints, Interval]:
        """Each row that a segment's stadium meets: the segment, the row, and the columns in between."""
        top = np.maximum(np.ceil(np.minimum(start[:, 0], end[:, 0]) - self.reach - EPSILON), 0).astype(np.intp)
        bottom = np.floor(np.maximum(start[:, 0], end[:, 0]) + self.reach + EPSILON).astype(np.intp)
        count = np.maximum(np.minimum(bottom, self.blocked.shape[0] - 1) - top + 1, 0)
        segment, row = np.repeat(np.arange(len(start)), count), consecutive(top, count)
        a, b = start[segment], end[segment]
        # a stadium is convex, so its part of a row is the hull of the parts of two discs and a rectangle
        parts = (_disc(a, row, self.reach), _disc(b, row, self.reach), _rectangle(a, b, row, self.reach))
        low = np.minimum.reduce([part.low for part in parts])
        high = np.maximum.reduce([part.high for part in parts])
        met = low <= high
        return segment[met], row[met], Interval(low[met], high[met])

    def _seen(self, start: Floats, end: Floats, found: Swept) -> Mask:
        """Whether the straight line from the nearest point of the segment to the cell is free."""
        cell = np.stack(np.divmod(found.cell, self.blocked.shape[1]), axis=1).astype(np.float64)
        a, along = start[found.segment], (end - start)[found.segment]
        share = ((cell - a) * along).sum(axis=1) / np.maximum((along**2).sum(axis=1), EPSILON)
        nearest = a + np.clip(share, 0, 1)[:, None] * along
        seen = np.ones(len(cell), np.bool_)
        for part in np.linspace(0, 1, int(np.ceil(self.reach / SIGHT_STEP)) + 1)[:-1]:
            row, col = np.rint(nearest + part * (cell - nearest)).astype(np.intp).T
            seen &= ~self.blocked[row, col]
        return seen


def consecutive(first: Ints, count: Ints) -> Ints:
    """The numbers `first`, `first` + 1, ... of each range, one range after the other."""
    return np.repeat(first - (np.cumsum(count) - count), count) + np.arange(count.sum())


def _disc(centre: Floats, row: Ints, radius: float) -> Interval:
    squared = radius**2 - (row - centre[:, 0]) ** 2
    half = np.sqrt(np.maximum(squared, 0))
    half[squared < -EPSILON] = -np.inf
    return Interval(centre[:, 1] - half, centre[:, 1] + half)


def _rectangle(start: Floats, end: Floats, row: Ints, reach: float) -> Interval:
    """The columns within `reach` of the segment's line and between its ends."""
    along = end - start
    length = np.hypot(along[:, 0], along[:, 1])
    unit = along / np.maximum(length, EPSILON)[:, None]
    down = row - start[:, 0]
    beside = _between(unit[:, 0], -unit[:, 1] * down, -reach, np.full(len(row), reach))
    within = _between(unit[:, 1], unit[:, 0] * down, 0.0, length)
    low, high = np.maximum(beside.low, within.low), np.minimum(beside.high, within.high)
    empty = (low > high) | (length < EPSILON)
    return Interval(np.where(empty, np.inf, low + start[:, 1]), np.where(empty, -np.inf, high + start[:, 1]))


def _between(slope: Floats, offset: Floats, low: float, high: Floats) -> Interval:
    """The x with low <= slope x + offset <= high."""
    flat = np.abs(slope) < EPSILON
    divisor = np.where(flat, 1.0, slope)
    one, other = (low - offset) / divisor, (high - offset) / divisor
    everywhere = np.where((offset >= low - EPSILON) & (offset <= high + EPSILON), np.inf, -np.inf)
    return Interval(
        np.where(flat, -everywhere, np.minimum(one, other)), np.where(flat, everywhere, np.maximum(one, other))
    )
