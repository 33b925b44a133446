"""One setting at several values: exact on a tiny map, the same as a plain run at the preset's own value, and drawn."""

from __future__ import annotations

import dataclasses
import io
import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import maps
import numpy as np
import pytest
from commands import Command
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image
from project import RECORDINGS
from rerun.chunk import RrdReader

from vdoor.api import run
from vdoor.errors import SettingError
from vdoor.evaluate import Division, Reference, Tally, evaluate, marked_doors, rooms_of
from vdoor.experiments import Choice, Point, Trial, by_setting, planned, read_trials, spread, swept, trial_of
from vdoor.experiments.steps import MOST_VALUES, PAPER, values_in
from vdoor.experiments.sweep import doors_counted
from vdoor.experiments.sweep_report import lines, value_text
from vdoor.method.search.optimisers import GeneticSearch
from vdoor.paper.door_counts import METHODS as COUNTED
from vdoor.paper.door_counts import count_doors as counted
from vdoor.pipeline import PRESETS
from vdoor.synth import PRESETS as KINDS
from vdoor.synth import synthesize, write_synthetic
from vdoor.viz.charts import sweep_png
from vdoor.viz.panels import PANELS, Line, axis_of, limits, series_of
from vdoor.viz.rerun.sweep import HEIGHT, WIDTH, Chart, save_sweeps, ticks

PIPELINE = PRESETS["paper"]
TWO_ROOMS = """
    #######################
    #..........#..........#
    #..........#..........#
    #..........#..........#
    #.....................#
    #.....................#
    #.....................#
    #..........#..........#
    #..........#..........#
    #..........#..........#
    #######################
"""
"""Rooms of 3.6 m2; the door's end cells are 0.8 m apart."""
TRUE_DOOR = np.array([[[4.0, 11.0], [6.0, 11.0]]])


@pytest.fixture(scope="module")
def two_rooms() -> Trial:
    grid = maps.drawn(TWO_ROOMS)
    division = Division(name="two", grid=grid, free=grid.free, rooms=np.zeros(grid.cells.shape, np.int32))
    rooms = np.where(grid.free, 1 + (np.arange(23) > 11), 0).astype(np.int32)
    return Trial(
        name="two",
        division=division,
        reference=Reference(path=Path("two.json"), rooms=rooms, doors=marked_doors(TRUE_DOOR, maps.CELL_M)),
    )


@pytest.fixture(scope="module")
def points(two_rooms: Trial) -> list[Point]:
    """Numbers and words, and values at which the map fails."""
    steps = planned(["simplify.cell_m=0.2,0.4,6", "search.method=annealing,genetic"], PIPELINE)
    division = dataclasses.replace(two_rooms.division, name="again")
    return list(swept(steps, [two_rooms, dataclasses.replace(two_rooms, name="again", division=division)]))


@pytest.mark.parametrize(
    ("text", "values"),
    [
        ("0.1..0.3:0.1", (0.1, 0.2, 0.3)),  # with floats 0.1 + 0.1 + 0.1 is beyond 0.3
        ("0.7..0.76:0.02", (0.7, 0.72, 0.74, 0.76)),
        ("0..9:4", (0, 4, 8)),
        ("3..5", (3, 4, 5)),
        ("-1..1:1", (-1, 0, 1)),
        ("7", (7,)),
        ("0, 0.5,2..4", (0, 0.5, 2, 3, 4)),
        ("paper,wide", ("paper", "wide")),
        ("none, 3, 0.5", ("none", 3, 0.5)),
        ("true,false", (True, False)),
        ("[1, 2],[3, 4.5]", ([1, 2], [3, 4.5])),
        ('"a,b","c"', ("a,b", "c")),
        ("my_curves.json,other..json", None),
    ],
)
def test_values_are_what_is_written(text: str, values: tuple[Any, ...] | None) -> None:
    if values is None:
        with pytest.raises(SettingError, match="wanted a range"):
            values_in(text, "here")
        return
    found = values_in(text, "here")
    assert (found, [type(value) for value in found]) == (values, [type(value) for value in values])


@maps.law
@given(st.integers(-500, 500), st.integers(0, 200), st.integers(1, 50), st.integers(0, 3))
def test_a_range_has_every_step_and_ends_within(low: int, length: int, step: int, digits: int) -> None:
    """Whatever the digits: the numbers are the nearest floats to the decimal ones."""
    one = 10**digits
    found = values_in(f"{low / one}..{(low + length) / one}:{step / one}", "here")
    assert found == tuple(number / one for number in range(low, low + length + 1, step))


@pytest.mark.parametrize(
    "text", ["", " ", "3..1", "0..1:0", "0..1:-1", "0..nan", "0..inf:1", "a..b", "1..2:x", "..", "1..2..3"]
)
def test_what_is_no_range_is_told(text: str) -> None:
    with pytest.raises(SettingError, match=r"^here: wanted .*, found"):
        values_in(text, "here")


@pytest.mark.parametrize("text", ["0..1:0.000001", "0..1e400:1e-400", ",".join(["1"] * (MOST_VALUES + 1))])
def test_too_many_values_are_told(text: str) -> None:
    with pytest.raises(SettingError, match=f"here: wanted at most {MOST_VALUES} values"):
        values_in(text, "here")


@pytest.mark.parametrize(
    ("sweep", "values", "own"),
    [
        ("doors.max_length_m=2,1,1.0", [1.0, 1.2, 2.0], 1.2),
        ("doors.max_length_m=1.2", [1.2], 1.2),
        ("search.population=10,90", [10, 50, 90], 50),
        ("search.method=exhaustive,annealing", ["exhaustive", "annealing", "genetic"], "genetic"),
        ("simplify.robot_m=[1,2]", [(1.0, 2.0), ()], ()),
        ("seed=5,1", [1, 3, 5], 3),
    ],
)
def test_own_value_is_always_there_once(sweep: str, values: list[Any], own: Any) -> None:
    steps = planned([sweep], PIPELINE, seed=3)
    assert [step.value for step in steps] == values
    assert [step.value for step in steps if step.own] == [own]
    (plain,) = (step for step in steps if step.own)
    assert (plain.pipeline, plain.seed) == (PIPELINE, 3)
    assert len({(step.pipeline, step.seed) for step in steps}) == len(steps)


@pytest.mark.parametrize(
    ("sweeps", "message"),
    [
        (["curvature.straightness=0.9,2"], "sweep: curvature.straightness: wanted 0 to 1, found 2"),
        (["curvature.straightness=0.9..1.1:0.1"], "sweep: curvature.straightness: wanted 0 to 1, found 1.1"),
        (["seed=1", "curvature.straightnes=0.9"], "sweep: curvature: no setting 'straightnes'; did you mean"),
        (["curve.straightness=0.9"], "sweep: no stage 'curve'"),
        (["search.method=genetics"], "sweep: search: no method 'genetics'; did you mean 'genetic'"),
        (["search.population=2.5"], "sweep: search.population: wanted a whole number, found 2.5"),
        (["seed=-1"], "sweep: seed: wanted whole numbers from 0, found -1"),
        (["seed=0.5,1"], "sweep: seed: wanted whole numbers from 0, found 0.5"),
        (["seed=1", "seed=2"], "sweep: wanted each setting once, found seed twice"),
        (["maps"], "sweep: wanted stage.field=VALUES or seed=VALUES, found 'maps'"),
        (["seed"], "sweep: seed: wanted FROM..TO:STEP or a list with commas, found nothing"),
    ],
)
def test_wrong_sweeps_are_told_before_anything_runs(sweeps: list[str], message: str) -> None:
    with pytest.raises(SettingError) as told:
        planned(sweeps, PIPELINE)
    assert str(told.value).startswith(message)


def test_the_papers_list_holds_the_papers_own_values() -> None:
    steps = planned(PAPER, PIPELINE)
    assert {step.setting.name: step.value for step in steps if step.own} == {
        "curvature.straightness": 0.9,
        "candidates.angle_deg": 155.0,
        "doors.max_length_m": 1.2,
        "cost.room_m2": 2.0,
        "cost.small_weight": 1.0,
        "cost.area_weight_per_m2": 0.05,
        "cost.tilt_weight_per_deg": 0.05,
        "simplify.cell_m": 0.2,
        "seed": 0,
    }
    assert all(step.setting.meaning for step in steps)
    assert {step.setting.name: step.setting.unit for step in steps}["cost.area_weight_per_m2"] == "1/m²"


def test_door_is_found_from_its_length_on(two_rooms: Trial) -> None:
    """Its end cells are 0.8 m apart: exactly there it begins."""
    found = list(swept(planned(["doors.max_length_m=0.7,0.8,1"], PIPELINE), [two_rooms]))
    assert [(point.value, point.totals["virtual"], point.totals["matched"]) for point in found] == [
        (0.7, 0, 0),
        (0.8, 1, 1),
        (1.0, 1, 1),
        (1.2, 1, 1),
    ]
    shut, opened = found[0], found[1]
    assert opened.totals == {
        "doors_true": 1,
        "doors_found": 1,
        "doors_hit": 1,
        "doors_false": 0,
        "virtual": 1,
        "matched": 1,
        "rooms_true": 2,
        "rooms_found": 2,
        "corners": opened.totals["corners"],
        "proposed": 1,
    }
    assert (opened.figures["door_f1"], opened.figures["accuracy"], opened.figures["rooms_excess"]) == (1.0, 1.0, 0.0)
    assert (shut.figures["door_recall"], shut.totals["rooms_found"], shut.totals["proposed"]) == (0.0, 1, 0)
    assert "accuracy" not in shut.figures
    assert shut.figures["rooms_excess"] == shut.figures["doors_excess"] == -1


def test_seeds_change_nothing_where_there_is_one_optimum(two_rooms: Trial) -> None:
    first, *others = swept(planned(["seed=0..4"], PIPELINE), [two_rooms])
    assert len(others) == 4
    assert all((point.figures, point.maps) == (first.figures, first.maps) for point in others)


def test_each_seed_is_a_run_of_its_own() -> None:
    """A search that stops at its first two strings ends wherever the seed says, as the same run by itself does."""
    home = synthesize(dataclasses.replace(KINDS["paper"], rooms=5, furniture=True), np.random.default_rng(3))
    pipeline = dataclasses.replace(PIPELINE, search=GeneticSearch(population=2, generations=0))
    found = list(swept(planned(["seed=0..3"], pipeline), [trial_of(home, "home")]))
    assert len({point.figures["cost"] for point in found}) == 4
    for point in found:
        labels = run(home.grid, pipeline, seed=point.value).labels
        assert point.totals["rooms_found"] == rooms_of(labels, maps.CELL_M).max()


def test_doors_of_the_list_and_contacts_are_told_apart(two_rooms: Trial) -> None:
    nothing = evaluate(two_rooms.division, two_rooms.reference)
    found = doors_counted(nothing, Tally(hits=3, missed=2, false=4))
    assert (found["virtual"], found["matched"], found["doors_hit"], found["doors_found"]) == (7, 3, 0, 0)


def test_map_that_fails_is_one_on_which_nothing_is_found(points: list[Point]) -> None:
    *_, last = (point for point in points if point.setting.name == "simplify.cell_m")
    assert (last.value, [*last.failed]) == (6.0, ["two", "again"])
    assert last.failed["two"].startswith("two: the map has no free cell")
    assert (last.totals["doors_true"], last.totals["doors_found"], last.figures["door_f1"]) == (2, 0, 0.0)
    assert "corners" not in last.totals
    assert not points[-1].failed


def test_doors_are_counted_as_table_one_counts_them() -> None:
    homes = [
        synthesize(dataclasses.replace(KINDS["paper"], rooms=5, furniture=True), np.random.default_rng(seed))
        for seed in (3, 5)
    ]
    pipeline = dataclasses.replace(PIPELINE, simplify=dataclasses.replace(PIPELINE.simplify, max_island_m=1.0))
    trials = [trial_of(home, f"home {number}") for number, home in enumerate(homes)]
    found = list(swept(planned(["doors.max_length_m=0.9,3"], pipeline), trials))
    assert len({point.totals["virtual"] for point in found}) > 1
    for point in found:
        method = dataclasses.replace(
            COUNTED["proposed"], doors=dataclasses.replace(PIPELINE.doors, max_length_m=point.value)
        )
        table = [counted(home, method) for home in homes]
        for figure, column in (("doors_true", "real"), ("virtual", "virtual"), ("matched", "matched")):
            assert point.totals[figure] == sum(getattr(row, column) for row in table)


def test_drawn_trial_is_the_one_its_files_give(tmp_path: Path) -> None:
    made = synthesize(dataclasses.replace(KINDS["paper-5cm"], rooms=3, rotation_deg=20.0), np.random.default_rng(2))
    write_synthetic(made, tmp_path / "home", seed=2)
    (read,) = read_trials(tmp_path, Choice(reference=tmp_path)).trials
    drawn = trial_of(made, "home")
    assert drawn.name == read.name
    assert np.array_equal(drawn.division.grid.cells, read.division.grid.cells)
    assert np.array_equal(drawn.reference.rooms, read.reference.rooms)
    for part in ("centre_m", "width_m", "ends"):
        assert np.allclose(getattr(drawn.reference.doors, part), getattr(read.reference.doors, part), rtol=0, atol=1e-9)


def test_spread_is_over_the_maps_that_have_the_figure() -> None:
    each = {"a": {"cost": 1.0}, "b": {"cost": 3.0}, "c": {}}
    assert spread(each, "cost") == (2.0, 1.0)
    assert np.isnan(spread(each, "corners").mean)


def test_table_has_a_star_at_the_own_value(points: list[Point]) -> None:
    printed = list(lines(points))
    assert [line.split()[0] for line in printed if line and not line.startswith(" " * 8)] == [
        "simplify.cell_m:",
        "0.2*",
        "0.4",
        "6",
        "search.method:",
        "annealing",
        "genetic*",
    ]
    assert [line.split()[-1] for line in printed if line.strip().startswith(("0.2*", "6"))] == ["0", "2"]


@pytest.mark.parametrize(
    ("value", "text"),
    [(0.1 + 0.2, "0.3"), (2.0, "2"), (7, "7"), (True, "true"), ("wide", "wide"), ((1.0, 2.5), "1,2.5")],
)
def test_values_are_written_short(value: Any, text: str) -> None:
    assert value_text(value) == text


@maps.law
@given(st.floats(-1e3, 1e3), st.floats(1e-3, 1e3))
def test_ticks_are_round_few_and_within(low: float, length: float) -> None:
    found = ticks(low, low + length)
    assert 2 <= len(found) <= 7
    steps = np.diff(found)
    assert np.allclose(steps, steps[0])
    assert f"{steps[0]:.0e}"[0] in "125"
    spare = 1e-9 * (1 + abs(low) + length)
    assert low - spare <= found[0] <= found[-1] <= low + length + spare


def test_band_is_as_wide_as_the_spread(points: list[Point]) -> None:
    """A chart from 0 to 2: a mean of 1 and a deviation of 0.5 cover the middle half, from first to last value."""
    point = dataclasses.replace(points[0], maps={"a": {"cost": 0.5}, "b": {"cost": 1.5}})
    own = [dataclasses.replace(point, value=value, own=not value) for value in (0.0, 1.0)]
    panel, line = PANELS[-1], Line("cost", "cost", (0, 0, 0), band=True)
    chart = Chart(own, panel, (0.0, 2.0))
    band = chart.band(series_of(own, line, panel))
    assert band.shape == (HEIGHT, WIDTH)
    rows, columns = (np.flatnonzero(band.any(axis=axis)) for axis in (1, 0))
    assert (rows[0], rows[-1]) == (HEIGHT // 4, HEIGHT * 3 // 4 - 1)
    assert band[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1].all()
    assert columns[0] == pytest.approx(float(chart.x(0.0)), abs=1.5)
    assert columns[-1] == pytest.approx(float(chart.x(1.0)), abs=1.5)


def test_shares_stay_between_nothing_and_all(points: list[Point]) -> None:
    panel = PANELS[0]
    assert limits(panel, [points]) == pytest.approx((0.0, 1.05))
    point = dataclasses.replace(points[0], maps={"a": {"door_f1": 0.0}, "b": {"door_f1": 1.0}, "c": {"door_f1": 1.0}})
    series = series_of([point], Line("", "door_f1", (0, 0, 0)), panel)
    assert (series.high.item(), series.mean.item()) == (1.0, pytest.approx(2 / 3))


def test_words_stand_in_their_order(points: list[Point]) -> None:
    numbers, words = map(axis_of, by_setting(points).values())
    assert (numbers.numeric, numbers.places.tolist(), numbers.own) == (True, [0.2, 0.4, 6.0], 0)
    assert (words.numeric, words.places.tolist(), words.own) == (False, [0, 1], 1)


def test_equal_sweeps_give_equal_pictures(points: list[Point]) -> None:
    numbers, words = by_setting(points).values()
    png = sweep_png(words)
    assert png == sweep_png(words)
    assert png != sweep_png(numbers)
    with Image.open(io.BytesIO(png)) as picture:
        assert not picture.info.keys() & {"Software", "Creation Time", "date"}
        assert picture.width > 3 * picture.height > 0
        assert len(np.unique(np.asarray(picture))) > 20


def test_recording_has_a_line_for_every_figure(points: list[Point], tmp_path: Path) -> None:
    save_sweeps(tmp_path / "s.rrd", points)
    assert [path.name for path in tmp_path.iterdir()] == ["s.rrd"]
    reader = RrdReader(tmp_path / "s.rrd")
    for number, own in enumerate(by_setting(points).values()):
        for place, panel in enumerate(PANELS):
            for line in panel.lines:
                entity = f"/sweep/{number}/{place}/{line.figure}/points"
                (chunk,) = reader.stream().filter(content=entity)
                batch = chunk.to_record_batch()
                (spots,) = batch.column("Points2D:positions").to_pylist()
                assert len(spots) == len([value for value in series_of(own, line, panel).mean if np.isfinite(value)])
    assert not any("failed" in text for text in reader.store().summary().splitlines() if "/sweep/1/" in text)
    assert "/sweep/0/0/failed" in reader.store().summary()


def test_own_row_is_what_evaluate_says_of_a_plain_run(tmp_path: Path) -> None:
    """From the command line, in processes of their own."""
    flat, truth = RECORDINGS / "flat.yaml", RECORDINGS / "flat_truth.json"

    def called(*words: str | Path) -> str:
        program = [sys.executable, "-c", "from vdoor.cli import main; main()"]
        return subprocess.run([*program, *map(str, words)], capture_output=True, text=True, check=True).stdout

    called("run", flat, "--preset", "paper", "--out", tmp_path / "flat")
    evaluated = json.loads(called("evaluate", tmp_path / "flat", "--reference", truth, "--json"))
    drawn = ("--png", tmp_path / "s.png", "--save", tmp_path / "s.rrd")
    words = ("sweep", "doors.max_length_m=0.8", "--preset", "paper", "--maps", flat, "--reference", truth, "--json")
    told = json.loads(called(*words, *drawn))
    (sweep,) = told["sweeps"]
    shut, own = sweep["points"]
    assert (own["value"], own["own"], shut["own"]) == (1.2, True, False)
    figures = evaluated["maps"][0]["figures"]
    assert {name: own["maps"]["flat"][name] for name in figures} == figures
    assert {name: own["figures"][name] for name in evaluated["summary"]} == evaluated["summary"]
    assert shut["figures"]["door_recall"] < own["figures"]["door_recall"]
    assert told["maps"] == ["flat"]
    assert {path.name for path in tmp_path.iterdir()} == {"flat", "s.png", "s.rrd"}


def test_command_goes_on_where_a_map_fails(command: Command) -> None:
    told = command("sweep", "simplify.cell_m=7", "--preset", "paper", "--apartments", "2")
    assert told.code == 0
    assert [line.split()[0] for line in told.out.splitlines()[2:]] == ["0.2*", "7"]
    assert told.out.splitlines()[-1].split()[-1] == "2"
    assert "note: apartment_1000 failed: the map has no free cell at 7 m per cell" in told.err
    assert "1 of 2: simplify.cell_m=0.2: door F1 1.000" in told.err


def test_equal_commands_print_the_same(command: Command) -> None:
    words = ("sweep", "seed=0,1", "cost.area_weight_per_m2=0,1", "--preset", "paper", "--apartments", "1")
    first, second = (command(*words, "--furnished", "--json", "-q") for _ in range(2))
    assert first == second
    assert not first.err
    assert [sweep["setting"] for sweep in first.json["sweeps"]] == ["seed", "cost.area_weight_per_m2"]
    assert first.json["furnished"] is True
    assert first.json["settings"]["doors"]["max_length_m"] == 1.2


def test_what_the_method_lacks_is_left_out(command: Command, tmp_path: Path) -> None:
    """The existing algorithm may have neither corners nor cost; what is drawn leaves them empty."""
    told = command(
        "sweep", "simplify.cell_m=0.1", "--preset", "eroded-space", "--apartments", "1", "--png", tmp_path / "s.png",
        "--save", tmp_path / "s.rrd",
    )  # fmt: skip
    assert told.code == 0
    assert told.out.splitlines()[-1].split()[-4:] == ["-", "-", "-", "0"]


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["curvature.straightness=2..12:1"], "sweep: curvature.straightness: wanted 0 to 1, found 2"),
        (["--preset", "default"], "sweep: doors: no setting 'max_length_m'"),
        (["score.model=gone.json", "--preset", "default"], "score.model: "),
        (["seed=1", "--maps", "gone"], "sweep: wanted --maps and --reference, found --maps alone"),
        (["seed=1", "--reference", "gone"], "sweep: wanted --maps and --reference, found --reference alone"),
        (["seed=1", "--maps", "gone", "--reference", "gone", "--furnished"], "sweep: wanted either --maps or"),
        (["seed=1", "--only", "flat"], "sweep: wanted --maps with the options on reading maps, found none"),
        (["seed=1", "--maps", "gone", "--reference", "gone"], "maps: wanted a map, found none: gone"),
        (["seed=1", "--png", str(RECORDINGS / "overview.png")], "output: already exists"),
        (
            ["seed=1", "--png", "no/such/folder/s.png", "--apartments", "1"],
            "output: wanted an existing folder, found none: no/such/folder",
        ),
        (["seed=1", "--png", f"{__file__}/s.png"], "output: wanted an existing folder, found none: "),
    ],
)
def test_wrong_input_is_one_line_and_exit_code_2(command: Command, words: list[str], message: str) -> None:
    told = command("sweep", *words)
    assert told.code == 2
    assert not told.out
    assert [line.startswith(f"vdoor: {message}") for line in told.err.splitlines()] == [True]


def test_read_only_folder_is_told_before_anything_runs(
    command: Command, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(os, "access", lambda *_: False)  # root may write anywhere
    told = command("sweep", "seed=1", "--apartments", "1", "--save", tmp_path / "s.rrd")
    assert (told.code, told.out) == (2, "")
    assert told.err.endswith(f": wanted a writable folder, found a read-only folder: {tmp_path}\n")
