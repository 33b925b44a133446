"""What changed between two results, in rooms, doors and metres: `diff` and `verify --only map`."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import commands
import finished_maps
import project
import small_recording

import vdoor
from vdoor.matching.result_changes import result_changes
from vdoor.recording.mcap import read_recording

GOLDEN = project.HOME / "recordings" / "golden" / "plain.mcap"


def test_nothing_changed_in_the_same_map() -> None:
    assert result_changes(finished_maps.topology("flat"), finished_maps.topology("flat")) == []


def test_a_merge_is_told_from_both_sides() -> None:
    before = finished_maps.topology("flat")
    door = before.doors[0]
    middle = "{},{}".format(*((a + b) / 2 for a, b in zip(door.start_m, door.end_m, strict=True)))
    after = vdoor.edited(before, [f"remove-door {middle}"])
    (one, other), (kept,) = door.rooms, set(door.rooms) & set(after.room_ids)
    lines = result_changes(before, after)
    assert lines[0] == f"rooms {one} and {other} were merged into room {kept}"
    assert [line.split(" at ")[0] for line in lines[1:]] == ["door 1"]
    assert lines[1].endswith(" went")
    back = result_changes(after, before)
    assert back[0] == f"room {kept} was split into rooms {one} and {other}"
    assert back[1].endswith(" came")


def test_a_door_that_moved_by_less_than_the_tolerance_is_the_same() -> None:
    flat = finished_maps.topology("flat")
    start_m = flat.start_m.copy()
    start_m[1] += (0.03, 0.04)
    moved = dataclasses.replace(flat, start_m=start_m)
    assert result_changes(flat, moved) == ["door 2 moved by 0.050 m"]
    assert result_changes(flat, moved, within_m=0.06) == []


def test_verify_of_the_map_alone_forgives_an_inner_number_and_no_door(
    tmp_path: Path, command: commands.Command
) -> None:
    records = small_recording.read(GOLDEN)
    info = read_recording(GOLDEN, types=small_recording.RECORDS).info
    curvature = next(at for at, record in enumerate(records) if record.topic == "curvature")
    angle_rad = records[curvature].angle_rad + 0.01  # type: ignore[attr-defined]  # it is a Curvature
    records[curvature] = dataclasses.replace(records[curvature], angle_rad=angle_rad)  # type: ignore[type-var]
    inner = small_recording.write(tmp_path / "inner.mcap", records, info)
    assert command("verify", inner).code == 1
    assert command("verify", inner, "--only", "map").code == 0
    start_m = records[-1].start_m + 0.2  # type: ignore[attr-defined]  # it is a TopologicalMap
    records[-1] = dataclasses.replace(records[-1], start_m=start_m)  # type: ignore[type-var]
    doors = small_recording.write(tmp_path / "doors.mcap", records, info)
    done = command("verify", doors, "--only", "map", "--within", "0.1", "--junit", tmp_path / "j.xml")
    assert done.code == 1
    assert "door 1 moved by 0.283 m" in done.out
    assert "door 1 moved by 0.283 m" in (tmp_path / "j.xml").read_text()
    assert command("verify", doors, "--only", "map", "--within", "0.3").code == 0
    assert command("diff", GOLDEN, doors).out.startswith("door 1 moved by 0.283 m\n")
    assert command("verify", doors, "--within", "0.3").code == 2
