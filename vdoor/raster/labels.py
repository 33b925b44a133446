"""Room labels at the input's resolution."""

from __future__ import annotations

import numpy as np
import skimage
from numpy.typing import NDArray

from vdoor.raster.morphology import distances, exact, labelled
from vdoor.raster.runs import runs_of

Ints = NDArray[np.int32]
Mask = NDArray[np.bool_]


def at_input(working: Ints, factor: int, free: Mask) -> Ints:
    """The labels of the working grid at the input's resolution, on its free cells only."""
    fine = working.repeat(factor, axis=0).repeat(factor, axis=1) if factor > 1 else working
    return fine[: free.shape[0], : free.shape[1]] * free


def parts_of(labels: Ints) -> Ints:
    """The 4-connected part (h, w) of each labelled cell, numbered from 1 in reading order; 0 elsewhere."""
    return np.asarray(skimage.measure.label(labels, connectivity=1, background=0), np.int32)


def whole(labels: Ints) -> Ints:
    """The labels, each restricted to its largest 4-connected part; of equally large ones the first.

    Cells that are connected at the working resolution may not be at the input's, as behind a line of unknown cells or
    inside furniture. Flooding later assigns those that are reachable to a room again.
    """
    part = parts_of(labels)
    runs = runs_of(part)
    cells = runs.cells(int(part.max(initial=0)))
    of_part = np.zeros(len(cells), np.int32)
    of_part[runs.label - 1] = labels[runs.row, runs.begin]
    order = np.lexsort((np.arange(len(cells)), -cells, of_part))
    leads = np.append(True, of_part[order][1:] != of_part[order][:-1])[: len(order)]
    kept = np.zeros(len(cells) + 1, np.int32)
    kept[order[leads] + 1] = of_part[order[leads]]
    return np.asarray(kept[part])


def flooded(labels: Ints, free: Mask) -> Ints:
    """The labels spread to all free cells reachable through free cells, nearest label first, the lower one at a tie."""
    width = labels.shape[1] + 2
    flat = np.pad(labels, 1).reshape(-1)
    todo = np.pad(free, 1).reshape(-1) & (flat == 0)
    steps = np.array([-width, -1, 1, width])
    pending = np.flatnonzero(todo)
    edge = (pending[:, None] + steps).ravel()
    front = np.unique(edge[flat[edge] > 0])
    while len(front):
        target = (front[:, None] + steps).ravel()
        label = np.repeat(flat[front], len(steps))
        fresh = todo[target]
        target, label = target[fresh], label[fresh]
        order = np.lexsort((label, target))
        target, label = target[order], label[order]
        first = np.append(True, target[1:] != target[:-1])[: len(target)]
        front = target[first]
        flat[front] = label[first]
        todo[front] = False
    return flat.reshape(labels.shape[0] + 2, width)[1:-1, 1:-1].copy()


def handed_on(labels: Ints, free: Mask) -> Ints:
    """The labels, with each 4-connected piece of unlabelled free cells assigned to a label as a whole.

    A piece gets the label with which it shares most cell sides, the lower one at a tie; a piece that touches none
    stays 0.
    """
    piece = labelled(free & (labels == 0))
    row, col = np.nonzero(piece)
    around = np.pad(labels, 1)
    near = np.stack([around[row + down, col + right] for down, right in ((0, 1), (1, 0), (1, 2), (2, 1))])
    own = np.broadcast_to(piece[row, col], near.shape)[near > 0]
    rooms = int(labels.max(initial=0)) + 1
    key, sides = np.unique(own.astype(np.int64) * rooms + near[near > 0], return_counts=True)
    order = np.lexsort((-key, sides, key // rooms))  # the last entry of a piece has the most sides, then lowest label
    of_piece = np.zeros(int(piece.max(initial=0)) + 1, np.int32)
    of_piece[key[order] // rooms] = key[order] % rooms
    return np.where(piece > 0, of_piece[piece], labels).astype(np.int32)


def half_seen(labels: Ints, free: Mask, open_: Mask, reach: float) -> Ints:
    """The labels, with free cells without one assigned to a label across unknown gaps of at most `reach` cells.

    Rays reach the rest of a room that is seen only in part cell by cell. `open_` (h, w) are the cells that are free or
    unknown. Cells with gaps between them that are at most twice as wide get one label, that of `handed_on`.
    """
    near = exact(distances((labels > 0) | ~free)) <= reach
    return np.where(free, handed_on(labels, near & open_), 0).astype(np.int32)


def numbered(labels: Ints, rooms: int) -> tuple[Ints, Ints]:
    """The labels renumbered 1, 2, ... in reading order of their first cells, and the new number of each old one.

    The new numbers are (rooms + 1,). Rooms without a free cell of the input (on removed islands) get 0.
    """
    present = runs_of(labels).label
    order = present[np.sort(np.unique(present, return_index=True)[1])]
    number = np.zeros(rooms + 1, np.int32)
    number[order] = np.arange(1, len(order) + 1)
    return number[labels], number
