"""The generalised Voronoi diagram of the free space, approximated by thinning, with its clearance from walls."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, ClassVar

import numpy as np
import scipy
import skimage
from numpy.typing import NDArray

from vdoor.frame import Frame
from vdoor.grid import FREE
from vdoor.method.simplify import SimplifiedGrid
from vdoor.record import Record, Spec


class Skeleton(Record):
    """One-cell-wide lines in the middle of the free space, cells in reading order."""

    topic: ClassVar[str] = "skeleton"

    cell: Annotated[NDArray[np.int32], Spec("cell", "point 2")]
    clearance_m: Annotated[NDArray[np.float64], Spec("column", "point", unit="m", tolerance=1e-9)]
    """Distance to the centre of the nearest cell that is not free."""
    frame: Frame


@dataclass(frozen=True, kw_only=True)
class DrawSkeleton:
    """Thin the free space to its skeleton."""

    def __call__(self, simplified: SimplifiedGrid) -> Skeleton:
        """8-connected lines, with the branches towards corners that thinning leaves."""
        thin = np.asarray(skimage.morphology.skeletonize(np.pad(simplified.cells == FREE, 1)))[1:-1, 1:-1]
        return Skeleton(
            cell=np.argwhere(thin).astype(np.int32),
            clearance_m=clearance_m(simplified)[thin],
            frame=simplified.frame,
        )


def clearance_m(simplified: SimplifiedGrid) -> NDArray[np.float64]:
    """Distance (h, w) from each free cell's centre to the centre of the nearest cell that is not free; else 0.

    Everything outside the map counts as not free.
    """
    free = np.pad(simplified.cells == FREE, 1)
    distance: NDArray[np.float64] = scipy.ndimage.distance_transform_edt(free)
    return distance[1:-1, 1:-1] * simplified.frame.resolution_m
