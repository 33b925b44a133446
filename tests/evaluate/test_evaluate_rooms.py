"""Measures of rooms: cases reckoned by hand, and plain slow definitions written out."""

from __future__ import annotations

from itertools import permutations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from maps import law
from numpy.typing import NDArray
from scipy import ndimage

from vdoor.errors import VdoorError
from vdoor.evaluate import compare_rooms, rooms_of
from vdoor.evaluate.label_files import MOST_ROOMS, flooded, labels_of_blobs

MEASURES = {"recall", "precision", "recall_by_area", "precision_by_area", "iou", "iou_sym", "mcc", "mcc_loose"}
Labels = NDArray[np.int32]


def row(text: str) -> Labels:
    """One row of cells, a digit each."""
    return np.array([[int(digit) for digit in text]], np.int32)


def everywhere(labels: Labels) -> NDArray[np.bool_]:
    return np.ones(labels.shape, bool)


def test_truth_against_itself_is_perfect() -> None:
    truth = row("1112220333")
    score = compare_rooms(truth, truth, everywhere(truth))
    assert [getattr(score, name) for name in MEASURES - {"mcc_loose"}] == pytest.approx([1] * 7)
    assert score.pairs.tolist() == [[1, 1], [2, 2], [3, 3]]
    assert score.pair_iou.tolist() == [1, 1, 1]


def test_two_rooms_found_as_one() -> None:
    truth, found = row("11111122"), row("11111111")
    score = compare_rooms(truth, found, everywhere(truth))
    assert (score.true, score.found) == (2, 1)
    assert (score.recall, score.recall_by_area) == (1, 1)
    assert score.precision == score.precision_by_area == 6 / 8
    assert score.iou == pytest.approx(6 / 8 / 2)
    assert score.iou_sym == pytest.approx(6 / 8 / 2)


def test_one_room_found_as_two_costs_the_symmetric_iou_alone() -> None:
    truth, found = row("11111111"), row("11111122")
    score = compare_rooms(truth, found, everywhere(truth))
    assert (score.precision, score.iou, score.iou_sym) == (1, 6 / 8, 6 / 8 / 2)


def test_means_weigh_rooms_and_areas() -> None:
    truth, found = row("1111111122"), row("1111111112")
    score = compare_rooms(truth, found, everywhere(truth))
    assert score.recall == pytest.approx((8 / 8 + 1 / 2) / 2)
    assert score.recall_by_area == pytest.approx(9 / 10)
    assert score.precision == pytest.approx((8 / 9 + 1) / 2)


def test_cells_that_are_not_free_count_for_recall_but_not_for_iou() -> None:
    truth, found = row("11112222"), row("11002222")
    score = compare_rooms(truth, found, row("11001111") > 0)
    assert score.recall == (2 / 4 + 1) / 2
    assert score.iou == 1


def test_matthews_correlation_by_hand() -> None:
    # Room 1 with 1: tp 3, fp 1, fn 1, tn 3; room 2 with 2 the same the other way round.
    truth, found = row("11112222"), row("11122221")
    assert compare_rooms(truth, found, everywhere(truth)).mcc == pytest.approx((3 * 3 - 1 * 1) / 4**2)


def test_published_correlation_adds_the_true_area_to_the_negatives() -> None:
    truth, found = row("11112222"), row("11122221")
    negatives = 8 - (1 - 4)
    each = (3 * negatives - 1) / np.sqrt(4 * 4 * (negatives + 1) * (negatives + 1))
    assert compare_rooms(truth, found, everywhere(truth)).mcc_loose == pytest.approx(each)


def test_published_correlation_gives_a_room_too_many_a_partner_that_is_taken() -> None:
    truth, found = row("111111"), row("111122")
    first = (4 * (6 - (0 - 6)) - 0) / np.sqrt(4 * 6 * 12 * (12 + 2))
    second = (2 * (6 - (0 - 6)) - 0) / np.sqrt(2 * 6 * 12 * (12 + 4))
    score = compare_rooms(truth, found, everywhere(truth))
    assert score.mcc_loose == pytest.approx((first + second) / 2)
    assert score.mcc == 0, "both correlations are undefined or without a partner"


def test_published_correlation_gives_it_the_one_it_overlaps_least() -> None:
    truth, found = row("1111111222222"), row("1111133322222")
    first = (5 * (13 - (0 - 7))) / np.sqrt(5 * 7 * 20 * 22)
    second = (5 * (13 - (0 - 6))) / np.sqrt(5 * 6 * 19 * 20)
    third = (1 * (13 - (2 - 6)) - 2 * 5) / np.sqrt(3 * 6 * (17 + 2) * (17 + 5))
    assert compare_rooms(truth, found, everywhere(truth)).mcc_loose == pytest.approx((first + second + third) / 3)


def test_published_correlation_counts_a_missed_room_once_for_each_room_that_overlaps_it() -> None:
    truth, found = row("111223"), row("111222")
    assert (found[truth == 3] == 2).all()
    first = (3 * (6 - (0 - 3))) / np.sqrt(3 * 3 * 9 * 9)
    second = (2 * (6 - (1 - 2))) / np.sqrt(3 * 2 * (7 + 1) * 7)
    assert compare_rooms(truth, found, everywhere(truth)).mcc_loose == pytest.approx((first + second + 0) / 3)


def test_no_rooms_on_either_side_is_worth_nothing() -> None:
    nothing, room = row("0000"), row("0110")
    for truth, found in ((nothing, room), (room, nothing), (nothing, nothing)):
        score = compare_rooms(truth, found, everywhere(truth))
        assert {getattr(score, name) for name in MEASURES} == {0}
        assert len(score.pairs) == 0


def rasters() -> st.SearchStrategy[tuple[Labels, Labels, NDArray[np.bool_]]]:
    """True rooms, found rooms and free cells of small random maps."""

    def drawn(seed: int) -> tuple[Labels, Labels, NDArray[np.bool_]]:
        rng = np.random.default_rng(seed)
        shape = tuple(rng.integers(2, 9, 2))
        truth, found = (rooms_of(rng.integers(0, rng.integers(2, 6), shape), 1.0) for _ in range(2))
        return (
            truth,
            np.where(rng.random(shape) < rng.random(), truth, 0) if seed % 3 else found,
            rng.random(shape) < 0.8,
        )

    return st.integers(0, 2**32 - 1).map(drawn).map(lambda made: (made[0], rooms_of(made[1], 1.0), made[2]))


def cells(labels: Labels, room: int) -> set[int]:
    return set(np.flatnonzero(labels == room).tolist())


@law
@given(rasters())
def test_recall_precision_and_iou_follow_their_definitions(made: tuple[Labels, Labels, NDArray[np.bool_]]) -> None:
    truth, found, free = made
    score = compare_rooms(truth, found, free)
    trues, founds = ([cells(side, room) for room in range(1, side.max() + 1)] for side in (truth, found))
    if not trues or not founds:
        return
    best = [max(len(true & other) for other in founds) for true in trues]
    assert score.recall == pytest.approx(np.mean([b / len(true) for b, true in zip(best, trues, strict=True)]))
    assert score.recall_by_area == pytest.approx(sum(best) / sum(map(len, trues)))
    inside = set(np.flatnonzero(free).tolist())
    iou = np.array([[len(a & b & inside) / max(len((a | b) & inside), 1) for b in founds] for a in trues])
    short, long = sorted(iou.shape)
    upright = iou if iou.shape[0] == short else iou.T
    total = max(sum(upright[k, p] for k, p in enumerate(choice)) for choice in permutations(range(long), short))
    assert score.iou == pytest.approx(total / len(trues))
    assert score.iou_sym == pytest.approx(total / long)


@law
@given(rasters())
def test_matthews_correlation_is_pearson_of_the_two_masks(made: tuple[Labels, Labels, NDArray[np.bool_]]) -> None:
    truth, found, free = made
    score = compare_rooms(truth, found, free)
    both = free & (truth > 0) & (found > 0)
    left = {
        (t, f): np.sum((truth == t) & (found == f) & both)
        for t in np.unique(truth[both])
        for f in np.unique(found[both])
    }
    values = []
    while left and max(left.values()) > 0:
        true, other = max(left, key=lambda pair: (left[pair], -pair[0], -pair[1]))
        a, b = truth[both] == true, found[both] == other
        defined = a.std() > 0 and b.std() > 0
        values.append(np.corrcoef(a, b)[0, 1] if defined else float((a == b).all()))
        left = {pair: size for pair, size in left.items() if pair[0] != true and pair[1] != other}
    alone = score.true + score.found - 2 * len(values)
    wanted = sum(values) / (len(values) + alone) if score.true and score.found else 0
    assert score.mcc == pytest.approx(wanted, abs=1e-12)


@law
@given(rasters(), st.permutations(range(1, 6)))
def test_names_of_rooms_do_not_matter(made: tuple[Labels, Labels, NDArray[np.bool_]], names: list[int]) -> None:
    truth, found, free = made
    renamed = rooms_of(np.array([0, *names])[found], 1.0)
    before, after = (compare_rooms(truth, side, free) for side in (found, renamed))
    for name in ("recall", "precision", "recall_by_area", "precision_by_area", "iou", "iou_sym"):
        assert getattr(after, name) == pytest.approx(getattr(before, name))


def test_rooms_are_numbered_in_the_order_of_their_labels_and_small_ones_dropped() -> None:
    labels = np.zeros((40, 40), np.int64)
    labels[:10, :10] = 7  # 100 cells of 5 cm: 0.25 m2
    labels[20:30, :11] = 9
    labels[20:31, 20:31] = -4
    rooms = rooms_of(labels, 0.05)
    assert rooms.dtype == np.int32
    assert {name: np.unique(rooms[labels == name]).tolist() for name in (0, 7, 9, -4)} == {
        0: [0],
        7: [0],
        9: [2],
        -4: [1],
    }
    assert rooms_of(labels, 0.1).max() == 3, "at 10 cm a cell none of them is small"


def test_noise_is_refused() -> None:
    with pytest.raises(VdoorError, match=f"wanted at most {MOST_ROOMS} rooms, found {MOST_ROOMS + 1}$"):
        rooms_of(np.arange(MOST_ROOMS + 2)[None], 1.0)


def test_blobs_are_the_components_of_white_by_eight_neighbours() -> None:
    greys = np.random.default_rng(0).choice(np.array([0, 250, 251, 255], np.uint8), (30, 30), p=[0.5, 0.2, 0.15, 0.15])
    labels = labels_of_blobs(greys)
    assert np.array_equal(labels > 0, greys > 250)
    assert labels.max() == ndimage.label(greys > 250, np.ones((3, 3)))[1]
    assert labels_of_blobs(np.array([[255, 0], [0, 255]], np.uint8)).tolist() == [[1, 0], [0, 1]]


@law
@given(st.integers(0, 2**32 - 1), st.integers(0, 4))
def test_flooding_is_one_cell_a_step_the_largest_label_first(seed: int, steps: int) -> None:
    rng = np.random.default_rng(seed)
    labels = rng.choice(np.array([0, 0, 0, 1, 2, 3], np.int32), (6, 7))
    free = (labels > 0) | (rng.random(labels.shape) < 0.7)
    wanted = labels
    for _ in range(steps):
        reaching = ndimage.maximum_filter(wanted, footprint=ndimage.generate_binary_structure(2, 1), mode="constant")
        wanted = np.where(free & (wanted == 0), reaching, wanted)
    assert np.array_equal(flooded(labels, free, steps), wanted)
