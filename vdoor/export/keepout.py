"""Nav2's keepout mask: keeps a robot in the rooms that were chosen."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from vdoor.errors import SettingError
from vdoor.export.chosen import check_rooms
from vdoor.export.raster import Raster
from vdoor.formats.result import greys
from vdoor.grid import FREE, OCCUPIED, OccupancyGrid
from vdoor.topology import TopologicalMap


def to_keepout(topology: TopologicalMap, rooms: Sequence[int]) -> Raster:
    """White (h, w) in the chosen rooms, black everywhere else, walls included; for Nav2's KeepoutFilter.

    Doors between chosen rooms are open. Raises `SettingError` where no room is chosen, or one that is not there.
    """
    if not rooms:
        raise SettingError("keepout: wanted the rooms that stay open, found none")
    check_rooms(topology, rooms)
    cells = np.where(np.isin(topology.labels, list(rooms)), FREE, OCCUPIED).astype(np.int8)
    mask = OccupancyGrid(cells=cells, frame=topology.frame)
    return Raster(greys(mask), mask, "trinary")
