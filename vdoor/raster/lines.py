"""Straight lines of cells between two cells."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Ints = NDArray[np.int32]


CHUNK = 50_000  # lines processed at a time, to limit memory


def lines_between(free: NDArray[np.bool_], start: Ints, end: Ints) -> tuple[NDArray[np.bool_], Ints, Ints]:
    """Which of the lines (k,) are free along their whole length, their free cells (m, 2), and the line of each (m,).

    A line has one cell per step along its longer axis, without its end cells. It is 8-connected, so it separates
    4-connected space. Where it runs exactly between two cells, it has whichever of them are free, and at least one must
    be, so that lines rotate, mirror and reverse with the map. Lines with no cell between their ends are not free.
    """
    clear, cells, owners = [np.zeros(0, np.bool_)], [np.zeros((0, 2), np.int32)], [np.zeros(0, np.int32)]
    around = np.pad(free, 1)  # a line may end one cell outside the map
    for begin in range(0, len(start), CHUNK):
        part = slice(begin, begin + CHUNK)
        good, cell, owner = _some_lines(around, start[part], end[part])
        clear.append(good)
        cells.append(cell)
        owners.append(owner + np.int32(begin))
    return np.concatenate(clear), np.concatenate(cells), np.concatenate(owners)


def _some_lines(around: NDArray[np.bool_], start: Ints, end: Ints) -> tuple[NDArray[np.bool_], Ints, Ints]:
    """`lines_between` for some lines on the padded map; internally arrays of (line, step, lower and upper cell)."""
    span = end - start
    steps = np.abs(span).max(axis=1, initial=0)
    at = np.arange(1, max(2, steps.max(initial=0)), dtype=np.int32)[None, :]
    between = at < steps[:, None]
    twice = np.maximum(2 * steps, 1)[:, None]
    sides = []
    for axis in (0, 1):
        ahead = 2 * at * span[:, axis, None]
        below, above = -((twice // 2 - ahead) // twice), (ahead + twice // 2) // twice
        offset = np.stack([below, above], axis=-1) * between[..., None]
        sides.append(start[:, axis, None, None] + offset)
    row, col = sides
    open_ = around[row + 1, col + 1]
    clear = (open_.any(axis=2) | ~between).all(axis=1) & (steps > 1)
    taken = open_ & (between & clear[:, None])[..., None]
    taken[..., 1] &= (row[..., 0] != row[..., 1]) | (col[..., 0] != col[..., 1])
    owner, step, side = np.nonzero(taken)
    cells = np.stack([row[owner, step, side], col[owner, step, side]], axis=1)
    return clear, cells.astype(np.int32), owner.astype(np.int32)
