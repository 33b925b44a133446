"""Images of the map's cells with a map_server YAML beside them."""

from __future__ import annotations

import io
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from vdoor.formats.result import map_server_yaml, png
from vdoor.grid import OccupancyGrid

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
