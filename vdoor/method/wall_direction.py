"""How the walls of a map lie: nothing may depend on a map lying straight."""

from __future__ import annotations

import numpy as np

from vdoor.method.boundary import BoundaryPath
from vdoor.method.corners import gaps_m

STRAIGHTNESS = 0.9
"""U_k: share of the path's length that a chord must have to be of a wall, not of a corner; slanted ones have 0.92."""
CHORD_M = 0.5
"""Walls are looked at in chords of this length."""


def wall_direction_rad(path: BoundaryPath) -> float:
    """Angle of the dominant walls from the grid's columns, -pi/4 to pi/4, clockwise on the image (row over col).

    The chords of the boundary have one vote each for the angle they have in common with all that turn by right angles,
    so that both families of walls count for one direction.
    """
    step = max(1, round(CHORD_M / path.frame.resolution_m))
    count = np.diff(np.append(path.first, len(path.cell))).astype(np.int64)
    local = np.arange(len(path.cell)) - path.first[path.contour]
    ahead = path.first[path.contour] + (local + step) % count[path.contour]
    down, right = (path.half[ahead] - path.half).T.astype(np.float64)
    length = np.hypot(down, right)
    way_m = gaps_m(path, np.arange(len(ahead), dtype=np.int32), ahead.astype(np.int32))
    straight = length * path.frame.resolution_m / 2 >= STRAIGHTNESS * way_m
    straight &= count[path.contour] > 2 * step
    if not straight.any():
        return 0.0
    turn = 4 * np.arctan2(down[straight], right[straight])
    bins = 720
    votes = np.bincount(np.floor((turn % (2 * np.pi)) / (2 * np.pi) * bins).astype(np.intp) % bins, minlength=bins)
    kernel = np.exp(-0.5 * (np.arange(-24, 25) / 8.0) ** 2)
    smooth = np.convolve(np.concatenate([votes[-24:], votes, votes[:24]]), kernel, "valid")
    peak = (np.argmax(smooth) + 0.5) / bins * 2 * np.pi
    near = np.cos(turn - peak) > np.cos(np.radians(24))
    mean = np.arctan2(np.sin(turn[near]).sum(), np.cos(turn[near]).sum())
    return float(mean / 4)
