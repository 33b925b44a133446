"""The cells that a tool sweeps while its centre moves along straight segments."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
import scipy
from numpy.typing import NDArray

from vdoor.raster.runs import consecutive

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


class Stretches(NamedTuple):
    """Stretches of rows of the raster near segments, sorted by segment; some are empty."""

    segment: Ints
    row: Ints
    begin: Ints
    """First cell, as a flat index."""
    stop: Ints
    """The cell behind the last one."""


class Interval(NamedTuple):
    """An interval of columns for each row looked at; empty where low > high."""

    low: Floats
    high: Floats


@dataclass(frozen=True, eq=False)
class Tool:
    """A round tool: it sweeps the free cells of its raster whose centres come within `reach` of its own centre.

    Lengths and points are in cells of the map; the raster on which it is counted what is swept may be finer.
    """

    reach: float
    """Half of its width."""
    radius: float
    """The clearance that its centre keeps. A wider tool sweeps nothing that lies behind a blocked cell."""
    blocked: Mask
    """Cells of the raster that stop it (h, w)."""
    fine: int = 1
    """How many cells of the raster lie along a cell of the map."""

    @classmethod
    def on(cls, blocked: Mask, fine: int, *, reach: float, radius: float) -> Tool:
        """A tool on a map with blocked cells (h, w), each of which becomes `fine` by `fine` cells of the raster."""
        return cls(reach, radius, finer(blocked, fine), fine)

    def on_raster(self, point: Floats) -> Floats:
        """Points (k, 2) of the map as row, col of the raster."""
        return np.asarray((point + 0.5) * self.fine - 0.5)

    def on_map(self, point: Floats) -> Floats:
        """Points (k, 2) of the raster as row, col of the map."""
        return np.asarray((point + 0.5) / self.fine - 0.5)

    def swept(self, start: Floats, end: Floats) -> Swept:
        """The cells of the raster that are swept along segments, given their ends (k, 2) as row, col of the map."""
        segment, _, begin, stop = self.runs(start, end)
        start, end = self.on_raster(start), self.on_raster(end)
        found = Swept(np.repeat(segment, stop - begin), consecutive(begin, stop - begin))
        seen = ~self.blocked.reshape(-1)[found.cell]
        if self.reach > self.radius:
            # nothing is blocked within the radius of the centre, or near a cell far from everything
            doubt = np.flatnonzero(seen & (self._free[found.cell] < self.fine * (self.reach - self.radius)))
            seen[doubt] = self._seen(start, end, Swept(found.segment[doubt], found.cell[doubt]))
        return Swept(found.segment[seen], found.cell[seen])

    def runs(self, start: Floats, end: Floats) -> Stretches:
        """The cells of the raster near segments, free or not, given their ends (k, 2) as row, col of the map."""
        segment, row, columns = self._rows(self.on_raster(start), self.on_raster(end))
        width = self.blocked.shape[1]
        first = np.maximum(np.ceil(columns.low - EPSILON), 0).astype(np.intp)
        behind = np.minimum(np.floor(columns.high + EPSILON) + 1, width).astype(np.intp)
        return Stretches(segment, row, row * width + first, row * width + np.maximum(behind, first))

    def reachable(self, start: Floats, end: Floats) -> Mask:
        """The cells of the raster (h, w) that can be swept from within rings, given their sides (k, 2)."""
        found = inside_rings(self.on_raster(start), self.on_raster(end), self.blocked.shape) & ~self.blocked
        if self.reach > self.radius:  # what a side's nearest point does not see another of its points may
            start, end = _split(start, end)
        found.reshape(-1)[self.swept(start, end).cell] = True
        return found

    def _rows(self, start: Floats, end: Floats) -> tuple[Ints, Ints, Interval]:
        """Each row that a segment's stadium meets: the segment, the row, and the columns in between."""
        reach = self.reach * self.fine
        top = np.maximum(np.ceil(np.minimum(start[:, 0], end[:, 0]) - reach - EPSILON), 0).astype(np.intp)
        bottom = np.floor(np.maximum(start[:, 0], end[:, 0]) + reach + EPSILON).astype(np.intp)
        count = np.maximum(np.minimum(bottom, self.blocked.shape[0] - 1) - top + 1, 0)
        segment, row = np.repeat(np.arange(len(start)), count), consecutive(top, count)
        a, b = start[segment], end[segment]
        # a stadium is convex, so its part of a row is the hull of the parts of two discs and a rectangle
        parts = (_disc(a, row, reach), _disc(b, row, reach), _rectangle(a, b, row, reach))
        low = np.minimum.reduce([part.low for part in parts])
        high = np.maximum.reduce([part.high for part in parts])
        met = low <= high
        return segment[met], row[met], Interval(low[met], high[met])

    @cached_property
    def _free(self) -> Floats:
        """How far each cell (h w,) is at least from the nearest blocked one, from centre to edge, in the raster."""
        return np.asarray(scipy.ndimage.distance_transform_edt(~self.blocked) - math.sqrt(0.5)).reshape(-1)

    def _seen(self, start: Floats, end: Floats, found: Swept) -> Mask:
        """Whether the straight line from the nearest point of the segment to the cell is free."""
        cell = np.stack(np.divmod(found.cell, self.blocked.shape[1]), axis=1).astype(np.float64)
        a, along = start[found.segment], (end - start)[found.segment]
        share = ((cell - a) * along).sum(axis=1) / np.maximum((along**2).sum(axis=1), EPSILON)
        nearest = a + np.clip(share, 0, 1)[:, None] * along
        apart = np.sqrt(((cell - nearest) ** 2).sum(axis=1))
        seen = np.asarray(self._free[found.cell] + self.radius * self.fine >= apart)
        doubt = np.flatnonzero(~seen)
        seen[doubt] = self._line_free(nearest[doubt], cell[doubt])
        return seen

    def _line_free(self, start: Floats, end: Floats) -> Mask:
        """Whether no point of the lines (k,) that is looked at lies in a blocked cell."""
        free = np.ones(len(start), np.bool_)
        for part in np.linspace(0, 1, int(np.ceil(self.reach * self.fine / SIGHT_STEP)) + 1)[:-1]:
            left = np.flatnonzero(free)
            row, col = np.rint(start[left] + part * (end[left] - start[left])).astype(np.intp).T
            free[left] = ~self.blocked[row, col]
        return free


def finer(mask: Mask, times: int) -> Mask:
    """A mask with so many times the rows and columns."""
    return mask if times == 1 else mask.repeat(times, axis=0).repeat(times, axis=1)


def inside_rings(start: Floats, end: Floats, shape: tuple[int, ...]) -> Mask:
    """The cells of a raster (h, w) whose centres lie within closed rings and not in their holes.

    `start` and `end` (k, 2) are the ends of all sides, as row, col.
    """
    upper = (start[:, 0] <= end[:, 0])[:, None]
    low, high = np.where(upper, start, end), np.where(upper, end, start)
    first, behind = (np.clip(np.ceil(ends[:, 0]), 0, shape[0]).astype(np.intp) for ends in (low, high))
    side, row = np.repeat(np.arange(len(low)), behind - first), consecutive(first, behind - first)
    span = (high - low)[side]
    column = low[side, 1] + (row - low[side, 0]) / span[:, 0] * span[:, 1]
    at = row * (shape[1] + 1) + np.clip(np.ceil(column), 0, shape[1]).astype(np.intp)
    crossed = np.bincount(at, minlength=shape[0] * (shape[1] + 1)).astype(np.uint8).reshape(shape[0], -1)
    return np.asarray(np.cumsum(crossed, axis=1, dtype=np.uint8)[:, :-1] % 2 == 1)


def _split(start: Floats, end: Floats) -> tuple[Floats, Floats]:
    """Segments cut into pieces of at most a cell."""
    count = np.maximum(np.ceil(np.hypot(*(end - start).T)), 1).astype(np.intp)
    of, number = np.repeat(np.arange(len(count)), count), consecutive(np.zeros_like(count), count)
    step = ((end - start) / count[:, None])[of]
    first = start[of] + number[:, None] * step
    return first, first + step


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
