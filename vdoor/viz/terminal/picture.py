"""Canvases as text, sized to the space in the terminal.

In colour, a character shows two pixels, one above the other (half blocks); without colour, it is the ink's letter.
"""

from __future__ import annotations

import colorsys
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray
from rich.console import Console, ConsoleOptions, RenderResult
from rich.segment import Segment
from rich.style import Style
from rich.text import Text

from vdoor.viz.terminal.canvas import CODE, INKS, LETTERS, Canvas, Label, readable

MOST_ZOOM = 4
PLAIN_ZOOM = 2
"""Two letters side by side are about as wide as high."""
PLAIN = Style()


@dataclass(frozen=True)
class Picture:
    """A canvas sized to the space in the terminal: the whole map, or the part around `centre` if that is given."""

    canvas: Canvas
    most_lines: int
    centre: tuple[float, float] | None = None
    zoom: int = 1
    """Pixels per cell, around a centre."""

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> RenderResult:
        """Lines of the map, then a note on the scale if it is reduced."""
        plain = console.color_system is None or options.ascii_only
        lines = min(self.most_lines, options.height or self.most_lines)
        view = self._view(options.max_width, lines, plain=plain)
        if view.note and options.height:
            view = self._view(options.max_width, lines - 1, plain=plain)
        grid = view.letters() if plain else view.half_blocks()
        view.place_labels(grid, self.canvas.labels)
        for line in grid:
            yield from _segments(line)
            yield Segment.line()
        if view.note:
            yield from console.render(Text(view.note, style="italic dim"), options)

    def _view(self, width: int, lines: int, *, plain: bool) -> _View:
        """Visible part of the canvas and its scale."""
        inks, tints = self.canvas.inks, self.canvas.tints
        high, wide = max(lines, 1) * 2, max(width, 1)  # a small terminal may have no line left: the layout crops
        if self.centre is not None:
            high, wide = max(high // self.zoom, 1), max(wide // self.zoom, 1)
            top, left = (round(at - size / 2) for at, size in zip(self.centre, (high, wide), strict=True))
            return _View(
                _window(inks, top, left, high, wide),
                _window(tints, top, left, high, wide),
                top,
                left,
                zoom=self.zoom,
                plain=plain,
            )
        top, left, bottom, right = _known(inks)
        inks, tints = inks[top:bottom, left:right], tints[top:bottom, left:right]
        zoom = min(PLAIN_ZOOM if plain else MOST_ZOOM, high // inks.shape[0], wide // inks.shape[1])
        if zoom >= 1:
            return _View(inks, tints, top, left, zoom=zoom, plain=plain)
        block = max(-(-inks.shape[0] // high), -(-inks.shape[1] // wide))
        return _View(_blocks(inks, block), _blocks(tints, block), top, left, block=block, plain=plain)


Cell = tuple[str, Style]


@dataclass(frozen=True)
class _View:
    """Pixels to show, the cell of the first one, and the scale: cells per pixel or pixels per cell."""

    inks: NDArray[np.uint8]
    tints: NDArray[np.uint8]
    top: int
    left: int
    block: int = 1
    zoom: int = 1
    plain: bool = False

    @property
    def note(self) -> str:
        """Note on the scale if cells had to be merged, else empty."""
        if self.block == 1 and (self.zoom > 1 or not self.plain):
            return ""
        size = f"{self.block} x {2 * self.block if self.plain else self.block}"
        return f"one {'letter' if self.plain else 'pixel'} is {size} cells: walls and doors hide cells beside them"

    def _pixels(self) -> NDArray[np.int64]:
        """Codes of pixels: the room's number + len(INKS) where tinted, else the ink; the number of rows is even."""
        shown = np.where((self.inks == CODE["free"]) & (self.tints > 0), self.tints - 1 + len(INKS), self.inks)
        shown = shown.repeat(self.zoom, axis=0).repeat(self.zoom, axis=1)
        return np.pad(shown.astype(np.int64), ((0, shown.shape[0] % 2), (0, 0)))

    def half_blocks(self) -> list[list[Cell]]:
        """Characters that show two pixels each, the upper one in the foreground colour."""
        pixels = self._pixels()
        pairs = zip(pixels[::2].tolist(), pixels[1::2].tolist(), strict=True)
        return [[("▀", _half(up, down)) for up, down in zip(*rows, strict=True)] for rows in pairs]

    def letters(self) -> list[list[Cell]]:
        """One letter for two pixels: that of the ink of higher priority, or that of the room's number."""
        pixels = self._pixels()
        rank = np.where(pixels >= len(INKS), CODE["free"], pixels)
        shown = np.where(rank[::2] >= rank[1::2], pixels[::2], pixels[1::2])
        alphabet = [ink.letter for ink in INKS] + list(LETTERS)
        return [[(alphabet[code], PLAIN) for code in row] for row in shown.tolist()]

    def place_labels(self, grid: list[list[Cell]], labels: Iterable[Label]) -> None:
        """Write the labels over the characters."""
        for label in labels:
            line = int((label.row - self.top + 0.5) / self.block * self.zoom / 2)
            begin = int((label.col - self.left + 0.5) / self.block * self.zoom - len(label.text) / 2)
            for offset, letter in enumerate(label.text):
                at = begin + offset
                if 0 <= line < len(grid) and 0 <= at < len(grid[line]):
                    grid[line][at] = letter, PLAIN if self.plain else _over(grid[line][at][1])


def _segments(line: list[Cell]) -> Iterable[Segment]:
    """Segments of a line; adjacent characters of one style are joined."""
    text, style = "", None
    for letter, own in line:
        if own is not style:
            if text:
                yield Segment(text, style)
            text, style = "", own
        text += letter
    yield Segment(text.rstrip() if not style else text, style)


def _known(inks: NDArray[np.uint8]) -> tuple[int, int, int, int]:
    """Bounding box of all cells that are not unknown, with a margin of one cell."""
    bounds = []
    for axis in (1, 0):
        used = np.flatnonzero((inks != CODE["unknown"]).any(axis=axis))
        size = inks.shape[1 - axis]
        bounds.append((max(int(used[0]) - 1, 0), min(int(used[-1]) + 2, size)) if len(used) else (0, size))
    (top, bottom), (left, right) = bounds
    return top, left, bottom, right


def _window(raster: NDArray[np.uint8], top: int, left: int, high: int, wide: int) -> NDArray[np.uint8]:
    """A part (high, wide) of a raster, 0 beyond the raster's edge."""
    part = np.zeros((high, wide), np.uint8)
    rows = slice(max(top, 0), max(min(top + high, raster.shape[0]), 0))
    cols = slice(max(left, 0), max(min(left + wide, raster.shape[1]), 0))
    inside = raster[rows, cols]
    part[rows.start - top :, cols.start - left :][: inside.shape[0], : inside.shape[1]] = inside
    return part


def _blocks(raster: NDArray[np.uint8], size: int) -> NDArray[np.uint8]:
    """Maximum of each block of `size` x `size` cells."""
    padded = np.pad(raster, [(0, -length % size) for length in raster.shape])
    height, width = (length // size for length in padded.shape)
    return np.asarray(padded.reshape(height, size, width, size).max(axis=(1, 3)))


@cache
def colour(code: int) -> str:
    """Colour of an ink, or of a room by its number + len(INKS); consecutive room numbers get distant hues."""
    if code < len(INKS):
        return INKS[code].colour
    golden = 0.618034
    rgb = colorsys.hsv_to_rgb((code - len(INKS)) * golden % 1, 0.35, 0.93)
    return "#" + "".join(f"{round(255 * part):02x}" for part in rgb)


@cache
def _half(up: int, down: int) -> Style:
    return Style(color=colour(up), bgcolor=colour(down))


@cache
def _over(style: Style) -> Style:
    """Style of a label over a character: black or white on the colour of its lower pixel."""
    below = style.bgcolor.name if style.bgcolor else INKS[0].colour
    return Style(color=readable(below), bgcolor=below, bold=True)
