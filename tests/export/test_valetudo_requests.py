"""Requests for a robot with Valetudo, and what rooms take from its segments: on homes drawn so that both are known."""

from __future__ import annotations

import json
import shlex
from pathlib import Path

import commands
import numpy as np
import pytest
from vacuum import FLAT, home, write_home

from vdoor.export.valetudo import covering


def large(text: str) -> str:
    """A drawing four times as large, so that it has rooms."""
    return "\n".join(line for row in text.split() for line in ["".join(sign * 4 for sign in row)] * 4)


def run(folder: Path, text: str, command: commands.Command) -> Path:
    path = write_home(folder / "h.json", home(large(text)))
    assert command("run", path, "--out", folder / "r").code == 0
    return folder / "r"


def test_rooms_that_are_segments_take_their_names_and_are_cleaned_by_id(
    tmp_path: Path, command: commands.Command
) -> None:
    result = run(tmp_path, FLAT, command)
    rooms = command("rooms", result, "--json").json["rooms"]
    assert [(room["name"], room.get("segment")) for room in rooms] == [("Flur", "97"), ("Flur", "98")]
    done = command("valetudo", result, "--clean", "2", "--clean", "1")
    body = {"action": "start_segment_action", "segment_ids": ["98", "97"], "iterations": 1, "customOrder": True}
    assert done.json == body
    (line,) = done.err.splitlines()
    words = shlex.split(line)
    assert json.loads(words[words.index("--data") + 1]) == body
    assert words[-1].endswith("/capabilities/MapSegmentationCapability")
    assert command("rename", result, "1", "Kitchen").code == 0
    assert command("rooms", result, "--json").json["rooms"][0]["name"] == "Kitchen"
    assert command("valetudo", result, "--segments").out == ""


def test_a_segment_of_two_rooms_is_split_at_the_door_and_its_rooms_are_cleaned_by_zones(
    tmp_path: Path, command: commands.Command
) -> None:
    result = run(tmp_path, FLAT.replace("b", "a"), command)
    split = command("valetudo", result, "--segments").json
    assert (split["action"], split["segment_id"]) == ("split_segment", "97")
    table = json.loads((result / "map.json").read_text())
    left_cm, bottom_cm = table["annotations"]["own_origin_cm"]
    (door,) = table["doors"]
    ends = {(round(left_cm + 100 * x), round(bottom_cm - 100 * y)) for x, y in (door["start_m"], door["end_m"])}
    apart = [min(np.hypot(split[end]["x"] - x, split[end]["y"] - y) for x, y in ends) for end in ("pA", "pB")]
    assert max(apart) <= 5  # a passage's line is half a cell longer at either end
    zones = command("valetudo", result, "--clean", "1").json["zones"]
    assert 1 <= len(zones) <= 5
    assert set(zones[0]["points"]) == {"pA", "pB", "pC", "pD"}


def test_segments_of_one_room_are_joined(tmp_path: Path, command: commands.Command) -> None:
    rows = [row[:16] + row[16:].replace("b", "c") for row in FLAT.split()]
    result = run(tmp_path, "\n".join(rows), command)
    joined = command("valetudo", result, "--segments").json
    assert joined == {"action": "join_segments", "segment_a_id": "98", "segment_b_id": "99"}


def test_boxes_cover_every_cell_and_an_l_with_two_boxes_nothing_else() -> None:
    mask = np.zeros((9, 9), np.bool_)
    mask[1:8, 1:4] = mask[5:8, 1:8] = True
    boxes = covering(mask)
    covered = np.zeros_like(mask)
    for top, left, bottom, right in boxes:
        covered[top:bottom, left:right] = True
    assert len(boxes) == 2
    assert np.array_equal(covered, mask)
    assert len(covering(np.eye(9, dtype=np.bool_), most=3)) == 3


@pytest.mark.parametrize("words", [(), ("--segments", "--clean", "1"), ("--clean", "Den")])
def test_wrong_use_is_one_line(words: tuple[str, ...], tmp_path: Path, command: commands.Command) -> None:
    done = command("valetudo", run(tmp_path, FLAT, command), *words)
    assert (done.code, done.out, len(done.err.splitlines())) == (2, "", 1)
