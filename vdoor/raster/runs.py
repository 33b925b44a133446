"""Label images as runs of equal cells: what takes all cells of an image takes a hundredth as many runs."""

from __future__ import annotations

import functools
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vdoor.raster.components import components

Ints = NDArray[np.int64]
Mask = NDArray[np.bool_]
Box = tuple[slice, ...]


@dataclass(frozen=True, eq=False)
class Runs:
    """Maximal runs of one label within a row, in reading order, without label 0."""

    label: NDArray[np.int32]
    first: Ints
    """The flat index of the first cell."""
    length: Ints
    shape: tuple[int, int]

    @functools.cached_property
    def row(self) -> Ints:
        """The row of each run."""
        return self.first // self.shape[1]

    @functools.cached_property
    def begin(self) -> Ints:
        """The first column of each run."""
        return self.first % self.shape[1]

    @functools.cached_property
    def most(self) -> int:
        """The greatest label, 0 without runs."""
        return int(self.label.max(initial=0))

    def cells(self, count: int) -> Ints:
        """The number of cells (count,) of each label 1 to `count`."""
        return self._sums(self.length, count).astype(np.int64)

    def means(self, count: int) -> NDArray[np.float64]:
        """The mean row and col (count, 2) of each label 1 to `count`; 0, 0 for a label without cells."""
        middles = (self.row, self.begin + (self.length - 1) / 2)
        sums = [self._sums(middle * self.length, count) for middle in middles]
        return np.stack(sums, axis=1) / np.maximum(self._sums(self.length, count), 1)[:, None]

    def boxes(self, count: int) -> Ints:
        """First row, first column, and the row and column after the last (count, 4) of each label; 0 without cells."""
        found = np.zeros((count + 1, 4), np.int64)
        found[np.unique(self.label), :2] = max(self.shape)
        for side, values in enumerate((self.row, self.begin)):
            np.minimum.at(found[:, side], self.label, values)
        for side, values in enumerate((self.row + 1, self.begin + self.length), start=2):
            np.maximum.at(found[:, side], self.label, values)
        return found[1:]

    def first_cells(self, count: int) -> Ints:
        """The flat index (count,) of the first cell of each label 1 to `count`; -1 for a label without cells."""
        found = np.full(count + 1, -1, np.int64)
        found[self.label[::-1]] = self.first[::-1]
        return found[1:]

    def at(self, cell: Ints) -> NDArray[np.int32]:
        """The labels (k,) of cells given by flat index; fast if these are sorted."""
        if not len(self.first):
            return np.zeros(len(cell), np.int32)
        run = np.maximum(np.searchsorted(self.first, cell, "right") - 1, 0)
        away = cell - self.first[run]
        return np.where((away >= 0) & (away < self.length[run]), self.label[run], 0).astype(np.int32)

    def labelled(self, label: NDArray[np.int32]) -> Runs:
        """The runs with other labels (k,); with 0 among them they are good for `image` alone."""
        return Runs(label, self.first, self.length, self.shape)

    def chosen(self, wanted: Mask) -> Runs:
        """The runs of the labels (count + 1,) that are wanted."""
        kept = wanted[self.label]
        return Runs(self.label[kept], self.first[kept], self.length[kept], self.shape)

    def inside(self, box: Box) -> Runs:
        """The runs in a window, as an image of its own."""
        rows, columns = box
        some = slice(*np.searchsorted(self.row, (rows.start, rows.stop)))
        begin = np.maximum(self.begin[some], columns.start)
        length = np.minimum(self.begin[some] + self.length[some], columns.stop) - begin
        kept = length > 0
        shape = rows.stop - rows.start, columns.stop - columns.start
        first = (self.row[some][kept] - rows.start) * shape[1] + begin[kept] - columns.start
        return Runs(self.label[some][kept], first, length[kept], shape)

    def image(self) -> NDArray[np.int32]:
        """The label image (h, w)."""
        return self._painted(self.label)

    def mask(self) -> Mask:
        """The cells (h, w) of all runs."""
        return self._painted(np.ones(len(self.label), np.bool_))

    def flat(self) -> Ints:
        """The flat indices of all cells, sorted."""
        return consecutive(self.first, self.length)

    def _painted(self, value: NDArray[Any]) -> NDArray[Any]:
        """An image (h, w) of the value of each run."""
        ends = np.stack([self.first, self.first + self.length], axis=1).ravel()
        values = np.zeros(len(ends) + 1, value.dtype)
        values[1::2] = value
        whole = np.concatenate([[0], ends, [self.shape[0] * self.shape[1]]])
        return np.repeat(values, np.diff(whole)).reshape(self.shape)

    def _sums(self, weights: NDArray[np.int64] | NDArray[np.float64], count: int) -> NDArray[np.float64]:
        sums = np.bincount(self.label, weights=weights, minlength=count + 1)[1 : count + 1]
        return sums.astype(np.float64, copy=False)


def runs_of(labels: NDArray[np.integer] | Mask) -> Runs:
    """The runs of a label image or mask (h, w)."""
    height, width = labels.shape
    flat = labels.reshape(-1)
    starts = np.zeros(flat.size, np.bool_)
    np.not_equal(flat[1:], flat[:-1], out=starts[1:])
    starts[:: max(width, 1)] = True
    first = np.flatnonzero(starts)
    length = np.diff(np.append(first, height * width))
    label = flat[first].astype(np.int32)
    set_ = label > 0
    return Runs(label[set_], first[set_], length[set_], (height, width))


def parts_of_runs(runs: Runs, connectivity: int = 1) -> Runs:
    """The runs with their connected parts as labels, numbered from 1 in reading order of their first cells.

    Parts have one label each; they are 4-connected (1) or 8-connected (2).
    """
    # One column more than the raster has: no run reaches from the end of a row to the beginning of the next.
    stride = runs.shape[1] + 1
    begin = runs.row * stride + runs.begin
    end = begin + runs.length
    reach = connectivity - 1
    above = np.searchsorted(end + stride + reach, begin, "right")
    count = np.maximum(np.searchsorted(begin + stride - reach, end, "left") - above, 0)
    own = np.repeat(np.arange(len(begin)), count)
    other = consecutive(above, count)
    links = np.stack([own, other])
    if len(links[0]) and runs.most > int(runs.label.min()):
        links = links[:, runs.label[own] == runs.label[other]]
    return replace(runs, label=(components(links, len(begin)) + 1).astype(np.int32))


def parts_of_mask(mask: Mask, connectivity: int = 1) -> Runs:
    """The connected parts of a mask (h, w) as runs; see `parts_of_runs`."""
    return parts_of_runs(runs_of(mask), connectivity)


def beside(runs: Runs, cell: Ints) -> tuple[NDArray[np.int32], NDArray[np.intp]]:
    """Labels (k,) of the eight neighbours of cells given by flat index, and which cell (k,) each is beside."""
    width = runs.shape[1]
    column = cell % width
    labels, owners = [], []
    for down, right in ((-1, -1), (-1, 0), (-1, 1), (0, -1), (0, 1), (1, -1), (1, 0), (1, 1)):
        found = runs.at(cell + (down * width + right))
        at = np.flatnonzero((found > 0) & (column + right >= 0) & (column + right < width))
        labels.append(found[at])
        owners.append(at)
    return np.concatenate(labels), np.concatenate(owners)


def overlaid(runs: Runs, cell: Ints, label: NDArray[np.integer], wanted: Ints) -> NDArray[np.int32]:
    """The labels (k,) at the `wanted` cells: those of runs, but `label` (m,) on `cell` (m,), sorted flat indices."""
    found = runs.at(wanted)
    if len(cell):
        place = np.minimum(np.searchsorted(cell, wanted), len(cell) - 1)
        listed = cell[place] == wanted
        found[listed] = label[place[listed]]
    return found


def neighbours(cell: Ints, shape: tuple[int, ...]) -> tuple[Ints, NDArray[np.intp]]:
    """The 4-neighbours (k,) of cells in a raster, as flat indices, and of which cell (k,) each is one."""
    height, width = shape
    found, source = [], []
    for step, last_column in ((1, width - 1), (width, -1), (-1, 0), (-width, -1)):  # -1: no column is the last
        other = cell + step
        inside = np.flatnonzero((cell % width != last_column) & (other >= 0) & (other < height * width))
        found.append(other[inside])
        source.append(inside)
    return np.concatenate(found), np.concatenate(source)


def consecutive(first: NDArray[Any], count: NDArray[Any]) -> NDArray[Any]:
    """The numbers `first`, `first` + 1, ... of each range, one range after the other."""
    return np.asarray(np.repeat(first - (np.cumsum(count) - count), count) + np.arange(count.sum()))
