"""The label image: every cell's room."""

from __future__ import annotations

import numpy as np

from vdoor.errors import VdoorError
from vdoor.export.raster import Raster
from vdoor.formats.result import MOST_ROOMS
from vdoor.grid import OccupancyGrid
from vdoor.topology import TopologicalMap


def to_labels(topology: TopologicalMap) -> Raster:
    """Room ids (h, w), 0 = no room.

    A PNG has 16 bits, as in a result folder. A PGM has 8 bits up to room 100: then map_server's raw mode gives the ids
    as the values of its cells. Raises `VdoorError` for ids that 16 bits do not hold.
    """
    if (most := int(topology.labels.max(initial=0))) > MOST_ROOMS:
        raise VdoorError(f"labels: wanted room ids up to {MOST_ROOMS}, found {most}")
    lies = OccupancyGrid(cells=np.zeros(topology.labels.shape, np.int8), frame=topology.frame)
    return Raster(topology.labels.astype(np.uint16), lies, "raw")
