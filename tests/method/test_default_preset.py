"""The preset `default`: wide virtual doors, their scores, the energy over them, its search and its certificate."""

from __future__ import annotations

import dataclasses
import itertools
import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from maps import Cells, drawn, law, small_maps
from scipy import ndimage
from scored_problems import CELL_M, DEFAULT, all_choices, problem_of, records_of, segments, two_rooms

from vdoor.api import run
from vdoor.errors import SettingError
from vdoor.grid import FREE, OccupancyGrid
from vdoor.method.boundary import BoundaryPath
from vdoor.method.corners import Corners
from vdoor.method.doors import PROPOSED, VirtualDoors
from vdoor.method.initial_map import InitialMap
from vdoor.method.scoring.closed_features import SHUT
from vdoor.method.scoring.conflicts import conflicts, surest
from vdoor.method.scoring.features import FEATURES, FIRST
from vdoor.method.scoring.model import Curve, model_named, table_of
from vdoor.method.scoring.score import JUDGEMENTS, LIKELY, DoorScores, ScoreDoors
from vdoor.method.scoring.segments import Segments
from vdoor.method.search.certificate import BoundEnergy, Certificate
from vdoor.method.search.costs import DoorEnergy
from vdoor.method.search.generation import Generation
from vdoor.method.search.incremental import FlipState
from vdoor.method.search.memetic import MemeticSearch, greedy
from vdoor.method.search.problem import MergeProblem
from vdoor.method.simplify import REASONS, SimplifyGrid, narrower
from vdoor.method.wall_direction import wall_direction_rad
from vdoor.pipeline import Pipeline
from vdoor.synth import PRESETS as KINDS_OF_MAPS
from vdoor.synth import Apartment, synthesize

MOST_DOORS = 13


def test_a_door_between_two_rooms_is_found_and_certified() -> None:
    found = records_of(two_rooms())
    result = run(OccupancyGrid.from_array(two_rooms(), CELL_M), "default")
    assert (len(result.rooms), len(result.doors)) == (2, 1)
    assert result.doors[0].width_m == pytest.approx(0.9, abs=0.01)
    assert found[Certificate].optimal == 1
    assert found[Certificate].gap == 0


def test_a_hall_is_one_room() -> None:
    cells = np.full((200, 300), 100, np.int8)
    cells[2:-2, 2:-2] = FREE
    cells[80:86, 100:106] = 100
    result = run(OccupancyGrid.from_array(cells, CELL_M), "default")
    assert (len(result.rooms), len(result.doors)) == (1, 0)


@pytest.mark.parametrize("furniture", [False, True])
@pytest.mark.parametrize("seed", [0, 1, 3, 4])  # in 2 a piece of wall stands free and goes as an island
def test_apartments_come_out_as_drawn(seed: int, furniture: bool) -> None:
    made = synthesize(Apartment(rooms=5, cell_m=0.05, furniture=furniture, windows=0), np.random.default_rng(seed))
    result = run(made.grid, "default")
    middles_m = np.array([np.add(door.start_m, door.end_m) / 2 for door in result.doors]).reshape(-1, 2)
    hits = sum(
        np.hypot(*(middles_m - np.add(door.start_m, door.end_m) / 2).T).min(initial=9.0) < 0.5 for door in made.doors
    )
    assert hits >= len(made.doors) - 1
    assert len(result.doors) <= len(made.doors) + 1


@pytest.mark.parametrize("kind", ["home", "office"])
def test_virtual_doors_turn_and_mirror_with_the_map(kind: str) -> None:
    """All but a few: pillars of one cell have no first sample that mirrors."""
    cells = synthesize(KINDS_OF_MAPS[kind], np.random.default_rng(2)).grid.cells
    pipeline = Pipeline(simplify=DEFAULT.simplify, doors=DEFAULT.doors)
    width = cells.shape[1]
    plain = segments(records_of(cells, pipeline)[VirtualDoors])
    turned = segments(records_of(np.rot90(cells).copy(), pipeline)[VirtualDoors])
    mirrored = segments(records_of(cells[:, ::-1].copy(), pipeline)[VirtualDoors])
    as_turned = {frozenset((width - 1 - col, row) for row, col in ends) for ends in plain}
    as_mirrored = {frozenset((row, width - 1 - col) for row, col in ends) for ends in plain}
    for found, wanted in ((turned, as_turned), (mirrored, as_mirrored)):
        assert len(found & wanted) >= 0.97 * len(found | wanted)


def test_scores_shift_with_the_map() -> None:
    """Doors' middles and looks often lie between two cells: which of the two is asked must not hang on where it is."""
    cells = synthesize(KINDS_OF_MAPS["home"], np.random.default_rng(2)).grid.cells
    plain, moved = (records_of(grid)[DoorScores] for grid in (cells, np.pad(cells, ((3, 0), (7, 0)), "edge")))
    np.testing.assert_array_equal(np.add(plain.middle, (3, 7)), moved.middle)
    np.testing.assert_allclose(plain.feature, moved.feature, rtol=0, atol=1e-9)
    np.testing.assert_array_equal(plain.sure, moved.sure)


@pytest.mark.parametrize("degrees", [0.0, 7.0, 20.0, 40.0])
def test_the_walls_direction_is_that_of_the_map(degrees: float) -> None:
    made = synthesize(Apartment(cell_m=0.05, rotation_deg=degrees, windows=0), np.random.default_rng(1))
    path = records_of(made.grid.cells)[BoundaryPath]
    found = np.degrees(-wall_direction_rad(path))  # rows run downwards
    assert abs((found - degrees + 45) % 90 - 45) < 1.5


def test_features_of_a_plain_door_are_what_one_measures() -> None:
    found = records_of(two_rooms())
    scores, doors = found[DoorScores], found[VirtualDoors]
    best = int(np.argmax(scores.log_odds))
    value = dict(zip(FEATURES, scores.feature[best].tolist(), strict=True))
    assert scores.judgement[best] == LIKELY
    assert value["length_m"] == pytest.approx(0.95, abs=0.01)  # centre to centre
    assert value["pair"] + value["extension"] <= 1
    assert value["in_wall_min_m"] == pytest.approx(0.3)
    assert value["thick_max_m"] == pytest.approx(0.2, abs=0.051)
    assert value["same_contour"] == 1
    assert np.exp(value["cut_off_log"]) == pytest.approx(16, rel=0.05)  # m2 of a room
    assert value["wider_min_m"] > 2
    assert value["longer_than_rival_m"] < 0.01
    assert len(scores.door) == np.count_nonzero(doors.verdict == PROPOSED)


def test_conflicting_doors_cross_or_lie_near_each_other() -> None:
    made = synthesize(KINDS_OF_MAPS["home"], np.random.default_rng(3))
    found = records_of(made.grid.cells)
    scores, doors = found[DoorScores], found[VirtualDoors]
    likely = np.flatnonzero(scores.judgement == LIKELY)
    pairs = set(zip(scores.rival_a.tolist(), scores.rival_b.tolist(), strict=True))
    middle = (doors.start[scores.door] + doors.end[scores.door]) / 2 * CELL_M
    for a, b in itertools.combinations(likely.tolist(), 2):
        if np.hypot(*(middle[a] - middle[b])) < ScoreDoors().apart_m:
            assert (a, b) in pairs
    assert all(a < b and a in likely and b in likely for a, b in pairs)
    outdone = scores.judgement == JUDGEMENTS.index("outdone")
    assert np.count_nonzero(outdone) > 0


def test_the_surest_doors_exclude_each_other_and_none_likelier_is_left_out() -> None:
    made = synthesize(KINDS_OF_MAPS["home"], np.random.default_rng(3))
    found = records_of(made.grid.cells)
    scores, doors = found[DoorScores], found[VirtualDoors]
    first = model_named("shipped").first.log_odds(scores.feature[:, : len(FIRST)], scores.share_rough)
    segments, sure = Segments(doors, scores.door), np.flatnonzero(scores.sure)
    assert isinstance(DEFAULT.score, ScoreDoors)
    least = DEFAULT.score.sure_log_odds
    assert 0 < len(sure) == len(surest(segments, first, least, 0.6))
    assert (first[sure] > least).all()
    likely = np.flatnonzero(first > least)
    pairs = conflicts(segments, likely, 0.6)
    assert not (scores.sure[pairs]).all(axis=1).any()
    for left_out in np.setdiff1d(likely, sure).tolist():
        others = pairs[(pairs == left_out).any(axis=1)].sum(axis=1) - left_out
        assert any(scores.sure[other] and first[other] >= first[left_out] for other in others.tolist())


def corridor_with_rooms() -> Cells:
    """A corridor of 12 m by 2 m, and above its middle a room of 4 m by 4 m, with a door of 0.9 m in its corner."""
    cells = np.full((130, 244), 100, np.int8)
    cells[86:126, 2:242] = FREE
    cells[2:82, 80:160] = FREE
    cells[82:86, 80:98] = FREE
    return cells


def test_no_look_escapes_through_a_shut_door() -> None:
    found = records_of(corridor_with_rooms())
    scores, doors = found[DoorScores], found[VirtualDoors]
    segments = Segments(doors, scores.door)
    middle = segments.middle
    value = {name: scores.feature[:, at] for at, name in enumerate(FEATURES)}
    (door,) = np.flatnonzero(scores.sure)
    assert 82 <= middle[door, 0] <= 86
    # Across the corridor, in line with the wall of the room: one looks into the room only as long as the door is open.
    across = np.flatnonzero((np.abs(segments.along[:, 0]) > 0.99) & (middle[:, 0] > 90) & (segments.length_m < 2.2))
    assert len(across) > 0
    assert (value["wider_max_m"][across] > 1.5).all()
    assert (value["shut_wider_max_m"][across] < 0.3).all()
    # The door's own look is as it was.
    for name in SHUT:
        assert value[name][door] == value[name.removeprefix("shut_")][door]


@law
@given(small_maps(), st.integers(0, 2**32 - 1))
def test_flips_and_whole_choices_have_one_energy(cells: Cells, seed: int) -> None:
    assume((cells == FREE).any())
    problem = problem_of(cells)
    assume(0 < problem.edges <= 60)
    rng = np.random.default_rng(seed)
    removed = rng.random(problem.edges) < 0.5
    state = FlipState(problem, np.flatnonzero(removed).tolist())
    for edge in rng.integers(problem.edges, size=10).tolist():
        state.try_flip(edge, np.inf)
    assert state.cost == problem.evaluate(np.array([state.removed])).cost[0]


def problem_of_home(seed: int) -> MergeProblem:
    """A home's choice."""
    made = synthesize(KINDS_OF_MAPS["home"], np.random.default_rng(seed))
    found = records_of(made.grid.cells)
    return MergeProblem(found[InitialMap], DEFAULT.cost, found[DoorScores])


@pytest.mark.parametrize("seed", [8, 15, 23, 24, 28, 29, 30])
def test_the_search_finds_the_optimum_and_the_bound_lies_below_it(seed: int) -> None:
    problem = problem_of_home(seed)
    assert 8 <= problem.edges <= MOST_DOORS  # so many that every choice can be tried
    optimum = float(problem.evaluate(all_choices(problem.edges)).cost.min())
    best = list(MemeticSearch()(problem, np.random.default_rng(seed)))[-1]
    certificate = BoundEnergy()(problem, best)
    assert certificate is not None
    assert best.best_cost == pytest.approx(optimum, abs=1e-9)
    assert certificate.lower_bound <= optimum + 1e-9
    assert certificate.optimal == (certificate.gap <= 1e-6)


@pytest.mark.parametrize("clash_weight", [0.0, 0.2, 3.0])
def test_the_bound_holds_where_clashes_are_cheap(clash_weight: float) -> None:
    made = synthesize(KINDS_OF_MAPS["home"], np.random.default_rng(5))
    found = records_of(made.grid.cells)
    energy = DoorEnergy(clash_weight=clash_weight, lack_weight=0.0, lack_weight_rough=0.0, bias_rough=5.0)
    problem = MergeProblem(found[InitialMap], energy, found[DoorScores])
    best = list(MemeticSearch()(problem, np.random.default_rng(0)))[-1]
    certificate = BoundEnergy()(problem, best)
    assert certificate is not None
    assert certificate.lower_bound <= best.best_cost + 1e-6


def test_the_search_never_gets_worse_and_keeps_no_conflicts() -> None:
    problem = problem_of_home(11)
    generations = list(MemeticSearch()(problem, np.random.default_rng(0)))
    costs = [generation.best_cost for generation in generations]
    assert costs == sorted(costs, reverse=True)
    assert costs[0] <= problem.evaluate(greedy(problem)[None]).cost[0]
    kept = ~generations[-1].removed
    assert not (kept[problem.conflicts[0]] & kept[problem.conflicts[1]]).any()


def test_where_nothing_was_scored_doors_that_part_rooms_gain_the_bias_alone() -> None:
    initial = records_of(two_rooms())[InitialMap]
    problem = MergeProblem(initial, DoorEnergy(bias=0.25))
    (cost,) = problem.evaluate(np.zeros((1, problem.edges), np.bool_)).cost
    assert problem.edges > 0
    assert cost == FlipState(problem).cost == -0.25 * problem.edges


def test_with_one_look_no_door_is_shut_and_both_looks_see_the_same() -> None:
    scores = records_of(corridor_with_rooms(), dataclasses.replace(DEFAULT, score=ScoreDoors(sure_log_odds=100)))[
        DoorScores
    ]
    assert not scores.sure.any()
    value = {name: scores.feature[:, at] for at, name in enumerate(FEATURES)}
    assert all((value[name] == value[name.removeprefix("shut_")]).all() for name in SHUT)


def test_a_small_room_costs_what_it_lacks() -> None:
    energy = DoorEnergy()
    problem = problem_of(two_rooms(side=24))  # rooms of 1.44 m2
    open_, shut = problem.evaluate(np.array([[True] * problem.edges, [False] * problem.edges])).cost
    assert open_ == 0
    assert energy.lack_weight > 0
    assert shut > -problem.gain.sum()


def test_a_curve_is_straight_between_and_level_beyond() -> None:
    curve = Curve((0.0, 1.0, 3.0), (0.0, 2.0, -2.0), (1.0, 1.0, 1.0))
    assert curve.says(np.array([-5.0, 0.5, 2.0, 9.0]), 0.0).tolist() == [0, 1, 0, -2]
    assert curve.says(np.array([0.5]), 0.5).tolist() == [1]


def test_the_shipped_curves_are_for_these_features_and_say_how_they_were_made() -> None:
    model = model_named("shipped")
    assert (tuple(model.first.curves), tuple(model.last.curves)) == (FIRST, FEATURES)
    assert not any(any(model.last.curves[name].rough) for name in SHUT)
    assert model.made["command"].startswith("vdoor train")
    assert model.made["labelled_maps"] == 0


@pytest.mark.parametrize("text", ["", "[]", "{}", '{"curves": {}}', "{"])
def test_a_file_without_curves_is_refused(tmp_path: Path, text: str) -> None:
    path = tmp_path / "curves.json"
    path.write_text(text)
    with pytest.raises(SettingError, match=r"score\.model"):
        model_named(str(path))
    with pytest.raises(SettingError, match=r"score\.model"):
        model_named(str(tmp_path / "none.json"))


def test_a_file_of_one_look_says_what_it_lacks(tmp_path: Path) -> None:
    path = tmp_path / "curves.json"
    path.write_text(json.dumps({**table_of(model_named("shipped"))["last"], "made": {}}))
    with pytest.raises(SettingError, match="found no key 'first'"):
        model_named(str(path))


@pytest.mark.parametrize(
    ("part", "value"),
    [("at", [1.0, 0.0]), ("at", []), ("clean", [0.0]), ("rough", [float("nan")]), ("at", "ab"), ("clean", None)],
)
def test_broken_curves_are_refused(tmp_path: Path, part: str, value: object) -> None:
    table = table_of(model_named("shipped"))
    table["last"]["curves"]["length_m"][part] = value
    path = tmp_path / "curves.json"
    path.write_text(json.dumps(table))
    with pytest.raises(SettingError, match=r"score\.model"):
        model_named(str(path))


@pytest.mark.parametrize("look", ["first", "last"])
def test_curves_for_other_features_are_refused(tmp_path: Path, look: str) -> None:
    table = table_of(model_named("shipped"))
    table[look]["curves"].pop("length_m")
    path = tmp_path / "curves.json"
    path.write_text(json.dumps(table))
    with pytest.raises(SettingError, match="length_m"):
        model_named(str(path))


def test_thin_unknown_lines_are_free_and_long_ones_are_walls() -> None:
    cells = np.full((60, 60), FREE, np.int8)
    cells[[0, -1]] = cells[:, [0, -1]] = 100
    cells[20, 10:20] = -1
    cells[40, 1:59] = -1
    found = SimplifyGrid(cell_m=0.0, thin_unknown_m=0.1)(OccupancyGrid.from_array(cells, CELL_M))
    thin = REASONS.index("thin unknown")
    assert (found.reason[20, 10:20] == thin).all()
    assert (found.cells[20, 10:20] == FREE).all()
    assert not (found.reason[40] == thin).any()


def test_slits_are_closed_and_say_so() -> None:
    cells = np.full((60, 90), 100, np.int8)
    cells[2:58, 2:40] = FREE
    cells[2:58, 44:88] = FREE
    cells[30:32, 40:44] = FREE  # a crack of 0.1 m
    cells[10:13, 40:44] = FREE  # a gap of 0.15 m
    grid = OccupancyGrid.from_array(cells, CELL_M)
    found = SimplifyGrid(cell_m=0.0, slit_m=0.1, jut_m=0.0)(grid)
    slit = found.reason == REASONS.index("slit")
    assert np.argwhere(slit).tolist() == [[row, col] for row in (30, 31) for col in range(40, 44)]
    assert (found.cells[slit] != FREE).all()
    apart = SimplifyGrid(cell_m=0.0, slit_m=0.15, jut_m=0.0)(grid)
    assert (apart.cells[:, 2:40] != FREE).all()
    assert (apart.reason[2:58, 2:40] == REASONS.index("unreachable")).all()
    narrow = SimplifyGrid(cell_m=0.0, slit_m=1.0)(OccupancyGrid.from_array(cells[28:34, 38:46], CELL_M))
    assert (narrow.cells == FREE).any()  # all of it is a slit: nothing is closed


@law
@given(small_maps(), st.integers(1, 6))
def test_narrow_is_what_an_opening_takes_away_however_the_map_lies(cells: Cells, thick: int) -> None:
    free = cells == FREE
    found = narrower(free, thick)
    side = thick + 1
    opened = ndimage.binary_opening(np.pad(free, side), np.ones((side, side), np.bool_))
    assert (found == free & ~opened[side:-side, side:-side]).all()
    assert (np.rot90(found) == narrower(np.rot90(free), thick)).all()
    assert (found[:, ::-1] == narrower(free[:, ::-1], thick)).all()


@law
@given(small_maps(), st.sampled_from([0.01, 0.02, 0.3]))
def test_no_look_leaves_the_map_however_small_its_cells(cells: Cells, cell_m: float) -> None:
    assume((cells == FREE).any())
    assert len(run(OccupancyGrid.from_array(cells, cell_m), "default").rooms) >= 1


def test_a_wall_at_the_edge_of_a_fine_map_leads_nowhere() -> None:
    result = run(drawn("##. ... ...", cell_m=0.01), "default")
    assert (len(result.rooms), len(result.doors)) == (1, 0)


def test_shut_rooms_are_kept_and_hollow_furniture_is_not() -> None:
    cells = np.full((100, 140), 100, np.int8)
    cells[2:98, 2:80] = FREE
    cells[2:50, 84:138] = FREE  # 2.4 by 2.7 m behind a shut door
    cells[60:69, 84:138] = FREE  # 0.45 by 2.7 m
    kept = SimplifyGrid(cell_m=0.0, least_part_m2=1.0)(OccupancyGrid.from_array(cells, CELL_M)).cells == FREE
    assert kept[10, 100]
    assert not kept[65, 100]
    alone = SimplifyGrid(cell_m=0.0)(OccupancyGrid.from_array(cells, CELL_M)).cells == FREE
    assert not alone[10, 100]


def test_equal_seeds_give_equal_generations() -> None:
    problem = problem_of_home(5)
    once, again = ([g.best_cost for g in MemeticSearch()(problem, np.random.default_rng(7))] for _ in range(2))
    assert once == again


def test_corners_and_generations_are_on_record() -> None:
    found = records_of(two_rooms())
    assert len(found[Corners].cell) == 12
    assert found[Generation].removed.shape == found[InitialMap].door.shape
