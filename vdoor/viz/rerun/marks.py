"""Marks of a stage drawn on a Rerun stream: one entity for each, so that a viewer can switch it on and off."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
import rerun as rr

from vdoor.viz.marks.kinds import Arrows, Cells, Dots, Lines, Mark
from vdoor.viz.rerun import style
from vdoor.viz.rerun.scene import Scene, classes, pixels

MOST_LABELS = 40
"""With more labels than that, text is shown for the element below the pointer only: they would cover each other."""
GROUND = "cells"
"""Marks of that name are the ground of their stage, and have its entity."""


def draw_marks(scene: Scene, prefix: str, marks: Iterable[Mark], *, order: float) -> None:
    """Draw marks, the first at the bottom, from a draw order on."""
    for number, mark in enumerate(marks):
        entity = prefix if mark.name == GROUND else f"{prefix}/{mark.name}"
        if isinstance(mark, Cells):
            _draw_cells(scene, entity, mark, order + number / 10)
        else:
            scene.log(entity, _shape(mark, order + number / 10))


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
    vectors = np.asarray(mark.vector, np.float64)[:, ::-1]
    return rr.Arrows2D(
        origins=pixels(mark.cell), vectors=vectors, colors=mark.colour, radii=-mark.wide_px / 2, draw_order=order
    )


def _texts(mark: Mark) -> dict[str, Any]:
    if mark.labels and len(mark.labels) <= MOST_LABELS:
        return {"labels": mark.labels, "show_labels": True}
    return {"labels": mark.tips, "show_labels": False} if mark.tips else {}
