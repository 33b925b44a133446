"""The energy's doors: how those between the same rooms count, which depend on each other, and the bound from that."""

from __future__ import annotations

import copy
import dataclasses
import itertools

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from maps import Cells, law
from scored_problems import all_choices, problem_of, records_of

from vdoor.grid import FREE
from vdoor.method.initial_map import InitialMap
from vdoor.method.scoring.score import DoorScores
from vdoor.method.search import certificate as certify
from vdoor.method.search import memetic
from vdoor.method.search.certificate import BoundEnergy, blocks
from vdoor.method.search.costs import DoorEnergy
from vdoor.method.search.incremental import FlipState
from vdoor.method.search.memetic import MemeticSearch
from vdoor.method.search.problem import MergeProblem
from vdoor.synth import PRESETS, synthesize

seeds = st.integers(0, 2**32 - 1)


def parted_by_two(*, side: int = 80) -> Cells:
    """Two square rooms with two openings in the wall between them, in cells of 5 cm."""
    cells = np.full((side + 8, 2 * side + 12), 100, np.int8)
    cells[4:-4, 4 : 4 + side] = FREE
    cells[4:-4, 8 + side : -4] = FREE
    for low in (8, 56):
        cells[4 + low : 4 + low + 16, 4 + side : 8 + side] = FREE
    return cells


@st.composite
def floors(draw: st.DrawFn, most: int = 3) -> Cells:
    """Rooms of 1.5 m in rows, with up to two openings in each wall between two of them."""
    rows, cols = (draw(st.integers(1, most)) for _ in range(2))
    cells = np.full((rows * 34 + 4, cols * 34 + 4), 100, np.int8)
    places = st.lists(st.sampled_from([0, 3, 16, 20]), max_size=2)
    for row, col in itertools.product(range(rows), range(cols)):
        top, left = 4 + 34 * row, 4 + 34 * col
        cells[top : top + 30, left : left + 30] = FREE
        for low in draw(places) if row else ():
            cells[top - 4 : top, left + low : left + low + 10] = FREE
        for low in draw(places) if col else ():
            cells[top + low : top + low + 10, left - 4 : left] = FREE
    return cells


def weighing(problem: MergeProblem, *, further_bias: float, lack_weight: float = 0.0) -> MergeProblem:
    """The same choice with other weights of the energy, of which the problem keeps nothing but the energy itself."""
    assert isinstance(problem.cost, DoorEnergy)
    changed = copy.copy(problem)
    changed.cost = dataclasses.replace(problem.cost, further_bias=further_bias, lack_weight=lack_weight)
    return changed


def parts(problem: MergeProblem, removed: np.ndarray[tuple[int], np.dtype[np.bool_]]) -> list[bool]:
    """Which kept doors separate rooms."""
    return list(problem.separating(removed[None], problem.rooms(removed[None])[0])[0][0])


def test_of_two_doors_between_the_same_rooms_one_counts_as_a_further_one() -> None:
    problem = weighing(problem_of(parted_by_two()), further_bias=0.0)
    both = next(
        removed
        for one, other in itertools.combinations(range(problem.edges), 2)
        for removed in [~np.isin(np.arange(problem.edges), (one, other))]
        if sum(parts(problem, removed)) == 2
        and not any(any(parts(problem, ~(np.arange(problem.edges) == door))) for door in (one, other))
    )
    plain, more = (float(weighing(problem, further_bias=bias).evaluate(both[None]).cost[0]) for bias in (0.0, 1.5))
    assert more == plain - 1.5
    assert FlipState(weighing(problem, further_bias=1.5), np.flatnonzero(both).tolist()).cost == more


@law
@given(floors(), seeds)
def test_flips_and_whole_choices_count_further_doors_alike(cells: Cells, seed: int) -> None:
    problem = weighing(problem_of(cells), further_bias=0.7, lack_weight=1.5)
    assume(0 < problem.edges <= 60)
    rng = np.random.default_rng(seed)
    state = FlipState(problem, np.flatnonzero(rng.random(problem.edges) < 0.5).tolist())
    for edge in rng.integers(problem.edges, size=10).tolist():
        state.try_flip(edge, np.inf)
    assert state.cost == problem.evaluate(np.array([state.removed])).cost[0]


@law
@given(floors(), seeds)
def test_what_doors_part_and_cost_depends_on_their_own_block(cells: Cells, seed: int) -> None:
    problem = weighing(problem_of(cells), further_bias=1.5)
    assume(1 < problem.edges <= 60)
    removed = np.random.default_rng(seed).random(problem.edges) < 0.4
    whole, together = parts(problem, removed), 0.0
    found = blocks(problem)
    assert sorted(np.concatenate(found).tolist()) == list(range(problem.edges))
    for block in found:
        alone = np.ones(problem.edges, np.bool_)
        alone[block] = removed[block]
        assert [parts(problem, alone)[door] for door in block] == [whole[door] for door in block]
        together += float(problem.evaluate(alone[None]).cost[0])
    assert together == pytest.approx(float(problem.evaluate(removed[None]).cost[0]), abs=1e-6)


@law
@given(floors(most=2), st.sampled_from([0.0, 1.5, 6.0]), st.sampled_from([0.3, 2.0, 3.0]), st.sampled_from([1, 10**6]))
def test_no_choice_costs_less_than_the_bound(cells: Cells, lack_weight: float, room_m2: float, most_nodes: int) -> None:
    energy = DoorEnergy(lack_weight=lack_weight, lack_weight_rough=lack_weight, room_m2=room_m2, bias=6, bias_rough=6)
    problem = problem_of(cells, dataclasses.replace(energy, further_bias=1.5, further_bias_rough=1.5))
    assume(0 < problem.edges <= 10)
    best = list(MemeticSearch()(problem, np.random.default_rng(0)))[-1]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(certify, "MOST_NODES", most_nodes)  # blocks too large for all choices to be tried, or none
        certificate = BoundEnergy()(problem, best)
    assert certificate is not None
    assert certificate.lower_bound <= float(problem.evaluate(all_choices(problem.edges)).cost.min()) + 1e-6


@pytest.mark.parametrize("seed", [1, 8, 12, 26, 34])
def test_where_no_block_is_large_and_no_room_lacks_area_the_choice_is_proven(seed: int) -> None:
    made = synthesize(PRESETS["home"], np.random.default_rng(seed))
    found = records_of(made.grid.cells)
    energy = DoorEnergy(lack_weight=0.0, lack_weight_rough=0.0, further_bias=1.0, further_bias_rough=1.0)
    problem = MergeProblem(found[InitialMap], energy, found[DoorScores])
    best = list(MemeticSearch()(problem, np.random.default_rng(seed)))[-1]
    certificate = BoundEnergy()(problem, best)
    assert certificate is not None
    assert certificate.optimal == 1


@law
@given(floors(), seeds)
def test_keeping_a_door_in_vain_lowers_no_cost(cells: Cells, seed: int) -> None:
    problem = problem_of(cells, DoorEnergy(bias=-2.0, bias_rough=-2.0, further_bias=1.0, further_bias_rough=1.0))
    assume(0 < problem.edges <= 60)
    removed = np.random.default_rng(seed).random(problem.edges) < 0.8
    state = FlipState(problem, np.flatnonzero(removed).tolist())
    flipped = removed ^ np.eye(problem.edges, dtype=np.bool_)
    for door, cost in enumerate(problem.evaluate(flipped).cost.tolist()):
        assert cost >= state.cost - 1e-9 or not state.is_vain(door)


@law
@given(floors(), st.sampled_from([0.0, 1.5, 6.0]), st.sampled_from([0.3, 2.0, 3.0]))
def test_one_door_after_another_and_all_choices_at_once_give_one_bound(
    cells: Cells, lack_weight: float, room_m2: float
) -> None:
    energy = DoorEnergy(lack_weight=lack_weight, lack_weight_rough=lack_weight, room_m2=room_m2, bias=6, bias_rough=6)
    problem = problem_of(cells, energy)
    assume(0 < problem.edges <= 60)
    few = [block for block in blocks(problem) if len(block) <= 6]
    bounds = []
    for nodes in (0, 10**6):
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(certify, "FEW_NODES", nodes)
            bounds.append(certify.gain_of_few(problem, few))
    assert bounds[0] == bounds[1]


def test_a_search_whose_work_is_limited_ends_early_and_can_be_told_from_one_that_is_not() -> None:
    problem, search = problem_of(parted_by_two()), MemeticSearch()
    costs = {}
    for most_work in (1, memetic.MOST_WORK):
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(memetic, "MOST_WORK", most_work)
            costs[most_work] = [one.best_cost for one in search(problem, np.random.default_rng(0))]
    assert len(costs[1]) == 2 < len(costs[memetic.MOST_WORK])
    assert [search.cut_short(one) for one in costs.values()] == [True, False]
