"""`vdoor verify` and the golden recordings: planted changes are caught at their stage, and nothing else is."""

from __future__ import annotations

import dataclasses
import shutil
from pathlib import Path
from xml.etree import ElementTree as ET

import numpy as np
import pytest
from commands import Command
from project import GOLDEN
from small_recording import PIPELINE, altered, small, small_run, write

from vdoor import goldens
from vdoor.emit import RunInfo
from vdoor.errors import MapError, SettingError
from vdoor.grid import OccupancyGrid, Source
from vdoor.method.search.generation import Generation
from vdoor.pipeline import RECORDS
from vdoor.record import Record
from vdoor.recording.diff import Pair, verify
from vdoor.recording.mcap import read_recording


def differing(command: Command, path: Path) -> dict[str, int]:
    """Give the stages that differ, and how many elements in each."""
    done = command("verify", path, "--json")
    (result,) = done.json
    assert (done.code, result["verdict"]) in ((0, "equal"), (1, "differs"))
    return {stage["topic"]: stage["elements"] for stage in result["comparison"]["stages"] if stage["differing"]}


def test_a_recording_verifies(tmp_path: Path, command: Command) -> None:
    path = small(tmp_path / "small.mcap")
    done = command("verify", path)
    assert done == (0, f"equal       {path}  13 records\n", "")
    assert differing(command, path) == {}


def test_a_micrometre_in_one_field_is_caught_where_it_is(tmp_path: Path, command: Command) -> None:
    path = write(tmp_path / "small.mcap", altered("path", "arc_m", 3, lambda arc_m: arc_m + 1e-6))
    assert differing(command, path) == {"path": 1}
    head, _, name, stage, worst = command("verify", path).out.splitlines()
    assert head == f"differs     {path}  from path on"
    assert name == f"{path}:"
    assert stage == "  path differs first: 1 element"
    assert worst.startswith("    arc_m: 1 of 44 differ, worst at 3 (cell 0,4; 0.900,1.500 m): recorded 0.600001")
    assert worst.endswith(" apart")


def test_what_is_within_the_tolerance_is_equal(tmp_path: Path, command: Command) -> None:
    path = write(tmp_path / "small.mcap", altered("path", "arc_m", 3, lambda arc_m: arc_m + 1e-10))
    assert differing(command, path) == {}


@pytest.mark.parametrize(("topic", "field"), [("input", "cells"), ("simplified", "cells"), ("map", "labels")])
def test_one_flipped_cell_is_caught_where_it_is(topic: str, field: str, tmp_path: Path, command: Command) -> None:
    path = write(tmp_path / "small.mcap", altered(topic, field, (3, 4), lambda cell: 1 if cell == 0 else 0))
    assert differing(command, path) == {topic: 1}
    assert "first at 3, 4 (cell 3,4; " in (out := command("verify", path).out) or "worst at 3, 4 (cell 3,4; " in out
    assert "0.900,0.900 m)" in out


@pytest.mark.parametrize("topic", [record.topic for record in PIPELINE.records])
def test_a_change_in_any_stage_is_caught_at_that_stage(topic: str, tmp_path: Path, command: Command) -> None:
    fields = {
        "input": ("cells", (0, 0)),
        "simplified": ("reason", (2, 2)),
        "path": ("heading", 5),
        "curvature": ("angle_rad", 7),
        "candidates": ("convex", 0),
        "corners": ("sample", 1),
        "doors": ("verdict", 0),
        "initial_map": ("area_m2", 0),
        "generation": ("removed", 0),
        "map": ("area_m2", 0),
    }
    name, index = fields[topic]
    path = write(tmp_path / "small.mcap", altered(topic, name, index, lambda was: 1 if was == 0 else 0))
    assert differing(command, path) == {topic: 1}


def test_a_generation_more_or_less_is_caught(tmp_path: Path, command: Command) -> None:
    _, records = small_run()
    last = max(i for i, record in enumerate(records) if isinstance(record, Generation))
    more = write(tmp_path / "more.mcap", [*records[: last + 1], records[last], *records[last + 1 :]])
    assert differing(command, more) == {"generation": 0}
    assert "generation differs first: recorded 5, now 4 records; 1 differ, 0 elements" in command("verify", more).out
    less = write(tmp_path / "less.mcap", [*records[:last], *records[last + 1 :]])
    assert "generation differs first: recorded 3, now 4 records; 1 differ, 0 elements" in command("verify", less).out
    assert "    in record 3 of this stage:\n    only now\n" in command("verify", less).out


@pytest.mark.parametrize(
    ("name", "value", "first"),
    [
        ("simplify.passes", 0, None),
        ("simplify.cell_m", 0.4, "simplified"),
        ("curvature.reach_m", 0.6, "curvature"),
        ("candidates.angle_deg", 60.0, "candidates"),
        ("doors.max_length_m", 0.3, "doors"),
        ("search.generations", 4, "generation"),
        ("search.population", 9, "generation"),
    ],
)
def test_a_changed_setting_is_caught_at_its_stage(
    name: str, value: float, first: str | None, tmp_path: Path, command: Command
) -> None:
    info, records = small_run()
    stage, _, setting = name.partition(".")
    settings = {**info.settings, stage: {**info.settings[stage], setting: value}}
    path = write(tmp_path / "small.mcap", records, dataclasses.replace(info, settings=settings))
    assert next(iter(differing(command, path)), None) == first


def test_another_seed_is_caught_in_the_search(tmp_path: Path, command: Command) -> None:
    info, records = small_run()
    path = write(tmp_path / "small.mcap", records, dataclasses.replace(info, seed=6))
    assert next(iter(differing(command, path))) == "generation"


def test_a_grid_without_files_is_run_again_from_its_cells(tmp_path: Path, command: Command) -> None:
    info, records = small_run()
    path = write(tmp_path / "small.mcap", records, dataclasses.replace(info, source=Source()))
    assert differing(command, path) == {}


def test_a_run_that_is_refused_half_way_differs_and_one_that_never_starts_is_an_error(tmp_path: Path) -> None:
    recording = read_recording(small(tmp_path / "small.mcap"), types=RECORDS)
    grid = small_run()[1][0]

    def refuse(_: object, emit: object) -> None:
        emit(grid)  # type: ignore[operator]  # it is an Emit
        raise MapError("nothing to divide")

    report = verify(recording, refuse)
    assert not report.equal
    assert report.stopped == "nothing to divide"
    assert report.first is not None
    assert report.first.topic == "simplified"

    def refuse_at_once(_: object, __: object) -> None:
        raise SettingError("no such setting")

    with pytest.raises(SettingError, match="no such setting"):
        verify(recording, refuse_at_once)


def test_a_listener_gets_both_records_of_each_pair(tmp_path: Path) -> None:
    recording = read_recording(small(tmp_path / "small.mcap"), types=RECORDS)
    pairs: list[Pair] = []
    grid = small_run()[1][0]
    assert isinstance(grid, OccupancyGrid)
    verify(recording, lambda run, emit: PIPELINE(grid, np.random.default_rng(run.info.seed), emit), listen=pairs.append)
    assert [pair.topic for pair in pairs] == [record.topic for record in small_run()[1]]
    assert all(pair.expected is not None and pair.found is not None and not pair.differs for pair in pairs)


def test_files_and_folders_give_a_table_json_and_junit(tmp_path: Path, command: Command) -> None:
    folder = tmp_path / "folder"
    (folder / "deeper").mkdir(parents=True)
    equal = small(folder / "deeper" / "equal.mcap")
    differs = write(folder / "differs.mcap", altered("path", "arc_m", 3, lambda arc_m: arc_m + 1e-6))
    torn = tmp_path / "torn.mcap"
    torn.write_bytes(equal.read_bytes()[:-20])
    done = command("verify", folder, torn, "--junit", tmp_path / "junit.xml")
    assert [line.split()[0] for line in done.out.splitlines()[:3]] == ["equal", "differs", "unreadable"]
    assert done.code == 2
    assert done.err == f"vdoor: recording: wanted a complete MCAP file, found it cut short: {torn}\n"
    (suite,) = ET.parse(tmp_path / "junit.xml").getroot()  # noqa: S314  # our own file
    assert suite.attrib == {"name": "vdoor verify", "tests": "3", "failures": "1", "errors": "1"}
    assert [(case.get("name"), [part.tag for part in case]) for case in suite] == [
        (str(equal), []),
        (str(differs), ["failure"]),
        (str(torn), ["error"]),
    ]
    assert "arc_m: 1 of 44 differ" in (suite[1][0].text or "")
    assert command("verify", folder).code == 1
    assert command("verify", folder / "deeper").code == 0


def test_an_empty_folder_is_no_success(tmp_path: Path, command: Command) -> None:
    assert command("verify", tmp_path) == (2, "", f"vdoor: folder: wanted .mcap files, found none: {tmp_path}\n")


@pytest.mark.parametrize("name", goldens.MAPS)
def test_every_golden_verifies(name: str, command: Command) -> None:
    path = GOLDEN / f"{name}.mcap"
    assert path.stat().st_size < 300_000
    assert command("verify", path).code == 0


def test_there_are_no_other_goldens() -> None:
    assert {path.name for path in GOLDEN.iterdir()} == {f"{name}.mcap" for name in goldens.MAPS}


@pytest.fixture
def two_goldens(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Path:
    """Give a folder with two of the goldens, which are all there are."""
    monkeypatch.setattr(goldens, "MAPS", {name: goldens.MAPS[name] for name in ("crossing", "one-room")})
    for name in goldens.MAPS:
        shutil.copy(GOLDEN / f"{name}.mcap", tmp_path)
    return tmp_path


def test_goldens_made_anew_are_the_same_bytes(two_goldens: Path, command: Command) -> None:
    before = {path.name: path.read_bytes() for path in two_goldens.iterdir()}
    done = command("golden", two_goldens)
    assert [line.split(",")[0] for line in done.out.splitlines()] == ["crossing: unchanged", "one-room: unchanged"]
    assert {path.name: path.read_bytes() for path in two_goldens.iterdir()} == before


def test_what_changes_in_a_golden_is_printed(two_goldens: Path, command: Command) -> None:
    old = read_recording(two_goldens / "crossing.mcap", types=RECORDS)
    records: list[Record] = [record for _, record in old]
    info: RunInfo = dataclasses.replace(old.info, seed=9)
    write(two_goldens / "crossing.mcap", [record for record in records if record.topic != "doors"], info)
    (two_goldens / "one-room.mcap").write_text("no recording")
    lines = command("golden", two_goldens).out.splitlines()
    assert lines[0].startswith("crossing: changed, ")
    assert lines[1:3] == [
        "  seed: before 9, now 0",
        "  doors differs first: before 0, now 1 records; 1 differ, 0 elements",
    ]
    assert lines[3] == "    only now"
    assert lines[4].startswith("one-room: replaced, ")
    assert "wanted an MCAP file, found another file" in lines[4]
    assert command("verify", two_goldens).code == 0
