"""Searches against plain loops, and the books of one flip at a time against the books of whole choices."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from maps import CELL_M, Cells, drawn, law, small_maps, stages

from vdoor.errors import SettingError
from vdoor.grid import OccupancyGrid
from vdoor.method.doors import ProposeDoors
from vdoor.method.search.costs import MapCost
from vdoor.method.search.generation import Generation
from vdoor.method.search.incremental import FlipState
from vdoor.method.search.optimisers import AnnealingSearch, ExhaustiveSearch, GeneticSearch
from vdoor.method.search.problem import MergeProblem
from vdoor.pipeline import Pipeline

LONG_DOORS = Pipeline(doors=ProposeDoors(max_length_m=2.4))
ONE_ROOM = "####\n#..#\n#..#\n####"
MOST_DOORS = 10
FOUR_ROOMS = """
    #######################
    #.........##..........#
    #.........##..........#
    #.........##..........#
    #.....................#
    #.....................#
    #.....................#
    #.....................#
    #.........##..........#
    ###....########....####
    #.........##..........#
    #.........##..........#
    #.....................#
    #.....................#
    #.....................#
    #.....................#
    #.........##..........#
    #.........##..........#
    #######################
"""


def problem_of(cells: Cells, pipeline: Pipeline = LONG_DOORS) -> MergeProblem:
    return MergeProblem(stages(OccupancyGrid.from_array(cells, CELL_M), pipeline).initial, pipeline.cost)


def searched(search: Any, problem: MergeProblem, seed: int = 0) -> list[Generation]:
    return list(search(problem, np.random.default_rng(seed)))


def all_choices(count: int) -> np.ndarray[Any, np.dtype[np.bool_]]:
    """Every string (2^r, r), counted in binary with the first bit the lowest."""
    return np.array([bits[::-1] for bits in itertools.product([False, True], repeat=count)], np.bool_).reshape(
        2**count, count
    )


@law
@given(cells=small_maps(most=26), batch=st.sampled_from([1, 7, 64, 4096]))
def test_exhaustive_search_is_a_plain_loop_over_all_choices(cells: Cells, batch: int) -> None:
    problem = problem_of(cells)
    assume(problem.edges <= MOST_DOORS)
    generations = searched(ExhaustiveSearch(batch=batch), problem)
    costs = [float(problem.evaluate(choice[None]).cost[0]) for choice in all_choices(problem.edges)]
    best = int(np.argmin(costs))
    assert generations[-1].best_cost == costs[best]
    assert generations[-1].removed.tolist() == all_choices(problem.edges)[best].tolist()
    assert generations[-1].evaluations == len(costs)
    assert [generation.number for generation in generations] == list(range(-(-len(costs) // batch)))
    assert max(generation.worst_cost for generation in generations) == max(costs)


@law
@given(cells=small_maps(most=26), seed=st.integers(0, 2**32))
def test_searches_report_costs_that_their_best_strings_have(cells: Cells, seed: int) -> None:
    problem = problem_of(cells)
    for search in (
        GeneticSearch(population=9, generations=5),
        AnnealingSearch(evaluations=105, per_generation=20),
    ):
        generations = searched(search, problem, seed)
        assert all(after.best_cost <= before.best_cost for before, after in itertools.pairwise(generations))
        for generation in generations:
            costs = problem.evaluate(generation.removed[None])
            found = (generation.best_cost, generation.small_rooms, generation.area_sd_m2, generation.tilt_sd_deg)
            assert found == tuple(float(term[0]) for term in costs)
            assert generation.best_cost <= generation.mean_cost * (1 + 1e-12)
            assert generation.mean_cost <= generation.worst_cost * (1 + 1e-12)
        repeated = searched(search, problem, seed)
        assert [one.removed.tolist() for one in generations] == [other.removed.tolist() for other in repeated]


@pytest.mark.parametrize("search", [GeneticSearch(), AnnealingSearch()], ids=["genetic", "annealing"])
@pytest.mark.parametrize("seed", range(3))
def test_a_search_by_chance_reaches_the_proven_optimum(search: Any, seed: int) -> None:
    problem = MergeProblem(stages(drawn(FOUR_ROOMS)).initial, Pipeline().cost)
    assert 4 <= problem.edges <= MOST_DOORS
    assert searched(search, problem, seed)[-1].best_cost == searched(ExhaustiveSearch(), problem)[-1].best_cost


@law
@given(cells=small_maps(most=26), data=st.data())
def test_flipping_doors_one_by_one_costs_what_the_whole_choice_costs_bit_for_bit(
    cells: Cells, data: st.DataObject
) -> None:
    problem = problem_of(cells)
    assume(problem.edges > 0)
    start = data.draw(st.sets(st.integers(0, problem.edges - 1)))
    state = FlipState(problem, start)
    choice = np.isin(np.arange(problem.edges), list(start))
    lowest = float("inf")
    flips = data.draw(
        st.lists(st.tuples(st.integers(0, problem.edges - 1), st.sampled_from([0.0, 0.3, 1e9])), max_size=40)
    )
    for edge, allowance in [(0, 0.0), *flips]:
        cost = float(problem.evaluate(choice[None]).cost[0])
        assert state.cost == cost
        assert state.removed == choice.tolist()
        lowest = min(lowest, cost)
        other = choice.copy()
        other[edge] ^= True
        taken = state.try_flip(edge, allowance)
        assert taken == (float(problem.evaluate(other[None]).cost[0]) <= cost + allowance)
        choice = other if taken else choice
    assert state.best_cost == min(lowest, state.cost)
    assert float(problem.evaluate(np.array([state.best])).cost[0]) == state.best_cost


@law
@given(cells=small_maps(most=26))
def test_removing_every_door_leaves_one_room_and_keeping_all_leaves_the_regions(cells: Cells) -> None:
    problem = problem_of(cells)
    assume(problem.edges > 0)
    both = np.stack([np.ones(problem.edges, np.bool_), np.zeros(problem.edges, np.bool_)])
    room, is_open = problem.rooms(both)
    assert is_open[0].all()
    assert len(np.unique(room[0])) == 1
    assert np.flatnonzero(is_open[1]).tolist() == list(range(problem.regions))
    assert len(np.unique(room[1, : problem.regions])) == problem.regions


def test_a_batch_of_choices_costs_what_each_costs_alone() -> None:
    problem = MergeProblem(stages(drawn(FOUR_ROOMS)).initial, MapCost(room_m2=3.0, tilt_weight_per_deg=0.2))
    choices = all_choices(problem.edges)
    together = problem.evaluate(choices)
    for number, choice in enumerate(choices):
        alone = problem.evaluate(choice[None])
        assert all(a[number] == b[0] for a, b in zip(together, alone, strict=True))


@pytest.mark.parametrize("search", [GeneticSearch(population=5), AnnealingSearch(), ExhaustiveSearch()])
def test_without_doors_there_is_one_choice(search: Any) -> None:
    problem = MergeProblem(stages(drawn(ONE_ROOM)).initial, Pipeline().cost)
    generations = searched(search, problem)
    assert generations[-1].removed.shape == (0,)
    assert generations[-1].tilt_sd_deg == 0
    assert generations[-1].small_rooms == 1
    assert generations[-1].area_sd_m2 == pytest.approx(2.0 - 0.16)
    assert generations[-1].best_cost == pytest.approx(1 + 0.05 * 1.84)


def test_exhaustive_search_refuses_what_would_take_too_long() -> None:
    problem = MergeProblem(stages(drawn(FOUR_ROOMS)).initial, Pipeline().cost)
    with pytest.raises(SettingError, match="wanted at most 3 doors, found 10; use annealing or genetic"):
        searched(ExhaustiveSearch(most_edges=3), problem)


def test_the_genetic_search_is_as_printed() -> None:
    """50 strings, 50 generations, survivors no worse than their parents, 50 evaluations a generation."""
    problem = MergeProblem(stages(drawn(FOUR_ROOMS)).initial, Pipeline().cost)
    generations = searched(GeneticSearch(), problem)
    assert [generation.number for generation in generations] == list(range(51))
    assert [generation.evaluations for generation in generations] == [50 * number for number in range(1, 52)]
    for before, after in itertools.pairwise(generations):
        assert after.mean_cost <= before.mean_cost
        assert after.worst_cost <= before.worst_cost


@pytest.mark.parametrize("size", [2, 5, 50])
def test_children_take_each_bit_from_a_parent_or_from_a_mutation(size: int) -> None:
    parents = np.random.default_rng(1).random((size, 40)) < 0.5
    swap = GeneticSearch(population=size, mutate_to_removed=0.0, mutate_to_kept=0.0)
    children = swap.offspring(parents, np.random.default_rng(2))
    assert children.shape == parents.shape
    if size % 2 == 0:
        assert children.sum(axis=0).tolist() == parents.sum(axis=0).tolist()
    still = GeneticSearch(population=size, crossover=0.0, mutate_to_removed=1.0, mutate_to_kept=0.0)
    assert still.offspring(parents, np.random.default_rng(2)).all()
    gone = GeneticSearch(population=size, crossover=0.0, mutate_to_removed=0.0, mutate_to_kept=1.0)
    assert not gone.offspring(parents, np.random.default_rng(2)).any()


def test_mutation_is_as_uneven_as_it_is_set() -> None:
    parents = np.random.default_rng(1).random((2000, 50)) < 0.5
    children = GeneticSearch(crossover=0.0).offspring(parents, np.random.default_rng(2))
    # With crossover off, children are the parents in another order: totals tell the rates.
    expected = parents.sum() * (1 - 0.01) + (~parents).sum() * 0.1
    assert children.sum() == pytest.approx(expected, rel=0.01)
