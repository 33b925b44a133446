"""Images of the map's cells, with a map_server YAML: the label image and Nav2's keepout mask."""

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
from vdoor.grid import FREE, OCCUPIED, Annotations, OccupancyGrid
from vdoor.navigate.blocked import ruled_out
from vdoor.results.writing import MOST_ROOMS, greys, map_server_yaml, png
from vdoor.topology import TopologicalMap

SUFFIXES = (".png", ".pgm")
MOST_RAW = 100
"""Largest value that map_server's raw mode passes through unchanged."""


class Raster(NamedTuple):
    """An image of the map's cells, with the data for its map_server YAML."""

    cells: NDArray[np.uint8] | NDArray[np.uint16]
    """Grey (h, w), row 0 at the top."""
    grid: OccupancyGrid
    """A map with the frame of the image."""
    mode: str
    """map_server mode."""

    def files(self, path: Path) -> list[tuple[Path, bytes]]:
        """The image, PNG or PGM by its suffix, and its YAML."""
        image = _pgm(self.cells) if path.suffix.lower() == ".pgm" else png(self.cells)
        return [(path, image), (path.with_suffix(".yaml"), map_server_yaml(self.grid, path.name, mode=self.mode))]


def _pgm(cells: NDArray[np.uint8] | NDArray[np.uint16]) -> bytes:
    """A PGM of 8 bits if map_server would read the exact values from it, else of 16."""
    fits = int(cells.max(initial=0)) <= MOST_RAW
    buffer = io.BytesIO()
    Image.fromarray(cells.astype(np.uint8) if fits else cells).save(buffer, format="ppm")
    return buffer.getvalue()


def to_labels(topology: TopologicalMap) -> Raster:
    """Room ids (h, w), 0 = no room.

    A PNG has 16 bits, as in a result folder. A PGM has 8 bits if no id is above 100: map_server's raw mode then gives
    the ids as cell values. Raises `VdoorError` for ids of more than 16 bits.
    """
    if (most := int(topology.labels.max(initial=0))) > MOST_ROOMS:
        raise VdoorError(f"labels: wanted room ids up to {MOST_ROOMS}, found {most}")
    grid = OccupancyGrid(cells=np.zeros(topology.labels.shape, np.int8), frame=topology.frame)
    return Raster(topology.labels.astype(np.uint16), grid, "raw")


def to_keepout(topology: TopologicalMap, rooms: Sequence[int], annotations: Annotations | None = None) -> Raster:
    """White (h, w) in the chosen rooms, black everywhere else, walls included; for Nav2's KeepoutFilter.

    Doors between chosen rooms are open; virtual walls and no-go areas of the map's file are black. Raises
    `SettingError` for no rooms or an unknown room.
    """
    if not rooms:
        raise SettingError("keepout: wanted the rooms to keep open, found none")
    check_rooms(topology, rooms)
    open_ = np.isin(topology.labels, list(rooms))
    if annotations is not None:
        open_ &= ~ruled_out(topology.frame, annotations, mops=False)
    cells = np.where(open_, FREE, OCCUPIED).astype(np.int8)
    mask = OccupancyGrid(cells=cells, frame=topology.frame)
    return Raster(greys(mask), mask, "trinary")
