"""Room labels at the input's resolution."""

from __future__ import annotations

from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from vdoor.raster.morphology import covered
from vdoor.raster.runs import neighbours, parts_of_mask, parts_of_runs, runs_of

Ints = NDArray[np.int32]
Mask = NDArray[np.bool_]
Cell = TypeVar("Cell", bound=np.generic)


def at_input(working: NDArray[Cell], factor: int, free: Mask) -> NDArray[Cell]:
    """The labels, or the mask, of the working grid at the input's resolution, on its free cells only."""
    fine = working.repeat(factor, axis=0).repeat(factor, axis=1) if factor > 1 else working.copy()
    fine = fine[: free.shape[0], : free.shape[1]]
    np.putmask(fine, ~free, 0)
    return fine


def whole(labels: Ints) -> Ints:
    """The labels, each restricted to its largest 4-connected part; of equally large ones the first.

    Cells that are connected at the working resolution may not be at the input's, as behind a line of unknown cells or
    inside furniture. Flooding later assigns those that are reachable to a room again.
    """
    runs = runs_of(labels)
    part = parts_of_runs(runs)
    cells = part.cells(part.most)
    of_part = np.zeros(len(cells), np.int32)
    of_part[part.label - 1] = runs.label
    order = np.lexsort((np.arange(len(cells)), -cells, of_part))
    lesser = np.append(False, of_part[order][1:] == of_part[order][:-1])[: len(order)]
    gone = np.zeros(len(cells) + 1, np.bool_)
    gone[order[lesser] + 1] = True
    if not gone.any():
        return labels
    found = labels.copy()
    found.reshape(-1)[part.chosen(gone).flat()] = 0
    return found


def flooded(labels: Ints, free: Mask) -> Ints:
    """The labels spread to all free cells reachable through free cells, nearest label first, the lower one at a tie."""
    todo = (free & (labels == 0)).reshape(-1)
    pending = np.flatnonzero(todo)
    if not len(pending):
        return labels
    found = labels.copy()
    flat = found.reshape(-1)
    edge, _ = neighbours(pending, labels.shape)
    front = np.unique(edge[flat[edge] > 0])
    while len(front):
        target, source = neighbours(front, labels.shape)
        fresh = todo[target]
        target, label = target[fresh], flat[front[source[fresh]]]
        order = np.lexsort((label, target))
        target, label = target[order], label[order]
        first = np.append(True, target[1:] != target[:-1])[: len(target)]
        front = target[first]
        flat[front] = label[first]
        todo[front] = False
    return found


def handed_on(labels: Ints, free: Mask) -> Ints:
    """The labels, with each 4-connected piece of unlabelled free cells assigned to a label as a whole.

    A piece gets the label with which it shares most cell sides, the lower one at a tie; a piece that touches none
    stays 0.
    """
    pieces = parts_of_mask(free & (labels == 0))
    if not pieces.most:
        return labels
    cell, piece = pieces.flat(), np.repeat(pieces.label, pieces.length)
    target, source = neighbours(cell, labels.shape)
    near = labels.reshape(-1)[target]
    own, near = piece[source[near > 0]], near[near > 0]
    rooms = int(near.max(initial=0)) + 1
    key, sides = np.unique(own.astype(np.int64) * rooms + near, return_counts=True)
    order = np.lexsort((-key, sides, key // rooms))  # the last entry of a piece has the most sides, then lowest label
    of_piece = np.zeros(pieces.most + 1, np.int32)
    of_piece[key[order] // rooms] = key[order] % rooms
    found = labels.copy()
    found.reshape(-1)[cell] = of_piece[piece]
    return found


def half_seen(labels: Ints, free: Mask, open_: Mask, reach: float) -> Ints:
    """The labels, with free cells without one assigned to a label across unknown gaps of at most `reach` cells.

    Rays reach the rest of a room that is seen only in part cell by cell. `open_` (h, w) are the cells that are free or
    unknown. Cells with gaps between them that are at most twice as wide get one label, that of `handed_on`.
    """
    away = np.arange(-int(reach), int(reach) + 1)
    apart = free & (labels == 0)
    if not apart.any():
        return labels
    near = covered(apart, np.hypot(away[:, None], away) <= reach)
    near &= open_
    found = handed_on(labels, near)
    np.putmask(found, ~free, 0)
    return found


def numbered(labels: Ints, rooms: int) -> tuple[Ints, Ints]:
    """The labels renumbered 1, 2, ... in reading order of their first cells, and the new number of each old one.

    The new numbers are (rooms + 1,). Rooms without a free cell of the input (on removed islands) get 0.
    """
    runs = runs_of(labels)
    order = runs.label[np.sort(np.unique(runs.label, return_index=True)[1])]
    number = np.zeros(rooms + 1, np.int32)
    number[order] = np.arange(1, len(order) + 1)
    return runs.labelled(number[runs.label]).image(), number
