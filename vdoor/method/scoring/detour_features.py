"""Features of a virtual door: the detour around it along the wall, and the area it cuts off."""

from __future__ import annotations

import numpy as np
import scipy
from numpy.typing import NDArray

from vdoor.method.boundary import BoundaryPath
from vdoor.method.corners import gaps_m
from vdoor.method.doors import VirtualDoors
from vdoor.method.scoring.segments import Segments

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Samples = NDArray[np.int32]

TYPICAL = {"arc_log": 2.8, "arc_ratio_log": 2.8, "cut_off_log": 2.2, "cut_off_ratio_log": 2.2, "islet_log": 4.0}
"""Values of a typical real door, used where a feature is undefined."""
LEAST_M, LEAST_M2, MOST_M2 = 0.05, 0.05, 1000.0
"""Limits for lengths and areas before taking logarithms: a cell of 5 cm, and more than any room."""


def detours(
    path: BoundaryPath, door: Segments, doors: VirtualDoors, rows: Ints, corner_sample: NDArray[np.int32]
) -> dict[str, Floats]:
    """The features of the detour along the wall, and of the area that the door would cut off."""
    one = corner_sample[doors.corner_start[rows]]
    tree = scipy.spatial.cKDTree(path.half.astype(np.float64))
    _, nearest = tree.query(2 * doors.end[rows] + 1.0)
    other = np.where(doors.corner_end[rows] >= 0, corner_sample[doors.corner_end[rows]], nearest).astype(np.int32)
    same = path.contour[one] == path.contour[other]
    whole_m = path.length_m[path.contour]
    arc_m = np.maximum(gaps_m(path, one, other), LEAST_M)
    area_m2 = np.clip(_cut_off_m2(path, one, other), LEAST_M2, MOST_M2)
    length_m = np.maximum(door.length_m, LEAST_M)
    own = {
        "arc_log": np.log(arc_m),
        "arc_ratio_log": np.log(arc_m / length_m),
        "cut_off_log": np.log(area_m2),
        "cut_off_ratio_log": np.log(area_m2 / length_m**2),
    }
    islet = np.log(np.maximum(np.minimum(whole_m[one], whole_m[other]), LEAST_M))
    # A detour requires both ends on one contour, an islet on two: features of the other case get a typical value.
    return {
        "same_contour": same.astype(np.float64),
        **{name: np.where(same, values, TYPICAL[name]) for name, values in own.items()},
        "islet_log": np.where(same, TYPICAL["islet_log"], islet),
    }


def _cut_off_m2(path: BoundaryPath, one: NDArray[np.int32], other: NDArray[np.int32]) -> Floats:
    """The area (k,) between a contour and the chord of two of its samples, on the smaller side."""
    at = path.half.astype(np.float64)
    after = np.arange(1, len(at) + 1)
    count = np.diff(np.append(path.first, len(at)))
    after[path.first + count - 1] = path.first
    twice = at[:, 1] * at[after, 0] - at[:, 0] * at[after, 1]
    total = np.add.reduceat(twice, path.first)
    before = np.concatenate([[0.0], np.cumsum(twice)])
    low, high = np.minimum(one, other), np.maximum(one, other)
    chord = at[high, 1] * at[low, 0] - at[high, 0] * at[low, 1]
    side = before[high] - before[low] + chord
    rest = total[path.contour[low]] - side
    return np.asarray(np.minimum(np.abs(side), np.abs(rest)) / 8 * path.frame.resolution_m**2)
