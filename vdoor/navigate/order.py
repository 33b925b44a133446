"""The order in which to visit places: exact for a few, a good one with a lower bound for many."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

MOST_EXACT = 12
"""So many places beside the start and the end are ordered exactly."""
KICKS = 60
"""How often a good order is shaken up and improved again."""
LONGEST_PIECE = 3
"""Pieces of up to so many places are moved."""
ASCENTS = 300
"""Steps of the ascent to the lower bound."""
LEAST_GAIN = 1e-9


@dataclass(frozen=True)
class Order:
    """An order of all places."""

    places: tuple[int, ...]
    """Row numbers of the matrix; a start that is returned to comes first and last."""
    length: float
    lower_bound: float
    """No order is shorter; the length itself if the order is exact."""

    @property
    def exact(self) -> bool:
        """Whether no order is shorter."""
        return self.lower_bound >= self.length - LEAST_GAIN


def best_order(
    distance: Floats, *, start: int | None = None, end: int | None = None, most_exact: int = MOST_EXACT
) -> Order:
    """A short order of all places, given the distances (k, k) between them, the same both ways.

    It begins at `start` and ends at `end`, each where it likes if None; with `start` equal to `end` it returns. Exact
    if at most `most_exact` places remain to be ordered, or where the bound meets the length. Otherwise it is the order
    from each place to the nearest next, improved by reversing and moving pieces, and shaken up by draws from a fixed
    seed. The length is infinite if some place cannot be reached.
    """
    free = [place for place in range(len(distance)) if place not in {start, end}]
    if len(free) <= most_exact:
        return _order(distance, _exact(distance, free, start, end) if free else _ended([], start, end))
    finite = np.where(np.isfinite(distance), distance, _beyond(distance))
    wide = np.pad(finite, (0, 1))  # one more place, which is everywhere: a free start or end
    nowhere = len(distance)
    places = [nowhere if start is None else start, *_greedy(finite, free, start), nowhere if end is None else end]
    found = [place for place in _shaken(wide, places) if place != nowhere]
    length = length_of(distance, found)
    bound = lower_bound(distance, length, start=start, end=end) if np.isfinite(length) else 0.0
    return _order(distance, found, bound)


def _beyond(distance: Floats) -> float:
    """More than any order over finite distances is long."""
    return float(distance[np.isfinite(distance)].sum()) + 1.0


def _order(distance: Floats, places: Sequence[int], bound: float = math.inf) -> Order:
    length = length_of(distance, places)
    return Order(tuple(places), length, min(bound, length))


def length_of(distance: Floats, places: Sequence[int]) -> float:
    """The length of a way through places in their order."""
    return math.fsum(float(distance[one, other]) for one, other in pairwise(places))


def _exact(distance: Floats, free: list[int], start: int | None, end: int | None) -> list[int]:
    """The shortest order, by the shortest ways through each set of places to each of its members (Held and Karp)."""
    count = len(free)
    between = distance[np.ix_(free, free)]
    least = np.full((1 << count, count), np.inf)
    before = np.zeros((1 << count, count), np.int8)
    for place in range(count):
        least[1 << place, place] = 0.0 if start is None else distance[start, free[place]]
    for members in range(1, 1 << count):
        last = np.flatnonzero(members >> np.arange(count) & 1)
        if len(last) == 1:
            continue
        lengths = least[members ^ 1 << last] + between[:, last].T
        before[members, last] = np.argmin(lengths, axis=1)
        least[members, last] = lengths.min(axis=1)
    final = least[-1] + (0.0 if end is None else distance[free, end])
    return _ended(_traced(before, int(np.argmin(final)), free), start, end)


def _traced(before: NDArray[np.int8], last: int, free: list[int]) -> list[int]:
    """The places up to a last one."""
    members, found = len(before) - 1, [last]
    while members := members ^ 1 << found[-1]:
        found.append(int(before[members | 1 << found[-1], found[-1]]))
    return [free[place] for place in reversed(found)]


def _ended(places: list[int], start: int | None, end: int | None) -> list[int]:
    return [*([] if start is None else [start]), *places, *([] if end is None else [end])]


def _greedy(distance: Floats, free: list[int], start: int | None) -> list[int]:
    """The places that are free, from each to the nearest one that is left."""
    left = list(free)
    places: list[int] = []
    while left:
        at = places[-1] if places else start
        places.append(left.pop(0 if at is None else int(np.argmin(distance[at, left]))))
    return places


def _shaken(distance: Floats, places: list[int]) -> list[int]:
    """The shortest of the orders found by exchanging two pieces of a good one and improving it again; ends stay."""
    rng = np.random.default_rng(0)
    best = _improved(distance, places)
    for _ in range(KICKS):
        one, two, three = np.sort(rng.choice(np.arange(1, len(best)), 3, replace=False)).tolist()
        other = _improved(distance, [*best[:one], *best[two:three], *best[one:two], *best[three:]])
        if length_of(distance, other) < length_of(distance, best) - LEAST_GAIN:
            best = other
    return best


def _improved(distance: Floats, places: list[int]) -> list[int]:
    """The order with pieces reversed and moved, as long as that makes it shorter; its ends stay."""
    while True:
        gains = [
            _reversals(distance, places),
            *(_moves(distance, places, size) for size in range(1, LONGEST_PIECE + 1)),
        ]
        gain, places_then = max(gains, key=lambda found: found[0])
        if gain <= LEAST_GAIN:
            return places
        places = places_then


def _reversals(distance: Floats, places: list[int]) -> tuple[float, list[int]]:
    """What the best reversal of a piece gains, and the order after it."""
    order = np.array(places)
    step = distance[order[:-1], order[1:]]
    first, last = np.triu_indices(len(order) - 2, 1)
    first, last = first + 1, last + 1
    after = distance[order[first - 1], order[last]] + distance[order[first], order[last + 1]]
    gain = step[first - 1] + step[last] - after
    at = int(np.argmax(gain))
    one, other = int(first[at]), int(last[at])
    return float(gain[at]), [*places[:one], *places[one : other + 1][::-1], *places[other + 1 :]]


def _moves(distance: Floats, places: list[int], size: int) -> tuple[float, list[int]]:
    """What the best move of a piece of some size gains, turned about if that is better, and the order after it."""
    order = np.array(places)
    step = distance[order[:-1], order[1:]]
    first = np.arange(1, len(order) - size)[:, None]
    if not len(first):
        return 0.0, places
    last, gap = first + size - 1, np.arange(len(order) - 1)[None]
    freed = step[first - 1] + step[last] - distance[order[first - 1], order[last + 1]]
    ends = [(order[first], order[last]), (order[last], order[first])]
    added = [distance[order[gap], one] + distance[other, order[gap + 1]] - step[gap] for one, other in ends]
    outside = (gap < first - 1) | (gap > last)
    gain = np.where(outside, freed - np.minimum(*added), -np.inf)
    row, to = np.unravel_index(int(np.argmax(gain)), gain.shape)
    piece = places[row + 1 : row + 1 + size]
    piece = piece if added[0][row, to] <= added[1][row, to] else piece[::-1]
    left = [*places[: row + 1], *places[row + 1 + size :]]
    at = int(to) + 1 if to <= row else int(to) + 1 - size
    return float(gain[row, to]), [*left[:at], *piece, *left[at:]]


def lower_bound(distance: Floats, length: float, *, start: int | None = None, end: int | None = None) -> float:
    """A length that no order falls below, given the length of one.

    That of a shortest tree with one more edge, where places are weighted so that it becomes almost a tour (Held and
    Karp). A way that does not return becomes a tour by one more place, which is everywhere, and is made to be next to
    a fixed start or end.
    """
    tour, extra = distance, 0.0
    if start is None or start != end:
        tour, forced = np.pad(distance, (1, 0)), length + 1.0
        for place in {place for place in (start, end) if place is not None}:
            tour[0, place + 1] = tour[place + 1, 0] = -forced
            extra += forced
    weight, best, pace = np.zeros(len(tour)), -math.inf, 2.0
    for _ in range(ASCENTS):
        weighted = tour + weight[:, None] + weight
        total, degree = _one_tree(weighted)
        bound = total - 2 * float(weight.sum()) + extra
        best, pace = max(best, bound), pace * 0.98
        spread = float(((degree - 2) ** 2).sum())
        if not spread:
            return best
        weight = weight + pace * max(length - bound, 0.0) / spread * (degree - 2)
    return best


def _one_tree(distance: Floats) -> tuple[float, Floats]:
    """The length of the shortest tree of all places but the first, which gets its two shortest edges; the degrees."""
    count = len(distance)
    degree, total = np.zeros(count), 0.0
    near, parent = distance[1].copy(), np.ones(count, np.intp)
    near[:2] = np.inf
    for _ in range(count - 2):
        at = int(np.argmin(near))
        total += float(near[at])
        degree[[at, parent[at]]] += 1
        near[at] = np.inf
        nearer = (distance[at] < near) & np.isfinite(near)
        near[nearer], parent[nearer] = distance[at][nearer], at
    two = np.argsort(distance[0, 1:], kind="stable")[:2] + 1
    degree[two] += 1
    degree[0] = 2
    return total + float(distance[0, two].sum()), degree
