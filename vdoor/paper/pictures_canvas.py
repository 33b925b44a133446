"""A map to draw on: cells in the colours of the paper's figures, circles and lines over them, and a legend."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from vdoor.grid import FREE_TO, OCCUPIED_FROM
from vdoor.viz.charts import rgb
from vdoor.viz.rerun import style

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Places = NDArray[Any]
"""Cells (k, 2) as row, column, not necessarily whole."""
LegendEntry = tuple[str, style.Colour, str]
"""A sign (``o`` circle, ``-`` line, ``s`` cell), its colour and its meaning."""

OCCUPIED: style.Colour = (24, 24, 24)
EMPTY: style.Colour = (214, 214, 214)
UNEXPLORED: style.Colour = (255, 255, 255)
"""Black, grey and white, as in the paper's figure 2."""
LEAST_DIAMETER_PT = 4.6
"""Of circles, so that they can be seen on small cells."""
LEAST_CELL_PT = 9
"""Cells as large as that have lines between them."""
POINTS_PER_INCH = 72


class Window(NamedTuple):
    """The part of a map that is drawn: first and last row, first and last column."""

    top: int
    bottom: int
    left: int
    right: int

    def inches(self, cell_pt: float) -> tuple[float, float]:
        """Width and height with cells of that size."""
        width, height = self.right - self.left + 1, self.bottom - self.top + 1
        return width * cell_pt / POINTS_PER_INCH, height * cell_pt / POINTS_PER_INCH


def known_window(cells: NDArray[np.int8], margin: int) -> Window:
    """All that is known of a map, with a margin."""
    rows, columns = np.nonzero(cells >= 0)
    (top, bottom), (left, right) = ((at.min() - margin, at.max() + margin) for at in (rows, columns))
    return Window(int(top), int(bottom), int(left), int(right))


class Canvas:
    """One map in one part of a picture."""

    def __init__(self, axes: Axes, title: str, window: Window, *, cell_pt: float) -> None:
        axes.set_xlim(window.left - 0.5, window.right + 0.5)
        axes.set_ylim(window.bottom + 0.5, window.top - 0.5)
        axes.set_aspect("equal")
        axes.set_axis_off()
        axes.set_title(title)
        self.axes = axes
        self.cell_pt = cell_pt
        """About how wide a cell is drawn; circles are scaled by it."""

    def cells(self, cells: NDArray[np.int8]) -> None:
        """The occupancy grid, with lines between its cells where these are large enough."""
        known = np.where((cells >= 0) & (cells <= FREE_TO), 1, 0) + np.where(cells >= OCCUPIED_FROM, 2, 0)
        self._image(np.array([UNEXPLORED, EMPTY, OCCUPIED], np.uint8)[known])
        if self.cell_pt >= LEAST_CELL_PT:
            height, width = cells.shape
            look: dict[str, Any] = {"color": "white", "linewidth": 0.5}
            self.axes.hlines(np.arange(height + 1) - 0.5, -0.5, width - 0.5, **look)
            self.axes.vlines(np.arange(width + 1) - 0.5, -0.5, height - 0.5, **look)

    def marked(self, where: NDArray[np.bool_], colour: Sequence[int]) -> None:
        """Some cells (h, w) in one colour."""
        over = np.zeros((*where.shape, 4), np.uint8)
        over[where] = (*colour[:3], 255)
        self._image(over)

    def _image(self, colours: NDArray[np.uint8]) -> None:
        """A colour (h, w, 3 or 4) for each cell."""
        self.axes.imshow(colours, interpolation="nearest", aspect="equal")

    def circles(self, places: Places, colour: style.Colour, *, size: float = 1.0) -> None:
        """Circles, by default nearly as wide as a cell."""
        diameter = max(self.cell_pt * 0.72, LEAST_DIAMETER_PT) * size
        self.axes.scatter(places[:, 1], places[:, 0], s=diameter**2, color=rgb(colour), linewidths=0, zorder=4)

    def lines(self, start: Places, end: Places, colour: style.Colour, *, wide: float = 2.0) -> None:
        """Lines between places."""
        for (y1, x1), (y2, x2) in zip(start.tolist(), end.tolist(), strict=True):
            self.axes.plot([x1, x2], [y1, y2], color=rgb(colour), linewidth=wide, solid_capstyle="round", zorder=3)

    def ring(self, places: Places, colour: style.Colour) -> None:
        """A closed line from place to place."""
        closed = np.concatenate([places, places[:1]])
        self.axes.plot(closed[:, 1], closed[:, 0], color=rgb(colour), linewidth=1.6, zorder=2)


def legend(axes: Axes, entries: Sequence[LegendEntry], *, columns: int) -> None:
    """What the signs mean, under the picture that the axes are part of."""
    from matplotlib.lines import Line2D  # noqa: PLC0415  # an extra

    signs = [
        Line2D([], [], color=rgb(colour), linewidth=2)
        if sign == "-"
        else Line2D([], [], color=rgb(colour), marker=sign, linestyle="none", markersize=6)
        for sign, colour, _ in entries
    ]
    figure = axes.get_figure(root=True)
    assert figure is not None
    figure.legend(signs, [meaning for *_, meaning in entries], loc="outside lower center", ncols=columns)
