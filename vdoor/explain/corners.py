"""Decisions about samples (straight, candidate, suppressed, corner) and the doors at each corner."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vdoor.explain.distances import Point, longest_m, nearest, point_of
from vdoor.history import History
from vdoor.method.boundary import BoundaryPath
from vdoor.method.corners import Candidates, Corners, cosine, gaps_m
from vdoor.method.curvature import EPSILON
from vdoor.method.doors import VirtualDoors

Ints = NDArray[np.int32]
Floats = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class Sample:
    """A sample of the path, its angle, and the decision about it."""

    sample: int
    away_m: float
    point_m: Point
    angle_deg: float
    below_deg: float
    """Samples with a smaller angle are candidates."""
    k_forward: int
    k_backward: int
    convex: bool | None = None
    """Convex or concave, for candidates; None for other samples."""
    corner: int = -1
    """Corner that the sample is, or whose plateau it belongs to; -1 if none."""
    rival: int = -1
    """Sharpest candidate of the same kind within the window, if it is sharper than this one; -1 if none."""
    rival_angle_deg: float = 0.0
    rival_gap_m: float = 0.0
    """Distance to that candidate along the path."""
    window_m: float = 0.0
    decision: str = ""
    """straight, candidate, corner, plateau or suppressed."""


@dataclass(frozen=True, kw_only=True)
class CornerFate:
    """A corner and the doors that end at it."""

    corner: int
    sample: int
    away_m: float
    point_m: Point
    angle_deg: float
    convex: bool
    doors: tuple[int, ...]
    nearest_convex: int
    """Nearest other convex corner, -1 if there is none."""
    nearest_convex_m: float
    max_length_m: float


def sample_fates(run: History, point_m: Point, among: Ints, count: int) -> tuple[Sample, ...]:
    """The `count` samples nearest to a point, out of the samples `among`."""
    near = nearest(run, point_m, (run.path.half[among] - 1) / 2, count)
    return tuple(sample_fate(run, int(among[index]), away_m) for index, away_m in near)


def sample_fate(run: History, sample: int, away_m: float = 0.0) -> Sample:
    """One sample of the path and the recorded decision about it."""
    curvature = run.curvature
    rest: dict[str, Any] = {"decision": "straight"}
    if run.has(Candidates):
        row = int(np.searchsorted(run.candidates.sample, sample))
        if row < len(run.candidates.sample) and run.candidates.sample[row] == sample:
            rest = {"convex": bool(run.candidates.convex[row]), "decision": "candidate"}
            if run.has(Corners):
                rest |= _peak(run, row)
    return Sample(
        sample=sample,
        away_m=away_m,
        point_m=point_of(run, (run.path.half[sample] - 1) / 2),
        angle_deg=float(np.degrees(curvature.angle_rad[sample])),
        below_deg=run.pipeline.candidates.angle_deg,
        k_forward=int(curvature.k_forward[sample]),
        k_backward=int(curvature.k_backward[sample]),
        **rest,
    )


def _peak(run: History, row: int) -> dict[str, Any]:
    """Decision about a candidate: corner, on a corner's plateau, or suppressed by a sharper candidate."""
    path, found, corners = run.path, run.candidates, run.corners
    window_m = run.pipeline.corners.reach_m(path)
    is_corner = np.flatnonzero(corners.sample == found.sample[row])
    if len(is_corner):
        return {"decision": "corner", "corner": int(is_corner[0]), "window_m": window_m}
    sharpness = cosine(run.curvature)[found.sample]
    gap_m = _gaps(path, int(found.sample[row]), found.sample)
    bend = found.convex & path.turned_left[found.sample] & (not path.on_cracks)
    sharper = (gap_m <= window_m + EPSILON) & (found.convex == found.convex[row]) & ~(bend & bend[row])
    sharper &= sharpness > sharpness[row]
    if sharper.any():
        best = min(np.flatnonzero(sharper), key=lambda other: (-sharpness[other], gap_m[other]))
        return {
            "decision": "suppressed",
            "rival": int(found.sample[best]),
            "rival_angle_deg": float(np.degrees(found.angle_rad[best])),
            "rival_gap_m": float(gap_m[best]),
            "window_m": window_m,
        }
    own = np.where(corners.convex == found.convex[row], _gaps(path, int(found.sample[row]), corners.sample), np.inf)
    return {"decision": "plateau", "corner": int(np.argmin(own)) if len(own) else -1, "window_m": window_m}


def _gaps(path: BoundaryPath, sample: int, others: Ints) -> Floats:
    """Path length (k,) from one sample to others; infinite between contours."""
    one = np.full(len(others), sample, np.int32)
    return np.where(path.contour[one] == path.contour[others], gaps_m(path, one, others), np.inf)


def corner_fates(run: History, point_m: Point, count: int) -> tuple[CornerFate, ...]:
    """The `count` corners nearest to a point."""
    near = nearest(run, point_m, run.corners.cell, count)
    return tuple(_corner_fate(run, corner, away_m) for corner, away_m in near)


def _corner_fate(run: History, corner: int, away_m: float) -> CornerFate:
    corners, cell_m = run.corners, run.simplified.frame.resolution_m
    apart_m = np.hypot(*(corners.cell - corners.cell[corner]).T) * cell_m
    apart_m[~corners.convex | (np.arange(len(apart_m)) == corner)] = np.inf
    other = int(np.argmin(apart_m))
    doors: tuple[int, ...] = ()
    if run.has(VirtualDoors):
        ends = (run.doors.corner_start == corner) | (run.doors.corner_end == corner)
        doors = tuple(np.flatnonzero(ends).tolist())
    return CornerFate(
        corner=corner,
        sample=int(corners.sample[corner]),
        away_m=away_m,
        point_m=point_of(run, corners.cell[corner]),
        angle_deg=float(np.degrees(corners.angle_rad[corner])),
        convex=bool(corners.convex[corner]),
        doors=doors,
        nearest_convex=other if np.isfinite(apart_m[other]) else -1,
        nearest_convex_m=float(apart_m[other]) if np.isfinite(apart_m[other]) else 0.0,
        max_length_m=longest_m(run.pipeline.doors),
    )
