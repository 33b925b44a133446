"""Walls and zones that a robot has already stay in what it is sent, and in the report of a folder."""

from __future__ import annotations

import json
from pathlib import Path

import commands
import finished_maps
import numpy as np
import pytest
from vacuum import FLAT, centre_cm, home, write_home

from vdoor.export import read_finished

AREA = [*centre_cm(1, 5), *centre_cm(1, 7), *centre_cm(3, 7), *centre_cm(3, 5)]
MOP = [*centre_cm(1, 14), *centre_cm(1, 16), *centre_cm(3, 16), *centre_cm(3, 14)]
WALL = [*centre_cm(6, 13), *centre_cm(6, 20)]
BIG = "\n".join(sign for line in FLAT.split() for sign in ["".join(c * 4 for c in line)] * 4)
"""The flat four times as large, so that it has rooms."""


@pytest.fixture
def runs(tmp_path: Path, command: commands.Command) -> Path:
    """A result folder `r` and a recording `r.mcap` of a home with a wall and two zones, and what `run` exported."""
    path = write_home(tmp_path / "h.json", home(BIG, virtual_wall=WALL, no_go_area=AREA, no_mop_area=MOP))
    exports = [f"--export={name}={tmp_path / name}" for name in ("virtual-walls", "report")]
    assert command("run", path, "--out", tmp_path / "r", "--mcap", tmp_path / "r.mcap", *exports).code == 0
    return tmp_path


def points(flat_cm: list[float]) -> list[dict[str, int]]:
    return [{"x": round(x), "y": round(y)} for x, y in np.array(flat_cm).reshape(-1, 2).tolist()]


def test_the_robots_walls_and_zones_come_first(runs: Path, command: commands.Command) -> None:
    sent = command("export", runs / "r", "--to", "virtual-walls")
    assert sent.out == command("export", runs / "r.mcap", "--to", "virtual-walls").out
    assert sent.out == (runs / "virtual-walls").read_text()
    first, *doors = [[*wall["points"].values()] for wall in sent.json["virtualWalls"]]
    assert len(doors) == len(read_finished(runs / "r").topology.doors) > 0
    assert first == points(WALL)
    zones = [([*zone["points"].values()], zone["type"]) for zone in sent.json["restrictedZones"]]
    assert zones == [(points(AREA), "regular"), (points(MOP), "mop")]
    assert "the robot replaces all its walls and zones by this list; 3 of its own are in it" in sent.err


def test_a_map_without_such_a_list_says_that_it_is_not_known(tmp_path: Path, command: commands.Command) -> None:
    assert (
        "its own are not known"
        in command("export", finished_maps.result("flat", tmp_path / "r"), "--to", "virtual-walls").err
    )


def test_the_report_of_a_folder_shows_them_as_that_of_a_recording_does(runs: Path, command: commands.Command) -> None:
    layers = {}
    for source in ("r", "r.mcap"):
        assert command("export", runs / source, "--to", "report", "-o", runs / f"{source}.html").code == 0
        page = (runs / f"{source}.html").read_text()
        data = json.loads(page.split('type="application/json" id="data">')[1].split("</script>")[0])
        layers[source] = [layer for layer in data["layers"] if layer["id"] == "restrictions"]
    assert layers["r"] == layers["r.mcap"]
    assert [len(layer["shapes"]) for layer in layers["r"]] == [3]


def test_a_folder_gives_back_all_that_the_robot_says(runs: Path) -> None:
    folder, recording = (read_finished(runs / name).annotations for name in ("r", "r.mcap"))
    assert folder is not None
    assert recording is not None
    assert np.array_equal(folder.labels, recording.labels)  # type: ignore[arg-type]  # both have segments
    for name in ("own_origin_cm", "robot_m", "segments", "virtual_walls_m", "no_go_areas_m", "no_mop_areas_m"):
        assert getattr(folder, name) == getattr(recording, name)
