"""Alignment of an older map with a new one of the same place: in the same frame, or shifted."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import NDArray

from vdoor.editing.places import Point
from vdoor.topology import TopologicalMap

Floats = NDArray[np.float64]
Ints = NDArray[np.int32]

CM_PER_M = 100
MOST_SIDE = 1024
"""Cells along the longer side of the rasters that are correlated."""
PEAKS = 8
"""Number of correlation peaks, as shifts, whose overlap is computed."""
BETTER = 0.02
"""Gain in overlap over the known shift that another shift must have to replace it."""
MOST_POINTS = 40_000
"""Largest number of room cells from which an overlap is computed."""


@dataclass(frozen=True)
class Alignment:
    """The position of the older map in the new map's frame."""

    shift_m: Point
    """The shift to add to the older map's x, y."""
    overlap: float
    """Intersection over union of the two maps' room areas, 0 to 1."""


def aligned(old: TopologicalMap, new: TopologicalMap) -> Alignment:
    """The shift with the largest overlap of the two maps' rooms; the known shift if no other is clearly better.

    The maps may differ in resolution, size and origin, and one may cover more than the other. No rotation is estimated:
    only the yaw of the two frames is used.
    """
    overlap = _Overlap(old, new)
    shifts = [np.array(known_shift_m(old, new)), *_candidates(old, new)]
    found = [(shift, overlap(shift)) for shift in shifts]
    known = found[0][1]
    best, most = max(found[1:], key=lambda pair: pair[1], default=found[0])
    if most > known:
        best, most = _refined(overlap, best, most, min(old.frame.resolution_m, new.frame.resolution_m) / 2)
    if most < known + BETTER:
        best, most = found[0]
    return Alignment((float(best[0]), float(best[1])), most)


def known_shift_m(old: TopologicalMap, new: TopologicalMap) -> Point:
    """The shift between the two map frames, from their origins in the robot's own frame; 0, 0 if these are unknown.

    Correct if the robot kept its own frame between the two maps.
    """
    if old.own_origin_cm is None or new.own_origin_cm is None:
        return 0.0, 0.0
    (old_x_cm, old_y_cm), (x_cm, y_cm) = old.own_origin_cm, new.own_origin_cm
    return (old_x_cm - x_cm) / CM_PER_M, (y_cm - old_y_cm) / CM_PER_M  # the robot's y axis points down


def labels_under(old: TopologicalMap, points_m: Floats, shift_m: Floats) -> Ints:
    """The older map's room (k,) at points (k, 2) of the new map; 0 for none."""
    cells = np.floor(old.frame.cell_from_world(points_m - shift_m) + 0.5).astype(np.int64)
    inside = ((cells >= 0) & (cells < old.labels.shape)).all(axis=1)
    labels = np.zeros(len(points_m), np.int32)
    labels[inside] = old.labels[tuple(cells[inside].T)]
    return labels


class _Overlap:
    """Intersection over union of the two maps' room areas, as a function of the older map's shift."""

    def __init__(self, old: TopologicalMap, new: TopologicalMap) -> None:
        inside = np.flatnonzero(new.labels)
        every = -(-len(inside) // MOST_POINTS) or 1
        cells = np.stack(np.unravel_index(inside[::every], new.labels.shape), axis=1)
        self._old, self._points_m = old, new.frame.world_from_cell(cells)
        self._old_m2, self._new_m2 = float(old.area_m2.sum()), float(new.area_m2.sum())

    def __call__(self, shift_m: Floats) -> float:
        under = np.count_nonzero(labels_under(self._old, self._points_m, shift_m))
        both_m2 = under / max(len(self._points_m), 1) * self._new_m2
        return both_m2 / max(self._old_m2 + self._new_m2 - both_m2, 1e-9)


def _candidates(old: TopologicalMap, new: TopologicalMap) -> list[Floats]:
    """The shifts in metres at which the edges of the two maps' rooms correlate most, best first."""
    borders_m = [_borders_m(topology) for topology in (old, new)]
    if not all(map(len, borders_m)):
        return []
    widest_m = max(float(np.ptp(points_m, axis=0).max()) for points_m in borders_m)
    cell_m = max(old.frame.resolution_m, new.frame.resolution_m, widest_m / MOST_SIDE)
    one, other = (_raster(points_m, cell_m) for points_m in borders_m)
    votes = scipy.signal.fftconvolve(other[0], one[0][::-1, ::-1])
    votes = np.where(scipy.ndimage.maximum_filter(votes, 5) == votes, votes, 0.0)
    places = np.argsort(-votes.round(6), axis=None, kind="stable")[:PEAKS]
    steps = np.stack(np.unravel_index(places, votes.shape), axis=1) - (np.array(one[0].shape) - 1)
    return list(other[1] - one[1] + steps * cell_m)


def _borders_m(topology: TopologicalMap) -> Floats:
    """The centres (k, 2), as x, y, of cells on the edge of the space covered by rooms."""
    rooms = np.pad(topology.labels > 0, 1)
    inner = rooms[1:-1, 1:-1] & rooms[:-2, 1:-1] & rooms[2:, 1:-1] & rooms[1:-1, :-2] & rooms[1:-1, 2:]
    return topology.frame.world_from_cell(np.argwhere(rooms[1:-1, 1:-1] & ~inner))


def _raster(points_m: Floats, cell_m: float) -> tuple[Floats, Floats]:
    """The points drawn on a raster and blurred, and x, y of its first cell."""
    low = points_m.min(axis=0)
    cells = np.rint((points_m - low) / cell_m).astype(int)
    drawn = np.zeros(cells.max(axis=0) + 1)
    drawn[tuple(cells.T)] = 1.0
    return scipy.ndimage.gaussian_filter(drawn, 0.7, mode="constant"), low


def _refined(overlap: _Overlap, shift_m: Floats, most: float, step_m: float) -> tuple[Floats, float]:
    """The shift improved by steps of `step_m` to a local maximum of the overlap, and that overlap."""
    ways = step_m * np.array([(dx, dy) for dx in (-1, 0, 1) for dy in (-1, 0, 1) if dx or dy], np.float64)
    for _ in range(20):
        tried = [(shift_m + way, overlap(shift_m + way)) for way in ways]
        best = max(tried, key=lambda pair: pair[1])
        if best[1] <= most + 1e-9:  # no better than by rounding
            break
        shift_m, most = best
    return shift_m, most
