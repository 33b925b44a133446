"""Images of the map's cells with a map_server YAML beside them: the label image, and Nav2's keepout mask."""

from __future__ import annotations

import io
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from vdoor.errors import SettingError, VdoorError
from vdoor.export.geometry import check_rooms
from vdoor.grid import FREE, OCCUPIED, OccupancyGrid
from vdoor.results.writing import MOST_ROOMS, greys, map_server_yaml, png
from vdoor.topology import TopologicalMap

SUFFIXES = (".png", ".pgm")
MOST_RAW = 100
"""The largest value that map_server's raw mode takes as it is."""


class Raster(NamedTuple):
    """An image of the map's cells, and what map_server has to know of it."""

    cells: NDArray[np.uint8] | NDArray[np.uint16]
    """Grey (h, w), row 0 at the top."""
    grid: OccupancyGrid
    """A map that lies where the image does."""
    mode: str
    """How map_server is to read it."""

    def files(self, path: Path) -> list[tuple[Path, bytes]]:
        """The image, PNG or PGM by its suffix, and the YAML beside it."""
        image = _pgm(self.cells) if path.suffix.lower() == ".pgm" else png(self.cells)
        return [(path, image), (path.with_suffix(".yaml"), map_server_yaml(self.grid, path.name, mode=self.mode))]


def _pgm(cells: NDArray[np.uint8] | NDArray[np.uint16]) -> bytes:
    """A PGM of 8 bits if map_server could read these very values from it, else of 16."""
    fits = int(cells.max(initial=0)) <= MOST_RAW
    buffer = io.BytesIO()
    Image.fromarray(cells.astype(np.uint8) if fits else cells).save(buffer, format="ppm")
    return buffer.getvalue()


def to_labels(topology: TopologicalMap) -> Raster:
    """Room ids (h, w), 0 = no room.

    A PNG has 16 bits, as in a result folder. A PGM has 8 bits up to room 100: then map_server's raw mode gives the ids
    as the values of its cells. Raises `VdoorError` for ids that 16 bits do not hold.
    """
    if (most := int(topology.labels.max(initial=0))) > MOST_ROOMS:
        raise VdoorError(f"labels: wanted room ids up to {MOST_ROOMS}, found {most}")
    lies = OccupancyGrid(cells=np.zeros(topology.labels.shape, np.int8), frame=topology.frame)
    return Raster(topology.labels.astype(np.uint16), lies, "raw")


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
