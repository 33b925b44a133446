"""Spaces of a robot: what is wide enough for it, the gaps between them, and the obstacles that keep two of them apart.

No robot fits through a gap, so it counts as closed. An obstacle in pieces, with gaps between them, is a wall where it
keeps two spaces apart, and furniture where a way leads around it. By that, removing furniture and closing gaps join no
two spaces that were apart.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage
from skimage.measure import label as label_cells

Ints = NDArray[np.int32]
Mask = NDArray[np.bool_]
Box = tuple[slice, ...]

CORNERS_TOO = np.ones((3, 3), np.bool_)
AROUND = tuple((down, right) for down in range(3) for right in range(3) if (down, right) != (1, 1))
BESIDE = 2
"""Cells beyond a gap's width within which narrow places beside an obstacle count as a part of it."""
SHORTEST_DASH = 2
"""Cells: less is a speck."""


def gaps(free: Mask, wide: int) -> Mask:
    """Free cells (h, w) of gaps at most `wide` cells wide: of narrow places with space for a robot on two sides.

    Nooks, which have it on one side, stay. A round robot decides, whatever the direction of the walls. Where they run
    along the grid a square one decides as well: it fits into corners, and not into the ends of a gap.
    """
    found = np.zeros_like(free)
    for element in (disc(wide + 1), square(wide + 1)):
        found |= between_spaces(free, free & ~opened(free, element))
    return found


def furniture(free: Mask, loose: Mask, *, gap: int, around: int, least: float) -> Mask:
    """The loose cells (h, w) that may go: all but those of walls.

    Loose pieces with only gaps of at most `gap` cells between them are a group. It is a wall if it keeps two spaces
    apart beside one of its pieces: if there is no way from one to the other, or none within `around` cells of the
    piece. Spaces have at least `least` cells there.
    """
    closed = gaps(free, gap) | (free & ~opened(free, disc(gap + 1)))
    space = free & ~closed
    piece, narrow, group = (label_cells(mask, connectivity=2) for mask in (loose, closed, loose | closed))
    boxes = ndimage.find_objects(piece)
    walls: set[int] = set()
    # A piece without a narrow place beside it stands in one space, which leads around it.
    for number in np.unique(pairs_beside(piece, narrow)[:, 0]).tolist():
        box, near = boxes[number - 1], grown(boxes[number - 1], max(around, gap + BESIDE), free.shape)
        obstacle = piece[near] == number
        own = int(group[near][obstacle][0])
        if own in walls:
            continue
        beside = narrow[near] * inside(grown(box, gap + BESIDE, free.shape), near)
        obstacle |= np.isin(beside, np.setdiff1d(beside[spread(obstacle)], 0))
        part, _ = ndimage.label(space[near])
        touched = np.setdiff1d(part[spread(obstacle)], 0)
        if (np.bincount(part.ravel())[touched] >= least).sum() > 1:
            walls.add(own)
    return loose & ~np.isin(group, list(walls))


def in_line(free: Mask, *, wide: int, thick: int, least: int) -> Mask:
    """Free cells (h, w) in gaps at most `wide` cells wide between two dashes of one wall along the grid.

    Dashes are at most `thick` cells thick, and one of the two is at least `least` cells long.
    """
    found = []
    for turned in (free, free.T):
        thin = ~turned & ~opened(~turned, square(thick + 1)[:, :1])
        dash, long = (opened(thin, square(length)[:1]) for length in (SHORTEST_DASH, least))
        gap = turned & ~opened(~dash, square(wide + 1)[:1])
        found.append(gap & beside_in_row(long, wide))
    return np.asarray(found[0] | found[1].T)


def square(side: int) -> Mask:
    """A square of `side` cells."""
    return np.ones((side, side), np.bool_)


def disc(side: int) -> Mask:
    """The cells of a square of `side` cells whose middles lie within the circle that touches its sides."""
    away = np.arange(side) - (side - 1) / 2
    return np.asarray(np.hypot(away[:, None], away) <= side / 2)


def opened(mask: Mask, element: Mask) -> Mask:
    """The cells that an element (j, k) covers wherever it has room in the mask (h, w)."""
    size = max(element.shape)
    height, width = (length + size for length in mask.shape)
    windows = [np.s_[down : down + height, right : right + width] for down, right in np.argwhere(element).tolist()]
    padded = np.pad(mask, size)
    room = np.ones((height, width), np.bool_)
    for window in windows:
        room &= padded[window]
    covered = np.zeros_like(padded)
    for window in windows:
        covered[window] |= room
    return covered[size:-size, size:-size]


def between_spaces(free: Mask, narrow: Mask) -> Mask:
    """The pieces of `narrow` around which the other free cells fall apart, as far as they lie beside the piece."""
    piece = label_cells(narrow, connectivity=2)
    space = free & ~narrow
    beside = label_cells(space & spread(narrow), connectivity=2)
    boxes = ndimage.find_objects(piece)
    found = np.zeros_like(free)
    for number in np.flatnonzero(np.bincount(pairs_beside(piece, beside)[:, 0], minlength=1) > 1).tolist():
        box, near = boxes[number - 1], grown(boxes[number - 1], 1, free.shape)
        part, _ = ndimage.label(space[near], CORNERS_TOO)
        if len(np.setdiff1d(part[spread(piece[near] == number)], 0)) > 1:
            found[box] |= piece[box] == number
    return found


def spread(mask: Mask) -> Mask:
    """The cells of a mask (h, w) and their eight neighbours."""
    tall = mask.copy()
    tall[1:] |= mask[:-1]
    tall[:-1] |= mask[1:]
    found = tall.copy()
    found[:, 1:] |= tall[:, :-1]
    found[:, :-1] |= tall[:, 1:]
    return found


def beside_in_row(mask: Mask, reach: int) -> Mask:
    """The cells of a mask (h, w) and those at most `reach` cells to their left or right."""
    padded = np.pad(mask, ((0, 0), (reach, reach)))
    return np.asarray(
        np.logical_or.reduce([padded[:, begin : begin + mask.shape[1]] for begin in range(2 * reach + 1)])
    )


def pairs_beside(one: Ints, other: Ints) -> Ints:
    """Pairs (k, 2) of labels of two images (h, w) that are neighbours, by sides or corners, sorted."""
    row, col = np.nonzero(one)
    padded = np.pad(other, 1)
    near = np.stack([padded[row + down, col + right] for down, right in AROUND])
    own = np.broadcast_to(one[row, col], near.shape)[near > 0]
    count = int(other.max(initial=0)) + 1
    key = np.unique(own.astype(np.int64) * count + near[near > 0])
    return np.stack([key // count, key % count], axis=1).astype(np.int32)


def grown(box: Box, margin: int, shape: tuple[int, ...]) -> Box:
    """A box with a margin, as far as it is on the grid."""
    return tuple(
        slice(max(side.start - margin, 0), min(side.stop + margin, length))
        for side, length in zip(box, shape, strict=True)
    )


def inside(box: Box, near: Box) -> Mask:
    """Which cells of a window `near` lie in a box within it."""
    found = np.zeros([side.stop - side.start for side in near], np.bool_)
    found[tuple(slice(b.start - n.start, b.stop - n.start) for b, n in zip(box, near, strict=True))] = True
    return found
