"""Where the parts of a picture go: maps as large as they can be, charts below or beside them. All in pixels."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

MARGIN, GAP = 18.0, 22.0
CHART_HEIGHT, LEAST_CHART_HEIGHT = 270.0, 200.0
CHART_SHARE = 0.44
"""Share of the width that charts beside maps take."""
LEAST_WIDTH = 420.0
"""Of a map with its legend, so that the legend can be read."""
LEAST_PICTURE = 640.0
"""Width of a picture, so that its heading can be read."""


class Box(NamedTuple):
    """A rectangle, y down from the upper left corner of the picture."""

    left: float
    top: float
    width: float
    height: float


@dataclass(frozen=True)
class Layout:
    """The size of a picture, and where its panels are: boxes of the maps alone, without what is above and below."""

    width: float
    height: float
    maps: tuple[Box, ...]
    charts: tuple[Box, ...]
    across: float
    """Width that the legend of each map has."""


@dataclass(frozen=True)
class Wanted:
    """What is to be laid out."""

    aspect: float
    """Width of a map over its height; all maps of a picture show the same place."""
    maps: int
    charts: int
    head: float
    """Height of the heading."""
    above: float
    """Height above each map, of its title."""
    below: float
    """Height below each map, of its legend."""


def laid_out(wanted: Wanted, most: tuple[float, float]) -> Layout:
    """The arrangement in which maps are largest, within a width and height; its height may be less than that."""
    options = [
        _arranged(wanted, most, columns, beside=beside)
        for columns, beside in itertools.product({1, wanted.maps}, {False, wanted.charts > 0})
    ]
    return max(options, key=lambda option: option.maps[0].width)


def charts_alone(charts: int, width: float, head: float) -> Layout:
    """Charts one below the other, in a picture without a map."""
    height = charts * (CHART_HEIGHT + GAP) - GAP
    boxes = _stacked(Box(MARGIN, MARGIN + head, width - 2 * MARGIN, height), charts)
    return Layout(width, head + height + 2 * MARGIN, (), boxes, 0.0)


def _arranged(wanted: Wanted, most: tuple[float, float], columns: int, *, beside: bool) -> Layout:
    rows = -(-wanted.maps // columns)
    left = top = MARGIN
    top += wanted.head
    across = most[0] - 2 * MARGIN - (most[0] * CHART_SHARE if beside else 0.0)
    down = most[1] - top - MARGIN - (0.0 if beside or not wanted.charts else CHART_HEIGHT + GAP)
    widest = (across - GAP * (columns - 1)) / columns
    highest = (down - GAP * (rows - 1)) / rows - wanted.above - wanted.below
    width = max(min(widest, highest * wanted.aspect), 1.0)
    height = width / wanted.aspect
    column = max(width, min(LEAST_WIDTH, widest))
    row = wanted.above + height + wanted.below
    maps = tuple(
        Box(left + at % columns * (column + GAP), top + at // columns * (row + GAP) + wanted.above, width, height)
        for at in range(wanted.maps)
    )
    right = left + columns * column + (columns - 1) * GAP
    bottom = top + rows * row + (rows - 1) * GAP
    if beside:
        chart = most[0] - MARGIN - right - GAP
        whole = max(bottom - top, wanted.charts * LEAST_CHART_HEIGHT)
        charts = _stacked(Box(right + GAP, top, chart, whole), wanted.charts)
        return Layout(most[0], top + whole + MARGIN, maps, charts, column)
    full = max(right + MARGIN, LEAST_PICTURE)
    legend = column if columns > 1 else full - 2 * MARGIN
    if not wanted.charts:
        return Layout(full, bottom + MARGIN, maps, (), legend)
    charts = _side_by_side(Box(left, bottom + GAP, full - 2 * MARGIN, CHART_HEIGHT), wanted.charts)
    return Layout(full, bottom + GAP + CHART_HEIGHT + MARGIN, maps, charts, legend)


def _stacked(box: Box, count: int) -> tuple[Box, ...]:
    height = (box.height - GAP * (count - 1)) / count
    return tuple(Box(box.left, box.top + at * (height + GAP), box.width, height) for at in range(count))


def _side_by_side(box: Box, count: int) -> tuple[Box, ...]:
    width = (box.width - GAP * (count - 1)) / count
    return tuple(Box(box.left + at * (width + GAP), box.top, width, box.height) for at in range(count))


def flowed(widths: Sequence[float], across: float) -> list[tuple[int, float]]:
    """Line and place of items that are written one after the other, as many in a line as there is room for."""
    places, line, at = [], 0, 0.0
    for width in widths:
        if at and at + width > across:
            line, at = line + 1, 0.0
        places.append((line, at))
        at += width
    return places


def free_places(
    sizes: Sequence[tuple[float, float]], tries: Sequence[Sequence[tuple[float, float]]], within: Box
) -> list[tuple[float, float] | None]:
    """For each label of a size the first middle, of those to try, where it covers no label before it; None if none."""
    taken: list[tuple[float, float, float, float]] = []
    found: list[tuple[float, float] | None] = []
    for (width, height), middles in zip(sizes, tries, strict=True):
        found.append(None)
        for x, y in middles:
            own = (x - width / 2, y - height / 2, x + width / 2, y + height / 2)
            if _inside(own, within) and not any(_overlap(own, other) for other in taken):
                found[-1] = x, y
                taken.append(own)
                break
    return found


def _inside(own: tuple[float, float, float, float], box: Box) -> bool:
    left, top, right, bottom = own
    return left >= box.left and top >= box.top and right <= box.left + box.width and bottom <= box.top + box.height


def _overlap(one: tuple[float, float, float, float], other: tuple[float, float, float, float]) -> bool:
    return one[0] < other[2] and other[0] < one[2] and one[1] < other[3] and other[1] < one[3]
