"""Narrow places: points of the skeleton that are closest to walls on both sides."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, ClassVar

import numpy as np
import scipy
import skimage
from numpy.typing import NDArray

from vdoor.baselines.skeleton import Skeleton
from vdoor.config import Within
from vdoor.frame import Frame
from vdoor.grid import FREE
from vdoor.method.simplify import SimplifiedGrid, touches
from vdoor.record import Record, Spec

Ints = NDArray[np.int32]
Mask = NDArray[np.bool_]
Raster = NDArray[np.float64]

FATES = ("narrow", "too wide", "one-sided")
NARROW = FATES.index("narrow")
EPSILON = 1e-9
AROUND = np.ones((3, 3), np.bool_)


class CriticalLines(Record):
    """Local minima of the skeleton's clearance and the walls nearest to them; `fate` is why some are rejected."""

    topic: ClassVar[str] = "narrows"

    cell: Annotated[NDArray[np.int32], Spec("cell", "narrow 2")]
    clearance_m: Annotated[NDArray[np.float64], Spec("column", "narrow", unit="m", tolerance=1e-9)]
    fate: Annotated[NDArray[np.uint8], Spec("code", "narrow", words=FATES)]
    start: Annotated[NDArray[np.int32], Spec("column", "narrow 2", unit="cells")]
    """The nearest cell that is not free; the narrow place's own cell if it is too wide."""
    end: Annotated[NDArray[np.int32], Spec("column", "narrow 2", unit="cells")]
    """The nearest one on the opposite side, visible or not; equal to `start` if there is none within reach."""
    frame: Frame


@dataclass(frozen=True, kw_only=True)
class FindCriticalLines:
    """Keep the narrowest points of the skeleton that have walls on opposite sides."""

    within_m: Annotated[float, Within(0, 100)] = 0.5
    """A narrow place has the smallest clearance within this distance along the skeleton."""
    max_length_m: Annotated[float, Within(0, 20)] = 1.2
    """Upper limit of twice the clearance, and of the distance between the two walls."""
    apart_deg: Annotated[float, Within(0, 180)] = 120.0
    """Two walls are on opposite sides if the angle between their directions is at least this."""

    def __call__(self, simplified: SimplifiedGrid, skeleton: Skeleton) -> CriticalLines:
        """Narrow places in reading order; adjacent points of equal clearance are represented by the middle one."""
        cell_m = skeleton.frame.resolution_m
        clearance_m = np.full(simplified.cells.shape, np.inf)
        clearance_m[tuple(skeleton.cell.T)] = skeleton.clearance_m
        group = minima(clearance_m, max(1, int(self.within_m / cell_m + EPSILON)))
        cell = middles(group)

        wide = 2 * clearance_m[tuple(cell.T)] > self.max_length_m + EPSILON
        start, end = cell.copy(), cell.copy()
        start[~wide], end[~wide] = self._walls(simplified.cells == FREE, cell[~wide], cell_m)
        fate = np.full(len(cell), NARROW, np.uint8)
        fate[(start == end).all(axis=1)] = FATES.index("one-sided")
        fate[wide | (np.hypot(*(end - start).T) * cell_m > self.max_length_m + EPSILON)] = FATES.index("too wide")
        return CriticalLines(
            cell=cell,
            clearance_m=clearance_m[tuple(cell.T)],
            fate=fate,
            start=start,
            end=end,
            frame=skeleton.frame,
        )

    def _walls(self, free: Mask, cell: Ints, cell_m: float) -> tuple[Ints, Ints]:
        """The wall cell (k, 2) nearest to each cell, and the nearest opposite one or, without one, the same again."""
        if not len(cell):
            return cell, cell
        wall = (np.argwhere(touches(np.pad(free, 1))) - 1).astype(np.int32)
        reach = self.max_length_m / cell_m + EPSILON
        near = scipy.spatial.cKDTree(cell).sparse_distance_matrix(
            scipy.spatial.cKDTree(wall), reach, output_type="ndarray"
        )
        which, to = near["i"], near["j"]
        away = wall[to] - cell[which]
        squared = (away * away).sum(axis=1)
        start = to[nearest(which, to, squared)]  # each cell has one within half the reach
        there = wall[start[which]] - cell[which]
        lengths = np.sqrt(squared * (there * there).sum(axis=1))
        apart = (away * there).sum(axis=1) <= math.cos(math.radians(self.apart_deg)) * lengths + EPSILON
        rows = np.flatnonzero(apart)[nearest(which[apart], to[apart], squared[apart])]
        end = start.copy()
        end[which[rows]] = to[rows]
        return wall[start], wall[end]


def middles(group: Ints) -> Ints:
    """The cell (k, 2) of each group (h, w) nearest to the group's mean, the first at a tie; in reading order."""
    cell = np.argwhere(group > 0)
    _, number, count = np.unique(group[group > 0], return_inverse=True, return_counts=True)
    total = np.stack([np.bincount(number, along) for along in cell.T], axis=1).astype(np.int64)
    off = cell * count[number, None] - total[number]  # integers, so that the result shifts with the map
    order = np.lexsort(((off * off).sum(axis=1), number))
    first = np.unique(number[order], return_index=True)[1]
    return cell[np.sort(order[first])].astype(np.int32)


def nearest(which: NDArray[np.intp], to: NDArray[np.intp], squared: Ints) -> NDArray[np.intp]:
    """The row of the smallest distance for each value of `which`, in order; the lowest `to` at a tie."""
    order = np.lexsort((to, squared, which))
    return order[np.unique(which[order], return_index=True)[1]]


def minima(clearance_m: Raster, steps: int) -> Ints:
    """Groups (h, w), numbered from 1, of points whose clearance is the smallest within `steps` along the skeleton.

    `clearance_m` is infinite off the skeleton. Minima within reach of each other are equal and form one group.
    """
    on = np.isfinite(clearance_m)
    least = clearance_m
    for _ in range(steps):
        least = np.where(
            on, scipy.ndimage.minimum_filter(least, footprint=AROUND, mode="constant", cval=np.inf), np.inf
        )
    lowest = on & (clearance_m <= least)
    reached = scipy.ndimage.binary_dilation(lowest, AROUND, iterations=max(1, steps // 2), mask=on)
    return np.where(lowest, skimage.measure.label(reached, connectivity=2), 0).astype(np.int32)
