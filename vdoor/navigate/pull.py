"""A path over cells pulled tight like a string, without losing the clearance."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from vdoor.navigate.sight import Sight

Cell = tuple[int, int]
Floats = NDArray[np.float64]

STRIDES = (16, 4, 1)
"""How far a bend is moved at a time, in cells."""
MOVES = np.array([(row * by, col * by) for by in STRIDES for row in (-1, 0, 1) for col in (-1, 0, 1) if row or col])
CUTS = np.array([0.5, 0.25])[:, None, None]
"""A corner is cut at these shares of its two sides."""
AHEAD = 16
"""Points are passed by up to this many at a time."""
LEAST_GAIN, LEAST_CUT = 1e-9, 0.05
"""What a bend moved, and a corner cut, must save, in cells."""


def pulled(points: Sequence[Cell], sight: Sight) -> list[Cell]:
    """The bends of a shorter path between the ends of a path whose pieces keep the clearance, ends included.

    Every piece of the result is one of the given path, or keeps the clearance along its whole length. Bends are cells.
    """
    path = _shortcut(bends(points), sight)
    for tightened in (_moved, _cut, _cut, _moved):
        if len(path) < 3:  # noqa: PLR2004  # two ends and a bend
            return path
        path = tightened(path, sight)
    return _shortcut(path, sight)


def bends(points: Sequence[Cell]) -> list[Cell]:
    """The ends of a path, and the points at which its direction changes."""
    ways = [(end[0] - start[0], end[1] - start[1]) for start, end in pairwise(points)]
    turns = [point for point, legs in zip(points[1:], pairwise(ways), strict=False) if _turns(*legs)]
    return [points[0], *turns, *points[-1:]] if len(points) > 1 else [*points]


def _turns(before: Cell, after: Cell) -> bool:
    """Whether two steps have different directions."""
    across = before[0] * after[1] - before[1] * after[0]
    return across != 0 or before[0] * after[0] + before[1] * after[1] <= 0


def _shortcut(points: list[Cell], sight: Sight) -> list[Cell]:
    """The shortest path over some of the points, in their order, that passes by at most `AHEAD` of them at a time."""
    place = np.array(points, np.float64)
    start, end = np.triu_indices(len(points), 1)
    near = end - start <= AHEAD
    start, end = start[near], end[near]
    length = np.hypot(*(place[end] - place[start]).T)
    open_ = end == start + 1
    open_[~open_] = sight.all_clear(place[start[~open_]], place[end[~open_]])
    least, before = [0.0] + [np.inf] * (len(points) - 1), [0] * len(points)
    for one, other, apart in zip(start[open_].tolist(), end[open_].tolist(), length[open_].tolist(), strict=True):
        if least[one] + apart < least[other] - LEAST_GAIN:
            least[other], before[other] = least[one] + apart, one
    kept = [len(points) - 1]
    while kept[-1]:
        kept.append(before[kept[-1]])
    return [points[at] for at in reversed(kept)]


def _moved(path: list[Cell], sight: Sight) -> list[Cell]:
    """The path with bends moved, no two neighbours at once, each to the place that makes it shortest."""
    place = np.array(path, np.float64)
    before, bend, after = place[:-2, None], place[1:-1, None], place[2:, None]
    to = bend + MOVES
    gain = _apart(before, bend) + _apart(bend, after) - _apart(before, to) - _apart(to, after)
    row, move = np.nonzero((gain > LEAST_GAIN) & sight.fits(to))
    return _changed(path, [to[row, move]], row, gain[row, move], sight)


def _cut(path: list[Cell], sight: Sight) -> list[Cell]:
    """The path with corners cut, no two neighbours at once, each where that makes it shortest."""
    place = np.array(path, np.float64)
    before, bend, after = place[:-2], place[1:-1], place[2:]
    one, other = np.rint(bend + (before - bend) * CUTS), np.rint(bend + (after - bend) * CUTS)
    gain = _apart(before, bend) + _apart(bend, after) - _apart(before, one) - _apart(one, other) - _apart(other, after)
    share, row = np.nonzero((gain > LEAST_CUT) & sight.fits(one) & sight.fits(other))
    return _changed(path, [one[share, row], other[share, row]], row, gain[share, row], sight)


def _changed(path: list[Cell], new: list[Floats], row: NDArray[np.intp], gain: Floats, sight: Sight) -> list[Cell]:
    """The path with some bends replaced, where the way stays clear, those first that gain most.

    Of k changes, each replaces the bend at `row` + 1 by one point (k, 2) of each of `new`.
    """
    place = np.array(path, np.float64)
    ways = [place[row], *new, place[row + 2]]
    clear = sight.all_clear(np.concatenate(ways[:-1]), np.concatenate(ways[1:])).reshape(len(ways) - 1, -1).all(axis=0)
    chosen: dict[int, list[Cell]] = {}
    for at in np.flatnonzero(clear)[np.argsort(-gain[clear], kind="stable")].tolist():
        number = int(row[at]) + 1
        if not {number - 1, number, number + 1} & chosen.keys():
            chosen[number] = [(int(point[at, 0]), int(point[at, 1])) for point in new]
    return [point for at, old in enumerate(path) for point in chosen.get(at, [old])]


def _apart(one: Floats, other: Floats) -> Floats:
    return np.hypot(one[..., 0] - other[..., 0], one[..., 1] - other[..., 1])
