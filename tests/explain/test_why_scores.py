"""`vdoor why` of scored doors: by hand on two rooms, and as laws over a whole apartment."""

from __future__ import annotations

import dataclasses
import json
import math
from pathlib import Path

import numpy as np
import pytest
from commands import call, process
from scored_runs import BIAS, DOOR_SAYS, GENEROUS, SINGLE_SAYS, scored, write_curves
from terminals import history, recorded
from two_rooms import DOOR_M

from vdoor.explain import explain
from vdoor.explain.doors import door_fate
from vdoor.explain.scores import Conflict, Reason, reasons_of, score_fate
from vdoor.explain.stages import percent
from vdoor.explain.text import to_lines
from vdoor.history import History
from vdoor.method.doors import PROPOSED
from vdoor.method.scoring.features import FEATURES
from vdoor.method.scoring.score import JUDGEMENTS, ScoreDoors
from vdoor.method.search.costs import DoorEnergy
from vdoor.method.search.incremental import FlipState
from vdoor.pipeline import PRESETS, Pipeline
from vdoor.synth import PRESETS as KINDS_OF_MAPS
from vdoor.synth import synthesize

SINGLES = (1, 2, 5, 6)
"""From the jambs two metres into the rooms."""


@pytest.fixture(scope="module")
def two_rooms(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return scored(tmp_path_factory.mktemp("two"))


@pytest.fixture(scope="module")
def apartment(tmp_path_factory: pytest.TempPathFactory) -> History:
    made = synthesize(KINDS_OF_MAPS["home"], np.random.default_rng(3))
    folder = tmp_path_factory.mktemp("apartment")
    default = PRESETS["default"]
    assert isinstance(default, Pipeline)
    lenient = dataclasses.replace(default, doors=GENEROUS, score=ScoreDoors(least_log_odds=-8.0, apart_m=1.0))
    return history(recorded(folder, made.grid, lenient, preset="default"))


def text_of(path: Path, **options: int) -> str:
    return "\n".join(to_lines(explain(history(path), DOOR_M, **options)))


def test_a_score_is_told_with_the_features_that_speak_for_and_against(two_rooms: Path) -> None:
    run = history(two_rooms)
    score = door_fate(run, 0).score
    assert score is not None
    assert (score.judgement, score.bias, score.least_log_odds, score.conflicts) == ("likely", BIAS, -2.0, ())
    assert score.log_odds == pytest.approx(BIAS + DOOR_SAYS)
    pair, length, contour = score.reasons_for
    assert pair == Reason(feature="pair", value=1.0, log_odds=2.0)
    assert (length.feature, length.value, length.log_odds) == ("length_m", pytest.approx(1.0), pytest.approx(1.0))
    assert contour == Reason(feature="same_contour", value=1.0, log_odds=0.75)
    assert score.reasons_against == ()
    assert score.sure
    single = score_fate(run, 1)
    assert single is not None
    assert single.log_odds == pytest.approx(BIAS + SINGLE_SAYS)
    assert not single.sure
    assert [reason.feature for reason in single.reasons_for] == ["pair", "same_contour"]
    (against,) = single.reasons_against
    assert (against.feature, against.log_odds) == ("length_m", -0.25)
    assert against.value == pytest.approx(math.hypot(2.0, 0.4))


def test_limits_are_those_of_each_kind_of_wide_doors(two_rooms: Path) -> None:
    run = history(two_rooms)
    fates = {fate.kind: fate for fate in (door_fate(run, door) for door in range(len(run.doors.kind)))}
    assert {kind: fate.max_length_m for kind, fate in fates.items()} == {"pair": 2.7, "single": 2.5, "extension": 3.5}
    assert (fates["extension"].verdict, fates["extension"].least_gap_m) == ("duplicate", None)
    assert fates["single"].least_gap_m == pytest.approx(1.8 * fates["single"].length_m)
    assert fates["pair"].gap_m == fates["extension"].gap_m
    assert {corner.max_length_m for corner in explain(run, DOOR_M).corners} == {3.5}
    assert "(at most 3.5), free gap 0.80 m, tilt 0.0 deg, path between its ends 7.73 m\n" in text_of(two_rooms)


def test_unlikely_doors_are_told_by_the_threshold(tmp_path: Path) -> None:
    path = scored(tmp_path, least_log_odds=1.0)
    run = history(path)
    fates = [door_fate(run, door) for door in (0, *SINGLES)]
    assert [fate.fate for fate in fates] == ["door", *["unlikely"] * 4]
    assert [(fate.edge, fate.idle) for fate in fates] == [(0, False), *[(-1, False)] * 4]
    assert ", unlikely, below +1: left out of the search; the map is " in text_of(path)


def test_outdone_doors_name_the_better_one(tmp_path: Path) -> None:
    path = scored(tmp_path, same_place_m=1.2)
    run = history(path)
    fates = [door_fate(run, door) for door in SINGLES]
    assert {fate.fate for fate in fates} == {"outdone"}
    scores = [fate.score for fate in fates]
    assert all(score is not None and score.suppressed_by == 0 for score in scores)
    assert "outdone by virtual door 0 at the same place, log-odds +2.50: left out of the" in text_of(path, count=6)


def test_conflicts_are_listed_by_which_door_was_kept(tmp_path: Path) -> None:
    path = scored(tmp_path, apart_m=1.2)
    run = history(path)
    scores = {door: door_fate(run, door).score for door in (0, 1)}
    assert scores[0] is not None
    assert scores[1] is not None
    assert [(rival.door, rival.kept) for rival in scores[0].conflicts] == [(door, False) for door in SINGLES]
    assert scores[1].conflicts[0] == Conflict(door=0, log_odds=float(run.scores.log_odds[0]), kept=True)
    text = text_of(path, count=6)
    singles = ", ".join(f"{door} ({BIAS + SINGLE_SAYS:+.2f})" for door in SINGLES)
    assert f"conflicts: virtual doors {singles} removed\n" in text
    assert "conflicts: virtual door 0 (+2.50) kept instead; " in text


def test_command_tells_scores_as_text_and_json(two_rooms: Path) -> None:
    text = call("why", two_rooms, "--at", "2.1,1.4").stdout
    assert "score: log-odds +2.50 (92 %, bias -1.25), likely (at least -2): passed to the search" in text
    assert (
        "      pass 1: sure, so it was closed in pass 2\n"
        "      for: pair 1.00 gives +2.00, length_m 1.00 gives +1.00, same_contour 1.00 gives +0.75\n"
        "      against: nothing\n" in text
    )
    (door, *_) = json.loads(call("why", two_rooms, "--at", "2.1,1.4", "--json").stdout)["doors"]
    assert door["score"]["judgement"] == "likely"
    assert door["score"]["reasons_for"][0] == {"feature": "pair", "value": 1.0, "log_odds": 2.0}


@pytest.mark.parametrize("change", ["gone", "other", "broken"])
def test_curves_that_are_no_longer_those_of_the_run_give_no_reasons(tmp_path: Path, change: str) -> None:
    path = scored(tmp_path)
    curves = tmp_path / "curves.json"
    if change == "gone":
        curves.unlink()
    elif change == "other":
        write_curves(curves, bias=0.5)
    else:
        curves.write_text("{}")
    text = process("why", path, "--at", "2.1,1.4").stdout  # curves are read once a process
    assert "score: log-odds +2.50 (92 %), likely" in text
    assert "reasons: not available" in text
    assert "gives" not in text


def test_features_and_bias_add_up_to_each_score(apartment: History) -> None:
    scores = apartment.scores
    assert len(scores.door) > 20
    for row in range(len(scores.door)):
        bias, reasons = reasons_of(scores, row, model="shipped")
        assert bias is not None
        assert {reason.feature for reason in reasons} == set(FEATURES)
        assert bias + sum(reason.log_odds for reason in reasons) == pytest.approx(scores.log_odds[row], abs=1e-6)
        fate = score_fate(apartment, int(scores.door[row]))
        assert fate is not None
        said = sorted(reason.log_odds for reason in reasons)
        assert [reason.log_odds for reason in fate.reasons_against] == [value for value in said[:3] if value < 0]
        assert [reason.log_odds for reason in fate.reasons_for] == [value for value in said[:-4:-1] if value > 0]


def test_fates_of_scored_doors_add_up_to_what_each_stage_recorded(apartment: History) -> None:
    run = apartment
    fates = [door_fate(run, door) for door in np.flatnonzero(run.doors.verdict == PROPOSED).tolist()]
    for code, judgement in enumerate(JUDGEMENTS[1:], start=1):
        assert sum(fate.fate == judgement for fate in fates) == (run.scores.judgement == code).sum() > 0
    assert [fate.door for fate in fates if fate.idle] == run.initial.idle_door.tolist()
    assert [fate.door for fate in fates if fate.edge >= 0] == run.initial.door.tolist()
    assert {fate.edge for fate in fates if fate.fate == "door"} == set(run.topology.edge.tolist()) - {-1}
    rivals = {(fate.door, rival.door) for fate in fates if fate.score for rival in fate.score.conflicts}
    assert rivals == {pair[::-1] for pair in rivals}
    assert len(rivals) == 2 * len(run.scores.rival_a) > 0


def test_what_the_search_paid_is_reckoned_again_from_the_recording(apartment: History) -> None:
    final = apartment.search[-1]
    assert FlipState(apartment.problem, np.flatnonzero(final.removed).tolist()).cost == pytest.approx(final.best_cost)
    search = door_fate(apartment, int(apartment.initial.door[0])).search
    assert search is not None
    assert search.cost == pytest.approx(final.best_cost)
    assert apartment.certificate.cost == final.best_cost


def test_terms_of_the_energy_add_up_and_the_lack_is_that_of_the_rooms(apartment: History) -> None:
    cost, problem = apartment.cost, apartment.problem
    assert isinstance(cost, DoorEnergy)
    for number, generation in enumerate(apartment.search):
        terms = {term.name: term for term in apartment.terms(number)}
        assert sum(term.cost for term in terms.values()) == pytest.approx(generation.best_cost)
        room, is_open = problem.rooms(generation.removed[None])
        area_m2 = np.bincount(room[0], weights=problem.cells * is_open[0]) * problem.cell_m2
        rooms_m2 = area_m2[np.unique(room[0, problem.is_region])]
        lack = np.maximum(cost.room_m2 - rooms_m2, 0).sum() / cost.room_m2
        assert terms["lack of area"].value == pytest.approx(lack, abs=1e-6)
        assert terms["separating doors"].value <= (~generation.removed).sum()


@pytest.mark.parametrize(
    ("share", "says"), [(0.0, "0 %"), (0.004, "under 1 %"), (0.126, "13 %"), (0.999, "over 99 %"), (1.0, "100 %")]
)
def test_percent_is_never_rounded_to_certainty(share: float, says: str) -> None:
    assert percent(share) == says
