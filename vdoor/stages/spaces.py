"""Spaces of a robot: what is wide enough for it, the gaps between them, and the obstacles that hold two of them apart.

A gap that no robot fits through is no way, so it counts as closed. Pieces of an obstacle with such gaps between them
are one wall where they hold two spaces apart, and furniture where one can walk around them.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage
from scipy.sparse import coo_array
from skimage.measure import label as label_cells

Ints = NDArray[np.int32]
Mask = NDArray[np.bool_]
Box = tuple[slice, ...]

RIM = 2
"""Cells around a narrow place within which the space beside it hangs together, where it is a nook and no gap."""
EIGHT = tuple((down, right) for down in (-1, 0, 1) for right in (-1, 0, 1) if down or right)


def gaps(free: Mask, wide: int) -> Mask:
    """Free cells of gaps at most `wide` cells wide: of narrow places with space for a robot on two sides.

    Nooks, which have it on one side, stay. A round robot of that size decides, and where walls run along the grid, in
    which a round one leaves every corner, a square one.
    """
    found = np.zeros_like(free)
    for element in (disc(wide + 1), square(wide + 1)):
        found |= between_spaces(free, free & ~opened(free, element))
    return found


def square(side: int) -> Mask:
    """A square of `side` cells."""
    return np.ones((side, side), np.bool_)


def disc(side: int) -> Mask:
    """The cells of a square of `side` cells whose middles lie within the circle that touches its sides."""
    away = np.arange(side) - (side - 1) / 2
    return np.asarray(np.hypot(away[:, None], away) <= side / 2)


def in_line(free: Mask, *, wide: int, thick: int, least: int) -> Mask:
    """Free cells in gaps at most `wide` cells wide between two pieces of one straight wall along the grid.

    Each piece is at most `thick` cells thick, and one of them at least `least` cells long.
    """
    found = np.zeros_like(free)
    for turned in (free, free.T):
        thin = ~turned & ~opened(~turned, np.ones((thick + 1, 1), np.bool_))
        dash, long = (opened(thin, np.ones((1, cells), np.bool_)) for cells in (2, least))
        gap = turned & ~opened(~dash, np.ones((1, wide + 1), np.bool_))
        gap &= beside_in_row(long, wide)
        found |= gap if turned is free else gap.T
    return found


def beside_in_row(mask: Mask, reach: int) -> Mask:
    """The cells at most `reach` cells to the left or right of the mask (h, w)."""
    around = np.pad(mask, ((0, 0), (reach, reach)))
    shifted = [around[:, begin : begin + mask.shape[1]] for begin in range(2 * reach + 1)]
    return np.asarray(np.logical_or.reduce(shifted))


def opened(free: Mask, element: Mask) -> Mask:
    """The cells that an element (j, k) covers wherever it has room in the free cells (h, w)."""
    size = max(element.shape)
    offsets = np.argwhere(element).tolist()
    height, width = free.shape
    around = np.pad(free, size)
    room = np.ones((height + size, width + size), np.bool_)
    for down, right in offsets:
        room &= around[down : down + height + size, right : right + width + size]
    covered = np.zeros_like(around)
    for down, right in offsets:
        covered[down : down + height + size, right : right + width + size] |= room
    return covered[size:-size, size:-size]


def between_spaces(free: Mask, narrow: Mask) -> Mask:
    """The pieces of `narrow` around which the rest of the free space falls apart within their own box."""
    space = free & ~narrow
    found = np.zeros_like(free)
    piece = label_cells(narrow, connectivity=2)
    beside = label_cells(space & spread(narrow), connectivity=2)
    boxes = ndimage.find_objects(piece)
    for number in with_several(piece, beside).tolist():
        own, near = window(boxes[number - 1], 1, free.shape)
        at = piece[near] == number
        part, _ = ndimage.label(space[near], np.ones((3, 3)))
        touched = part[spread(at) & (part > 0)]
        if touched.size and touched.min() != touched.max():
            found[own] |= piece[own] == number
    return found


def furniture(free: Mask, loose: Mask, *, gap: int, around: int, least: float) -> Mask:
    """The loose cells that may go: all but those of walls.

    Loose pieces with only gaps of at most `gap` cells between them are a group. It is a wall if it holds two spaces
    apart beside one of its pieces: if there is no way from one to the other, or none within `around` cells of the
    piece. Spaces have at least `least` cells there.
    """
    closed = gaps(free, gap) | (free & ~opened(free, disc(gap + 1)))
    space = free & ~closed
    piece = label_cells(loose, connectivity=2)
    group = label_cells(loose | closed, connectivity=2)
    beside = label_cells(closed, connectivity=2)
    boxes = ndimage.find_objects(piece)
    walls = {0}
    for number in linked(piece, beside).tolist():
        own, near = window(boxes[number - 1], around, free.shape)
        at = piece[near] == number
        which = int(group[near][at][0])
        if which in walls:
            continue
        attached = np.unique(beside[near][spread(at)])
        at |= np.isin(beside[near], attached[attached > 0]) & within(own, near, gap + RIM)
        part, _ = ndimage.label(space[near])
        touched = np.unique(part[spread(at) & (part > 0)])
        if (np.bincount(part.ravel())[touched] >= least).sum() > 1:
            walls.add(which)
    return loose & ~np.isin(group, list(walls - {0}))


def spread(mask: Mask) -> Mask:
    """The cells and their eight neighbours."""
    tall = mask.copy()
    tall[1:] |= mask[:-1]
    tall[:-1] |= mask[1:]
    found = tall.copy()
    found[:, 1:] |= tall[:, :-1]
    found[:, :-1] |= tall[:, 1:]
    return found


def pairs_beside(one: Ints, other: Ints) -> Ints:
    """Pairs (k, 2) of labels of two images (h, w) that are neighbours, by sides or corners, sorted."""
    row, col = np.nonzero(one)
    around = np.pad(other, 1)
    near = np.stack([around[row + 1 + down, col + 1 + right] for down, right in EIGHT])
    own = np.broadcast_to(one[row, col], near.shape)[near > 0]
    count = int(other.max(initial=0)) + 1
    key = np.unique(own.astype(np.int64) * count + near[near > 0])
    return np.stack([key // count, key % count], axis=1).astype(np.int32)


def with_several(piece: Ints, beside: Ints) -> Ints:
    """The pieces that have several others beside them."""
    return np.flatnonzero(np.bincount(pairs_beside(piece, beside)[:, 0], minlength=1) > 1).astype(np.int32)


def linked(piece: Ints, beside: Ints) -> Ints:
    """The pieces that have any other beside them."""
    return np.unique(pairs_beside(piece, beside)[:, 0])


def window(box: Box, margin: int, shape: tuple[int, ...]) -> tuple[Box, Box]:
    """A box, and the same with a margin, as far as it is on the grid."""
    near = tuple(
        slice(max(side.start - margin, 0), min(side.stop + margin, length))
        for side, length in zip(box, shape, strict=True)
    )
    return box, near


def within(box: Box, near: Box, margin: int) -> Mask:
    """Which cells of a window are at most `margin` cells outside of a box in it."""
    rows, cols = (
        (np.arange(outer.start, outer.stop) >= inner.start - margin) & (np.arange(outer.start, outer.stop) < inner.stop + margin)
        for inner, outer in zip(box, near, strict=True)
    )
    return np.asarray(rows[:, None] & cols)
