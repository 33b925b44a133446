"""The direction of a map's walls, so that results do not depend on the map's rotation."""

from __future__ import annotations

import numpy as np

from vdoor.method.boundary import BoundaryPath
from vdoor.method.corners import gaps_m

STRAIGHTNESS = 0.9
"""U_k: smallest ratio of chord to path length for a chord along a wall, not across a corner; slanted walls: 0.92."""
CHORD_M = 0.5
"""Length of the chords that vote for a direction: more than the depth of furniture."""
BINS = 720
"""Bins of the histogram of angles: an eighth of a degree each, as directions repeat every 90 degrees."""
KERNEL_BINS, KERNEL_SIGMA_BINS = 24, 8.0
"""Half width and standard deviation of the Gaussian that smooths the histogram: 3 degrees and 1 degree."""
PEAK_DEG = 24.0
"""Votes within this of the peak, in quadruple angles, are averaged: 6 degrees of the walls' directions."""


def wall_direction_rad(path: BoundaryPath) -> float:
    """The angle of the dominant walls to the image's x axis, -pi/4 to pi/4, clockwise in the image (row over col).

    Each chord of the boundary votes for its angle modulo 90 degrees, so that walls in both perpendicular directions
    count for the same one.
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
    votes = np.bincount(np.floor((turn % (2 * np.pi)) / (2 * np.pi) * BINS).astype(np.intp) % BINS, minlength=BINS)
    kernel = np.exp(-0.5 * (np.arange(-KERNEL_BINS, KERNEL_BINS + 1) / KERNEL_SIGMA_BINS) ** 2)
    smooth = np.convolve(np.concatenate([votes[-KERNEL_BINS:], votes, votes[:KERNEL_BINS]]), kernel, "valid")
    peak = (np.argmax(smooth) + 0.5) / BINS * 2 * np.pi
    near = np.cos(turn - peak) > np.cos(np.radians(PEAK_DEG))
    mean = np.arctan2(np.sin(turn[near]).sum(), np.cos(turn[near]).sum())
    return float(mean / 4)
