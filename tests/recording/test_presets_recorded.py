"""Every preset's recordings: whole, verified, walked through and drawn, each with the stages it has."""

from __future__ import annotations

import dataclasses
import json
import re
from pathlib import Path

import numpy as np
import pytest
from commands import call
from rerun.chunk import RrdReader
from rich.console import Console
from scored_runs import scored
from terminals import history, recorded
from two_rooms import TWO_ROOMS

from vdoor.config import settings_of
from vdoor.emit import RunInfo
from vdoor.errors import RecordingError
from vdoor.explain.stages import tabs_of
from vdoor.goldens import drawing
from vdoor.history import History
from vdoor.method.initial_map import InitialMap
from vdoor.method.scoring.score import JUDGEMENTS, LIKELY
from vdoor.method.search import certificate as certify
from vdoor.pipeline import METHODS, PRESETS, RECORDS, Pipeline, emitted
from vdoor.pipeline import recorded as pipeline_of
from vdoor.recording.check import check
from vdoor.recording.mcap import McapSink, read_recording
from vdoor.viz.picture.pictures import pictures
from vdoor.viz.rerun.style import DOUBTFUL, SURE, odds
from vdoor.viz.terminal.facts import facts
from vdoor.viz.terminal.stepper import Stepper
from vdoor.viz.terminal.walk import Walk, entered, stops

TABS = ("Overview", "Simplified", "Path", "Curvature", "Corners", "Doors", "Initial map", "Search", "Rooms")
TAB_NAMES = {
    "paper": TABS,
    "default": (*TABS[:6], "Scores", *TABS[6:]),
    "voronoi-doors": ("Overview", "Simplified", "Narrow places", "Doors", "Initial map", "Rooms"),
    "eroded-space": ("Overview", "Simplified", "Cores", "Rooms"),
}


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """A recording of each preset."""
    return {
        preset: recorded(tmp_path_factory.mktemp(preset), drawing(TWO_ROOMS)(), pipeline, preset=preset)
        for preset, pipeline in PRESETS.items()
    }


@pytest.fixture(scope="module")
def two_rooms(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return scored(tmp_path_factory.mktemp("two"))


def copied(source: Path, target: Path, *, without: str = "", info: RunInfo | None = None) -> Path:
    """The recording without one stage, or of another run."""
    recording = read_recording(source, types=RECORDS)
    sink = McapSink(target, info or recording.info)
    for step, record in recording:
        if record.topic != without:
            sink.write(step, record)
    sink.close()
    return target


@pytest.mark.parametrize("preset", PRESETS)
def test_a_recording_is_whole_with_the_stages_its_pipeline_has(runs: dict[str, Path], preset: str) -> None:
    path = runs[preset]
    topics = [record.topic for record in PRESETS[preset].records]
    found = json.loads(call("check", path, "--json").stdout)
    assert (list(found["records"]), found["missing"], found["damage"]) == (topics, [], [])
    assert json.loads(call("info", path, "--json").stdout)["missing"] == []
    assert call("check", path).stdout.splitlines()[-1].startswith("whole")
    assert call("verify", path).stdout.startswith("equal")


@pytest.mark.parametrize("preset", PRESETS)
def test_each_stage_that_is_not_there_is_missed_and_no_other(
    runs: dict[str, Path], preset: str, tmp_path: Path
) -> None:
    for topic in [record.topic for record in PRESETS[preset].records if record.topic != "input"]:
        path = copied(runs[preset], tmp_path / f"{topic}.mcap", without=topic)
        health = check(path, types=RECORDS, emits=emitted)
        assert [line for line in health.missing if line.endswith(": no record")] == [f"{topic}: no record"]
        assert not health.whole


def test_check_and_recover_name_the_missing_score(runs: dict[str, Path], tmp_path: Path) -> None:
    path = copied(runs["default"], tmp_path / "cut.mcap", without="door_scores")
    assert "door_scores: no record" in call("check", path, code=1).stdout
    out = call("recover", path, "--out", tmp_path / "out.mcap").stdout
    assert [line for line in out.splitlines() if line.startswith("lost")] == ["lost: door_scores: no record"]
    whole = call("recover", runs["paper"], "--out", tmp_path / "whole.mcap").stdout
    assert whole.splitlines()[-1] == "nothing was lost"


def test_a_recording_from_before_there_were_scores_is_one_of_the_papers_stages(
    runs: dict[str, Path], tmp_path: Path
) -> None:
    """The preset `default` was once the paper's stages with other settings, and stages had no `method`."""
    info = read_recording(runs["paper"], types=RECORDS).info
    new = {"score", "certify", "cost"}
    settings = {
        stage: {name: value for name, value in table.items() if name != "method" or stage == "search"}
        for stage, table in info.settings.items()
        if stage not in new
    }
    old = dataclasses.replace(info, preset="default", settings=settings)
    path = copied(runs["paper"], tmp_path / "old.mcap", info=old)
    assert pipeline_of(old) == Pipeline()
    assert call("check", path).stdout.splitlines()[-1].startswith("whole")
    assert call("verify", path).stdout.startswith("equal")


def test_settings_that_nobody_can_read_leave_the_stages_of_the_preset(runs: dict[str, Path], tmp_path: Path) -> None:
    info = read_recording(runs["paper"], types=RECORDS).info
    strange = dataclasses.replace(info, settings={**info.settings, "cellar": {"depth_m": 3.0}})
    path = copied(runs["paper"], tmp_path / "strange.mcap", info=strange)
    assert call("check", path).stdout.splitlines()[-1].startswith("whole")
    short = copied(path, tmp_path / "short.mcap", without="corners")
    assert "corners: no record" in call("check", short, code=1).stdout
    assert "corners: no record" in call("recover", short, "--out", tmp_path / "out.mcap").stdout
    assert "recorded settings: no stage 'cellar'" in call("verify", path, code=2).stderr


@pytest.mark.parametrize(("column", "value"), [("door", 10_000), ("rival_a", 10_000), ("rival_b", -1)])
def test_scores_of_doors_that_are_not_there_are_refused(
    two_rooms: Path, tmp_path: Path, column: str, value: int
) -> None:
    recording = read_recording(two_rooms, types=RECORDS)
    sink = McapSink(tmp_path / "unfit.mcap", recording.info)
    for step, record in recording:
        if record.topic == "door_scores":
            values = np.full_like(getattr(record, column), value)
            record = dataclasses.replace(record, **{column: values})  # type: ignore[type-var]  # noqa: PLW2901  # a dataclass
        sink.write(step, record)
    sink.close()
    with pytest.raises(RecordingError, match=rf"door_scores\.{column}: wanted rows of door"):
        history(tmp_path / "unfit.mcap")


def test_an_edge_without_a_score_is_refused(two_rooms: Path, tmp_path: Path) -> None:
    recording = read_recording(two_rooms, types=RECORDS)
    sink = McapSink(tmp_path / "unfit.mcap", recording.info)
    for step, record in recording:
        if record.topic == "initial_map":
            duplicates = np.full_like(getattr(record, "door"), 3)  # noqa: B009  # of any record
            record = dataclasses.replace(record, door=duplicates)  # type: ignore[type-var,call-arg]  # noqa: PLW2901  # a dataclass
        sink.write(step, record)
    sink.close()
    error = call("why", tmp_path / "unfit.mcap", "--at", "2,1", code=2).stderr
    assert "initial_map.door: wanted doors that have scores, found others" in error


@pytest.mark.parametrize("lost", [0, -1])
def test_an_edge_that_borders_nothing_is_refused(two_rooms: Path, tmp_path: Path, lost: int) -> None:
    recording = read_recording(two_rooms, types=RECORDS)
    sink = McapSink(tmp_path / "unfit.mcap", recording.info)
    for step, record in recording:
        if isinstance(record, InitialMap):
            border_edge = record.border_edge.copy()
            border_edge[border_edge == border_edge[lost]] = 1
            record = dataclasses.replace(record, border_edge=border_edge)  # noqa: PLW2901  # the same but for that
        sink.write(step, record)
    sink.close()
    error = call("show", tmp_path / "unfit.mcap", code=2).stderr
    assert "initial_map.border_edge: wanted each edge, in order, found others" in error


def test_scores_and_certificate_are_one_line_each(two_rooms: Path) -> None:
    run = history(two_rooms)
    lines = call("show", two_rooms).stdout.splitlines()
    (score,) = [line for line in lines if " door_scores " in line]
    judged = r"5 likely, 0 unlikely, 0 outdone; 2 pairs in conflict; 1 closed in pass 2; map (\d+) % rough"
    (rough,) = re.findall(judged, score)
    assert int(rough) == round(100 * run.scores.share_rough)
    (proof,) = [line for line in lines if " certificate " in line]
    found = run.certificate
    assert (found.gap, found.optimal) == (0, 1)
    assert proof.rstrip().endswith(f"  proven optimal: no choice costs less than {found.cost:.4f}")


def test_a_gap_is_said(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(certify, "MOST_NODES", 1)  # all blocks are too large for all choices to be tried
    path = scored(tmp_path)
    found = history(path).certificate
    assert found.gap > 0
    (proof,) = [line for line in call("show", path).stdout.splitlines() if " certificate " in line]
    numbers = f"cost {found.cost:.4f}, bound {found.lower_bound:.4f}, gap {found.gap:.4f}"
    assert proof.rstrip().endswith(f"not proven optimal: {numbers}")


def test_scored_doors_are_listed_with_their_loudest_reasons(two_rooms: Path) -> None:
    lines = call("show", two_rooms, "--stage", "door_scores").stdout.splitlines()
    begin = next(number for number, line in enumerate(lines) if line.startswith("door  judgement"))
    rows = [line.split() for line in lines[begin + 1 :]]
    assert [row[0] for row in rows] == ["0", "1", "2", "5", "6"]
    assert rows[0] == ["0", "likely", "+2.50", "pair", "1.00", "2.10,1.40", "0", "pair", "+2.0"]
    assert rows[1][-4:] == ["pair", "+1.0", "length_m", "-0.2"]


def test_energy_of_a_generation_is_reckoned_up(two_rooms: Path) -> None:
    text = call("show", two_rooms, "--stage", "generation").stdout
    sums = "4 x 0 rooms lack of area + 100 x 0 conflicts - 1 x 2.5 log-odds - 0.25 x 1 separating doors"
    assert f"cost -2.750000 = {sums}" in " ".join(text.split())


@pytest.mark.parametrize("preset", PRESETS)
def test_every_stage_of_every_preset_is_shown_and_walked_through(runs: dict[str, Path], preset: str) -> None:
    run = history(runs[preset])
    topics = [record.topic for record in PRESETS[preset].records]
    text = call("show", runs[preset], "--stage", "all").stdout
    assert [line.split()[0] for line in text.splitlines() if "(step " in line] == topics
    stepper, console = Stepper(run), Console(width=120, height=40, record=True)
    for topic in topics:
        walk = entered(run, Walk(topic), topic)
        told = dict(facts(run, walk))
        assert "step" in told
        with console.capture() as seen:
            console.print(stepper.screen(walk, 40), height=40)
        assert f" {topic} " in seen.get().splitlines()[0]


def test_scored_doors_are_walked_along(two_rooms: Path) -> None:
    run = history(two_rooms)
    assert stops(run, "door_scores").tolist() == run.scores.door.tolist()
    told = list(facts(run, Walk("door_scores", door=1)))
    assert ("virtual door", f"1 of {len(run.doors.kind)}, single") in told
    assert any(value.startswith("score: log-odds +0.25 (56 %") for _, value in told)


@pytest.mark.parametrize("preset", PRESETS)
def test_tabs_are_those_in_which_there_is_something_to_see(preset: str) -> None:
    assert tabs_of(PRESETS[preset].records, settings_of(PRESETS[preset], METHODS)) == TAB_NAMES[preset]


def entities(path: Path) -> dict[str, int]:
    """Rows of each entity in a Rerun recording."""
    found: dict[str, int] = {}
    for chunk in RrdReader(path).stream():
        name = str(chunk.entity_path)
        found[name] = found.get(name, 0) + chunk.to_record_batch().num_rows
    return found


def test_scores_and_certificate_are_drawn(two_rooms: Path, tmp_path: Path) -> None:
    path = tmp_path / "run.rrd"
    call("replay", two_rooms, "--save", path)
    rows, scores = entities(path), history(two_rooms).scores
    assert rows["/tables/door_scores"] == rows["/tables/door_features"] == len(scores.door)
    judged = {JUDGEMENTS[code] for code in scores.judgement.tolist()} - {JUDGEMENTS[LIKELY]}
    layers = ("doubtful", "likely", "sure", "conflicts", *judged)
    assert {name: rows[f"/map/scores/{name}"] for name in layers} == dict.fromkeys(layers, 1)
    assert rows["/certificate"] == 1
    assert rows["/charts/cost/levels/lower"] == 1


def test_colours_go_from_doubtful_to_sure() -> None:
    assert odds(-9.0) == odds(-4.0) == DOUBTFUL
    assert odds(9.0) == odds(4.0) == SURE
    assert odds(0.0) == tuple(round((one + other) / 2) for one, other in zip(DOUBTFUL, SURE, strict=True))


@pytest.mark.parametrize("preset", PRESETS)
def test_every_preset_has_a_picture_of_every_tab(runs: dict[str, Path], preset: str) -> None:
    run = History.read(read_recording(runs[preset], types=RECORDS))
    found = list(pictures(run, size=(500, 400)))
    assert [(picture.number, picture.tab) for picture in found] == list(enumerate(TAB_NAMES[preset]))
    assert len({picture.png for picture in found}) == len(found)


def test_a_picture_is_named_by_its_tab_and_a_tab_that_is_not_there_by_what_is(
    runs: dict[str, Path], tmp_path: Path
) -> None:
    words = ("--out", tmp_path / "shots", "--size", "400x300")
    done = call("shot", runs["default"], "--stage", "scores", *words)
    assert done.stdout.split() == [str(tmp_path / "shots" / "6_scores.png")]
    assert "--force" in call("shot", runs["default"], "--stage", "scores", *words, code=2).stderr
    error = call("shot", runs["paper"], "--stage", "cores", *words, code=2).stderr
    assert "wanted one of the recording's tabs, Overview, Simplified, " in error
    assert len(error.splitlines()) == 1


def _rrd(recording: Path, folder: Path) -> Path:
    call("replay", recording, "--save", folder / "paper.rrd")
    return folder / "paper.rrd"
