"""Marks: what a picture of a stage is made of, in cells of a frame, and how to make them from columns of records.

A mark has one colour and one meaning, so that a legend has one line for it. Sizes are pixels of the finished picture,
whatever the size of the map.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vdoor.frame import Frame

Colour = tuple[int, ...]
"""Red, green, blue and, for cells, opacity, each 0 to 255."""
Places = NDArray[Any]
"""Points (k, 2) as row, col; whole numbers are the centres of cells."""
Strips = Sequence[Places] | NDArray[Any]
"""Lines, each (k, 2)."""
MOST_CODES = 2**16


@dataclass(frozen=True, kw_only=True)
class Mark:
    """What all marks have."""

    name: str
    """Name within the stage, in letters that suit a path."""
    frame: Frame
    meaning: str = ""
    """What it means, for the legend; empty if something else says so."""
    tips: Sequence[str] = ()
    """Text for the pointer, one for each element."""
    labels: Sequence[str] = ()
    """Short text beside each element."""


@dataclass(frozen=True, kw_only=True)
class Cells(Mark):
    """A raster (h, w) of codes; those without a colour are transparent. In one pixel the highest code is seen."""

    codes: NDArray[Any]
    colours: Mapping[int, tuple[Colour, str]]
    """Colour and meaning of each code."""
    opacity: float = 1.0
    listed: bool = True
    """Whether the legend has a line for each code."""


@dataclass(frozen=True, kw_only=True)
class Dots(Mark):
    """A dot at each place."""

    cell: Places
    colour: Colour
    wide_px: float = 6.0


@dataclass(frozen=True, kw_only=True)
class Lines(Mark):
    """Lines, each through two places or more."""

    strips: Strips
    colour: Colour
    wide_px: float = 2.0


@dataclass(frozen=True, kw_only=True)
class Arrows(Mark):
    """Arrows from places by vectors (k, 2) in cells."""

    cell: Places
    vector: Places
    colour: Colour
    wide_px: float = 1.5


@dataclass(frozen=True)
class Curve:
    """A line of a chart, or dots at its points; nan parts a line."""

    name: str
    x: NDArray[np.float64]
    y: NDArray[np.float64]
    colour: Colour
    meaning: str
    dotted: bool = False
    """Dots in place of a line."""


@dataclass(frozen=True, kw_only=True)
class Chart:
    """Curves over one axis."""

    name: str
    x_label: str
    y_label: str
    curves: Sequence[Curve]
    levels: Sequence[tuple[float, Colour, str]] = field(default=())
    """Height, colour and meaning of lines across the chart."""
    low: float | None = None
    """Lower end of the y axis; None to fit the curves."""
    high: float | None = None


def segments(start: Places, end: Places) -> NDArray[np.float64]:
    """Lines (k, 2, 2) from each start to its end."""
    return np.stack([np.asarray(start, np.float64), np.asarray(end, np.float64)], axis=1)


def by_code(codes: NDArray[np.uint8], words: Sequence[str]) -> Iterator[tuple[int, str, NDArray[np.intp]]]:
    """Number, word and rows of each code that there is, the lowest code last: what it marks is seen best on top."""
    for code in sorted(np.unique(codes).tolist(), reverse=True):
        yield code, words[code], np.flatnonzero(codes == code)


def path_name(word: str) -> str:
    """A word as the name of a mark."""
    return word.replace(" ", "_").replace("-", "_")


def reduced(raster: NDArray[Any], by: int) -> NDArray[Any]:
    """Maximum of each block of `by` x `by` cells; blocks at the right and lower edge may be smaller."""
    rows, cols = (np.arange(0, length, by) for length in raster.shape)
    by_rows = np.maximum.reduceat(raster, rows, axis=0)
    return np.asarray(np.maximum.reduceat(by_rows, cols, axis=1))


def wrapped(labels: NDArray[np.int32]) -> NDArray[Any]:
    """Labels as codes in the smallest type that holds them; from 65,536 on, numbers begin again at 1."""
    most = int(labels.max(initial=0))
    if most < MOST_CODES:
        return labels.clip(0).astype(np.uint8 if most < 2**8 else np.uint16)
    return np.where(labels > 0, (labels - 1) % (MOST_CODES - 1) + 1, 0).astype(np.uint16)
