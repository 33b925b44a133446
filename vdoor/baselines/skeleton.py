"""The generalised Voronoi diagram of the free space, as thinning leaves it, and how far its cells are from walls."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, ClassVar

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage
from skimage.morphology import skeletonize

from vdoor.frame import Frame
from vdoor.grid import FREE
from vdoor.method.simplify import SimplifiedGrid
from vdoor.record import Record, Spec


class Skeleton(Record):
    """Lines one cell wide in the middle of the free space, cells in reading order."""

    topic: ClassVar[str] = "skeleton"

    cell: Annotated[NDArray[np.int32], Spec("cell", "point 2")]
    clearance_m: Annotated[NDArray[np.float64], Spec("column", "point", unit="m", tolerance=1e-9)]
    """To the centre of the nearest cell that is not free."""
    frame: Frame


@dataclass(frozen=True, kw_only=True)
class DrawSkeleton:
    """Thin the free space to its skeleton."""

    def __call__(self, simplified: SimplifiedGrid) -> Skeleton:
        """8-connected lines, with a branch towards every corner that thinning leaves one in."""
        thin = np.asarray(skeletonize(np.pad(simplified.cells == FREE, 1)))[1:-1, 1:-1]
        return Skeleton(
            cell=np.argwhere(thin).astype(np.int32),
            clearance_m=clearance_m(simplified)[thin],
            frame=simplified.frame,
        )


def clearance_m(simplified: SimplifiedGrid) -> NDArray[np.float64]:
    """Distance (h, w) of each free cell's centre to that of the nearest cell that is not; 0 where not free.

    What lies beyond the map's edge is not free.
    """
    free = np.pad(simplified.cells == FREE, 1)
    distance: NDArray[np.float64] = ndimage.distance_transform_edt(free)
    return distance[1:-1, 1:-1] * simplified.frame.resolution_m
