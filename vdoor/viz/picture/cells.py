"""Rasters of a picture, looked up by pixel: matplotlib resamples images as floats, which takes ten times as long."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from numpy.typing import NDArray

from vdoor.viz.marks.kinds import Cells, Colour, reduced
from vdoor.viz.picture.layout import Box

Ints = NDArray[np.int64]


class Pixels(Artist):
    """Colours (h, w, 4) of pixels, the upper left one at a place of the picture, y down."""

    def __init__(self, colours: NDArray[np.uint8], left: int, top: int, zorder: float) -> None:
        super().__init__()
        self.set_zorder(zorder)
        self.colours, self.left, self.top = colours, left, top

    def draw(self, renderer: Any) -> None:
        """Put the pixels on the canvas as they are."""
        bottom = renderer.height - self.top - len(self.colours)
        renderer.draw_image(renderer.new_gc(), self.left, bottom, np.ascontiguousarray(self.colours[::-1]))


def draw_cells(axes: Axes, box: Box, mark: Cells, whole: Box, zorder: float) -> None:
    """Draw the part of a raster within a box; `whole` is where all of it would be.

    Of several cells in a pixel the one with the highest code is seen.
    """
    px_per_cell = whole.width / mark.codes.shape[1]
    by = max(int(1 / px_per_cell), 1)
    codes = reduced(mark.codes, by) if by > 1 else mark.codes
    left, cols = _seen(box.left, box.width, whole.left, px_per_cell * by, codes.shape[1])
    top, rows = _seen(box.top, box.height, whole.top, px_per_cell * by, codes.shape[0])
    if len(cols) and len(rows):
        own = codes[np.ix_(rows, cols)]
        axes.add_artist(Pixels(palette_of(mark.colours, int(own.max()), mark.opacity)[own], left, top, zorder))


def _seen(first: float, length: float, start: float, size: float, count: int) -> tuple[int, Ints]:
    """First pixel of a box that shows a row of cells, and the cell that it and each further one shows."""
    begin, end = max(round(first), round(start)), min(round(first + length), round(start + size * count))
    cells = ((np.arange(begin, end) + 0.5 - start) / size).astype(np.int64)
    return begin, cells.clip(0, count - 1)


def palette_of(colours: Mapping[int, tuple[Colour, str]], most: int, opacity: float) -> NDArray[np.uint8]:
    """Red, green, blue and opacity (codes, 4) of each code."""
    palette = np.zeros((most + 1, 4), np.uint8)
    for code, (colour, _) in colours.items():
        if code <= most:
            palette[code] = (*colour, 255)[:4]
    palette[:, 3] = palette[:, 3] * opacity
    return palette
