"""The order of the pieces: nearest first, then improved by reversing stretches and moving short ones."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Ints = NDArray[np.intp]
Floats = NDArray[np.float64]

MOST_MOVES = 2_000
"""Largest number of improvements."""
LONGEST_MOVED = 3
"""Largest number of pieces that are moved together."""
EPSILON = 1e-6


@dataclass(frozen=True, eq=False)
class Tour:
    """Pieces in order, by the points where each is entered and left; the first and the last stay where they are."""

    enter: Ints
    leave: Ints

    def reversed(self, first: int, last: int) -> Tour:
        """With the stretch from `first` to `last` driven backwards."""
        enter, leave = self.enter.copy(), self.leave.copy()
        enter[first : last + 1] = self.leave[first : last + 1][::-1]
        leave[first : last + 1] = self.enter[first : last + 1][::-1]
        return Tour(enter, leave)

    def moved(self, first: int, last: int, after: int, *, backwards: bool) -> Tour:
        """With a stretch moved behind the piece `after`, which is outside it, and driven backwards if wanted."""
        tour = self.reversed(first, last) if backwards else self
        rest = np.concatenate([np.arange(first), np.arange(last + 1, len(self.enter))])
        at = int(np.searchsorted(rest, after, "right"))
        order = np.concatenate([rest[:at], np.arange(first, last + 1), rest[at:]])
        return Tour(tour.enter[order], tour.leave[order])


def tour_of(distance: Floats, piece: Ints, start: int, end: int | None) -> Tour:
    """A short tour over all pieces (n, 2), given by the numbers of their end points.

    `distance` (k, k) is between points and symmetric; the tour begins at the point `start` and ends at `end`, or
    anywhere: then there is no last stop.
    """
    if end is None:  # a last stop that is equally near to all points
        tour = tour_of(np.pad(distance, ((0, 1), (0, 1))), piece, start, len(distance))
        return Tour(tour.enter[:-1], tour.leave[:-1])
    tour = _nearest_first(distance, piece, start, end)
    for _ in range(MOST_MOVES):
        better = _better(distance, tour)
        if better is None:
            break
        tour = better
    return tour


def _nearest_first(distance: Floats, piece: Ints, start: int, end: int) -> Tour:
    """Always the piece whose nearer end is nearest."""
    enter, leave = [start], [start]
    todo = np.ones(len(piece), np.bool_)
    for _ in range(len(piece)):
        near = np.where(todo[:, None], distance[leave[-1]][piece], np.inf)
        chosen, side = divmod(int(near.argmin()), 2)
        enter.append(int(piece[chosen, side]))
        leave.append(int(piece[chosen, 1 - side]))
        todo[chosen] = False
    return Tour(np.array([*enter, end]), np.array([*leave, end]))


def _better(distance: Floats, tour: Tour) -> Tour | None:
    """The tour after the move that saves most; None if no move saves anything."""
    step = distance[tour.leave[:-1], tour.enter[1:]]
    out_out, in_in = distance[np.ix_(tour.leave, tour.leave)], distance[np.ix_(tour.enter, tour.enter)]
    out_in = distance[np.ix_(tour.leave, tour.enter)]
    saved, move = _best_reversal(step, out_out, in_in)
    for length in range(1, min(LONGEST_MOVED, len(step) - 2) + 1):
        saved, move = max((saved, move), _best_move(step, out_out, in_in, out_in, length), key=lambda found: found[0])
    if saved < EPSILON:
        return None
    first, last, after, backwards = move
    return tour.reversed(first, last) if after < 0 else tour.moved(first, last, after, backwards=backwards)


Move = tuple[int, int, int, bool]
"""First and last piece of the stretch, the piece after which it goes (-1: it stays), and whether it is reversed."""


def _best_reversal(step: Floats, out_out: Floats, in_in: Floats) -> tuple[float, Move]:
    """Reverse pieces i to j: the steps before i and behind j change."""
    inner = np.arange(1, len(step))
    if not len(inner):
        return 0.0, (0, 0, -1, True)
    i, j = inner[:, None], inner[None]
    saved = np.where(i <= j, step[i - 1] + step[j] - out_out[i - 1, j] - in_in[i, j + 1], -np.inf)
    first, last = np.unravel_index(int(saved.argmax()), saved.shape)
    return float(saved[first, last]), (int(first) + 1, int(last) + 1, -1, True)


def _best_move(
    step: Floats, out_out: Floats, in_in: Floats, out_in: Floats, length: int
) -> tuple[float, Move]:
    """Move pieces i to j = i + length - 1 between k and k + 1, forwards or backwards."""
    i = np.arange(1, len(step) - length + 1)[:, None]
    j, k = i + length - 1, np.arange(len(step))[None]
    closed = step[i - 1] + step[j] - out_in[i - 1, j + 1] + step[k]
    ways = np.stack([closed - out_in[k, i] - out_in[j, k + 1], closed - out_out[k, j] - in_in[i, k + 1]])
    ways[:, (k >= i - 1) & (k <= j)] = -np.inf
    way, row, after = np.unravel_index(int(ways.argmax()), ways.shape)
    first = int(row) + 1
    return float(ways[way, row, after]), (first, first + length - 1, int(after), bool(way))
