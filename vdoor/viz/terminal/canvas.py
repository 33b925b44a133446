"""Maps drawn cell by cell: each cell has one ink, and the one of highest priority stays."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from rich.columns import Columns
from rich.style import Style
from rich.text import Text

from vdoor.grid import FREE, OCCUPIED

Raster = NDArray[Any]


class Ink(NamedTuple):
    """Name, colour and letter of one kind of cell."""

    name: str
    colour: str
    letter: str


INKS = (
    Ink("unknown", "#1b1f27", " "),
    Ink("free", "#e9e6dc", "."),
    Ink("wall", "#565d6b", "#"),
    Ink("unreachable", "#8d6e8f", "~"),
    Ink("jut flattened", "#58b368", "+"),
    Ink("notch filled", "#2f7fc1", "%"),
    Ink("island removed", "#e0a030", "o"),
    Ink("thin unknown freed", "#b9a6dd", "i"),
    Ink("slit closed", "#4fa3a0", "s"),
    Ink("path", "#3f8efc", ":"),
    Ink("bend", "#f2c14e", "b"),
    Ink("sharp bend", "#e4572e", "B"),
    Ink("concave candidate", "#7fb7e6", "c"),
    Ink("convex candidate", "#f5a3b5", "v"),
    Ink("concave corner", "#1261c9", "C"),
    Ink("convex corner", "#e01e5a", "V"),
    Ink("rejected door", "#b07d62", "x"),
    Ink("unlikely door", "#8c8579", "u"),
    Ink("outdone door", "#d9a441", "d"),
    Ink("removed door", "#a58ad6", "-"),
    Ink("door", "#ff3b30", "="),
    Ink("backward", "#00c2c7", "<"),
    Ink("forward", "#00d26a", ">"),
    Ink("selected", "#ff00d4", "*"),
    Ink("walker", "#ffe600", "@"),
)
"""All inks, by increasing priority: later ones cover earlier ones."""
CODE = {ink.name: code for code, ink in enumerate(INKS)}
LETTERS = "0123456789abcdefghijklmnopqrstuvwxyz"
"""Letters of rooms in plain text, by room number; they repeat after z."""


class Label(NamedTuple):
    """A text over the map; row and col are its middle."""

    row: float
    col: float
    text: str


@dataclass
class Canvas:
    """A map to draw on: inks (h, w), and tints (h, w), the room's number + 1 for tinted free cells, else 0."""

    inks: NDArray[np.uint8]
    tints: NDArray[np.uint8]
    labels: list[Label] = field(default_factory=list)

    @classmethod
    def of(cls, cells: Raster) -> Canvas:
        """Canvas with the unknown, free and occupied cells of an occupancy raster (-1, 0 to 100)."""
        inks = np.full(cells.shape, CODE["unknown"], np.uint8)
        inks[cells == FREE] = CODE["free"]
        inks[cells == OCCUPIED] = CODE["wall"]
        return cls(inks, np.zeros(cells.shape, np.uint8))

    def copy(self) -> Canvas:
        """Copy that can be drawn on without changing this one."""
        return Canvas(self.inks.copy(), self.tints.copy(), list(self.labels))

    def paint(self, ink: str, cells: Raster) -> Canvas:
        """Paint cells (k, 2), except where an ink of higher priority is; cells beyond the edge are ignored."""
        row, col = np.rint(np.asarray(cells, np.float64).reshape(-1, 2)).astype(np.int64).T
        inside = (row >= 0) & (col >= 0) & (row < self.inks.shape[0]) & (col < self.inks.shape[1])
        np.maximum.at(self.inks, (row[inside], col[inside]), np.uint8(CODE[ink]))
        return self

    def fill(self, ink: str, where: Raster) -> Canvas:
        """Paint all cells of a mask (h, w), except where an ink of higher priority is."""
        self.inks[where] = np.maximum(self.inks[where], CODE[ink])
        return self

    def line(self, ink: str, start: Raster, end: Raster, *, ends: bool = False) -> Canvas:
        """Paint straight lines between cells (k, 2) and (k, 2), with or without their ends."""
        for one, other in zip(np.reshape(start, (-1, 2)), np.reshape(end, (-1, 2)), strict=True):
            steps = max(int(np.ceil(np.abs(other - one).max())), 1)
            share = np.arange(1 - ends, steps + ends)[:, None] / steps
            self.paint(ink, one + share * (other - one))
        return self

    def tint(self, rooms: Raster, where: Raster) -> Canvas:
        """Tint the free cells of a mask (h, w) in the colours of their rooms (h, w)."""
        self.tints[where] = 1 + rooms[where] % len(LETTERS)
        return self

    def write(self, cells: Raster, texts: Iterable[str]) -> Canvas:
        """Write texts centred at cells (k, 2)."""
        self.labels += [Label(float(cell[0]), float(cell[1]), text) for cell, text in zip(cells, texts, strict=True)]
        return self

    def legend(self) -> Columns:
        """Legend of the inks in use, each with its colour and letter."""
        used = np.flatnonzero(np.bincount(self.inks.ravel(), minlength=len(INKS)))
        swatches = []
        for ink in (INKS[code] for code in used.tolist() if code != CODE["unknown"]):
            colours = Style(color=readable(ink.colour), bgcolor=ink.colour)
            swatches.append(Text(no_wrap=True).append(f" {ink.letter} ", colours).append(f" {ink.name}"))
        return Columns(swatches, padding=(0, 2))


def readable(background: str) -> str:
    """Black or white, whichever is readable on a colour."""
    red, green, blue = (int(background[at : at + 2], 16) for at in (1, 3, 5))
    bright = 140_000  # threshold of perceived brightness, from 0 to 255 x 1000
    return "black" if 299 * red + 587 * green + 114 * blue > bright else "white"
