"""Paths over cells simplified to a few straight segments."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

SLACK = 1.1
"""Maximum cost of a straight segment, relative to the path it replaces; at 1, each cell on a slope would be a bend."""


def straightened(path: Floats, spent: Floats, weight: Floats) -> Floats:
    """Bends (n, 2) of a path (k, 2) as row, col, both ends included: few, and deterministic.

    `spent` (k,) is the cost of the path up to each of its points. A segment between two bends stays in cells with a
    finite `weight` (h, w) and costs at most `SLACK` times as much as the path between them.
    """

    def clear(begin: int, end: int) -> bool:
        allowed = SLACK * (spent[end] - spent[begin])
        return bool(cost(path[begin], path[end], weight) <= allowed)

    bends, ahead = [0], [len(path) - 1]
    while ahead:  # split where the path is farthest from the straight line, until every segment is clear
        begin, end = bends[-1], ahead[-1]
        if end == begin + 1 or clear(begin, end):
            bends.append(ahead.pop())
        else:
            ahead.append(_farthest(path, begin, end))
    kept = bends[:1]
    for bend, after in zip(bends[1:], [*bends[2:], None], strict=True):
        if after is None or not clear(kept[-1], after):
            kept.append(bend)
    return path[kept]


def cost(start: Floats, end: Floats, weight: Floats) -> float:
    """Cost of a straight segment between two points (2,) as row, col: its length in each cell times the cell's weight.

    Infinite if it leaves the cells with a finite `weight` (h, w), or passes through a corner of another cell.
    """
    cells, length = crossed(start, end)
    weights = weight[tuple(cells.T)]
    return float(weights @ length) if np.isfinite(weights).all() else np.inf


def crossed(start: Floats, end: Floats) -> tuple[NDArray[np.intp], Floats]:
    """Cells (k, 2) that a straight segment crosses, and its length (k,) in each, in cells.

    Points (2,) are row, col; integers are cell centres. Where the segment passes through a corner of cells, all four of
    them are listed again, with length 0. Exact if the ends are multiples of a half: equal fractions are equal floats.
    """
    span = end - start
    by_row, by_col = (_borders(a, b) for a, b in zip(start.tolist(), end.tolist(), strict=True))
    share = np.unique(np.concatenate([[0.0], by_row, by_col, [1.0]]))
    middle = start + (share[:-1] + share[1:])[:, None] / 2 * span
    corner = start + np.intersect1d(by_row, by_col, assume_unique=True)[:, None] * span - 0.5
    around = (np.rint(corner)[:, None] + [[0, 0], [0, 1], [1, 0], [1, 1]]).reshape(-1, 2)
    cells = np.concatenate([np.rint(middle), around]).astype(np.intp)
    length = np.concatenate([np.diff(share) * np.hypot(*span), np.zeros(len(around))])
    return cells, length


def _borders(start: float, end: float) -> Floats:
    """Fractions, 0 to 1, at which the way from `start` to `end` crosses borders between rows (or columns)."""
    low, high = min(start, end), max(start, end)
    border = np.arange(np.floor(low + 0.5), np.ceil(high - 0.5)) + 0.5
    border = border[(low < border) & (border < high)]
    return np.asarray((border - start) / (end - start) if len(border) else border)


def _farthest(path: NDArray[Any], begin: int, end: int) -> int:
    """Index of the point between two others that is farthest from the straight line through them."""
    along, between = path[end] - path[begin], path[begin + 1 : end] - path[begin]
    return begin + 1 + int(np.argmax(np.abs(between[:, 0] * along[1] - between[:, 1] * along[0])))
