"""`vdoor route` and `vdoor order`: what they print, write and put on record, on results, recordings and maps."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import commands
import numpy as np
import pytest
import vacuum
import yaml
from mcap.reader import make_reader

import vdoor.cli
from vdoor.navigate.find_route import Route
from vdoor.pipeline import RECORDS
from vdoor.recording import ros
from vdoor.recording.mcap import read_recording
from vdoor.results.known_map import TABLES

FLAT = Path(__file__).parents[2] / "recordings" / "flat.yaml"
WAY = ["1", "4"]


class Command:
    """The command, called in this process, with the exit code that is wanted."""

    def __init__(self, call: commands.Command) -> None:
        self._call = call

    def __call__(self, *words: str | Path, code: int = 0) -> commands.Done:
        done = self._call(*words)
        assert done.code == code, done
        return done


@pytest.fixture
def command() -> Command:
    return Command(commands.Command())


@pytest.fixture(scope="module")
def flat(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a result and a recording of the example map."""
    folder = tmp_path_factory.mktemp("flat")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("sys.argv", ["vdoor", "run", str(FLAT), "--out", f"{folder}/res", "--mcap", f"{folder}/a.mcap"])
        with pytest.raises(SystemExit):
            vdoor.cli.main()
    return folder


def test_result_recording_and_map_give_the_same_route(flat: Path, command: Command) -> None:
    told = [command("route", source, *WAY, "--json").json for source in (flat / "res", flat / "a.mcap", FLAT)]
    assert told[0] == told[1] == told[2]
    assert told[0]["found"]
    assert told[0]["doors"] == [1, 2, 3, 4]
    assert told[0]["clear_m"] >= 0.17
    assert told[0]["path"][-1]["along_m"] == pytest.approx(told[0]["length_m"])
    assert (flat / "res" / TABLES).is_file()
    assert (flat / f"a.mcap.{TABLES}").is_file()
    again = command("route", flat / "res", *WAY, "--json").json  # with the distances that are kept
    assert again == told[0]


def test_no_way_is_exit_code_1_and_says_what_is_in_the_way(flat: Path, command: Command) -> None:
    told = command("route", flat / "res", *WAY, "--closed", "2", "--json", code=1).json
    assert [(item["kind"], item["id"]) for item in told["in_the_way"]] == [("closed door", 2)]
    assert told["length_m"] is None
    text = command("route", flat / "res", *WAY, "--robot-radius", "0.35", code=1).out
    assert text.startswith("no way with a clearance of 0.35 m: door 1 at 4.90,6.50 leaves 0.300 m; door 2")


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (["1", "9"], "goal: wanted one of 1, 2, 3, 4, 5, found 9"),
        (["1", "Kitchen"], "goal: wanted a room's id, its name or X,Y, found 'Kitchen'"),
        (["1", "0,0"], "goal: wanted a place within 0.17 m of where the robot fits, found none near 0,0"),
        (["1", "4", "--closed", "7"], "closed: wanted one of the map's 4 doors, found 7"),
        (["1", "4", "--export", "kml=a"], "--export: wanted FORMAT=FILE with csv, geojson, waypoints, found 'kml=a'"),
        (["1", "4", "--mcap", "a.mcap"], "--save, --mcap: wanted a recording or a map, found a result folder"),
    ],
)
def test_wrong_use_is_one_line_that_names_the_file(
    words: list[str], says: str, flat: Path, command: Command, tmp_path: Path
) -> None:
    words = [word.replace("a.mcap", str(tmp_path / "a.mcap")) for word in words]
    told = command("route", flat / "res", *words, code=2).err
    assert told.startswith(f"vdoor: {says}")
    assert "--export" in words or told.rstrip().endswith(str(flat / "res"))
    assert told.count("\n") == 1


def test_a_moved_start_is_noted(flat: Path, command: Command) -> None:
    told = command("route", flat / "res", "2.9,5.15", "4")
    assert told.err.startswith("vdoor: note: FROM: moved by 0.15 m to 2.90,5.30, where the robot fits")


def test_paths_as_files_say_the_same(flat: Path, command: Command, tmp_path: Path) -> None:
    words = [f"--export={name}={tmp_path / name}" for name in ("csv", "geojson", "waypoints")]
    told = command("route", flat / "res", *WAY, "--json", *words).json
    wanted = [[bend["x_m"], bend["y_m"]] for bend in told["path"]]
    rows = list(csv.DictReader((tmp_path / "csv").read_text().splitlines()))
    assert np.allclose([[float(row["x_m"]), float(row["y_m"])] for row in rows], wanted, atol=1e-9)
    feature = json.loads((tmp_path / "geojson").read_text())["features"][0]
    assert feature["geometry"] == {"type": "LineString", "coordinates": wanted}
    assert feature["properties"]["length_m"] == told["length_m"]
    waypoints = yaml.safe_load((tmp_path / "waypoints").read_text())["waypoints"]
    for number, (x_m, y_m) in enumerate(wanted):
        w, _, _, z = waypoints[f"waypoint{number}"]["orientation"]
        assert waypoints[f"waypoint{number}"]["pose"] == [x_m, y_m, 0.0]
        assert 2 * np.arctan2(z, w) == pytest.approx(told["path"][number]["yaw_rad"], abs=6e-5)
        assert float(rows[number]["yaw_rad"]) == pytest.approx(told["path"][number]["yaw_rad"], abs=1e-6)
    again = command("route", flat / "res", *WAY, words[0], code=2).err
    assert "already exists, --force overwrites it" in again


def test_a_route_is_recorded_and_verified_like_any_stage(flat: Path, command: Command, tmp_path: Path) -> None:
    added, ran = tmp_path / "added.mcap", tmp_path / "ran.mcap"
    command("route", flat / "a.mcap", *WAY, "--avoid", "9", "--mcap", added, code=2)
    assert not added.exists()
    told = command("route", flat / "a.mcap", *WAY, "--mcap", added, "--json").json
    command("route", FLAT, *WAY, "--mcap", ran)
    assert added.read_bytes() == ran.read_bytes()
    route = [record for _, record in read_recording(added, types=RECORDS) if isinstance(record, Route)]
    assert len(route) == 1
    assert round(route[0].length_m, 3) == told["length_m"]
    assert command("verify", added).out.startswith("equal")
    assert command("check", added).out.splitlines()[-1].startswith("whole")
    differs = command("diff", flat / "a.mcap", added, code=1).out
    assert "route differs first: A 0, B 1 records" in differs
    assert f"{told['length_m']:.2f} m, doors 1, 2, 3, 4" in command("show", added, "--stage", "route").out
    command("route", added, "2", "3", "--mcap", tmp_path / "other.mcap")  # takes the place of the one before
    assert command("verify", tmp_path / "other.mcap").out.startswith("equal")


def test_the_recorded_path_is_a_ros_message(command: Command, tmp_path: Path) -> None:
    told = command("route", FLAT, *WAY, "--mcap", tmp_path / "a.mcap", "--json").json
    with (tmp_path / "a.mcap").open("rb") as stream:
        ((_, _, message),) = make_reader(stream).iter_messages(topics=["/vdoor/route/path"])
    path = ros.unpack(message.data, "nav_msgs/msg/Path")
    assert path.header.frame_id == "map"
    for pose, bend in zip(path.poses, told["path"], strict=True):
        assert (pose.pose.position.x, pose.pose.position.y) == pytest.approx((bend["x_m"], bend["y_m"]), abs=6e-4)
        turn = 2 * np.arctan2(pose.pose.orientation.z, pose.pose.orientation.w)
        assert turn == pytest.approx(bend["yaw_rad"], abs=6e-5)


def test_the_order_of_rooms_is_that_of_the_corridor_of_doors(flat: Path, command: Command) -> None:
    told = command("order", flat / "res", "--json").json
    rooms = [stop["room"] for stop in told["stops"]]
    assert min(rooms, rooms[::-1]) == [1, 2, 3, 5, 4]  # the rooms lie in a row
    assert told["exact"]
    assert told["length_m"] == told["lower_bound_m"]
    back = command("order", flat / "a.mcap", "--start", "4", "--return").out.splitlines()
    assert (back[1], back[-1]) == ("room 4", "room 4")
    some = command("order", flat / "res", "--room", "1", "--room", "4", "--start", "7.1,6.7", "--end", "5").out
    assert some.splitlines()[1:] == ["7.1,6.7", "room 1", "room 4", "room 5"]


def test_rooms_out_of_reach_are_named(flat: Path, command: Command) -> None:
    told = command("order", flat / "res", "--start", "1", "--robot-radius", "0.35").out.splitlines()
    assert told == ["0.00 m, the shortest", "room 1", *(f"out of reach: room {room}" for room in (2, 3, 4, 5))]
    refused = command("order", flat / "res", "--start", "1", "--end", "2", "--robot-radius", "0.35", code=2).err
    assert refused.startswith("vdoor: order: wanted a way from the start to the end, found none")
    assert command("order", flat / "res", "--return", code=2).err.startswith("vdoor: --return: wanted a --start")


def test_restrictions_of_the_map_file_hold_in_its_result_too(command: Command, tmp_path: Path) -> None:
    rows = ["#" * 83, *["#" + "." * 40 + "#" + "." * 40 + "#"] * 40, "#" * 83]
    rows[14:30] = ["#" + "." * 81 + "#"] * 16  # a door of 0.8 m
    wall = [*vacuum.centre_cm(13, 45), *vacuum.centre_cm(31, 45)]
    home = vacuum.write_home(tmp_path / "home.json", vacuum.home("\n".join(rows), virtual_wall=wall))
    command("run", home, "--out", tmp_path / "res", "--mcap", tmp_path / "a.mcap", "--quiet")
    told = [command("route", source, "1", "2", "--json", code=1).json for source in (home, tmp_path / "res")]
    told.append(command("route", tmp_path / "a.mcap", "1", "2", "--json", code=1).json)
    assert told[0] == told[1] == told[2]
    assert [item["kind"] for item in told[0]["in_the_way"]] == ["no-go area"]
