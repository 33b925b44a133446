"""The order of the pieces: nearest first, then improved by reversing stretches and moving short ones."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Ints = NDArray[np.intp]
Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]

MOST_ROUNDS = 1_000
"""Largest number of rounds of improvements."""
NEAREST, LEAST_NEAREST, MOST_PAIRS = 24, 10, 12_000
"""Moves are tried that bring a piece beside one of so many of its nearest, fewer in a tour of very many pieces."""
LONGEST_MOVED = 3
"""Largest number of pieces that are moved together."""
EPSILON = 1e-6


@dataclass(frozen=True, eq=False)
class Tour:
    """Stops in order: the points where each piece is entered and left; the first and the last stop are ends."""

    enter: Ints
    leave: Ints
    piece: Ints
    """The piece of each stop; the ends have numbers of their own."""

    def changed(self, move: Move) -> Tour:
        """The tour after a move."""
        first, last = move.first, move.last
        stretch = np.arange(first, last + 1)[:: -1 if move.backwards else 1]
        rest = np.concatenate([np.arange(first), np.arange(last + 1, len(self.piece))])
        at = int(np.searchsorted(rest, move.after, "right"))
        order = np.concatenate([rest[:at], stretch, rest[at:]])
        enter, leave = self.enter.copy(), self.leave.copy()
        if move.backwards:
            enter[stretch], leave[stretch] = self.leave[stretch], self.enter[stretch]
        return Tour(enter[order], leave[order], self.piece[order])


class Move(NamedTuple):
    """Stops `first` to `last` go behind the stop `after`, which is outside them, and are reversed or not."""

    first: int
    last: int
    after: int
    backwards: bool


class Moves(NamedTuple):
    """Moves that are tried, as columns of `Move`."""

    first: Ints
    last: Ints
    after: Ints
    backwards: Mask

    def saved(self, distance: Floats, tour: Tour) -> Floats:
        """What each move saves (k,)."""
        first, last, after, backwards = self
        begin = np.where(backwards, tour.leave[last], tour.enter[first])
        end = np.where(backwards, tour.enter[first], tour.leave[last])
        stays = after == first - 1
        before = tour.leave[first - 1]
        behind = tour.enter[last + 1]
        gap_start, gap_end = tour.leave[after], np.where(stays, behind, tour.enter[after + 1])
        old = distance[before, tour.enter[first]] + distance[tour.leave[last], behind]
        new = distance[gap_start, begin] + distance[end, gap_end]
        closed = np.where(stays, 0, distance[before, behind] - distance[gap_start, gap_end])
        return old - new - closed

    def chosen(self, rows: Ints) -> Moves:
        """Some of them."""
        return Moves(self.first[rows], self.last[rows], self.after[rows], self.backwards[rows])

    def ends(self) -> Ints:
        """The stops (n,) beside which something changes, not each once."""
        first, last, after, _ = self
        return np.concatenate([first - 1, first, last, last + 1, after, after + 1])

    def move(self, row: int) -> Move:
        """One of them."""
        return Move(int(self.first[row]), int(self.last[row]), int(self.after[row]), bool(self.backwards[row]))


def tour_of(distance: Floats, piece: Ints, start: int, end: int | None) -> Tour:
    """A short tour over all pieces (n, 2), given by the numbers of their end points.

    `distance` (k, k) is between points and symmetric; the tour begins at the point `start` and ends at `end`, or
    anywhere: then there is no last stop.
    """
    if end is None:  # a last stop that is equally near to all points
        tour = tour_of(np.pad(distance, ((0, 1), (0, 1))), piece, start, len(distance))
        return Tour(tour.enter[:-1], tour.leave[:-1], tour.piece[:-1])
    tour = _nearest_first(distance, piece, start, end)
    near = _neighbours(distance, piece, start, end)
    active = np.ones(len(tour.piece), np.bool_)
    for _ in range(MOST_ROUNDS):
        tried = _tried(tour, near[active[near].any(axis=1)])
        saved = tried.saved(distance, tour)
        better = tried.chosen(np.flatnonzero(saved > EPSILON))
        if not len(better.first):
            break
        active = np.zeros(len(tour.piece), np.bool_)
        active[tour.piece[better.ends()]] = True
        for move in _best_apart(better, saved[saved > EPSILON], len(tour.piece)):
            tour = tour.changed(move)
    return tour


def _nearest_first(distance: Floats, piece: Ints, start: int, end: int) -> Tour:
    """Always the piece whose nearer end is nearest."""
    order: list[int] = []
    sides: list[int] = []
    here = start
    todo = np.ones(len(piece), np.bool_)
    for _ in range(len(piece)):
        near = np.where(todo[:, None], distance[here][piece], np.inf)
        chosen, side = divmod(int(near.argmin()), 2)
        order.append(chosen)
        sides.append(side)
        here = int(piece[chosen, 1 - side])
        todo[chosen] = False
    stops, first = np.array(order, np.intp), np.array(sides, np.intp)
    enter = np.concatenate([[start], piece[stops, first], [end]])
    leave = np.concatenate([[start], piece[stops, 1 - first], [end]])
    return Tour(enter, leave, np.concatenate([[len(piece)], stops, [len(piece) + 1]]))


def _neighbours(distance: Floats, piece: Ints, start: int, end: int) -> Ints:
    """Pairs (k, 2) of pieces, or of the ends, that are near each other."""
    all_ends = np.concatenate([piece, [[start, start], [end, end]]])
    apart = distance[np.ix_(all_ends[:, 0], all_ends.reshape(-1))]
    apart = np.minimum(apart, distance[np.ix_(all_ends[:, 1], all_ends.reshape(-1))])
    apart = apart.reshape(len(all_ends), len(all_ends), 2).min(axis=2)
    np.fill_diagonal(apart, np.inf)
    near_enough = int(np.clip(MOST_PAIRS // len(all_ends), LEAST_NEAREST, NEAREST))
    count = min(near_enough, len(all_ends) - 1)
    near = np.argsort(apart, axis=1, kind="stable")[:, :count]
    pair = np.sort(np.stack([np.repeat(np.arange(len(all_ends)), count), near.reshape(-1)], axis=1), axis=1)
    return np.unique(pair, axis=0)


def _tried(tour: Tour, near: Ints) -> Moves:
    """All moves that bring two near pieces side by side."""
    place = np.empty(len(tour.piece), np.intp)
    place[tour.piece] = np.arange(len(tour.piece))
    one, other = np.sort(place[near], axis=1).T
    stretches = list(_stretches(one, other))
    first, last, after = (np.concatenate([stretch[column] for stretch in stretches]) for column in range(3))
    backwards = np.repeat([stretch[3] for stretch in stretches], len(one))
    end = len(tour.piece) - 1
    possible = (first >= 1) & (first <= last) & (last < end) & (after >= 0) & (after < end)
    possible &= (after < first) | (after > last)
    possible &= (after != first - 1) | backwards
    return Moves(first[possible], last[possible], after[possible], backwards[possible])


def _best_apart(better: Moves, saved: Floats, stops: int) -> list[Move]:
    """The moves that save most and change different stretches of the tour, so that each saves what it saves alone."""
    low = np.minimum(better.first - 1, better.after)
    high = np.maximum(better.last, better.after) + 1
    used = np.zeros(stops, np.bool_)
    found = []
    for row in np.argsort(-saved, kind="stable").tolist():
        if not used[low[row] : high[row] + 1].any():
            used[low[row] : high[row] + 1] = True
            found.append(better.move(row))
    return found


def _stretches(one: Ints, other: Ints) -> Iterator[tuple[Ints, Ints, Ints, bool]]:
    """Moves, as columns, that bring the stops `one` and `other`, the later ones, side by side."""
    yield one + 1, other, one, True
    yield one, other - 1, one - 1, True
    for length in range(1, LONGEST_MOVED + 1):
        for moved, fixed in ((one, other), (other, one)):
            # the stretch begins or ends with the stop that is moved, and goes before or behind the other
            for first, after, backwards in product(sorted({0, 1 - length}), (-1, 0), (False, True)):
                yield moved + first, moved + first + length - 1, fixed + after, backwards
