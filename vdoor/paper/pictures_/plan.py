"""A map to draw on: cells in the colours of the paper's figures, and circles and lines over them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from vdoor.grid import FREE_TO, OCCUPIED_FROM
from vdoor.viz.rerun import style

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Cells = NDArray[Any]
Window = tuple[int, int, int, int]

SMALLEST = 4.6
"""Circles are at least so wide, in points."""

OCCUPIED: style.Colour = (24, 24, 24)
EMPTY: style.Colour = (214, 214, 214)
UNEXPLORED: style.Colour = (255, 255, 255)
"""Black, grey and white, as in the paper's figure 2."""


def window_of(cells: NDArray[np.int8], margin: int = 1) -> Window:
    """First and last row, first and last column of what is known, with a margin."""
    rows, columns = np.nonzero(cells >= 0)
    (top, bottom), (left, right) = ((at.min() - margin, at.max() + margin) for at in (rows, columns))
    return int(top), int(bottom), int(left), int(right)


class Plan:
    """One map in one part of a picture; places are cells (k, 2) as row, col."""

    def __init__(self, axes: Axes, title: str, window: Window, *, px: float) -> None:
        top, bottom, left, right = window
        axes.set_xlim(left - 0.5, right + 0.5)
        axes.set_ylim(bottom + 0.5, top - 0.5)
        axes.set_aspect("equal")
        axes.set_axis_off()
        axes.set_title(title)
        self.axes = axes
        self.px = px
        """How wide a cell is, about: circles and lines go by it."""

    def cells(self, cells: NDArray[np.int8]) -> None:
        """The occupancy grid, with lines between its cells where these are large enough."""
        known = np.where((cells >= 0) & (cells <= FREE_TO), 1, 0) + np.where(cells >= OCCUPIED_FROM, 2, 0)
        self.picture(np.array([UNEXPLORED, EMPTY, OCCUPIED], np.uint8)[known])
        if self.px >= 9:  # noqa: PLR2004  # smaller cells would be all lines
            height, width = cells.shape
            look: dict[str, Any] = {"color": "white", "linewidth": 0.5}
            self.axes.hlines(np.arange(height + 1) - 0.5, -0.5, width - 0.5, **look)
            self.axes.vlines(np.arange(width + 1) - 0.5, -0.5, height - 0.5, **look)

    def picture(self, colours: NDArray[np.uint8]) -> None:
        """A colour (h, w, 3 or 4) for each cell."""
        self.axes.imshow(colours, interpolation="nearest", aspect="equal")

    def marked(self, where: NDArray[np.bool_], colour: Sequence[int]) -> None:
        """Cells (h, w) in one colour."""
        over = np.zeros((*where.shape, 4), np.uint8)
        over[where] = (*colour[:3], 255)
        self.picture(over)

    def circles(self, places: Cells, colour: style.Colour, *, size: float = 1.0) -> None:
        """Circles, by themselves nearly as wide as a cell, but never too small to be seen."""
        diameter = max(self.px * 0.72, SMALLEST) * size
        self.axes.scatter(places[:, 1], places[:, 0], s=diameter**2, color=_rgb(colour), linewidths=0, zorder=4)

    def lines(self, start: Cells, end: Cells, colour: style.Colour, *, wide: float = 2.0, on_top: float = 3) -> None:
        """Lines between places."""
        for (y1, x1), (y2, x2) in zip(start.tolist(), end.tolist(), strict=True):
            self.axes.plot(
                [x1, x2], [y1, y2], color=_rgb(colour), linewidth=wide, solid_capstyle="round", zorder=on_top
            )

    def ring(self, places: Cells, colour: style.Colour, *, wide: float = 1.6) -> None:
        """A closed line from place to place."""
        closed = np.concatenate([places, places[:1]])
        self.axes.plot(closed[:, 1], closed[:, 0], color=_rgb(colour), linewidth=wide, zorder=2)


def key(axes: Axes, meanings: Sequence[tuple[str, style.Colour, str]], *, columns: int) -> None:
    """What signs mean, under a picture: sign (``o`` circle, ``-`` line, ``s`` cell), colour, words."""
    from matplotlib.lines import Line2D  # noqa: PLC0415  # an extra

    signs = [
        Line2D([], [], color=_rgb(colour), linewidth=2)
        if sign == "-"
        else Line2D([], [], color=_rgb(colour), marker=sign, linestyle="none", markersize=6)
        for sign, colour, _ in meanings
    ]
    figure = axes.get_figure(root=True)
    assert figure is not None
    figure.legend(signs, [words for *_, words in meanings], loc="outside lower center", ncols=columns)


def _rgb(colour: style.Colour) -> tuple[float, float, float]:
    red, green, blue = (part / 255 for part in colour)
    return red, green, blue
