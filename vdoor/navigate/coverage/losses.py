"""How much area changes to a path lose, from sums along the rows of the raster, so that no cell is looked at.

What a segment sweeps of a row has no gaps, so what several segments sweep in common has none either. A change loses a
cell if as many segments sweep it as segments that sweep it go, and none sweeps it that comes. Cells that a tool wider
than the robot cannot reach past an obstacle count as swept here; `Polish` counts each change that it takes exactly.
"""

from __future__ import annotations

from itertools import combinations
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from vdoor.navigate.coverage.sweep import Tool

Ints = NDArray[np.intp]
Floats = NDArray[np.float64]
Counts = NDArray[np.int32]


class Segments(NamedTuple):
    """Segments of different changes."""

    change: Ints
    """The change of each (n,)."""
    start: Floats
    """Row, col on the map (n, 2)."""
    end: Floats


class Run(NamedTuple):
    """A stretch of each row that is looked at: first cell and the one behind the last, flat; none if not in order."""

    begin: Ints
    stop: Ints

    def within(self, other: Run) -> Run:
        """What both have in common."""
        return Run(np.maximum(self.begin, other.begin), np.minimum(self.stop, other.stop))

    def at(self, rows: Ints) -> Run:
        """Some of the rows."""
        return Run(self.begin[rows], self.stop[rows])

    def total(self, sums: Counts) -> Counts:
        """The sums over the cells of each row, given the sums of all cells before each cell, modulo 2 ** 32."""
        found: Counts = sums[np.maximum(self.stop, self.begin)] - sums[self.begin]
        return found


class Losses:
    """The rows of the raster that changes touch, with the runs of the segments that go and that come."""

    def __init__(self, tool: Tool, count: int, goes: list[Segments], comes: list[Segments]) -> None:
        every = [*goes, *comes]
        change = np.concatenate([part.change for part in every])
        at = tool.on_raster(np.concatenate([np.stack([part.start, part.end]) for part in every], axis=1))[..., 0]
        reach = tool.reach * tool.fine
        top, bottom = np.full(count, tool.blocked.shape[0]), np.zeros(count, np.intp)
        np.minimum.at(top, change, np.maximum(np.floor(at.min(axis=0) - reach), 0).astype(np.intp))
        np.maximum.at(bottom, change, np.ceil(at.max(axis=0) + reach).astype(np.intp))
        rows = np.maximum(np.minimum(bottom + 1, tool.blocked.shape[0]) - top, 0)
        self._change = np.repeat(np.arange(count), rows)
        self._first = np.cumsum(rows) - rows - top
        self._count = count
        self._goes, self._comes = ([self._runs(tool, part) for part in parts] for parts in (goes, comes))

    def _runs(self, tool: Tool, part: Segments) -> Run:
        """The runs of at most one segment a change, in all rows of the changes."""
        runs = tool.runs(part.start, part.end)
        place = self._first[part.change][runs.segment] + runs.row
        found = Run(np.zeros(len(self._change), np.intp), np.zeros(len(self._change), np.intp))
        found.begin[place], found.stop[place] = runs.begin, runs.stop
        return found

    def lost(self, times: Counts, counts: Counts) -> Floats:
        """What each change loses less what it wins (k,), if cells (n,) are swept so often and count as so many."""
        found = -self._won(_sums(np.where(times == 0, counts, 0)))
        for size in range(1, len(self._goes) + 1):
            sums = _sums(np.where(times == size, counts, 0))
            for together in combinations(self._goes, size):
                found += self._only(together, sums)
        return found

    def _only(self, together: tuple[Run, ...], sums: Counts) -> Floats:
        """What these segments sweep in common, and none that comes."""
        common = together[0]
        for other in together[1:]:
            common = common.within(other)
        rows = np.flatnonzero(common.begin < common.stop)
        common = common.at(rows)
        total = common.total(sums)
        one, other = (common.within(run.at(rows)) for run in self._comes)
        total += one.within(other).total(sums) - one.total(sums) - other.total(sums)
        return np.asarray(np.bincount(self._change[rows], total, minlength=self._count), np.float64)

    def _won(self, sums: Counts) -> Floats:
        """What the segments sweep that come, of the cells that are summed."""
        one, other = self._comes
        total = one.total(sums) + other.total(sums) - one.within(other).total(sums)
        return np.asarray(np.bincount(self._change, total, minlength=self._count), np.float64)


def _sums(count: Counts) -> Counts:
    """The sum of all before each cell and of all (n + 1,), modulo 2 ** 32."""
    sums = np.zeros(len(count) + 1, np.int32)
    np.cumsum(count, out=sums[1:], dtype=np.int32)
    return sums
