"""Run-length encoded label images: sums over the cells of each label take a few thousand runs instead of all cells."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Ints = NDArray[np.int64]


@dataclass(frozen=True)
class Runs:
    """Maximal runs of one label within a row, in reading order, without label 0."""

    label: NDArray[np.int32]
    row: Ints
    begin: Ints
    """First column."""
    length: Ints

    def cells(self, count: int) -> Ints:
        """The number of cells (count,) of each label 1 to `count`."""
        return self._sums(self.length, count).astype(np.int64)

    def means(self, count: int) -> NDArray[np.float64]:
        """The mean row and col (count, 2) of each label 1 to `count`; 0, 0 for a label without cells."""
        middles = (self.row, self.begin + (self.length - 1) / 2)
        sums = [self._sums(middle * self.length, count) for middle in middles]
        return np.stack(sums, axis=1) / np.maximum(self._sums(self.length, count), 1)[:, None]

    def _sums(self, weights: NDArray[np.int64] | NDArray[np.float64], count: int) -> NDArray[np.float64]:
        sums = np.bincount(self.label, weights=weights, minlength=count + 1)[1 : count + 1]
        return sums.astype(np.float64, copy=False)


def runs_of(labels: NDArray[np.integer]) -> Runs:
    """The runs of a label image (h, w)."""
    height, width = labels.shape
    flat = labels.reshape(-1)
    starts = np.zeros(flat.size, np.bool_)
    np.not_equal(flat[1:], flat[:-1], out=starts[1:])
    starts[::width] = True
    begin = np.flatnonzero(starts)
    length = np.diff(np.append(begin, height * width))
    label = flat[begin].astype(np.int32, copy=False)
    begin, length, label = begin[label > 0], length[label > 0], label[label > 0]
    return Runs(label, begin // width, begin % width, length)
