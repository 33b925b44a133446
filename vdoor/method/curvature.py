"""Section II.B, eq. 1 to 5: adaptive curvature at each sample."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, ClassVar

import numpy as np
from numpy.typing import NDArray

from vdoor.config import Within
from vdoor.frame import Frame
from vdoor.method.boundary import BoundaryPath, step_counts
from vdoor.record import Record, Spec

EPSILON = 1e-9


class Curvature(Record):
    """The curvature at each sample of the boundary path."""

    topic: ClassVar[str] = "curvature"

    cell: Annotated[NDArray[np.int32], Spec("cell", "sample 2", of="path.cell")]
    k_forward: Annotated[NDArray[np.int32], Spec("column", "sample")]
    """K_f, eq. 1."""
    k_backward: Annotated[NDArray[np.int32], Spec("column", "sample")]
    """K_b, eq. 2."""
    forward: Annotated[NDArray[np.int32], Spec("column", "sample 2", unit="half cells")]
    """f as (row, col), eq. 3."""
    backward: Annotated[NDArray[np.int32], Spec("column", "sample 2", unit="half cells")]
    """b as (row, col), eq. 4."""
    angle_rad: Annotated[NDArray[np.float64], Spec("column", "sample", unit="rad", tolerance=1e-9)]
    """Angle between f and b: pi on a straight wall, 0 at the tip of a thin one."""
    rho_per_deg: Annotated[NDArray[np.float64], Spec("column", "sample", unit="1/deg", tolerance=1e-9)]
    """Curvature, eq. 5: the inverse of the angle, infinite at a tip."""
    frame: Frame


@dataclass(frozen=True, kw_only=True)
class EstimateCurvature:
    """Measure the angle between the straight stretches of the path before and after each sample."""

    straightness: Annotated[float, Within(0, 1)] = 0.9
    """U_k: share of the path length that the straight distance must exceed."""
    reach_m: Annotated[float, Within(0, 100)] = 1.0
    """Longest stretch of the path; without a limit, distant walls would affect the estimate."""

    def __call__(self, path: BoundaryPath) -> Curvature:
        """Vectors and angle at each sample; the angle is pi on a contour of one sample."""
        k_forward, k_backward = self.neighbours(path)
        around = _Unrolled(path, 1 + int(max(k_forward.max(initial=0), k_backward.max(initial=0))))
        here = around.position[around.base]
        forward = around.position[around.base + k_forward] - here  # eq. 3
        backward = around.position[around.base - k_backward] - here  # eq. 4
        angle_rad = np.arctan2(np.abs(cross(forward, backward)), dot(forward, backward)).astype(np.float64)  # eq. 5
        angle_rad[k_forward == 0] = np.pi
        with np.errstate(divide="ignore"):
            rho_per_deg = 1.0 / np.degrees(angle_rad)
        return Curvature(
            cell=path.cell,
            k_forward=k_forward,
            k_backward=k_backward,
            forward=forward,
            backward=backward,
            angle_rad=angle_rad,
            rho_per_deg=rho_per_deg,
            frame=path.frame,
        )

    def neighbours(self, path: BoundaryPath) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
        """K_f and K_b (n,): the largest K in the whole range with distance > U_k times path length (eq. 1, 2).

        The pair (i, i + K) counts for both K_f[i] and K_b[i + K], so one loop over K computes both.
        """
        reach_half = 2 * self.reach_m / path.frame.resolution_m
        shortest_step = math.sqrt(2) if path.on_cracks else 2.0
        limit = max(1, int(reach_half / shortest_step + EPSILON))
        around = _Unrolled(path, limit)
        k_forward = np.zeros(len(around.position), np.int32)
        k_backward = np.zeros_like(k_forward)
        row, col = around.position[:, 0].copy(), around.position[:, 1].copy()
        for k in range(1, limit + 1):
            d_squared = np.square(row[k:] - row[:-k]) + np.square(col[k:] - col[:-k])
            length = around.straight[k:] - around.straight[:-k] + math.sqrt(2) * (around.slant[k:] - around.slant[:-k])
            straight = d_squared > np.square(self.straightness * length)
            straight &= (length <= reach_half + EPSILON) & (k <= around.most[:-k])
            np.copyto(k_forward[:-k], k, where=straight)
            np.copyto(k_backward[k:], k, where=straight)
        return k_forward[around.base], k_backward[around.base]


class _Unrolled:
    """The contours, each with `reach` of its samples repeated before and after it: cyclic offsets become slices."""

    def __init__(self, path: BoundaryPath, reach: int) -> None:
        count = np.diff(np.append(path.first, len(path.cell))).astype(np.int64)
        block = count + 2 * reach
        begin = np.cumsum(block) - block
        of = np.repeat(np.arange(len(count)), block)
        local = np.arange(block.sum()) - begin[of] - reach
        wraps, within = np.divmod(local, count[of])
        source = path.first[of] + within
        straight, slant, contour_straight, contour_slant = step_counts(path.half, path.first)
        self.position = path.half[source]
        self.straight = (straight[source] + wraps * contour_straight[of]).astype(np.int32)
        self.slant = (slant[source] + wraps * contour_slant[of]).astype(np.int32)
        self.most = (count // 2)[of]
        """Largest K: half way around the contour."""
        self.base = np.arange(len(path.cell)) + reach * (1 + 2 * path.contour.astype(np.int64))
        """The index of each sample in the unrolled arrays."""


def dot(a: NDArray[np.int32], b: NDArray[np.int32]) -> NDArray[np.int64]:
    """Exact dot products (n,) of rows (n, 2)."""
    wide = a.astype(np.int64)
    return wide[:, 0] * b[:, 0] + wide[:, 1] * b[:, 1]


def cross(a: NDArray[np.int32], b: NDArray[np.int32]) -> NDArray[np.int64]:
    """Exact cross products (n,) of rows (n, 2) as (row, col), with y up: positive if b is to the left of a."""
    wide = a.astype(np.int64)
    return wide[:, 1] * -b[:, 0] + wide[:, 0] * b[:, 1]
