"""`vdoor run MAP` and `vdoor.run(vdoor.read_map(MAP))` are one: one preset, one preparation of the map."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from bags import bare_mcap, grid_message
from commands import Command, call
from maps import text_of
from PIL import Image
from project import HOME
from small_recording import write
from vacuum import centre_cm, home, write_home

import vdoor
from vdoor.api import prepared
from vdoor.config import DEFAULT_PRESET, settings_of, to_toml
from vdoor.editing.edits import appended, parse
from vdoor.editing.places import place_text
from vdoor.emit import RunInfo
from vdoor.export import save
from vdoor.grid import FREE, UNKNOWN, OccupancyGrid
from vdoor.method.simplify import SimplifiedGrid
from vdoor.pipeline import METHODS, PRESETS, RECORDS
from vdoor.record import Record
from vdoor.recording.mcap import read_recording
from vdoor.synth import PRESETS as KINDS
from vdoor.synth import synthesize

Cells = np.ndarray[tuple[int, int], np.dtype[np.int8]]


def two_homes(**entities: list[float]) -> dict[str, Any]:
    """A robot's map of its home and, apart from it, of the one next door that it looked into."""
    cells = synthetic("home", 5)
    return home(text_of(np.hstack([cells, np.full((len(cells), 3), UNKNOWN, np.int8), cells])), **entities)


def synthetic(kind: str, seed: int) -> Cells:
    cells: Cells = synthesize(KINDS[kind], np.random.default_rng(seed)).grid.cells
    return cells


def at_home(part: int) -> list[float]:
    """A free place with free ones around it in the home (0) or next door (1)."""
    cells = synthetic("home", 5)
    rows, cols = np.nonzero(cells[20:-20, 20:-20] == FREE)
    middle = len(rows) // 2
    return centre_cm(int(rows[middle]) + 20, int(cols[middle]) + 20 + part * (cells.shape[1] + 3))


NOWHERE = centre_cm(1000, 1000)
HOMES: dict[str, dict[str, list[float]]] = {
    "nobody": {},
    "robot": {"robot_position": at_home(1)},
    "charger": {"charger_location": at_home(0)},
    "robot lost": {"robot_position": NOWHERE, "charger_location": at_home(1)},
    "restrictions": {
        "robot_position": at_home(0),
        "virtual_wall": [*at_home(0), *centre_cm(60, 60)],
        "no_go_area": [*at_home(0), *centre_cm(60, 60), *centre_cm(60, 70)],
    },
}


def bag(folder: Path) -> Path:
    message = grid_message(synthetic("paper-5cm", 2), at_m=(-3.0, 1.5))
    return bare_mcap(folder / "bag.mcap", [("/map", 1, message)])


def array(folder: Path) -> Path:
    np.save(folder / "office.npy", synthetic("office", 2))
    return folder / "office.npy"


MAPS: dict[str, Callable[[Path], Path]] = {
    **{name: lambda _, name=name: HOME / "recordings" / f"{name}.yaml" for name in ("flat", "furnished", "turned")},
    "bag": bag,
    "array": array,
    "golden": lambda _: HOME / "recordings" / "golden" / "rotated.mcap",
    **{
        f"home, {name}": lambda folder, name=name: write_home(folder / "home.json", two_homes(**HOMES[name]))
        for name in HOMES
    },
}


def same(folder: Path, topology: vdoor.TopologicalMap) -> None:
    """Claim that a result folder holds this very map."""
    assert np.array_equal(np.asarray(Image.open(folder / "rooms.png")), topology.labels)
    document = json.loads((folder / "map.json").read_text())
    for name, found in (("doors", topology.doors), ("rooms", topology.rooms)):
        told = json.loads(json.dumps([dataclasses.asdict(one) for one in found]))
        keys = told[0].keys() - {"corners"} if told else ()
        assert [{key: one[key] for key in keys} for one in document[name]] == [
            {key: one[key] for key in keys} for one in told
        ]
    assert document["preset"] == DEFAULT_PRESET


@pytest.mark.parametrize("name", MAPS)
@pytest.mark.filterwarnings("ignore::vdoor.MapWarning")
def test_command_and_python_find_the_same_rooms_and_doors(name: str, tmp_path: Path) -> None:
    path = MAPS[name](tmp_path)
    call("run", path, "--out", tmp_path / "out", "-q")
    same(tmp_path / "out", vdoor.run(vdoor.read_map(path)))


def test_both_homes_are_kept_wherever_the_robot_is(tmp_path: Path) -> None:
    """Its place says where it is, not what there is."""
    areas_m2 = {}
    for name in ("nobody", "robot", "charger", "robot lost"):
        path = write_home(tmp_path / f"{name}.json", two_homes(**HOMES[name]))
        labels = vdoor.run(vdoor.read_map(path)).labels > 0
        half = labels.shape[1] // 2
        areas_m2[name] = bool(labels[:, :half].any()), bool(labels[:, half:].any())
    assert set(areas_m2.values()) == {(True, True)}


def test_settings_of_the_command_start_from_pythons_preset() -> None:
    assert call("config").stdout == to_toml(PRESETS[DEFAULT_PRESET], METHODS)


def test_other_presets_and_a_place_that_is_set_are_one_as_well(tmp_path: Path, command: Command) -> None:
    path = write_home(tmp_path / "home.json", two_homes(**HOMES["robot"]))
    grid = vdoor.read_map(path)
    (x_cm, y_cm), said = at_home(0), prepared(PRESETS["paper"], grid).pipeline.simplify.robot_m
    own = said[0] - (at_home(1)[0] - x_cm) / 100, said[1] + (at_home(1)[1] - y_cm) / 100
    paper = dataclasses.replace(PRESETS["paper"], simplify=dataclasses.replace(PRESETS["paper"].simplify, robot_m=own))
    for words, preset in (
        ((), "paper"),
        (("--robot", f"{own[0]},{own[1]}"), paper),
        (("--set", f"simplify.robot_m={list(own)}"), paper),
    ):
        command("run", path, "--preset", "paper", *words, "--out", tmp_path / "out", "-q", "--force")
        labels = np.asarray(Image.open(tmp_path / "out" / "rooms.png"))
        assert np.array_equal(labels, vdoor.run(grid, preset).labels)
        assert (labels[:, : labels.shape[1] // 2] > 0).any() == bool(words)


def test_a_place_that_cannot_be_is_a_note_and_a_warning(tmp_path: Path) -> None:
    path = write_home(tmp_path / "home.json", two_homes(robot_position=NOWHERE))
    told = "the robot's position in the map file is not free; using the largest free space"
    assert call("run", path).stderr == f"vdoor: note: {told}\n"
    with pytest.warns(vdoor.MapWarning, match=told) as seen:
        vdoor.run(vdoor.read_map(path))
    assert [warning.filename for warning in seen] == [__file__]


def test_to_prepare_twice_changes_nothing(tmp_path: Path) -> None:
    for entities in HOMES.values():
        grid = vdoor.read_map(write_home(tmp_path / "home.json", two_homes(**entities)))
        once = prepared(PRESETS[DEFAULT_PRESET], grid).pipeline
        assert prepared(once, grid).pipeline == once


def kept(pipeline: Any, grid: OccupancyGrid) -> list[Record]:
    """All records of a pipeline that is done just as its settings are."""
    records: list[Record] = []

    def emit(record: Any, /) -> Any:
        records.append(record)
        return record

    pipeline(grid, np.random.default_rng(0), emit)
    return records


def test_a_recording_is_done_again_with_its_own_place_or_none(tmp_path: Path, command: Command) -> None:
    """A recorded run that took no place from its file, as once from Python, takes none when it is verified."""
    path = write_home(tmp_path / "home.json", two_homes(**HOMES["robot"]))
    grid, free = vdoor.read_map(path), {}
    bare = PRESETS[DEFAULT_PRESET]
    for name, pipeline in (("bare", bare), ("placed", prepared(bare, grid).pipeline)):
        settings = settings_of(pipeline, METHODS)
        info = RunInfo(version=vdoor.__version__, preset=DEFAULT_PRESET, seed=0, settings=settings, source=grid.source)
        recording = write(tmp_path / f"{name}.mcap", kept(pipeline, grid), info)
        assert command("verify", recording).code == 0
        records = [record for _, record in read_recording(recording, types=RECORDS)]
        (simplified,) = (record for record in records if isinstance(record, SimplifiedGrid))
        free[name] = int((simplified.cells == FREE).sum())
    assert free["bare"] == free["placed"]
    command("run", path, "--mcap", tmp_path / "command.mcap", "-q")
    assert (tmp_path / "command.mcap").read_bytes() == (tmp_path / "placed.mcap").read_bytes()


def test_virtual_walls_are_in_the_robots_frame_from_both(tmp_path: Path) -> None:
    path = write_home(tmp_path / "home.json", two_homes(**HOMES["robot"]))
    call("run", path, "--export", f"virtual-walls={tmp_path / 'command.json'}", "-q")
    save(vdoor.run(vdoor.read_map(path)), tmp_path / "python.json", "virtual-walls")
    assert (tmp_path / "python.json").read_text() == (tmp_path / "command.json").read_text()


def test_older_rooms_are_found_by_the_robots_frame_from_both(tmp_path: Path, command: Command) -> None:
    """The home next door looks the same: which of the two the older map shows, its place in the robot's frame says."""
    cells = synthetic("home", 5)
    there = np.hstack([np.full((len(cells), cells.shape[1] + 3), UNKNOWN, np.int8), cells])
    old = write_home(tmp_path / "old.json", home(text_of(there)))
    new = write_home(tmp_path / "new.json", two_homes())
    before, after = (vdoor.run(vdoor.read_map(path)) for path in (old, new))
    kitchen = f"name {place_text(before.rooms[0].centre_m)} Kitchen"
    (tmp_path / "mine.toml").write_bytes(appended(tmp_path / "mine.toml", [parse(kitchen)]))
    command("run", old, "--edits", tmp_path / "mine.toml", "--out", tmp_path / "old", "-q")
    told = command("run", new, "--match", tmp_path / "old", "--json", "-q").json
    match = vdoor.match(vdoor.edited(before, [kitchen]), after)
    assert list(match.alignment.shift_m) == told["match"]["shift_m"]
    named = vdoor.edited(after, match.edits)
    assert {room.id: room.name for room in named.rooms} == {room["id"]: room["name"] for room in told["rooms"]}
    assert named.room_named("Kitchen").centre_m[0] > after.frame.width / 2 * after.frame.resolution_m
