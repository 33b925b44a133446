"""Where the robot's centre may be: a hard clearance, measured from the edges of the cells that it must not touch.

Obstacles are whole cells, so distances are measured to squares. Two facts make a path over cell centres safe along its
whole length, not only at the centres: a step to a neighbour in the same row or column comes nearest to every square at
one of its ends; a diagonal step does so at an end or in its middle, which is a corner of four cells. So cells and
their corners are checked, once for a map.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy
from numpy.typing import NDArray

from vdoor.frame import Frame
from vdoor.raster.components import components

Mask = NDArray[np.bool_]
Ints = NDArray[np.int32]
Floats = NDArray[np.float64]

EPSILON = 1e-9
"""Rounding errors of distances, in cells."""


@dataclass(frozen=True, eq=False)
class Space:
    """The cells that the robot's centre may pass, and the diagonal steps between them."""

    frame: Frame
    blocked: Mask
    """Cells that the robot must not touch (h, w)."""
    radius_m: float
    """The clearance that is kept, from the centre to the edge of any blocked cell."""
    allowed: Mask
    """Cells whose centre keeps the clearance (h, w)."""
    crossing: Mask
    """Corners of cells that keep the clearance (h - 1, w - 1): [r, c] lies between cells [r, c] and [r+1, c+1]. Both
    diagonal steps through a corner are possible if it does."""

    @classmethod
    def of(cls, blocked: Mask, frame: Frame, radius_m: float) -> Space:
        """The space of a robot of that radius; everything outside the map is blocked."""
        radius = radius_m / frame.resolution_m
        return cls(frame, blocked, radius_m, ~grown(blocked, radius, 0.0), ~grown(blocked, radius, 0.5))

    @cached_property
    def parts(self) -> Ints:
        """The connected part of each allowed cell (h, w), numbered from 1 in reading order; 0 elsewhere."""
        label, count = scipy.ndimage.label(self.allowed)
        one, other = label[:-1], label[1:]
        links = [(one[:, :-1], other[:, 1:]), (one[:, 1:], other[:, :-1])]
        pairs = [np.stack([a[self._joined(a, b)], b[self._joined(a, b)]]) for a, b in links]
        part = components(np.concatenate(pairs, axis=1).astype(np.intp) - 1, count)
        return np.asarray(np.concatenate([[0], part + 1]).astype(np.int32)[label])

    def _joined(self, one: NDArray[np.integer], other: NDArray[np.integer]) -> Mask:
        return np.asarray(self.crossing & (one > 0) & (other > 0) & (one != other))

    def graph(self, cells: Mask) -> tuple[scipy.sparse.csr_array, Ints]:
        """The steps between some allowed cells (h, w) as a graph weighted by length in metres, and each cell's node.

        Nodes (h, w) are numbered in reading order; -1 for other cells. Each step appears in both directions.
        """
        node = np.full(cells.shape, -1, np.int32)
        node[cells] = np.arange(np.count_nonzero(cells), dtype=np.int32)
        starts, ends, lengths = [], [], []
        for one, other, possible, length in self._steps(node):
            taken = possible & (one >= 0) & (other >= 0)
            starts.append(one[taken])
            ends.append(other[taken])
            lengths.append(np.full(len(starts[-1]), length * self.frame.resolution_m))
        start, end, length_m = (np.concatenate(part) for part in (starts, ends, lengths))
        both = (np.concatenate([start, end]), np.concatenate([end, start]))
        count = int(np.count_nonzero(cells))
        return scipy.sparse.coo_array((np.tile(length_m, 2), both), shape=(count, count)).tocsr(), node

    def _steps(self, node: Ints) -> list[tuple[Ints, Ints, Mask, float]]:
        """Neighbours right, down, and on both diagonals: their nodes, whether the step is possible, its length."""
        across, down = np.ones_like(node[:, 1:], np.bool_), np.ones_like(node[1:], np.bool_)
        return [
            (node[:, :-1], node[:, 1:], across, 1.0),
            (node[:-1], node[1:], down, 1.0),
            (node[:-1, :-1], node[1:, 1:], self.crossing, 2.0**0.5),
            (node[:-1, 1:], node[1:, :-1], self.crossing, 2.0**0.5),
        ]


def grown(blocked: Mask, radius: float, offset: float = 0.0) -> Mask:
    """The lattice points nearer than `radius` cells to a blocked cell: centres (offset 0) or inner corners (0.5).

    Everything outside the map is blocked.
    """
    pad = int(np.ceil(radius)) + 1
    padded = np.pad(blocked, pad, constant_values=True)
    reach = np.arange(-pad, pad + 1) - offset  # from a point to cell rows, or columns
    to_edge = np.maximum(np.abs(reach) - 0.5, 0)
    height, width = (side - round(2 * offset) for side in blocked.shape)
    grown = np.zeros((height, width), np.bool_)
    for row, gap in enumerate(to_edge):
        columns = np.flatnonzero(gap**2 + to_edge**2 < radius**2 - EPSILON)
        if len(columns):
            grown |= _any_of(padded[row:][:height], int(columns[0]), len(columns), width)
    return grown


def _any_of(strip: Mask, first: int, length: int, width: int) -> Mask:
    """Whether any of `length` cells in the row, from `first` cells on, is set: for `width` places in a row."""
    sums = np.zeros((strip.shape[0], strip.shape[1] + 1), np.int32)
    np.cumsum(strip, axis=1, out=sums[:, 1:], dtype=np.int32)
    return sums[:, first + length :][:, :width] > sums[:, first:][:, :width]
