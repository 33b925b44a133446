"""A map with its marks, drawn into a box of a sheet."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Rectangle
from matplotlib.patheffects import withStroke
from numpy.typing import NDArray

from vdoor.frame import Frame
from vdoor.viz.marks.kinds import Arrows, Cells, Dots, Lines, Mark, Places
from vdoor.viz.picture.cells import draw_cells
from vdoor.viz.picture.layout import Box, free_places
from vdoor.viz.picture.sheet import INK, POINTS_PER_PX, Entry, Sheet, hex_of, width_of
from vdoor.viz.rerun import style

Floats = NDArray[np.float64]
BAR_PX = 24.0
"""Height of the line with the scale."""
SPARE = 0.02
"""Margin around what is known, as a share of the longer side."""
CROWD = 80
"""Marks of more elements than that are drawn smaller."""
LEAST_CROWDED = 0.6
ARROW: dict[str, Any] = {
    "angles": "xy",
    "scale_units": "xy",
    "scale": 1,
    "units": "dots",
    "pivot": "tail",
    "headwidth": 6,
    "headlength": 7,
    "headaxislength": 6,
    "minlength": 0,
}
"""Arrows as long as their vectors, with heads of a size in pixels."""
LABEL_PX, NUMBER_PX = 13.0, 11.0


class Window(NamedTuple):
    """The part of a map that is seen, in metres right and down from the upper left corner of its frame."""

    frame: Frame
    left: float
    top: float
    width: float
    height: float

    @classmethod
    def around(cls, frame: Frame, seen: NDArray[np.bool_]) -> Window:
        """Some cells (h, w) of a raster, with a margin; all of it if there are none."""
        rows, cols = (np.flatnonzero(seen.any(axis=axis)) for axis in (1, 0))
        if not len(rows):
            rows, cols = np.array([0, frame.height - 1]), np.array([0, frame.width - 1])
        (top, bottom), (left, right) = ((int(own[0]), int(own[-1]) + 1) for own in (rows, cols))
        spare = SPARE * max(bottom - top, right - left) + 2
        cells = (left - spare, top - spare, right - left + 2 * spare, bottom - top + 2 * spare)
        return cls(frame, *(cell * frame.resolution_m for cell in cells))

    def points(self, cells: Places, frame: Frame) -> Floats:
        """Cells (k, 2) of any frame as x, y (k, 2) of the window's frame."""
        own = self.frame.cell_from_world(frame.world_from_cell(cells))
        return (own[:, ::-1] + 0.5) * self.frame.resolution_m

    def placed(self, frame: Frame, box: Box) -> Box:
        """Where all of a frame would be in a picture that shows the window in a box."""
        px_per_m = box.width / self.width
        x, y = self.points(np.array([[-0.5, -0.5]]), frame)[0]
        size_px = frame.resolution_m * px_per_m
        left, top = box.left + (x - self.left) * px_per_m, box.top + (y - self.top) * px_per_m
        return Box(float(left), float(top), frame.width * size_px, frame.height * size_px)


def draw_plan(sheet: Sheet, box: Box, window: Window, marks: Sequence[Mark]) -> None:
    """Draw the marks, the first at the bottom, then their labels and the scale."""
    axes = sheet.axes(box)
    axes.set(xlim=(window.left, window.left + window.width), ylim=(window.top + window.height, window.top))
    axes.set_axis_off()
    corner = window.left, window.top
    axes.add_patch(Rectangle(corner, window.width, window.height, color=hex_of(style.UNKNOWN), linewidth=0))
    px_per_m = box.width / window.width
    for order, mark in enumerate(marks, start=2):
        if isinstance(mark, Cells):
            draw_cells(axes, box, mark, window.placed(mark.frame, box), order)
        else:
            _draw(axes, window, mark, order)
    _draw_labels(sheet, box, window, marks, px_per_m)
    _draw_bar(sheet, box, px_per_m)


def fitted(marks: Sequence[Mark]) -> list[Mark]:
    """The marks as they are drawn: none without elements, and smaller where there are many of a kind and size."""
    sizes = [(type(mark), getattr(mark, "wide_px", 0.0)) for mark in marks]
    total = Counter[tuple[type, float]]()
    for own, mark in zip(sizes, marks, strict=True):
        total[own] += _count(mark)
    return [
        replace(mark, wide_px=mark.wide_px * crowded(total[own])) if isinstance(mark, Dots | Lines) else mark
        for own, mark in zip(sizes, marks, strict=True)
        if _count(mark)
    ]


def _count(mark: Mark) -> int:
    return len(mark.strips) if isinstance(mark, Lines) else len(mark.cell) if isinstance(mark, Dots | Arrows) else 1


def crowded(count: int) -> float:
    """Size of marks as a share of what they have when they are few."""
    return max(math.sqrt(CROWD / max(count, CROWD)), LEAST_CROWDED)


def entries(marks: Sequence[Mark]) -> list[Entry]:
    """The legend: a line for each mark with a meaning, and for each code of cells."""
    found: list[Entry] = []
    for mark in marks:
        if isinstance(mark, Cells):
            there = [code for code in sorted(mark.colours) if mark.listed and (mark.codes == code).any()]
            found += [Entry("s", *mark.colours[code]) for code in there]
        elif mark.meaning:
            sign = "o" if isinstance(mark, Dots) else ">" if isinstance(mark, Arrows) else "-"
            found.append(Entry(sign, mark.colour, mark.meaning, mark.wide_px))  # type: ignore[attr-defined]
    return list(dict.fromkeys(found))


def _draw(axes: Axes, window: Window, mark: Mark, zorder: float) -> None:
    if isinstance(mark, Dots):
        x, y = window.points(mark.cell, mark.frame).T
        size = mark.wide_px * POINTS_PER_PX
        axes.plot(x, y, "o", color=hex_of(mark.colour), markersize=size, markeredgewidth=0, zorder=zorder)
    elif isinstance(mark, Lines):
        x, y = _joined(mark, window)
        wide = mark.wide_px * POINTS_PER_PX
        axes.plot(x, y, color=hex_of(mark.colour), linewidth=wide, solid_capstyle="round", zorder=zorder)
    elif isinstance(mark, Arrows):
        start, end = (window.points(cell, mark.frame) for cell in (mark.cell, mark.cell + mark.vector))
        by = end - start
        axes.quiver(*start.T, *by.T, color=hex_of(mark.colour), width=mark.wide_px, zorder=zorder, **ARROW)


def _joined(mark: Lines, window: Window) -> tuple[Floats, Floats]:
    """All lines as one, parted by nan: it is drawn far sooner than many."""
    ends = np.cumsum([len(strip) for strip in mark.strips])[:-1]
    places = window.points(np.concatenate([*mark.strips]), mark.frame)
    x, y = np.insert(places, ends, np.nan, axis=0).T
    return x, y


def _draw_labels(sheet: Sheet, box: Box, window: Window, marks: Sequence[Mark], px_per_m: float) -> None:
    """Write the labels beside their elements, those of dots first; one that would cover another is left out."""
    wanted = [
        item for kind in (Dots, Lines) for mark in marks if isinstance(mark, kind) for item in _labels(mark, window)
    ]
    sizes = [(width_of(text, px, bold=True) + 6, px + 5) for text, px, *_ in wanted]
    tries = []
    for (width, height), (_, _, at, aside, _) in zip(sizes, wanted, strict=True):
        x = box.left + (at[0] - window.left) * px_per_m
        y = box.top + (at[1] - window.top) * px_per_m
        tries.append([*_around(x, y, width, height, aside)])
    for (text, px, *_, colour), place in zip(wanted, free_places(sizes, tries, box), strict=True):
        if place is not None:
            look: dict[str, Any] = {"color": colour, "ha": "center", "fontweight": "bold"}
            sheet.write(*place, text, size_px=px, path_effects=[withStroke(linewidth=3, foreground="white")], **look)


def _labels(mark: Dots | Lines, window: Window) -> Iterator[tuple[str, float, Floats, float, str]]:
    """Text, size, place, distance from the place, and colour of each label of a mark."""
    if isinstance(mark, Dots):
        places = window.points(mark.cell, mark.frame)[: len(mark.labels)]
        yield from ((text, LABEL_PX, at, mark.wide_px / 2, INK) for text, at in zip(mark.labels, places, strict=True))
    else:
        strips = zip(mark.labels, mark.strips, strict=True) if len(mark.labels) else ()
        for text, strip in strips:
            middle = window.points(np.mean(strip, axis=0)[None], mark.frame)[0]
            yield text, NUMBER_PX, middle, mark.wide_px, hex_of(mark.colour)


def _around(x: float, y: float, width: float, height: float, aside: float) -> Iterator[tuple[float, float]]:
    """Middles to try for a label, near a place: below, above, right, left, then farther off."""
    for far in (1.0, 2.2):
        down, right = (aside + height / 2) * far, (aside + width / 2) * far
        yield from ((x, y + down), (x, y - down), (x + right, y), (x - right, y))
        yield from ((x + right, y + down), (x - right, y + down), (x + right, y - down), (x - right, y - down))


def _draw_bar(sheet: Sheet, box: Box, px_per_m: float) -> None:
    """Draw the scale below the map: a bar of a round number of metres, about a fifth of the map's width."""
    length_m = round_length_m(box.width / px_per_m / 5)
    long_px, y = length_m * px_per_m, box.top + box.height + BAR_PX / 2
    for x1, x2, up in ((0.0, long_px, 0.0), (0.0, 0.0, 4.0), (long_px, long_px, 4.0)):
        ends = [box.left + 1 + x1, box.left + 1 + x2], [y - up, y + up]
        sheet.line(*ends)
    sheet.write(box.left + long_px + 8, y, f"{length_m:g} m", size_px=12)


def round_length_m(length_m: float) -> float:
    """The largest of 1, 2 and 5 times a power of ten that is no more than a length."""
    power = 10.0 ** math.floor(math.log10(max(length_m, 1e-9)))
    return max(part * power for part in (1, 2, 5) if part == 1 or part * power <= length_m)
