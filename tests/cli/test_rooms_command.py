"""`vdoor rooms` and `vdoor room-at` as their users meet them: real processes, their streams and exit codes."""

from __future__ import annotations

from pathlib import Path

import finished_maps
import numpy as np
import pytest
from commands import Command, process


@pytest.fixture(scope="module")
def pillars(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A result of a map that lies askew, most of it at negative coordinates."""
    return finished_maps.result("pillars", tmp_path_factory.mktemp("pillars") / "result")


def test_table_has_a_line_a_room(pillars: Path, command: Command) -> None:
    topology = finished_maps.topology("pillars")
    head, *lines = command("rooms", pillars).out.splitlines()
    assert head.split("  ")[0] == "room"
    assert len(lines) == len(topology.rooms) == 3
    for line, room in zip(lines, topology.rooms, strict=True):
        assert line.split()[:2] == [str(room.id), f"{room.area_m2:.2f}"]
        assert line.endswith(" ".join(map(str, room.neighbours)))
    assert [line.split()[3:] for line in lines] == [["1", "3", "2"], ["1", "2", "3", "1", "3"], ["2", "2"]]


def test_json_says_the_same_of_a_recording_and_a_result(tmp_path: Path, command: Command) -> None:
    command(
        "run",
        finished_maps.HOME / "recordings" / "flat.yaml",
        "--preset",
        "paper",
        "--mcap",
        tmp_path / "a.mcap",
        "--out",
        tmp_path / "a",
    )
    told = command("rooms", tmp_path / "a", "--json")
    assert told.json == command("rooms", tmp_path / "a.mcap", "--json").json
    doors = {(door["id"], *sorted((room["id"], door["to"]))) for room in told.json["rooms"] for door in room["doors"]}
    topology = finished_maps.topology("flat")
    assert doors == {(door.id, *door.rooms) for door in topology.doors}
    assert [room["area_m2"] for room in told.json["rooms"]] == topology.area_m2.round(4).tolist()


def test_place_is_in_the_room_of_its_cell(pillars: Path, command: Command) -> None:
    topology = finished_maps.topology("pillars")
    rng = np.random.default_rng(0)
    cells = np.argwhere(topology.labels >= 0)[rng.choice(topology.labels.size, 60, replace=False)]
    within = cells + rng.uniform(-0.49, 0.49, cells.shape)
    for (row, col), (x_m, y_m) in zip(cells.tolist(), topology.frame.world_from_cell(within).tolist(), strict=True):
        room = int(topology.labels[row, col])
        for words in ((f"{x_m},{y_m}",), ("--cells", f"{col},{row}")):
            done = command("room-at", pillars, *words)
            assert done.code == (0 if room else 1)
            assert done.out == (f"room {room}\n" if room else "")
        told = command("room-at", pillars, f"{x_m},{y_m}", "--json").json
        assert told["cell"] == [col, row]
        assert (told["room"] or {"id": 0})["id"] == room


def test_middle_of_each_room_is_in_it(pillars: Path, command: Command) -> None:
    for room in finished_maps.topology("pillars").rooms:
        done = command("room-at", pillars, "{},{}".format(*room.centre_m))
        assert done == (0, f"room {room.id}\n", "")
        assert min(room.centre_m) < 0


@pytest.mark.parametrize(
    ("words", "says"),
    [(("0,0", "--cells"), "outside all rooms"), (("-1,5", "--cells"), "outside"), (("900,900"), "outside")],
)
def test_place_without_a_room_is_one_line_and_1(
    words: tuple[str, ...] | str, says: str, pillars: Path, command: Command
) -> None:
    words = (words,) if isinstance(words, str) else words
    done = command("room-at", pillars, *words)
    assert (done.code, done.out) == (1, "")
    (line,) = done.err.splitlines()
    assert says in line
    assert line.endswith(str(pillars))
    told = command("room-at", pillars, *words, "--json")
    assert (told.code, told.json["room"]) == (1, None)


@pytest.mark.parametrize("place", ["", "1", "1,2,3", "a,b", "nan,1", "1,inf", "1e300,1"])
def test_what_is_no_place_is_refused(place: str, pillars: Path, command: Command) -> None:
    done = command("room-at", pillars, place)
    assert (done.code, done.out) == (2, "")
    assert len(done.err.splitlines()) == 1
    assert repr(place) in done.err


@pytest.mark.parametrize("name", ["rooms", "room-at"])
def test_what_is_no_result_is_refused_by_name(name: str, tmp_path: Path, command: Command) -> None:
    words = ["1,1"] if name == "room-at" else []
    done = command(name, tmp_path / "none.mcap", *words)
    assert (done.code, done.out) == (2, "")
    assert done.err.strip().endswith("none.mcap")


@pytest.mark.parametrize("name", ["rooms", "room-at"])
def test_help_has_an_example(name: str) -> None:
    done = process(name, "--help")
    assert f"Example: vdoor {name} " in done.stdout
