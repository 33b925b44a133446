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
    """How sharply the path bends at each sample of the boundary path."""

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
    """Between f and b: pi on a straight wall, 0 at the tip of a thin one."""
    rho_per_deg: Annotated[NDArray[np.float64], Spec("column", "sample", unit="1/deg", tolerance=1e-9)]
    """Eq. 5: the angle's inverse, infinite at a tip."""
    frame: Frame


@dataclass(frozen=True, kw_only=True)
class EstimateCurvature:
    """Look as far along the path as it stays straight, in both directions, and take the angle between."""

    straightness: Annotated[float, Within(0, 1)] = 0.9
    """U_k: how much of the path's length the straight distance must reach."""
    reach_m: Annotated[float, Within(0, 100)] = 1.0
    """Longest path looked along; without a limit far walls would bend into the estimate."""

    def __call__(self, path: BoundaryPath) -> Curvature:
        """Angle and vectors at each sample; a contour of one sample does not bend."""
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
        """K_f and K_b (n,): the largest K, over the whole range, with distance > U_k times path length (eq. 1, 2).

        The pair (i, i + K) decides about K_f[i] and K_b[i + K] alike, so one loop over K serves both.
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
    """Every contour with `reach` samples of itself before and after it, so that cyclic neighbours are slices."""

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
        """K may not go more than half around."""
        self.base = np.arange(len(path.cell)) + reach * (1 + 2 * path.contour.astype(np.int64))
        """Where each sample stands in the unrolled arrays."""


def dot(a: NDArray[np.int32], b: NDArray[np.int32]) -> NDArray[np.int64]:
    """Dot products (n,) of rows (n, 2), exact."""
    wide = a.astype(np.int64)
    return wide[:, 0] * b[:, 0] + wide[:, 1] * b[:, 1]


def cross(a: NDArray[np.int32], b: NDArray[np.int32]) -> NDArray[np.int64]:
    """Cross products (n,) of rows (n, 2) given as (row, col), with y up: positive where b lies to the left of a."""
    wide = a.astype(np.int64)
    return wide[:, 1] * -b[:, 0] + wide[:, 0] * b[:, 1]
