"""Parts of the free space that are not connected: which of them are indoors, and sills that join two of them."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from vdoor.method.spaces import grown
from vdoor.raster.morphology import dilated, distances, eroded, exact, room_for, square
from vdoor.raster.runs import Runs, parts_of_mask, runs_of

Mask = NDArray[np.bool_]
Ints = NDArray[np.int32]
Cells = NDArray[np.int64]

NARROW_M, WIDE_M = 0.5, 1.2
"""Side of the square that fits into every room, and of one that fits into no hollow furniture."""
WALL_M = 0.25
"""Largest thickness of the sides of hollow furniture."""
WALLED_SHARE = 0.4
"""A small room has walls along at least this share of its boundary."""
HOLLOW_SHARE = 0.55
"""Hollow furniture has at least this share of its boundary beside the same room: about three sides."""


def large_parts(parts: Runs, free: Mask, wall: Mask, least: float, cell_m: float) -> Mask:
    """Which of the 4-connected `parts` (count + 1,) of `free` are rooms.

    They have at least `least` cells and fit a square of `NARROW_M`. One that fits no square of `WIDE_M` is not hollow
    furniture, that is, does not stand in a single other part; and it is not ground outside that was seen through a
    window, that is, has `wall` cells beside much of its boundary.
    """
    kept = large(parts, least) & wide_enough(parts, free, NARROW_M / cell_m)
    unsure = kept & ~wide_enough(parts, free, WIDE_M / cell_m)
    boxes = parts.chosen(unsure).boxes(parts.most)
    for number in np.flatnonzero(unsure).tolist():
        top, left, bottom, right = boxes[number - 1].tolist()
        near = grown((slice(top, bottom), slice(left, right)), int(WALL_M / cell_m) + 2, free.shape)
        labels = parts.inside(near).image()
        hollow = shared_side(labels, number, WALL_M / cell_m) >= HOLLOW_SHARE
        kept[number] = not hollow and walled((labels == number).astype(np.int32), 1, wall[near])[1]
    return kept


def wide_parts(parts: Runs, free: Mask, least: float, cell_m: float) -> Mask:
    """Which of the `parts` (count + 1,) of `free` have at least `least` cells and fit a square of `WIDE_M`."""
    return large(parts, least) & wide_enough(parts, free, WIDE_M / cell_m)


def large(parts: Runs, least: float) -> Mask:
    """Which labels (count + 1,) have at least `least` cells; 0 has not."""
    return np.append(False, parts.cells(parts.most) >= least)


def remaining(parts: Runs, before: Mask) -> Mask:
    """Which of the `parts` (count + 1,) are the largest piece that is left of a 4-connected part of `before` (h, w)."""
    cells = parts.cells(parts.most)
    part_of = parts_of_mask(before).at(parts.first_cells(parts.most))  # any cell will do: a piece lies in one part
    order = np.lexsort((np.arange(len(cells)), -cells, part_of))
    leads = np.append(True, part_of[order][1:] != part_of[order][:-1])[: len(order)]
    chosen = np.zeros(len(cells) + 1, np.bool_)
    chosen[1 + order[leads & (part_of[order] > 0)]] = True
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


def wide_enough(parts: Runs, free: Mask, width: float) -> Mask:
    """Which of the 4-connected `parts` (count + 1,) of `free` fit a square of `width` cells."""
    inner = runs_of(room_for(free, square(max(1, round(width)))))
    found = np.zeros(parts.most + 1, np.bool_)
    found[parts.at(inner.first)] = True
    return found


def sills(unknown: Mask, part: Runs, thick: int, least: float) -> Mask:
    """Unknown cells (h, w) in strips at most `thick` cells thick between two parts, at least `least` cells long.

    Robots often do not see the floor of a doorway: it is mapped from both rooms up to the sill.
    """
    found = np.zeros(unknown.shape, np.bool_)
    flat = found.reshape(-1)
    for step, length in zip((unknown.shape[1], 1), unknown.shape, strict=True):
        for cell in _strips(unknown.reshape(-1), part, thick, step, length):
            flat[cell] = True
    return long_pieces(found, least, connectivity=2)


def _strips(unknown: Mask, part: Runs, thick: int, step: int, length: int) -> Iterator[Cells]:
    """Flat indices of cells of strips that run across the axis with `length` places, `step` cells apart."""
    inside = part.mask().reshape(-1)
    before = np.flatnonzero(inside[:-step] & unknown[step:])
    for size in range(1, thick + 1):
        place = before // step % length  # without the others there is no cell behind the strip
        before = before[place + size + 1 < length]
        before = before[unknown[before + size * step]]
        over = before[inside[before + (size + 1) * step]]
        over = over[part.at(over) != part.at(over + (size + 1) * step)]
        yield from (over + way * step for way in range(1, size + 1))


def long_pieces(mask: Mask, least: float, connectivity: int = 1) -> Mask:
    """The pieces of `mask`, 4-connected (1) or 8-connected (2), whose bounding boxes are longer than `least` cells."""
    pieces = parts_of_mask(mask, connectivity)
    return pieces.chosen(sides_of(pieces) > least).mask()


def sides_of(parts: Runs) -> NDArray[np.int64]:
    """The longer side (count + 1,) of each part's bounding box, in cells; 0 for label 0."""
    boxes = parts.boxes(parts.most)
    return np.append(0, (boxes[:, 2:] - boxes[:, :2]).max(axis=1, initial=0))
