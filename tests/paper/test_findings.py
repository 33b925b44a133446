"""The paper's figures and tables as this project finds them."""

from __future__ import annotations

import dataclasses
import itertools
from typing import Any

import numpy as np
import pytest
from maps import stages, text_of
from scipy.stats import binomtest
from small_evidence import small_evidence

from vdoor.api import run
from vdoor.baselines.voronoi_doors import everything_kept
from vdoor.goldens import CROSSING, drawing
from vdoor.method.final_map import MergeRooms
from vdoor.method.search.costs import MapCost
from vdoor.method.search.optimisers import GeneticSearch
from vdoor.method.search.problem import MergeProblem
from vdoor.paper.claims import claims
from vdoor.paper.door_counts import (
    ENVIRONMENTS,
    METHODS,
    PRINTED,
    DoorCount,
    Environment,
    Share,
    count_by_method,
    count_doors,
    methods_for,
    study_apartments,
    table_one,
    virtual_doors_m,
)
from vdoor.paper.figures import SUB_CASES, Operation, crossover, measured_rates, mutation, run_sub_case, sub_cases
from vdoor.paper.search import POPULATION, PRINTED_LOG2_LOAD, log2_load, study_search
from vdoor.paper.walkthrough import PRINTED_EDGES, PRINTED_GENERATION, figure_5_run, run_method, walk_through
from vdoor.synth import PRESETS as KINDS
from vdoor.synth import synthesize

DOORS_OF_CASES = {
    # candidates, corners: concave and convex; doors between pairs and at single corners; final doors
    "3b": ((16, 0), (4, 0), (0, 0), 0),
    "3c, 3d": ((20, 1), (5, 1), (0, 0), 0),
    "3e": ((32, 2), (8, 2), (1, 0), 1),
    "3f": ((24, 1), (6, 1), (0, 1), 1),
    "3g": ((32, 4), (8, 4), (4, 0), 1),
}


@pytest.mark.parametrize(
    "case", [case for case in SUB_CASES if case.part in DOORS_OF_CASES], ids=lambda case: case.part
)
def test_each_part_of_figure_3_shows_what_it_is_there_for(case: Any) -> None:
    counts = run_sub_case(case).counts
    candidates = (counts.concave_candidates, counts.convex_candidates)
    corners = (counts.concave_corners, counts.convex_corners)
    found = (candidates, corners, (counts.pairs, counts.singles), counts.final_edges)
    assert found == DOORS_OF_CASES[case.part]


def test_figure_3a_removes_what_is_outside_and_what_is_shut_in() -> None:
    part = sub_cases()[0]
    outside = part.case.drawing.split()[1][12:]
    assert "." in outside
    assert all(set(line[12:]) == {"?"} for line in part.simplified.split())
    assert part.simplified.split()[5] == "#...#??#...#??????"
    assert part.counts.unreachable_cells == part.case.drawing.count(".") - part.simplified.count(".") == 12


def test_figure_3b_has_a_corner_less_with_the_jut_flattened_than_with_it() -> None:
    part = sub_cases()[1]
    assert part.counts.jut_cells == 1
    assert part.simplified.split()[-2] == "#.............#"
    assert part.counts.convex_corners == 0
    assert part.undone is not None
    assert part.undone.convex_corners == 1


def test_a_case_is_drawn_as_it_is_written() -> None:
    for case in SUB_CASES:
        assert text_of(case.grid.cells) == case.drawing


def offspring(search: GeneticSearch, operation: Operation) -> list[str]:
    """What a search makes of an operation's strings by its seed."""
    parents = np.array([[bit == "1" for bit in text] for text in operation.before])
    children = search.offspring(parents, np.random.default_rng(operation.seed))
    return ["".join("01"[bit] for bit in child) for child in children.astype(int)]


def test_crossover_exchanges_the_bits_that_figure_4_exchanges_and_no_others() -> None:
    found = crossover()
    assert found.before == ("0000000", "1111111")
    assert found.after == ("1100001", "0011110")
    assert found.changed == (0, 1, 6)
    search = GeneticSearch(mutate_to_removed=0.0, mutate_to_kept=0.0)
    assert {*offspring(search, found)} == {*found.after}


def test_mutation_turns_the_string_of_figure_4_into_its_result() -> None:
    found = mutation()
    assert found.before == ("00010110000",)
    assert found.after == ("10010100000",)
    assert [found.before[0][bit] for bit in found.changed] == ["0", "1"]
    assert offspring(GeneticSearch(crossover=0.0), found) == [*found.after]


@pytest.mark.parametrize("chances", [(0.5, 0.1, 0.01), (0.2, 0.3, 0.05), (0.9, 0.0, 1.0)])
def test_bits_change_as_often_as_the_search_sets(chances: tuple[float, float, float]) -> None:
    crossover, to_removed, to_kept = chances
    search = GeneticSearch(crossover=crossover, mutate_to_removed=to_removed, mutate_to_kept=to_kept)
    rates = measured_rates(search)
    for found, chance in zip((rates.exchanged, rates.to_removed, rates.to_kept), chances, strict=True):
        assert abs(found - chance) <= 4 * np.sqrt(chance * (1 - chance) / rates.bits)


def test_the_rates_shown_are_those_of_the_printed_chances() -> None:
    assert measured_rates() == measured_rates(GeneticSearch(crossover=0.5, mutate_to_removed=0.1, mutate_to_kept=0.01))


def test_the_walk_through_ends_as_the_paper_does_and_the_search_finds_the_proven_optimum() -> None:
    walk = figure_5_run()
    ours = {line.what: line.ours for line in walk_through(walk).lines}
    assert ours["nodes of the final map"] == 4
    assert ours["edges of the final map"] == 3
    found = study_search(walk, graphs=1)
    assert found.proven
    assert found.search_space == 2 ** ours["edges of the initial map"]
    assert found.evaluations < found.search_space / 10


def test_the_walk_through_is_of_the_printed_size_or_has_a_note_why_not() -> None:
    for line in walk_through(figure_5_run()).lines:
        assert line.printed / 2 <= line.ours <= line.printed * 2, line
        assert line.note or abs(line.ours - line.printed) <= 1, line


def test_the_papers_own_numbers_do_not_give_the_load_it_prints() -> None:
    assert log2_load(2**7, 16) == PRINTED_LOG2_LOAD
    assert log2_load(PRINTED_GENERATION * POPULATION, PRINTED_EDGES) == pytest.approx(-7.19, abs=0.01)


def test_counts_are_those_of_the_run() -> None:
    grid = SUB_CASES[-1].grid
    walk = run_method(grid, seed=3)
    assert walk.counts.final_edges == len(run(grid, "paper", seed=3).doors)
    assert len(walk.search) == 51
    assert walk.counts.virtual_doors == walk.counts.pairs + walk.counts.singles


def test_printed_accuracies_are_those_of_table_1() -> None:
    accuracies = [[round(PRINTED[case][name].accuracy.value, 2) for name in PRINTED[case]] for case in PRINTED]
    assert accuracies == [[0.44, 0.57], [0.40, 1.00], [0.60, 1.00]]


def test_environments_are_the_first_with_so_many_doors() -> None:
    """So nobody chose them by what a method finds in them."""
    for rooms, of_kind in itertools.groupby(ENVIRONMENTS, key=lambda environment: environment.rooms):
        wanted = list(of_kind)
        seeds = (
            seed
            for seed in itertools.count()
            if len(dataclasses.replace(wanted[0], seed=seed).made.doors) == wanted[0].doors
        )
        assert [environment.seed for environment in wanted] == list(itertools.islice(seeds, len(wanted))), rooms
    for environment in ENVIRONMENTS:
        assert environment.doors == PRINTED[environment.name]["existing"].real


@pytest.mark.parametrize("furniture", [False, True], ids=["empty", "furnished"])
def test_table_1_the_proposed_method_finds_every_door_as_accurately_as_printed(*, furniture: bool) -> None:
    for row in table_one(furniture=furniture):
        proposed, printed = row.found["proposed"], row.printed["proposed"]
        assert proposed.real == proposed.matched == row.environment.doors
        assert proposed.accuracy.value >= printed.accuracy.value
        assert all(proposed.accuracy.value >= other.accuracy.value for other in row.found.values())


def test_table_1_furnished_the_voronoi_doors_are_as_wrong_as_printed() -> None:
    found = sum((row.found["voronoi-doors"] for row in table_one(furniture=True)), DoorCount())
    printed = sum((row.printed["existing"] for row in table_one(furniture=True)), DoorCount())
    assert found.accuracy.value == pytest.approx(printed.accuracy.value, abs=0.1)


def test_furniture_changes_no_door_of_an_environment() -> None:
    for environment in ENVIRONMENTS:
        assert dataclasses.replace(environment, furniture=True).made.doors == environment.made.doors


@pytest.mark.parametrize("furniture", [False, True], ids=["empty", "furnished"])
def test_over_apartments_the_proposed_method_is_above_both_stand_ins(*, furniture: bool) -> None:
    study = study_apartments(30, furniture=furniture)
    proposed = study.doors["proposed"]
    assert proposed.found.value >= 0.98
    assert proposed.accuracy.value >= 0.95
    for name in set(METHODS) - {"proposed"}:
        assert study.doors[name].accuracy.value < proposed.accuracy.value
        assert study.doors[name].found.value <= proposed.found.value
        assert study.without_error[name].part < study.without_error["proposed"].part


def test_a_study_is_the_sum_of_its_apartments() -> None:
    study = study_apartments(2, furniture=True)
    kind = dataclasses.replace(KINDS["paper"], furniture=True)
    made = [synthesize(dataclasses.replace(kind, rooms=4 + at), np.random.default_rng(1000 + at)) for at in range(2)]
    for name, method in METHODS.items():
        assert study.doors[name] == count_doors(made[0], method) + count_doors(made[1], method, seed=1)
    assert study_apartments(2, furniture=True) == study


@pytest.mark.parametrize(("part", "of"), [(0, 5), (5, 5), (3, 7), (772, 780)])
def test_intervals_are_wilsons(part: int, of: int) -> None:
    share = Share(part=part, of=of)
    reference = binomtest(part, of).proportion_ci(0.95, method="wilson")
    assert share.value == part / of
    assert share.interval == pytest.approx((reference.low, reference.high), abs=1e-12)


def test_nothing_has_no_share_and_any_interval() -> None:
    assert np.isnan(DoorCount().accuracy.value)
    assert DoorCount().found.interval == (0.0, 1.0)


def test_where_islands_are_kept_nothing_is_taken_out_and_more_is_found_that_is_no_door() -> None:
    empty, furnished = (dataclasses.replace(ENVIRONMENTS[2], furniture=furniture).made for furniture in (False, True))
    assert [*methods_for(empty)] == [*METHODS]
    islands_m = {name: method.simplify.max_island_m for name, method in methods_for(furnished).items()}
    assert islands_m == dict.fromkeys(METHODS, 1.0) | {"islands-kept": 0.0}
    found = table_one(furniture=True)[2].found
    assert found["islands-kept"] == count_by_method(furnished)["islands-kept"]
    assert found["islands-kept"].virtual > found["proposed"].virtual


def test_section_3_is_counted_from_the_searches_themselves() -> None:
    walk = figure_5_run(seed=5)
    found = study_search(walk, graphs=2)
    assert found.reached[5] == walk.counts.best_generation == found.best_generation
    assert found.evaluations == 50 * (walk.counts.best_generation + 1)
    assert found.all_evaluations == 50 * 51
    best = [course.best for course in found.courses]
    assert best == sorted(best, reverse=True)
    assert all(course.best - 1e-9 <= course.mean <= course.worst + 1e-9 for course in found.courses)
    assert best[-1] == pytest.approx(found.optimum)
    assert found.hits.part == len(found.reached_in) <= found.hits.of == 200
    shares = [share for _, share in found.groups.values()]
    assert sum(share.of for share in shares) == 2 * 50
    assert sum(share.part for share in shares) == sum(graph.hits for graph in found.graphs)


def test_a_claim_that_fails_is_reported_as_failed() -> None:
    evidence = small_evidence()
    assert all(claim.holds for claim in claims(evidence))
    missed = [{**evidence.studies[0].each[0], "proposed": DoorCount(real=4, virtual=5, matched=3)}]
    worse = dataclasses.replace(evidence.studies[0], each=tuple(missed))
    found = claims(dataclasses.replace(evidence, studies=(worse, evidence.studies[1])))
    assert [claim.what for claim in found if not claim.holds] == [
        "1 empty apartments: matched / real",
        "1 empty apartments: matched / virtual, against both stand-ins",
    ]
    all_right, nearly = (DoorCount(real=100, virtual=100, matched=matched) for matched in (100, 99))
    beaten = {"voronoi-doors": all_right, "eroded-space": nearly, "proposed": nearly}
    studies = dataclasses.replace(evidence.studies[0], each=(beaten,)), evidence.studies[1]
    found = claims(dataclasses.replace(evidence, studies=studies))
    assert [claim.what for claim in found if not claim.holds] == [
        "1 empty apartments: matched / virtual, against both stand-ins",
    ]


def test_a_door_between_more_than_two_rooms_is_counted_once() -> None:
    """Where two passages cross and every virtual door is kept, the map has a row for each pair of rooms at a door."""
    grid = drawing(CROSSING)()
    stage = stages(grid)
    problem = MergeProblem(stage.initial, MapCost())
    found = MergeRooms()(grid, stage.simplified, stage.initial, everything_kept(problem), problem, path=stage.path)
    ends = {(door.start_m, door.end_m) for door in found.doors}
    assert len(virtual_doors_m(found)) < len(found.doors)
    assert len(virtual_doors_m(found)) == len(ends)
    # doors that cross are two, though their middles are one
    assert len(ends) > len({tuple(np.add(*pair).round(6)) for pair in ends})


def test_an_environment_without_a_door_is_counted_too() -> None:
    made = Environment(name="one room", rooms=1, doors=0, seed=0).made
    assert count_doors(made, METHODS["proposed"]) == DoorCount(real=0, virtual=0, matched=0)
