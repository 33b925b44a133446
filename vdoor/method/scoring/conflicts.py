"""Conflicts: pairs of virtual doors that cannot both be real because they cross or are close to each other."""

from __future__ import annotations

import functools

import numpy as np
import scipy
from numpy.typing import NDArray

from vdoor.method.scoring.segments import Segments

Floats = NDArray[np.float64]
Index = NDArray[np.intp]
Mask = NDArray[np.bool_]

PARALLEL = 0.8
"""Doors whose directions have a greater cosine count as parallel."""
BESIDE_M, WIDEST_M = 0.25, 1.5
"""Parallel doors conflict if their middles are closer than half the shorter one's length, capped at `WIDEST_M`, plus
`BESIDE_M`: then they close the same opening."""
TIP = 0.02
"""Share of a segment at each end where a crossing does not count, so that doors may share a jamb."""


def suppressed(door: Segments, log_odds: Floats, near_m: float) -> Mask:
    """Which doors (k,) have a likelier one whose middle is within `near_m` of theirs."""
    lost = np.zeros(len(log_odds), np.bool_)
    if len(log_odds):
        pairs = scipy.spatial.cKDTree(door.middle).query_pairs(near_m / door.cell_m, output_type="ndarray")
        one, other = log_odds[pairs[:, 0]], log_odds[pairs[:, 1]]
        lost[pairs[one < other, 0]] = True
        lost[pairs[one > other, 1]] = True
    return lost


def conflicts(door: Segments, among: Index, apart_m: float) -> Index:
    """Conflicts: sorted pairs (m, 2) of the doors `among` that cross, are close, or are parallel in one opening."""
    if not len(among):
        return np.zeros((0, 2), np.intp)
    reach = max(apart_m / door.cell_m, float(door.length[among].max()))
    near = scipy.spatial.cKDTree(door.middle[among]).query_pairs(reach, output_type="ndarray")
    pairs = among[np.sort(near, axis=1)].reshape(-1, 2)
    a, b = pairs.T
    away_m = np.hypot(*(door.middle[a] - door.middle[b]).T) * door.cell_m
    side_by_side = np.abs((door.along[a] * door.along[b]).sum(axis=1)) > PARALLEL
    shorter_m = np.minimum(door.length[a], door.length[b]) * door.cell_m
    together = side_by_side & (away_m < np.minimum(shorter_m, WIDEST_M) / 2 + BESIDE_M)
    pairs = pairs[(away_m < apart_m) | crossing(door, a, b) | together]
    return np.asarray(pairs[np.lexsort((pairs[:, 1], pairs[:, 0]))])


def surest(door: Segments, log_odds: Floats, least_log_odds: float, apart_m: float) -> Index:
    """The doors (m,) above `least_log_odds`, ascending, chosen greedily without conflicts, the likeliest first."""
    likely = np.flatnonzero(log_odds > least_log_odds)
    place = np.empty(len(log_odds), np.intp)
    order = likely[np.lexsort((likely, -log_odds[likely]))]
    place[order] = np.arange(len(order))
    pairs = place[conflicts(door, likely, apart_m)]
    worse = [np.zeros(0, np.intp)] * len(order)
    better, other = np.sort(pairs, axis=1).reshape(-1, 2).T
    for one in np.unique(better).tolist():
        worse[one] = other[better == one]
    taken = np.ones(len(order), np.bool_)
    for one in range(len(order)):
        if taken[one]:
            taken[worse[one]] = False
    return np.sort(order[taken])


def crossing(door: Segments, a: Index, b: Index) -> Mask:
    """Whether segments (k,) cross, other than at a common end."""
    span_a, span_b = door.end[a] - door.start[a], door.end[b] - door.start[b]
    between = door.start[b] - door.start[a]
    turn = functools.partial(lambda one, other: one[:, 0] * other[:, 1] - one[:, 1] * other[:, 0])
    area = turn(span_a, span_b)
    safe = np.where(area == 0, 1.0, area)
    on_a, on_b = turn(between, span_b) / safe, turn(between, span_a) / safe
    inside = [(share > TIP) & (share < 1 - TIP) for share in (on_a, on_b)]
    return np.asarray((area != 0) & inside[0] & inside[1])
