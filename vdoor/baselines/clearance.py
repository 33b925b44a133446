"""How far free cells are from what is not free."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from vdoor.grid import FREE
from vdoor.stages.simplify import SimplifiedGrid


def clearance_m(simplified: SimplifiedGrid) -> NDArray[np.float64]:
    """Distance (h, w) of each free cell's centre to that of the nearest cell that is not; 0 where not free.

    What lies beyond the map's edge is not free.
    """
    free = np.pad(simplified.cells == FREE, 1)
    distance: NDArray[np.float64] = ndimage.distance_transform_edt(free)
    return distance[1:-1, 1:-1] * simplified.frame.resolution_m
