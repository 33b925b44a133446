"""Parts of the free space that are not connected: which of them are indoors, and sills that join two of them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from vdoor.grid import UNKNOWN
from vdoor.method.spaces import grown
from vdoor.raster.morphology import components_of, dilated, distances, eroded, exact, labelled, room_for, square
from vdoor.raster.runs import runs_of

Mask = NDArray[np.bool_]
Ints = NDArray[np.int32]

NARROW_M, WIDE_M = 0.5, 1.2
"""Side of the square that fits into every room, and of one that fits into no hollow furniture."""
WALL_M = 0.25
"""Largest thickness of the sides of hollow furniture."""
WALLED_SHARE = 0.4
"""A small room has walls along at least this share of its boundary."""
HOLLOW_SHARE = 0.55
"""Hollow furniture has at least this share of its boundary beside the same room: about three sides."""


def large_parts(free: Mask, wall: Mask, least: float, cell_m: float) -> Ints:
    """The 4-connected parts (h, w) of `free` that are rooms, numbered; 0 elsewhere.

    They have at least `least` cells and fit a square of `NARROW_M`. One that fits no square of `WIDE_M` is not hollow
    furniture, that is, does not stand in a single other part; and it is not ground outside that was seen through a
    window, that is, has `wall` cells beside much of its boundary.
    """
    parts = components_of(free)
    labels, kept = parts.label, parts.cells >= least
    kept[0] = False
    kept &= wide_enough(labels, kept, NARROW_M / cell_m)
    unsure = kept & ~wide_enough(labels, kept, WIDE_M / cell_m)
    for number in np.flatnonzero(unsure).tolist():
        near = grown(parts.box(number), int(WALL_M / cell_m) + 2, free.shape)
        hollow = shared_side(labels[near], number, WALL_M / cell_m) >= HOLLOW_SHARE
        kept[number] = not hollow and walled((labels[near] == number).astype(np.int32), 1, wall[near])[1]
    return labels * kept[labels]


def wide_parts(labels: Ints, least: float, cell_m: float) -> Mask:
    """Which labels (count + 1,) have at least `least` cells and fit a square of `WIDE_M`."""
    chosen = np.bincount(labels.ravel(), minlength=int(labels.max(initial=0)) + 1) >= least
    chosen[0] = False
    return wide_enough(labels, chosen, WIDE_M / cell_m)


def remaining(labels: Ints, before: Mask) -> Mask:
    """Which labels (count + 1,) are the largest piece that is left of a 4-connected part of `before` (h, w)."""
    part = labelled(before)
    cells = np.bincount(labels.ravel(), minlength=int(labels.max(initial=0)) + 1)
    runs = runs_of(labels)
    part_of = np.zeros(len(cells), np.int64)
    part_of[runs.label] = part[runs.row, runs.begin]  # any cell will do: a piece lies in one part
    order = np.lexsort((np.arange(len(cells)), -cells, part_of))
    leads = np.append(True, part_of[order][1:] != part_of[order][:-1])
    chosen = np.zeros(len(cells), np.bool_)
    chosen[order[leads & (part_of[order] > 0)]] = True
    return chosen


def shared_side(labels: Ints, number: int, thick: float) -> float:
    """The share of a part's boundary behind which the same other part lies, through at most `thick` cells of wall."""
    part = labels == number
    edge = part & ~eroded(part)
    others, cells = np.unique(labels[(labels > 0) & ~part], return_counts=True)
    if not len(others):
        return 0.0
    away = distances(labels != others[cells.argmax()])
    return float((exact(away[edge]) <= thick + 1).mean())


def walled(labels: NDArray[np.integer], count: int, wall: Mask) -> Mask:
    """Which of the 4-connected parts (count + 1,) have walls along enough of their boundary to be indoors."""
    edge = (labels > 0) & ~eroded(labels > 0)
    beside = edge & dilated(wall)
    cells, walls = (np.bincount(labels[where], minlength=count + 1) for where in (edge, beside))
    found = walls >= WALLED_SHARE * cells
    found[0] = False
    return np.asarray(found)


def wide_enough(labels: NDArray[np.int32], chosen: Mask, width: float) -> Mask:
    """Which of the labels `chosen` (count + 1,) fit a square of `width` cells."""
    side = max(1, round(width))
    inner = room_for(chosen[labels], square(side))
    found = np.zeros(len(chosen), np.bool_)
    found[labels[inner]] = True
    return found


def sills(cells: NDArray[np.int8], part: Ints, thick: int, least: float) -> Mask:
    """Unknown cells (h, w) in strips at most `thick` cells thick between two parts, at least `least` cells long.

    Robots often do not see the floor of a doorway: it is mapped from both rooms up to the sill.
    """
    unknown = cells == UNKNOWN
    found = np.zeros(cells.shape, np.bool_)
    for strip, gap, label in ((found, unknown, part), (found.T, unknown.T, part.T)):
        for size in range(1, min(thick, len(label) - 2) + 1):
            before, after = label[: -size - 1], label[size + 1 :]
            inner = [gap[1 + step : len(gap) - size + step] for step in range(size)]
            across = np.logical_and.reduce([(before > 0) & (after > 0) & (before != after), *inner])
            for step in range(size):
                strip[1 + step : len(gap) - size + step] |= across
    return long_pieces(found, least, connectivity=2)


def long_pieces(mask: Mask, least: float, connectivity: int = 1) -> Mask:
    """The pieces of `mask`, 4-connected (1) or 8-connected (2), whose bounding boxes are longer than `least` cells."""
    pieces = components_of(mask, connectivity)
    found = np.zeros_like(mask)
    found[mask] = (pieces.sides > least)[pieces.label[mask]]
    return found
