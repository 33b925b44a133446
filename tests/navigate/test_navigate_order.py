"""The order of places: against all orders tried, and bounds that hold."""

from __future__ import annotations

from itertools import permutations

import numpy as np
import pytest
from numpy.typing import NDArray

from vdoor.navigate.order import best_order, length_of, lower_bound

ENDS = ((None, None), (0, None), (None, 1), (0, 1), (0, 0))


def graph(rng: np.random.Generator, count: int) -> NDArray[np.float64]:
    """Random distances, by turns of points in a plane and of no geometry."""
    if rng.random() < 0.5:
        place = rng.uniform(size=(count, 2))
        return np.hypot(*(place[:, None] - place).T)
    apart = rng.uniform(0.1, 1, (count, count))
    return np.triu(apart, 1) + np.triu(apart, 1).T


def shortest(distance: NDArray[np.float64], start: int | None, end: int | None) -> float:
    """The least length over all orders."""
    free = [place for place in range(len(distance)) if place not in {start, end}]
    first, last = ([] if place is None else [place] for place in (start, end))
    return min(length_of(distance, [*first, *order, *last]) for order in permutations(free))


def test_the_order_equals_the_best_of_all_on_200_random_graphs() -> None:
    rng = np.random.default_rng(0)
    for number in range(200):
        distance = graph(rng, int(rng.integers(3, 8 if number % 20 else 9)))
        start, end = ENDS[number % len(ENDS)]
        order = best_order(distance, start=start, end=end)
        assert order.length == pytest.approx(shortest(distance, start, end), abs=1e-12)
        assert order.length == pytest.approx(length_of(distance, order.places), abs=1e-12)
        assert sorted(set(order.places)) == list(range(len(distance)))
        assert order.exact
        assert start is None or order.places[0] == start
        assert end is None or order.places[-1] == end


def test_the_heuristic_is_near_the_best_and_its_bound_below_it() -> None:
    rng = np.random.default_rng(1)
    over = []
    for number in range(40):
        distance = graph(rng, 11)
        start, end = ENDS[number % len(ENDS)]
        best = best_order(distance, start=start, end=end).length
        order = best_order(distance, start=start, end=end, most_exact=0)
        assert order.lower_bound <= best + 1e-9 <= order.length + 2e-9
        over.append(order.length / best)
    assert max(over) <= 1.02
    assert np.mean(over) <= 1.002


def test_many_places_get_a_close_bound_and_the_same_order_each_time() -> None:
    place = np.random.default_rng(2).uniform(size=(40, 2))
    distance = np.hypot(*(place[:, None] - place).T)
    order = best_order(distance, start=0)
    assert order.length <= 1.03 * order.lower_bound
    assert best_order(distance, start=0) == order
    assert sorted(order.places) == list(range(40))


def test_places_on_a_line_are_visited_along_it() -> None:
    at = np.array([3.0, 0.0, 2.0, 1.0])
    distance = np.abs(at[:, None] - at)
    assert best_order(distance, start=1).places == (1, 3, 2, 0)
    assert best_order(distance, start=0, end=0).length == 6
    assert lower_bound(distance, 6.0, start=0, end=0) == pytest.approx(6)


def test_few_places_and_places_out_of_reach() -> None:
    assert best_order(np.zeros((1, 1))).places == (0,)
    assert best_order(np.zeros((1, 1)), start=0, end=0).places == (0, 0)
    assert best_order(np.array([[0.0, 2.0], [2.0, 0.0]]), start=1, end=0).places == (1, 0)
    apart = np.full((15, 15), np.inf)
    np.fill_diagonal(apart, 0)
    apart[:14, :14] = 1 - np.eye(14)
    assert best_order(apart).length == np.inf
