"""Maps whose truth is known: changed so that no wall opens and truth stays where it is, and runs on them in a table."""

from __future__ import annotations

import dataclasses
import json
import shutil
from pathlib import Path
from typing import Any

import maps
import numpy as np
import pytest
import vacuum
from commands import Command
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray
from PIL import Image
from project import HOME
from scipy import ndimage

from vdoor.config import settings_of
from vdoor.errors import MapError, SettingError, VdoorError
from vdoor.evaluate import evaluate, marked_doors
from vdoor.experiments import (
    CHANGES,
    VARIANTS,
    Change,
    Choice,
    Row,
    Trial,
    Variant,
    ablation,
    changed,
    measured,
    read_trials,
    robustness,
    summarised,
    tables,
    variants_with,
)
from vdoor.experiments.ablation import mean_and_spread
from vdoor.experiments.changes import Sheet, as_is, coarsen, keeps_walls_closed, roughen, turn, turned, turned_frame
from vdoor.experiments.robustness import moved
from vdoor.grid import FREE, OCCUPIED, UNKNOWN, OccupancyGrid
from vdoor.method.simplify import SimplifiedGrid
from vdoor.pipeline import METHODS, PRESETS
from vdoor.record import equal
from vdoor.synth import PRESETS as KINDS
from vdoor.synth import synthesize, write_synthetic

RNG = np.random.default_rng(0)
angles = st.floats(-180, 180)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two small apartments with the truth beside them."""
    folder = tmp_path_factory.mktemp("maps")
    for seed, name in enumerate(("flat", "flat_b")):
        apartment = dataclasses.replace(KINDS["paper-5cm"], rooms=3, rooms_spread=0)
        write_synthetic(synthesize(apartment, np.random.default_rng(seed)), folder / name, seed=seed)
    return folder


@pytest.fixture(scope="module")
def trials(folder: Path) -> list[Trial]:
    return read_trials(folder, Choice(reference=folder)).trials


def random_map(seed: int, *, unknown: bool = True) -> OccupancyGrid:
    """A map of lines a cell thin in all directions, solid lumps, and unknown cells, lying anywhere."""
    rng = np.random.default_rng(seed)
    height, width = rng.integers(3, 30, 2)
    cells = np.full((height, width), FREE, np.int8)
    for _ in range(rng.integers(1, 8)):
        ends = rng.integers(0, [height, width], (2, 2))
        count = np.abs(ends[1] - ends[0]).max() + 1
        row, col = np.rint(np.linspace(ends[0], ends[1], count)).astype(int).T
        cells[row, col] = rng.choice([OCCUPIED, UNKNOWN]) if unknown else OCCUPIED
    cells[rng.random(cells.shape) < 0.02] = OCCUPIED
    x_m, y_m, yaw_rad = rng.uniform(-3, 3, 3).tolist()
    return OccupancyGrid.from_array(cells, 0.05, x_m=x_m, y_m=y_m, yaw_rad=yaw_rad)


def joined(free: NDArray[np.bool_], region: NDArray[Any]) -> bool:
    """Whether some 4-connected part of the free cells holds cells of two regions."""
    part, count = ndimage.label(free)
    return any(len(np.unique(region[part == number])) > 1 for number in range(1, count + 1))


@maps.law
@given(st.integers(0, 10**6))
def test_turning_by_nothing_changes_nothing(seed: int) -> None:
    grid = random_map(seed)
    same, free = turned(grid, grid.free, 0.0)
    assert np.array_equal(same.cells, grid.cells)
    assert np.array_equal(free, grid.free)
    assert dataclasses.astuple(same.frame) == pytest.approx(dataclasses.astuple(grid.frame), abs=1e-12)


@maps.law
@given(st.integers(0, 10**6), st.integers(0, 3))
def test_quarter_turns_to_the_left_are_exact(seed: int, quarters: int) -> None:
    grid = random_map(seed)
    assert np.array_equal(turned(grid, grid.free, 90.0 * quarters)[0].cells, np.rot90(grid.cells, quarters))


@maps.long_law
@given(st.integers(0, 10**6), angles)
def test_turning_opens_no_wall(seed: int, angle_deg: float) -> None:
    """What was not 4-connected by free cells is not so after the turn either."""
    grid = random_map(seed)
    region, _ = ndimage.label(grid.free)
    again, _ = turned(grid, grid.free, angle_deg)
    cells = np.argwhere(again.free)
    back = np.floor(grid.frame.cell_from_world(again.frame.world_from_cell(cells)) + (0.5 + 1e-9)).astype(int)
    there = np.zeros(again.free.shape, int)
    there[tuple(cells.T)] = region[tuple(back.T)]
    assert there[again.free].all()
    assert not joined(again.free, there)


@pytest.mark.parametrize("angle_deg", [5.0, 15.0, 30.0, 45.0, 60.0])
@pytest.mark.parametrize("thin", [OCCUPIED, UNKNOWN])
def test_two_rooms_stay_two_behind_a_wall_one_cell_thin(angle_deg: float, thin: int) -> None:
    cells = np.full((41, 61), FREE, np.int8)
    cells[0], cells[-1], cells[:, 0], cells[:, -1] = thin, thin, thin, thin
    slanting = np.arange(41)
    cells[slanting, slanting + 10] = thin
    grid = OccupancyGrid.from_array(cells, 0.05)
    again, _ = turned(grid, grid.free, angle_deg)
    sizes = np.bincount(ndimage.label(again.free)[0].ravel())[1:]
    assert len(sizes) == 2
    assert sizes.sum() == pytest.approx(grid.free.sum(), rel=0.1)


@maps.law
@given(st.integers(0, 10**6), angles)
def test_turned_map_holds_the_whole_map_and_knows_where_it_lies(seed: int, angle_deg: float) -> None:
    frame = random_map(seed).frame
    new = turned_frame(frame, np.radians(angle_deg))
    corners = np.array([[-0.5, -0.5], [-0.5, frame.width - 0.5], [frame.height - 0.5, -0.5]])
    place = new.cell_from_world(frame.world_from_cell(corners))
    assert (place >= -0.5 - 1e-5).all()
    assert (place <= np.array([new.height, new.width]) - 0.5 + 1e-5).all()
    right, down = (place[1] - place[0])[::-1], (place[2] - place[0])[::-1]
    assert np.hypot(*right) == pytest.approx(frame.width)
    # To the left in an image, whose rows go down.
    for found_rad in (np.arctan2(-right[1], right[0]), np.arctan2(down[0], down[1])):
        assert (np.degrees(found_rad) - angle_deg + 180) % 360 == pytest.approx(180, abs=1e-6)


@maps.law
@given(st.integers(0, 10**6), angles)
def test_doors_moved_to_a_frame_and_back_are_the_same(seed: int, angle_deg: float) -> None:
    frame = random_map(seed).frame
    new = turned_frame(frame, np.radians(angle_deg))
    doors = marked_doors(np.random.default_rng(seed).uniform(0, 20, (5, 2, 2)), frame.resolution_m)
    there = moved(doors, frame, new)
    spans = np.hypot(*(there.ends[:, 1] - there.ends[:, 0]).T) * new.resolution_m
    assert spans == pytest.approx(doors.width_m)
    assert marked_doors(there.ends, new.resolution_m).centre_m == pytest.approx(there.centre_m)
    back = moved(there, new, frame)
    assert back.ends == pytest.approx(doors.ends, abs=1e-9)
    assert back.centre_m == pytest.approx(doors.centre_m, abs=1e-9)


@pytest.mark.parametrize("change", CHANGES, ids=lambda change: change.name)
def test_true_rooms_moved_with_the_map_have_the_moved_doors(trials: list[Trial], change: Change) -> None:
    """Division and truth agree on every changed map, to the last door."""
    for trial in trials:
        there = changed(trial, change, np.random.default_rng(3))
        old, new = trial.division.frame, there.division.frame
        place = old.cell_from_world(new.world_from_cell(np.argwhere(there.division.free)))
        row, col = np.clip(np.floor(place + 0.5).astype(int), 0, np.array(trial.division.free.shape) - 1).T
        rooms = np.zeros(there.division.free.shape, np.int32)
        assert trial.reference.rooms is not None
        rooms[there.division.free] = trial.reference.rooms[row, col]
        figures = evaluate(dataclasses.replace(there.division, rooms=rooms), there.reference).figures()
        assert figures["doors_true"] > 1
        assert figures["door_f1"] == 1


def test_quarter_turn_turns_the_truth(trials: list[Trial]) -> None:
    trial = trials[0]
    quarter = changed(trial, Change("", lambda sheet, rng: turn(sheet, rng, angle_deg=90.0)), RNG)
    width_m = trial.division.frame.width * trial.division.frame.resolution_m
    right_m, down_m = trial.reference.doors.centre_m.T
    assert quarter.reference.doors.centre_m == pytest.approx(np.stack([down_m, width_m - right_m], axis=1))


def test_unsure_doors_move_along(trials: list[Trial]) -> None:
    reference = dataclasses.replace(trials[0].reference, unsure=trials[0].reference.doors)
    there = changed(dataclasses.replace(trials[0], reference=reference), CHANGES[2], RNG).reference
    assert there.unsure is not None
    assert np.array_equal(there.unsure.centre_m, there.doors.centre_m)
    assert not np.allclose(there.doors.centre_m, reference.doors.centre_m)


def test_map_as_it_is_is_the_same_map(trials: list[Trial]) -> None:
    there = changed(trials[0], Change("", as_is), RNG)
    assert equal(there.division.grid, trials[0].division.grid)
    assert there.reference.doors.centre_m == pytest.approx(trials[0].reference.doors.centre_m, abs=1e-12)


def test_coarse_cell_is_occupied_where_a_fine_one_is() -> None:
    grid = maps.drawn("..#.?\n....?\n...??", cell_m=0.05)
    coarse = coarsen(Sheet(grid, grid.free), RNG)
    assert np.array_equal(coarse.grid.cells, maps.cells_drawn(".#?\n..?"))
    assert np.array_equal(coarse.free, coarse.grid.free)
    assert coarse.grid.frame.resolution_m == pytest.approx(0.1)
    corner = np.array([[-0.5, -0.5]])
    assert coarse.grid.frame.world_from_cell(corner) == pytest.approx(grid.frame.world_from_cell(corner))


def test_cells_that_are_not_measured_are_not_after_any_change() -> None:
    grid = OccupancyGrid.from_array(np.zeros((40, 40), np.int8), 0.05)
    for change in CHANGES:
        assert not change.make(Sheet(grid, np.zeros((40, 40), np.bool_)), np.random.default_rng(0)).free.any()


@maps.long_law
@given(st.integers(0, 10**6))
def test_dents_go_through_no_wall(seed: int) -> None:
    grid = random_map(seed, unknown=False)
    region, _ = ndimage.label(grid.free)
    rough = roughen(Sheet(grid, grid.free), np.random.default_rng(seed), noise=1.6, specks=0.0).grid
    # What was dented belongs to whichever region it opened into: only cells that were free are asked.
    part, count = ndimage.label(rough.free)
    for number in range(1, count + 1):
        assert len(np.unique(region[(part == number) & grid.free])) <= 1


def test_noise_is_as_much_as_is_asked_for() -> None:
    cells = np.full((400, 400), FREE, np.int8)
    cells[:100] = OCCUPIED
    grid = OccupancyGrid.from_array(cells, 0.05)
    rough = roughen(Sheet(grid, grid.free), np.random.default_rng(0), noise=0.15, specks=0.002)
    assert (rough.grid.cells[:99] == OCCUPIED).all()
    assert (rough.grid.cells[99] == FREE).mean() == pytest.approx(0.075, abs=0.03)
    assert (rough.grid.cells[100] == OCCUPIED).mean() == pytest.approx(0.075, abs=0.03)
    assert (rough.grid.cells[101:] == OCCUPIED).mean() == pytest.approx(0.002, rel=0.2)
    assert np.array_equal(rough.free, rough.grid.free)


def test_noise_is_that_of_its_seed() -> None:
    sheet = Sheet(random_map(7), random_map(7).free)
    one, same, other = (roughen(sheet, np.random.default_rng(seed), noise=0.5).grid for seed in (1, 1, 2))
    assert equal(one, same)
    assert not equal(one, other)


@pytest.mark.parametrize(
    ("drawing", "closed"),
    [
        ("...\n###\n...", False),
        ("...\n###\n###", True),
        ("...\n.##\n.##", True),
        (".##\n###\n##.", False),
        ("...\n.#.\n...", False),
        ("###\n###\n###", False),
        ("#.#\n###\n##.", True),
        ("#.#\n##.\n###", False),
    ],
)
def test_cell_that_may_be_dented(drawing: str, closed: bool) -> None:  # a parameter of the test
    assert keeps_walls_closed(maps.drawn(drawing).free)[1, 1] == closed


def test_run_in_memory_has_the_figures_of_run_and_evaluate(
    folder: Path, trials: list[Trial], tmp_path: Path, command: Command
) -> None:
    assert not command("run", folder / "flat.yaml", "--out", tmp_path / "flat", "--quiet").code
    told = command("evaluate", tmp_path / "flat", "--reference", folder / "flat_truth.json", "--json").json
    outcome = measured(trials[0], PRESETS["default"])
    assert outcome.evaluation.figures() == pytest.approx(told["maps"][0]["figures"])
    assert outcome.cpu_s > 0


def test_every_variant_fits_the_default_preset_and_changes_it() -> None:
    pipelines = [variant.of(PRESETS["default"]) for variant in VARIANTS]
    assert pipelines[0] == PRESETS["default"]
    assert pipelines[-1] == PRESETS["paper"]
    assert all(one != other for at, one in enumerate(pipelines) for other in pipelines[:at])
    assert len({variant.name for variant in VARIANTS}) == len(VARIANTS)


def test_ablation_has_a_row_a_variant_and_mean_and_spread_of_models(trials: list[Trial]) -> None:
    variants = [VARIANTS[0], Variant(name="little", settings={"score": {"least_log_odds": 5.0}})]
    models = [Variant(name=f"m{k}", settings={"cost": {"bias": bias}}) for k, bias in enumerate((-50.0, 0.3))]
    rows = list(ablation(trials, PRESETS["default"], variants=variants, models=models))
    assert [row.name for row in rows] == [
        "full method",
        "little",
        "m0",
        "m1",
        "mean of 2 models",
        "spread of 2 models",
    ]
    whole, none, good = rows[0].figures, rows[2].figures, rows[3].figures
    assert none["door_recall"] == 0
    assert {key: value for key, value in good.items() if "cpu" not in key} == {
        key: value for key, value in whole.items() if "cpu" not in key
    }
    assert rows[4].figures["door_f1"] == pytest.approx(good["door_f1"] / 2)
    assert rows[5].figures["door_f1"] == pytest.approx(good["door_f1"] / np.sqrt(2))
    assert rows[0].figures["worst_door_f1"] == min(rows[0].door_f1.values()) == rows[0].door_f1[rows[0].worst_map]
    assert rows[0].figures["door_f1"] == pytest.approx(np.mean([*rows[0].door_f1.values()]))


def test_worst_map_is_the_one_with_the_lowest_f1(trials: list[Trial]) -> None:
    doors = dataclasses.replace(trials[1].reference.doors, centre_m=trials[1].reference.doors.centre_m + 50.0)
    lost = dataclasses.replace(trials[1], reference=dataclasses.replace(trials[1].reference, doors=doors))
    row = summarised("", [measured(trial, PRESETS["default"]) for trial in (trials[0], lost)])
    assert (row.worst_map, row.figures["worst_door_f1"]) == ("flat_b", 0)
    assert row.door_f1["flat"] > 0
    assert row.figures["cpu_max_s"] >= row.figures["cpu_s"] > 0


def test_spread_is_that_of_a_sample() -> None:
    rows = [Row(name="", figures={"door_f1": value}) for value in (0.2, 0.4, 0.9)]
    mean, spread = mean_and_spread(rows)
    assert mean.figures["door_f1"] == pytest.approx(0.5)
    assert spread.figures["door_f1"] == pytest.approx(0.1300000**0.5)


def test_variant_names_what_the_pipeline_lacks() -> None:
    (room_term,) = (variant for variant in VARIANTS if variant.name == "no room term")
    with pytest.raises(SettingError, match="variant 'no room term': cost: no setting 'lack_weight'"):
        next(ablation([], PRESETS["paper"], variants=[VARIANTS[0], room_term]))


def test_robustness_compares_with_the_first_row(trials: list[Trial]) -> None:
    rows = list(robustness(trials[:1], PRESETS["default"], changes=[CHANGES[0], CHANGES[5]]))
    first, second = (row.figures for row in rows)
    assert first["door_f1_difference"] == 0
    assert second["door_f1_difference"] == pytest.approx(second["door_f1"] - first["door_f1"])
    assert "iou_sym" not in first


@pytest.mark.parametrize("change", CHANGES, ids=lambda change: change.name)
def test_robot_is_placed_where_it_is_on_the_changed_map(change: Change, tmp_path: Path) -> None:
    """Points of the map frame stay what they are, so the robot stands in the same flat, the smaller one of two."""
    rows = [f"#{'a' * 60}#?#{'b' * 40}#" for _ in range(40)]
    table = vacuum.home("\n".join(["#" * 105, *rows, "#" * 105]), robot_position=vacuum.centre_cm(20, 80))
    path, truth = (vacuum.write_home(tmp_path / name, table) for name in ("home.json", "truth.json"))
    (trial,) = read_trials(path, Choice(reference=truth)).trials
    there = changed(trial, change, RNG)
    seen: list[SimplifiedGrid] = []

    def keep(record: Any, /) -> Any:
        seen.extend([record] if isinstance(record, SimplifiedGrid) else [])
        return record

    default = PRESETS["default"]  # which keeps all rooms: here those of the robot's flat alone
    alone = dataclasses.replace(default, simplify=dataclasses.replace(default.simplify, least_part_m2=0.0))
    measured(there, alone, emit=keep)
    (simplified,) = seen
    x_m, _ = simplified.frame.world_from_cell(np.argwhere(simplified.cells == FREE)).T
    left_m = vacuum.CELL_CM / 100 * (2 + 64)
    assert left_m - 0.1 < x_m.min()
    assert x_m.max() < left_m + 40 * vacuum.CELL_CM / 100 + 0.1


def test_maps_and_references_of_a_folder(folder: Path, tmp_path: Path) -> None:
    """No truth is taken for a map, and no image beside its YAML for another one."""
    for path in folder.iterdir():
        shutil.copy(path, tmp_path)
    Image.fromarray(np.full((5, 5), 254, np.uint8)).save(tmp_path / "other.png")
    found = read_trials(tmp_path, Choice(reference=tmp_path))
    assert [trial.name for trial in found.trials] == ["flat", "flat_b"]
    assert [trial.reference.path.name for trial in found.trials] == ["flat_truth.json", "flat_b_truth.json"]
    assert found.without_reference == ["other"]


def test_one_map_and_one_reference_may_be_called_anything(folder: Path, tmp_path: Path) -> None:
    shutil.copy(folder / "flat.pgm", tmp_path / "tower.pgm")
    choice = Choice(reference=folder / "flat_truth.json", resolution_m=0.05)
    (trial,) = read_trials(tmp_path / "tower.pgm", choice).trials
    assert trial.name == "tower"
    with pytest.raises(VdoorError, match="reference: wanted one for tower, found flat"):
        read_trials(tmp_path, choice)


def test_one_file_may_hold_the_doors_of_several_maps(folder: Path, tmp_path: Path) -> None:
    """Doors in cells, and places that count for nobody."""
    segment = {"x1": 10, "y1": 20, "x2": 10, "y2": 36}
    table = {"flat": {"doors": [segment], "ignore": [segment]}, "gone": {"doors": []}}
    (tmp_path / "truth.json").write_text(json.dumps(table))
    found = read_trials(folder, Choice(reference=tmp_path / "truth.json"))
    assert found.without_reference == []
    reference = found.trials[0].reference
    assert reference.rooms is None
    assert reference.unsure is not None
    assert reference.doors.centre_m == pytest.approx(np.array([[0.525, 1.425]]))


@pytest.mark.parametrize(
    ("choice", "names"),
    [({"only": ["flat"]}, ["flat", "flat_b"]), ({"only": ["_b"]}, ["flat_b"]), ({"exclude": ["_b"]}, ["flat"])],
)
def test_maps_are_chosen_by_their_names(folder: Path, choice: dict[str, Any], names: list[str]) -> None:
    assert [trial.name for trial in read_trials(folder, Choice(reference=folder, **choice)).trials] == names


def test_bare_map_and_grey_are_those_of_evaluate(tmp_path: Path) -> None:
    """Furniture in the door hides it, unless the truth is looked for on the bare map."""
    grey = np.full((60, 80), 254, np.uint8)
    grey[:, 39:41] = 0
    grey[20:40, 39:41] = 254
    Image.fromarray(grey).save(tmp_path / "lab.png")
    rooms = np.where(grey == 254, 255, 0).astype(np.uint8)
    rooms[:, 39:41] = 0
    Image.fromarray(rooms).save(tmp_path / "lab_gt_segmentation.png")
    grey[15:45, 30:50] = 0
    grey[:, 75:] = 230
    Image.fromarray(grey).save(tmp_path / "lab_full.png")
    common: dict[str, Any] = {"reference": tmp_path, "resolution_m": 0.05, "only": ["full"]}
    assert not len(read_trials(tmp_path, Choice(**common)).trials[0].reference.doors)
    (trial,) = read_trials(tmp_path, Choice(**common, bare=tmp_path, free_from=250)).trials
    assert len(trial.reference.doors) == 1
    assert trial.division.grid.free[:, 75:].all()
    assert not trial.division.free[:, 75:].any()


@pytest.mark.parametrize(
    ("choice", "message"),
    [
        ({"only": ["nothing"]}, "maps: wanted one of 2 maps to be selected, found none"),
        ({"reference": Path("gone.json")}, "found none"),
        ({"free_from": 250}, "--free-from: wanted a map that is a plain image"),
    ],
)
def test_wrong_choices_are_told(folder: Path, choice: dict[str, Any], message: str) -> None:
    with pytest.raises(VdoorError, match=message):
        read_trials(folder, Choice(**{"reference": folder, **choice}))


def test_folder_without_a_map_or_reference_is_told(folder: Path, tmp_path: Path) -> None:
    with pytest.raises(VdoorError, match="maps: wanted a map, found none"):
        read_trials(tmp_path, Choice(reference=folder))
    shutil.copy(folder / "flat.pgm", tmp_path / "tower.pgm")
    with pytest.raises(VdoorError, match="reference: wanted one for tower"):
        read_trials(tmp_path, Choice(reference=folder))


def test_map_on_which_a_run_fails_is_named(trials: list[Trial]) -> None:
    division = trials[0].division
    solid = OccupancyGrid(cells=np.full_like(division.grid.cells, OCCUPIED), frame=division.frame)
    with pytest.raises(MapError, match="flat: the map has no free cell"):
        measured(dataclasses.replace(trials[0], division=dataclasses.replace(division, grid=solid)), PRESETS["paper"])


def test_file_that_is_no_model_is_told_before_the_first_run(tmp_path: Path) -> None:
    (tmp_path / "curves.json").write_text("[]")
    with pytest.raises(SettingError, match=r"score\.model: wanted a file from"):
        variants_with([tmp_path / "curves.json"])


def test_model_is_a_row_of_its_own(tmp_path: Path) -> None:
    shipped = HOME / "vdoor" / "method" / "scoring" / "door_score.json"
    file = Path(shutil.copy(shipped, tmp_path / "seed1.json"))
    _, (model,) = variants_with([file])
    assert model.name == "model seed1.json"
    settings = settings_of(model.of(PRESETS["default"]), METHODS)
    default = settings_of(PRESETS["default"], METHODS)
    assert settings == default | {"score": default["score"] | {"model": str(file)}}


def test_table_and_json() -> None:
    rows = [
        Row(name="as it is", figures={"door_f1": 0.5, "door_f1_difference": 0.0}, worst_map="lab"),
        Row(name="turned", figures={"door_f1": 0.25, "door_f1_difference": -0.25}),
    ]
    lines = list(tables.table(rows, {"F1": "door_f1", "differs": "door_f1_difference", "iou": "iou_sym"}, "maps"))
    assert [line.split() for line in lines] == [
        ["maps", "F1", "differs", "iou", "worst", "map"],
        ["as", "it", "is", "0.500", "+0.000", "-", "lab"],
        ["turned", "0.250", "-0.250", "-", "-"],
    ]
    told = tables.document(rows, [], "default", 3)
    assert json.loads(json.dumps(told, allow_nan=False)) == told
    assert [row["name"] for row in told["rows"]] == ["as it is", "turned"]


def test_commands_print_a_row_each(folder: Path, command: Command) -> None:
    """Progress goes to stderr, one table or one JSON to stdout."""
    told = command("robust", folder, "--reference", folder, "--exclude", "_b")
    assert [line[:22].strip() for line in told.out.splitlines()] == ["maps", *(change.name for change in CHANGES)]
    assert told.err.count("door F1") == len(CHANGES)
    told = command("ablate", folder, "--reference", folder, "--exclude", "_b", "--json", "--quiet")
    assert not told.err
    assert [row["name"] for row in told.json["rows"]] == [variant.name for variant in VARIANTS]
    assert [entry["name"] for entry in told.json["maps"]] == ["flat"]
    assert {"door_f1", "pooled_door_f1", "iou_sym", "cpu_s", "cpu_max_s"} < told.json["rows"][0]["figures"].keys()


@pytest.mark.parametrize("name", ["ablate", "robust"])
def test_wrong_input_is_one_line_and_exit_code_2(folder: Path, command: Command, name: str) -> None:
    told = command(name, folder / "gone", "--reference", folder)
    assert told.code == 2
    assert len(told.err.splitlines()) == 1
    assert not told.out
