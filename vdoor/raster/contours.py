"""Closed boundaries of labelled regions, by crack following with the wall on the left.

A state is a cell and a heading with a wall on the left. The rules in `follow` give each state exactly one successor and
one predecessor, so the contours are the cycles of a permutation, found from a table without walking step by step.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from vdoor.raster.runs import Runs

# Row and column step of the headings east, north, west, south: left of heading h is heading h + 1.
STEP = np.array([(0, 1), (-1, 0), (0, -1), (1, 0)], np.int32)
# The corner of a cell (row, col) behind the walker on its left, where the crack to its left begins.
CRACK_START = np.array([(0, 0), (1, 0), (1, 1), (0, 1)], np.int32)

ROWS = 512
"""Rows of a raster that are walked at a time."""


@dataclass(frozen=True)
class Contours:
    """All contours, one after another, each in walking order."""

    cell: NDArray[np.int32]
    """(n, 2) row, col of the cell that the walker is on."""
    heading: NDArray[np.int32]
    """(n,) index into `STEP`."""
    turn: NDArray[np.int32]
    """(n,) quarter turns to the left towards the next state: 1, 0 or -1."""
    contour: NDArray[np.int32]
    """(n,) index of the contour."""
    first: NDArray[np.int32]
    """(contours,) index of the first state: at the uppermost, then leftmost cell."""
    length: NDArray[np.int32]
    """(contours,) number of states."""
    outer: NDArray[np.bool_]
    """(contours,) whether the contour runs around its region, not around a hole in it."""


class Band(NamedTuple):
    """Some rows of a raster with one cell more on each side, 0 outside the raster."""

    first: int
    """The flat index of the first cell in the whole raster with a margin of one cell."""
    cells: NDArray[Any]


def bands(labels: NDArray[Any] | Runs) -> Iterator[Band]:
    """A raster (h, w) in bands of `ROWS` rows, which take little memory."""
    height, width = labels.shape
    for top in range(0, height, ROWS):
        bottom = min(top + ROWS, height)
        rows = slice(max(top - 1, 0), min(bottom + 1, height))
        some = labels.inside((rows, slice(0, width))).image() if isinstance(labels, Runs) else labels[rows]
        missing = (int(top == 0), int(bottom == height))
        yield Band(top * (width + 2), np.pad(some, (missing, (1, 1))))


def follow(labels: NDArray[np.int32] | NDArray[np.bool_] | Runs, *, cross_corners: bool = False) -> Contours:
    """Contours of all regions of equal, non-zero labels (h, w).

    Blocked ahead: turn right. Free ahead with a wall ahead on the left: go straight. Otherwise: turn left around the
    wall's end. This treats regions as 4-connected. With `cross_corners` the path crosses a corner to a diagonal cell of
    its own region, so that no ring touches itself, though a hole may touch the outer ring: valid polygons.
    """
    found = [_states(band, cross_corners=cross_corners) for band in bands(labels)]
    state, to, turn = (np.concatenate(parts) for parts in zip(*found, strict=True))
    at, heading = np.divmod(state, 4)
    successor = np.searchsorted(state, to * 4 + (heading + turn) % 4)
    width = labels.shape[1] + 2

    order, first, length = cycles(successor)
    contour = np.repeat(np.arange(len(first), dtype=np.int32), length)
    cell = np.stack(np.divmod(at[order], width), axis=1).astype(np.int32) - 1
    turns = np.bincount(contour, weights=turn[order], minlength=len(first))
    return Contours(cell, heading[order].astype(np.int32), turn[order], contour, first, length, turns < 0)


def _states(band: Band, *, cross_corners: bool) -> tuple[NDArray[np.intp], NDArray[np.intp], NDArray[np.int32]]:
    """The states (n,) in a band as 4 * cell + heading, sorted; the cell of each one's successor, and the turn to it."""
    flat, width = band.cells.ravel(), band.cells.shape[1]
    ahead_by = np.array([1, -width, -1, width])
    left_by = np.roll(ahead_by, -1)

    edge = np.zeros(flat.size, np.bool_)
    for by in (1, width):
        differs = flat[by:] != flat[:-by]
        edge[by:] |= differs
        edge[:-by] |= differs
    at = width + np.flatnonzero((edge & (flat != 0))[width:-width])
    beside = np.stack([flat[at + by] != flat[at] for by in left_by], axis=1)
    row, heading = np.nonzero(beside)
    at = at[row]

    ahead = at + ahead_by[heading]
    across = ahead + left_by[heading]
    ahead_free, across_free = flat[ahead] == flat[at], flat[across] == flat[at]
    left = across_free if cross_corners else across_free & ahead_free
    turn = np.where(left, 1, np.where(ahead_free, 0, -1)).astype(np.int32)
    to = np.where(left, across, np.where(ahead_free, ahead, at))
    return (band.first + at) * 4 + heading, band.first + to, turn


def cycles(successor: NDArray[np.intp]) -> tuple[NDArray[np.intp], NDArray[np.int32], NDArray[np.int32]]:
    """The order that lists a permutation cycle by cycle; the index of each cycle's start in it, and each length.

    Cycles are sorted by their smallest member and begin with it. Pointer doubling: log2(n) gathers.
    """
    count = len(successor)
    root, jump = np.arange(count), successor
    while not np.array_equal(root, root[successor]):
        root = np.minimum(root, root[jump])
        jump = jump[jump]
    last = successor == root
    to_end = np.where(last, 0, 1)
    jump = np.where(last, np.arange(count), successor)
    while to_end[jump].any():
        to_end = to_end + to_end[jump]
        jump = jump[jump]
    roots = np.flatnonzero(root == np.arange(count))
    length = to_end[roots] + 1
    first = np.cumsum(length) - length
    cycle = np.cumsum(root == np.arange(count)) - 1
    order = np.empty(count, np.intp)
    order[first[cycle[root]] + to_end[root] - to_end] = np.arange(count)
    return order, first.astype(np.int32), length.astype(np.int32)
