"""A picture under way: a matplotlib figure measured in pixels from its upper left corner, with text and legends."""

from __future__ import annotations

import functools
import io
import textwrap
from collections.abc import Sequence
from typing import Any, NamedTuple

from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties
from matplotlib.lines import Line2D
from matplotlib.text import Text
from matplotlib.transforms import Affine2D
from PIL import Image

from vdoor.viz.picture.layout import Box, flowed

DOTS_PER_INCH = 100
POINTS_PER_PX = 72 / DOTS_PER_INCH
FONT = "DejaVu Sans"
"""Comes with matplotlib, so pictures do not depend on the fonts of a machine."""
INK, EDGE = "#26282e", "#8a8d94"
LINE_PX = 19.0
SIGN_PX, BETWEEN_PX = 26.0, 18.0
"""Width of a legend's sign, and between two of its entries."""


class Entry(NamedTuple):
    """A line of a legend."""

    sign: str
    """``s`` cells, ``o`` dots, ``-`` lines, ``--`` dashed lines, ``>`` arrows."""
    colour: Sequence[int]
    text: str
    wide_px: float = 8.0


class Sheet:
    """A picture of a width and height in pixels."""

    def __init__(self, width: float, height: float) -> None:
        self.width, self.height = round(width), round(height)
        self.figure = Figure(figsize=(self.width / DOTS_PER_INCH, self.height / DOTS_PER_INCH), dpi=DOTS_PER_INCH)
        self.canvas = FigureCanvasAgg(self.figure)
        self.pixels = Affine2D().scale(1, -1).translate(0, self.height)
        """From pixels, y down, to those of the canvas."""

    def axes(self, box: Box) -> Axes:
        """Axes in a box."""
        bottom = self.height - box.top - box.height
        share = (box.left / self.width, bottom / self.height, box.width / self.width, box.height / self.height)
        return self.figure.add_axes(share)

    def write(self, x: float, y: float, text: str, *, size_px: float = 13, **look: Any) -> None:
        """Text with its left end and its middle line at a place."""
        look = {"ha": "left", "va": "center", "color": INK, "fontfamily": FONT} | look
        words = Text(x, y, text, fontsize=size_px * POINTS_PER_PX, parse_math=False, transform=self.pixels, **look)
        self.figure.add_artist(words)

    def line(self, x: Sequence[float], y: Sequence[float]) -> None:
        """A thin dark line through places."""
        self.figure.add_artist(Line2D(x, y, color=INK, linewidth=1.0, transform=self.pixels))

    def legend(self, entries: Sequence[Entry], left: float, top: float, across: float) -> None:
        """The entries' signs and texts, in as many lines as they need."""
        for entry, (line, at) in zip(entries, flowed_entries(entries, across), strict=True):
            x, y = left + at, top + (line + 0.5) * LINE_PX
            self._sign(entry, x, y)
            self.write(x + SIGN_PX, y, entry.text, size_px=12)

    def _sign(self, entry: Entry, x: float, y: float) -> None:
        wide = entry.wide_px * POINTS_PER_PX
        look: dict[str, Any] = {"color": hex_of(entry.colour), "transform": self.pixels}
        if entry.sign == "s":
            look |= {"marker": "s", "markersize": 12 * POINTS_PER_PX, "markeredgecolor": EDGE, "markeredgewidth": 0.5}
        elif entry.sign == "o":
            look |= {"marker": "o", "markersize": max(wide, 2.5), "markeredgewidth": 0}
        elif entry.sign == ">":
            look |= {"marker": ">", "markevery": [1], "markersize": 5}
        elif entry.sign == "--":
            look |= {"linestyle": (0, (2.5, 1.2))}
        xs = [x + 11] if entry.sign in "so" else [x, x + 18]
        self.figure.add_artist(Line2D(xs, [y] * len(xs), linewidth=max(wide, 1.0), **look))

    def png(self) -> bytes:
        """The finished picture, of at most 256 colours."""
        self.canvas.draw()  # type: ignore[no-untyped-call]  # matplotlib types its canvases in part
        image = Image.frombuffer("RGBA", (self.width, self.height), bytes(self.canvas.buffer_rgba()))  # type: ignore[no-untyped-call]
        buffer = io.BytesIO()
        palette = image.convert("RGB").quantize(256, method=Image.Quantize.FASTOCTREE, dither=Image.Dither.NONE)
        palette.save(buffer, format="png")
        return buffer.getvalue()


_MEASURE = FigureCanvasAgg(Figure(dpi=DOTS_PER_INCH))


@functools.cache
def width_of(text: str, size_px: float, *, bold: bool = False) -> float:
    """How wide a text is in pixels."""
    font = FontProperties(family=FONT, size=size_px * POINTS_PER_PX, weight="bold" if bold else "normal")
    renderer = _MEASURE.get_renderer()  # type: ignore[no-untyped-call]
    return float(renderer.get_text_width_height_descent(text, font, ismath=False)[0])


def flowed_entries(entries: Sequence[Entry], across: float) -> list[tuple[int, float]]:
    """Line and place of each entry of a legend."""
    return flowed([SIGN_PX + width_of(entry.text, 12) + BETWEEN_PX for entry in entries], across + BETWEEN_PX)


def lines_of(entries: Sequence[Entry], across: float) -> int:
    """How many lines a legend has."""
    return max((line for line, _ in flowed_entries(entries, across)), default=-1) + 1


def folded(text: str, across: float, size_px: float) -> list[str]:
    """A text in lines of about a width."""
    average = max(width_of(text, size_px) / max(len(text), 1), 1.0)
    return textwrap.wrap(text, max(int(across / average), 20))


def hex_of(colour: Sequence[int]) -> str:
    """A colour as matplotlib takes it, with its opacity if it has one."""
    return "#" + "".join(f"{part:02x}" for part in colour)
