"""Section II.B, eq. 6: candidates, and corners, the candidates of locally greatest curvature."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, ClassVar

import numpy as np
from numpy.typing import NDArray

from vdoor.config import Within
from vdoor.frame import Frame
from vdoor.method.boundary import BoundaryPath
from vdoor.method.curvature import EPSILON, Curvature, cross, dot
from vdoor.record import Record, Spec


class Candidates(Record):
    """Samples with more curvature than the threshold."""

    topic: ClassVar[str] = "candidates"

    cell: Annotated[NDArray[np.int32], Spec("cell", "candidate 2")]
    sample: Annotated[NDArray[np.int32], Spec("column", "candidate", of="path.cell")]
    angle_rad: Annotated[NDArray[np.float64], Spec("column", "candidate", unit="rad", tolerance=1e-9)]
    convex: Annotated[NDArray[np.bool_], Spec("column", "candidate")]
    frame: Frame


class Corners(Record):
    """Candidates of locally greatest curvature, in the order of the path."""

    topic: ClassVar[str] = "corners"

    cell: Annotated[NDArray[np.int32], Spec("cell", "corner 2")]
    sample: Annotated[NDArray[np.int32], Spec("column", "corner", of="path.cell")]
    quarter: Annotated[NDArray[np.int32], Spec("column", "corner 2", unit="quarter cells")]
    """Middle of the corner's plateau of greatest curvature; the centre of a cell is (4 row + 2, 4 col + 2)."""
    angle_rad: Annotated[NDArray[np.float64], Spec("column", "corner", unit="rad", tolerance=1e-9)]
    convex: Annotated[NDArray[np.bool_], Spec("column", "corner")]
    frame: Frame


@dataclass(frozen=True, kw_only=True)
class FindCandidates:
    """Keep the samples with more curvature than the threshold."""

    angle_deg: Annotated[float, Within(0, 180)] = 155.0
    """Samples with a smaller angle are candidates (rho > 1/155)."""

    def __call__(self, path: BoundaryPath, curvature: Curvature) -> Candidates:
        """Candidates in path order; angles are compared, since rho = 1/angle is infinite at the tip of a wall."""
        sharp = cosine(curvature) > math.cos(math.radians(self.angle_deg))
        sample = np.flatnonzero(sharp & (curvature.k_forward > 0)).astype(np.int32)
        # Eq. 6 with atan2: convex where f is to the right of b. Where the path folds back, the walker's turn decides.
        side = cross(curvature.backward[sample], curvature.forward[sample])
        convex = (side < 0) | ((side == 0) & path.turned_left[sample])
        return Candidates(
            cell=path.cell[sample],
            sample=sample,
            angle_rad=curvature.angle_rad[sample],
            convex=convex,
            frame=path.frame,
        )


@dataclass(frozen=True, kw_only=True)
class FindCorners:
    """Keep the sharpest candidates of each kind within a window along the path."""

    window_m: Annotated[float, Within(0, 10)] = 0.25
    """Window to either side if samples are obstacle cells (paper); at least 1.42 cells."""
    crack_window_m: Annotated[float, Within(0, 10)] = 0.12
    """Window to either side if samples are crack middles; at least 1.2 cells."""

    def __call__(self, path: BoundaryPath, curvature: Curvature, candidates: Candidates) -> Corners:
        """Corners in path order, one at the middle of each plateau of equal angle.

        If the middle falls between two obstacle cells of a convex plateau (the end of a wall two cells thick), both
        cells are corners; choosing one would not mirror with the map.
        """
        window_m = self.reach_m(path)
        peak = peaks(path, curvature, candidates, window_m)
        sample, quarter = middles(path, candidates.sample[peak], candidates.convex[peak], window_m)
        order = np.argsort(sample, kind="stable")
        sample, quarter = sample[order], quarter[order]
        convex = np.zeros(len(path.cell), np.bool_)
        convex[candidates.sample] = candidates.convex
        return Corners(
            cell=path.cell[sample],
            sample=sample,
            quarter=quarter,
            angle_rad=curvature.angle_rad[sample],
            convex=convex[sample],
            frame=path.frame,
        )

    def reach_m(self, path: BoundaryPath) -> float:
        """The window on this path; at least one step, so that the samples of a square corner are within it."""
        cell_m = path.frame.resolution_m
        return max(self.crack_window_m, 1.2 * cell_m) if path.on_cracks else max(self.window_m, 1.42 * cell_m)


def cosine(curvature: Curvature) -> NDArray[np.float64]:
    """Cosine (n,) of the angle between f and b; computed from integers, so that equal bends give equal values."""
    forward, backward = curvature.forward, curvature.backward
    size = np.sqrt(dot(forward, forward) * dot(backward, backward).astype(np.float64))
    return np.round(dot(forward, backward) / np.maximum(size, 1.0), 12)


def gaps_m(path: BoundaryPath, one: NDArray[np.int32], other: NDArray[np.int32]) -> NDArray[np.float64]:
    """Path length (k,) in metres between samples of the same contour, the shorter way round."""
    ahead_m = np.abs(path.arc_m[other] - path.arc_m[one])
    return np.minimum(ahead_m, path.length_m[path.contour[one]] - ahead_m)


def next_on_contour(path: BoundaryPath, sample: NDArray[np.int32], ahead: int) -> NDArray[np.int64]:
    """Index (k,) into `sample`, which is sorted, of the element `ahead` positions later, cyclically in its contour."""
    contour = path.contour[sample]
    count = np.bincount(contour, minlength=len(path.first))
    begin = np.cumsum(count) - count
    place = np.arange(len(sample)) - begin[contour] + ahead
    return (begin[contour] + place % count[contour]).astype(np.int64, copy=False)


def peaks(path: BoundaryPath, curvature: Curvature, candidates: Candidates, window_m: float) -> NDArray[np.bool_]:
    """Which candidates (k,) are peaks: no candidate of the same kind within the window is sharper."""
    sharpness = cosine(curvature)[candidates.sample]
    bend = candidates.convex & path.turned_left[candidates.sample] & (not path.on_cracks)
    peak = np.ones(len(sharpness), np.bool_)
    count = np.bincount(path.contour[candidates.sample])[path.contour[candidates.sample]]
    # Candidates are in path order: once none has a partner within the window `ahead` positions later, none has later.
    for ahead in range(1, count.max(initial=0)):
        partner = next_on_contour(path, candidates.sample, ahead)
        near = gaps_m(path, candidates.sample, candidates.sample[partner]) <= window_m + EPSILON
        near &= ahead < count
        if not near.any():
            break
        competing = near & (candidates.convex == candidates.convex[partner]) & ~(bend & bend[partner])
        peak[competing & (sharpness[partner] > sharpness)] = False
        peak[partner[competing & (sharpness > sharpness[partner])]] = False
    return peak


def middles(
    path: BoundaryPath, sample: NDArray[np.int32], convex: NDArray[np.bool_], window_m: float
) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
    """The middle samples (m,) of the plateaus formed by the peaks, and their positions (m, 2) in quarter cells."""
    after = next_on_contour(path, sample, 1)
    linked = (gaps_m(path, sample, sample[after]) <= window_m + EPSILON) & (convex == convex[after])
    linked &= after != np.arange(len(sample))
    begins = np.ones(len(sample), np.bool_)
    begins[after[linked]] = False
    closed = np.bincount(path.contour[sample[begins]], minlength=len(path.first)) == 0
    round_trip = closed[path.contour[sample]]

    # A plateau may contain its contour's first sample: start each contour's list at the beginning of a plateau.
    order = _from_a_beginning(path.contour[sample], begins)
    order = order[~round_trip[order]]
    plateau = np.cumsum(begins[order]) - 1
    size = np.bincount(plateau)
    begin = np.cumsum(size) - size
    low, high = order[begin + (size - 1) // 2], order[begin + size // 2]
    quarter = path.half[sample[low]] + path.half[sample[high]]
    two = convex[low] & (path.cell[sample[low]] != path.cell[sample[high]]).any(axis=1)

    # A plateau that is a whole contour (a pillar) has no middle: all its obstacle cells are corners.
    pillar = np.flatnonzero(round_trip)
    keys = np.column_stack([path.contour[sample[pillar]], path.cell[sample[pillar]]])
    pillar = pillar[np.unique(keys, axis=0, return_index=True)[1]]
    chosen = np.concatenate([low, high[two], pillar])
    places = np.concatenate(
        [
            np.where(two[:, None], 2 * path.half[sample[low]], quarter),
            2 * path.half[sample[high[two]]],
            4 * path.cell[sample[pillar]] + 2,  # the cell's centre, since its cracks are equivalent
        ]
    )
    return sample[chosen], places.astype(np.int32)


def _from_a_beginning(group: NDArray[np.int32], begins: NDArray[np.bool_]) -> NDArray[np.intp]:
    """The order (k,) that rotates each run of equal `group` so that it starts where `begins` is first set."""
    count = np.bincount(group)
    start = np.cumsum(count) - count
    first = np.full(len(count), len(group))
    np.minimum.at(first, group[begins], np.flatnonzero(begins))
    shift = np.where(first < len(group), first - start, 0)
    place = start[group] + (np.arange(len(group)) - start[group] - shift[group]) % count[group]
    order = np.empty(len(group), np.intp)
    order[place] = np.arange(len(group))
    return order
