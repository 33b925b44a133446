"""A path over cells pulled tight like a string, without losing the clearance."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from vdoor.navigate.sight import Sight

Cell = tuple[int, int]
Floats = NDArray[np.float64]

STRIDES = (16, 8, 4, 2, 1)
"""How far a bend is moved at a time, in cells."""
MOVES = np.array([(row * by, col * by) for by in STRIDES for row in (-1, 0, 1) for col in (-1, 0, 1) if row or col])
ROUNDS = 4
"""Bends are moved at most that often: the first moves gain most."""
AHEAD = 16
"""Points are passed by up to this many at a time."""
LEAST_GAIN = 1e-9


def pulled(points: Sequence[Cell], sight: Sight) -> list[Cell]:
    """The bends of a shorter path between the ends of a path whose pieces keep the clearance, ends included.

    Every piece of the result is one of the given path, or keeps the clearance along its whole length. Bends are cells.
    """
    path = _shortcut(bends(points), sight)
    moved = False
    for _ in range(ROUNDS):
        if len(path) < 3 or not (changed := _better(path, sight)):  # noqa: PLR2004  # two ends and a bend
            break
        for at, place in changed:
            path[at] = place
        moved = True
    return _shortcut(path, sight) if moved else path


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


def _better(path: list[Cell], sight: Sight) -> list[tuple[int, Cell]]:
    """Bends to move, no two of them neighbours, each to the place with a clear way that makes the path shortest."""
    place = np.array(path, np.float64)
    before, bend, after = place[:-2, None], place[1:-1, None], place[2:, None]
    places = bend + MOVES
    gain = _apart(before, bend) + _apart(bend, after) - _apart(before, places) - _apart(places, after)
    row, move = np.nonzero((gain > LEAST_GAIN) & sight.fits(places))
    to = places[row, move]
    clear = sight.all_clear(np.concatenate([place[row], place[row + 2]]), np.concatenate([to, to]))
    both = clear[: len(row)] & clear[len(row) :]
    chosen: dict[int, Cell] = {}
    for at in np.flatnonzero(both)[np.argsort(-gain[row[both], move[both]], kind="stable")].tolist():
        number = int(row[at]) + 1
        if not {number - 1, number, number + 1} & chosen.keys():
            chosen[number] = (int(to[at, 0]), int(to[at, 1]))
    return [*chosen.items()]


def _apart(one: Floats, other: Floats) -> Floats:
    return np.hypot(one[..., 0] - other[..., 0], one[..., 1] - other[..., 1])
