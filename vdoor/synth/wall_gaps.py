"""Where walls are interrupted: gaps that no robot fits through, along the faces of a plan's floors."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from vdoor.grid import FREE
from vdoor.synth.canvas import FINE_M, Axis, Canvas, Rect
from vdoor.synth.layout import Layout
from vdoor.synth.sense import Face
from vdoor.synth.wall_style import PIECE_M, THIN_M, Gaps

CORNER_M = 0.2
"""Left whole where walls end or turn, so that two gaps never make one about a corner."""
JAMB_M = 0.15
"""Left whole beside doors, so that they stay as wide as they are."""
DEEPEST_M = 0.6
"""No wall between two rooms is thicker."""
FACE_M = 0.3
"""Scans show no more of a wall's face than this."""
SHUT, UNKNOWN_FACE, FREE_FACE, THROUGH = range(4)
"""No gap; one in a face only, which shows unknown or free cells; one through which the other side is seen."""


def gap_raster(layout: Layout, floor: Canvas, gaps: Gaps, cell_m: float, rng: np.random.Generator) -> NDArray[np.uint8]:
    """Return on the fine raster which cells are SHUT, and which kind of gap the others are in.

    Each gap lies in a wall, square to it, and no other one is near it on the same face.
    """
    found = Canvas(np.zeros(floor.rooms.shape, np.int32))
    doors = [gap.rect.grown(JAMB_M + cell_m, JAMB_M + cell_m) for gap in layout.gaps]
    shown = FREE_FACE if gaps.face == FREE else UNKNOWN_FACE
    axes: tuple[Axis, Axis] = (0, 1)
    for room, rect in enumerate((*layout.floors, *layout.pits)):
        near = [door for door in doors if door.overlaps(rect.grown(DEEPEST_M, DEEPEST_M))]
        for face in (Face(room, rect, axis, sign) for axis in axes for sign in (-1, 1)):
            for start_m, width_m in _along(face, gaps, cell_m, rng):
                through = THROUGH if rng.random() < gaps.free_share else UNKNOWN_FACE
                hole = _hole(face, floor, start_m, width_m)
                if hole is None or any(door.overlaps(hole[0]) for door in near):
                    continue
                beside = hole[0].spanning(face.along, start_m - CORNER_M, start_m + width_m + CORNER_M)
                if not found.rooms[found.window(beside)].any():
                    found.paint(hole[0], through if hole[1] else shown)
    return found.rooms.astype(np.uint8)


def _along(face: Face, gaps: Gaps, cell_m: float, rng: np.random.Generator) -> Iterator[tuple[float, float]]:
    """Yield start and width of gaps along a face, with pieces of wall of about one length between them."""
    low, high = face.floor.low[face.along], face.floor.high[face.along]
    at = low + max(rng.uniform(0.0, gaps.piece_m), CORNER_M)
    while True:
        width = int(rng.integers(1, gaps.cells_max + 1)) * cell_m
        if at + width > high - CORNER_M:
            return
        yield at, width
        at += width + float(np.clip(gaps.piece_m * rng.uniform(0.6, 1.4), *PIECE_M))


def _hole(face: Face, floor: Canvas, start_m: float, width_m: float) -> tuple[Rect, bool] | None:
    """Return what a gap takes of the wall behind a face, and whether that is all of it, up to another floor.

    Nothing where the wall ends or turns. A thin wall is left to the upper one of its two sides' floors, or gaps from
    both sides would meet.
    """
    beside = (start_m - CORNER_M, start_m, start_m + width_m, start_m + width_m + CORNER_M)
    if any(floor.at(_behind(face, at_m, 0.0, FINE_M).middle) for at_m in beside):
        return None
    depth_m = _thickness(face, floor, start_m + width_m / 2)
    if depth_m <= THIN_M + FINE_M / 2:
        return (_behind(face, start_m, width_m, depth_m), True) if face.sign < 0 and depth_m else None
    return _behind(face, start_m, width_m, min(depth_m / 2, FACE_M)), False


def _behind(face: Face, start_m: float, width_m: float, depth_m: float) -> Rect:
    """Return a part of the wall behind a face."""
    ends = sorted((face.at_m, face.at_m + face.sign * depth_m))
    return face.floor.spanning(face.axis, *ends).spanning(face.along, start_m, start_m + width_m)


def _thickness(face: Face, floor: Canvas, at_m: float) -> float:
    """Return how far it is from a face to the next floor behind it, or 0.6 m where none is near."""
    for k in range(round(DEEPEST_M / FINE_M)):
        point = _behind(face, at_m, 0.0, (2 * k + 1) * FINE_M).middle
        if floor.at(point):
            return k * FINE_M
    return DEEPEST_M
