"""Doors found between rooms, and which of them are the true ones."""

from __future__ import annotations

from itertools import permutations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from maps import law
from numpy.typing import NDArray
from scipy.spatial.distance import cdist, pdist

from vdoor.evaluate import Doors, Tally, contact_doors, marked_doors, match_doors
from vdoor.evaluate.door_places import _farthest, angles_rad, nearest_pairs

CELL_M = 0.05


def two_rooms(*gaps: slice, wall: slice = slice(40, 42)) -> tuple[NDArray[np.int32], NDArray[np.bool_]]:
    """Room 1 left and room 2 right of a wall with gaps, in which no cell has a label."""
    labels = np.full((60, 80), 2, np.int32)
    labels[:, : wall.start] = 1
    labels[:, wall] = 0
    free = labels > 0
    for gap in gaps:
        free[gap, wall] = True
    return labels, free


def test_a_gap_in_a_wall_is_a_door_of_its_width() -> None:
    doors = contact_doors(*two_rooms(slice(20, 36)), CELL_M)
    assert len(doors) == 1
    assert doors.width_m == pytest.approx([16 * CELL_M])
    assert doors.centre_m == pytest.approx(np.array([[41 * CELL_M, 28 * CELL_M]]))
    assert sorted(map(tuple, doors.ends[0].tolist())) == [(20.0, 40.5), (35.0, 40.5)]
    assert doors.centre.tolist() == [[27.5, 40.5]]


def test_two_gaps_are_two_doors_unless_less_than_a_post_is_between() -> None:
    assert len(contact_doors(*two_rooms(slice(5, 20), slice(40, 52)), CELL_M)) == 2
    # Edges five cells apart, 0.25 m, are one door; seven cells, 0.35 m, two.
    assert len(contact_doors(*two_rooms(slice(5, 20), slice(24, 40)), CELL_M)) == 1
    assert len(contact_doors(*two_rooms(slice(5, 20), slice(26, 40)), CELL_M)) == 2


def test_slits_are_no_doors() -> None:
    assert len(contact_doors(*two_rooms(slice(10, 14)), CELL_M)) == 0
    assert len(contact_doors(*two_rooms(slice(10, 15)), CELL_M)) == 1


def test_rooms_reach_each_other_over_sixty_centimetres_and_no_further() -> None:
    assert len(contact_doors(*two_rooms(slice(10, 30), wall=slice(34, 46)), CELL_M)) == 1
    assert len(contact_doors(*two_rooms(slice(10, 30), wall=slice(34, 47)), CELL_M)) == 0


def test_every_pair_of_rooms_has_its_own_doors() -> None:
    labels = np.ones((40, 40), np.int32)
    labels[20:, :20], labels[20:, 20:] = 2, 3
    doors = contact_doors(labels, labels > 0, CELL_M)
    assert len(doors) == 3
    assert sorted(doors.width_m.tolist()) == pytest.approx([1.0, 1.0, 1.0])


def test_a_map_of_one_room_has_no_door() -> None:
    doors = contact_doors(np.ones((9, 9), np.int32), np.ones((9, 9), bool), CELL_M)
    assert (len(doors), doors.centre_m.shape, doors.ends.shape) == (0, (0, 2), (0, 2, 2))


@law
@given(st.integers(0, 2**32 - 1), st.integers(1, 40))
def test_the_farthest_two_are_the_farthest_two(seed: int, count: int) -> None:
    places = np.random.default_rng(seed).integers(0, 12, (count, 2)) / 2
    ends = _farthest(places)
    assert np.hypot(*(ends[1] - ends[0])) == pytest.approx(pdist(places).max() if count > 1 else 0)
    assert all((places == end).all(axis=1).any() for end in ends)


@pytest.mark.parametrize("step", [(0.0, 1.0), (1.0, 0.0), (0.5, 0.5), (0.5, -0.5)])
def test_the_ends_of_a_line_are_its_ends(step: tuple[float, float]) -> None:
    places = np.arange(30)[:, None] * np.array(step)
    ends = _farthest(np.random.default_rng(0).permutation(places))
    assert {tuple(end) for end in ends.tolist()} == {tuple(places[0].tolist()), tuple(places[-1].tolist())}


def test_marked_doors_lie_in_the_middle_of_their_segment() -> None:
    doors = marked_doors(np.array([[[10.0, 4.0], [10.0, 24.0]]]), CELL_M)
    assert doors.centre_m == pytest.approx(np.array([[14.5 * CELL_M, 10.5 * CELL_M]]))
    assert doors.width_m == pytest.approx([1.0])


def at(*places_m: tuple[float, float], width_m: float = 0.9) -> Doors:
    """Doors at places right and down in metres."""
    centre_m = np.array(places_m, float).reshape(-1, 2)
    ends = np.repeat(centre_m[:, None, ::-1] / CELL_M - 0.5, 2, axis=1)
    return Doors(centre_m=centre_m, width_m=np.full(len(centre_m), width_m), ends=ends)


def test_hits_misses_and_false_doors() -> None:
    true, found = at((1, 1), (5, 1), (9, 1)), at((5.3, 1), (1, 1.2), (7, 1))
    match = match_doors(true, found, 0.5)
    assert sorted(zip(match.hit_true.tolist(), match.hit_found.tolist(), strict=True)) == [(0, 1), (1, 0)]
    assert (match.missed.tolist(), match.false.tolist(), match.excused.tolist()) == ([2], [2], [])
    tally = match.tally
    assert (tally.precision, tally.recall, tally.f1) == pytest.approx((2 / 3, 2 / 3, 2 / 3))


def test_one_door_is_hit_once() -> None:
    match = match_doors(at((1, 1)), at((1, 1), (1.1, 1)), 0.5)
    assert (match.hit_found.tolist(), match.false.tolist()) == ([0], [1])


def test_an_unsure_door_excuses_one_false_door_and_is_never_missed() -> None:
    true, found = at((1, 1)), at((1, 1), (5, 1), (5.5, 1), (8, 1))
    match = match_doors(true, found, 0.5, unsure=at((5, 1.8), (12, 1)))
    assert (match.excused.tolist(), match.false.tolist(), match.missed.tolist()) == ([1], [2, 3], [])
    assert match.tally.precision == 1 / 3


def test_an_unsure_door_does_not_take_a_hit_away() -> None:
    match = match_doors(at((1, 1)), at((1, 1)), 0.5, unsure=at((1, 1)))
    assert match.tally == Tally(hits=1, narrow_hits=1)


def test_doors_up_to_a_metre_twenty_are_narrow() -> None:
    true = Doors(
        centre_m=at((1, 1), (5, 1), (9, 1)).centre_m, width_m=np.array([1.2, 1.25, 0.8]), ends=np.zeros((3, 2, 2))
    )
    tally = match_doors(true, at((1, 1), (5, 1)), 0.5).tally
    assert (tally.narrow_hits, tally.narrow_missed, tally.narrow_recall) == (1, 1, 0.5)


@pytest.mark.parametrize(
    ("tally", "precision", "recall", "f1"),
    [
        (Tally(), 1, 1, 1),
        (Tally(missed=2), 0, 0, 0),
        (Tally(false=2), 0, 1, 0),
        (Tally(hits=1, missed=1), 1, 0.5, 2 / 3),
    ],
)
def test_shares_of_nothing(tally: Tally, precision: float, recall: float, f1: float) -> None:
    assert (tally.precision, tally.recall, tally.f1) == pytest.approx((precision, recall, f1))


def test_tallies_add_up() -> None:
    one, other = Tally(hits=1, missed=2, false=3, narrow_hits=4, narrow_missed=5), Tally(hits=10, false=30)
    assert one + other == Tally(hits=11, missed=2, false=33, narrow_hits=4, narrow_missed=5)


@law
@given(st.integers(0, 2**32 - 1), st.integers(0, 5), st.integers(0, 4))
def test_pairs_are_as_many_and_then_as_near_as_can_be(seed: int, ones: int, others: int) -> None:
    rng = np.random.default_rng(seed)
    one, other = rng.random((ones, 2)) * 2, rng.random((others, 2)) * 2
    rows, columns = nearest_pairs(one, other, 0.7)
    apart = cdist(one, other)
    upright = apart if ones <= others else apart.T
    best = (0, 0.0)
    for choice in permutations(range(upright.shape[1]), upright.shape[0]):
        near = [upright[k, c] for k, c in enumerate(choice) if upright[k, c] <= 0.7]
        best = min(best, (-len(near), sum(near)))
    assert (-len(rows), apart[rows, columns].sum()) == pytest.approx(best)
    assert len({*rows.tolist()}) == len({*columns.tolist()}) == len(rows)


def test_the_angle_between_doors_does_not_depend_on_the_order_of_their_ends() -> None:
    one = marked_doors(np.array([[[0.0, 0.0], [0.0, 9.0]]] * 4), CELL_M)
    other = marked_doors(
        np.array([[[3, 3], [3, 5]], [[3, 5], [3, 3]], [[0, 0], [5, 0]], [[1, 1], [0, 2]]], float), CELL_M
    )
    assert np.degrees(angles_rad(one, other)) == pytest.approx([0, 0, 90, 45])
    assert np.degrees(angles_rad(other, one)) == pytest.approx([0, 0, 90, 45])
