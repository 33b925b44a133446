"""Marks of a stage drawn on a Rerun stream: one entity for each, so that a viewer can switch it on and off."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import Any

import numpy as np
import rerun as rr
from numpy.typing import NDArray

from vdoor.viz.marks.kinds import Arrows, Cells, Dots, Lines, Mark
from vdoor.viz.picture.layout import Box, free_places
from vdoor.viz.rerun import style
from vdoor.viz.rerun.scene import Scene, classes, pixels

SEEN_PX = 600.0
"""About the size of a map's longer side in the viewer's tabs, by which labels that would cover others are found."""
LETTER_PX, LABEL_PX = 7.0, 24.0
"""Width of a letter, and height of a label, in the viewer."""
HEAD_LONG, HEAD_WIDE = 0.4, 0.2
"""Size of an arrow's head, as shares of its length."""
WHITE = (255, 255, 255)
GROUND = "cells"
"""Marks of that name are the ground of their stage, and have its entity."""


def draw_marks(scene: Scene, prefix: str, marks: Iterable[Mark], *, order: float) -> None:
    """Draw marks, the first at the bottom, from a draw order on, and their labels over all of them."""
    labelled: list[Dots | Lines] = []
    for number, mark in enumerate(marks):
        entity = prefix if mark.name == GROUND else f"{prefix}/{mark.name}"
        if isinstance(mark, Cells):
            _draw_cells(scene, entity, mark, order + number / 10)
        else:
            scene.log(entity, _shape(mark, order + number / 10))
        if isinstance(mark, Dots | Lines) and mark.labels:
            labelled.append(mark)
    if labelled:
        scene.log(f"{prefix}/labels", _labels(labelled, order + 1))


def _draw_cells(scene: Scene, entity: str, mark: Cells, order: float) -> None:
    there = np.flatnonzero(np.bincount(mark.codes.ravel())).tolist()
    named = {code: mark.colours.get(code, (style.CLEAR, "")) for code in sorted({0, *there, *mark.colours})}
    scene.keep(entity, classes({code: (text, colour) for code, (colour, text) in named.items()}))
    scene.raster(entity, mark.codes, order=order, opacity=mark.opacity)


def _shape(mark: Mark, order: float) -> Any:
    """Dots, lines or arrows. Negative radii are in pixels of the screen, so they can be seen on maps of any size."""
    common: dict[str, Any] = {"draw_order": order, **_texts(mark)}
    if isinstance(mark, Dots):
        return rr.Points2D(pixels(mark.cell), colors=mark.colour, radii=-mark.wide_px / 2, **common)
    if isinstance(mark, Lines):
        strips = [pixels(strip).astype(np.float32) for strip in mark.strips]
        return rr.LineStrips2D(strips, colors=mark.colour, radii=-mark.wide_px / 2, **common)
    assert isinstance(mark, Arrows)
    arrows = [pixels(arrow).astype(np.float32) for arrow in _with_heads(mark)]
    return rr.LineStrips2D(arrows, colors=mark.colour, radii=-mark.wide_px / 2, draw_order=order)


def _with_heads(mark: Arrows) -> NDArray[np.float64]:
    """Arrows as lines (k, 5, 2) with heads that grow with them: the viewer's own are as small as a line is thin."""
    by = np.asarray(mark.vector, np.float64)
    tail = np.asarray(mark.cell, np.float64)
    tip, aside = tail + by, HEAD_WIDE * by[:, ::-1] * [1, -1]
    back = tip - HEAD_LONG * by
    return np.stack([tail, tip, back + aside, tip, back - aside], axis=1)


def _labels(marks: Sequence[Dots | Lines], order: float) -> rr.Points2D:
    """The labels, in white, those of dots first; one that would cover another is left to the pointer.

    Text has the colour of its element, and the viewer writes it below: so labels are elements of their own.
    """
    found = [item for kind in (Dots, Lines) for mark in marks if isinstance(mark, kind) for item in _places(mark)]
    frame = marks[0].frame
    px_per_cell = min(SEEN_PX / frame.width, SEEN_PX / frame.height)
    box = Box(-SEEN_PX, -SEEN_PX, 3 * SEEN_PX, 3 * SEEN_PX)
    sizes = [(LETTER_PX * len(text) + 14, LABEL_PX) for text, _ in found]
    tries = [[(x * px_per_cell, y * px_per_cell)] for _, (x, y) in found]
    free = [item for item, place in zip(found, free_places(sizes, tries, box), strict=True) if place]
    texts, points = [text for text, _ in free], np.array([point for _, point in free])
    return rr.Points2D(points, labels=texts, show_labels=True, colors=WHITE, radii=-0.5, draw_order=order)


def _places(mark: Dots | Lines) -> Iterator[tuple[str, NDArray[np.float64]]]:
    """Each label of a mark with its place: that of a dot, or the middle of a line."""
    cells = mark.cell if isinstance(mark, Dots) else np.array([np.mean(strip, axis=0) for strip in mark.strips])
    yield from zip(mark.labels, pixels(cells), strict=False)


def _texts(mark: Mark) -> dict[str, Any]:
    """Texts that are seen when the pointer is over an element."""
    return {"labels": mark.tips, "show_labels": False} if mark.tips else {}
