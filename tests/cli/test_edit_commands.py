"""Commands that edit a result, and ids and names in all that is written."""

from __future__ import annotations

import dataclasses
import io
import json
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as ET

import finished_maps
import jsonschema
import networkx as nx
import numpy as np
import pytest
import small_recording
import yaml
from commands import Command
from edited_flat import FLAT, at, flat

import vdoor
from vdoor import export
from vdoor.editing.edits import appended, parse, read_edits
from vdoor.export import read_finished
from vdoor.export.graphs import schema
from vdoor.results.writing import document_of, write_result


@pytest.fixture
def result(tmp_path: Path, command: Command) -> Path:
    """A result folder of the flat."""
    assert command("run", FLAT, "--preset", "paper", "--out", tmp_path / "r").code == 0
    return tmp_path / "r"


def told(folder: Path) -> dict[str, Any]:
    """What map.json says of rooms and doors; corners in no order, since a folder does not know it."""
    table = json.loads((folder / "map.json").read_text())
    for room in table["rooms"]:
        room["corners"].sort(key=str)
    return {key: table[key] for key in ("rooms", "doors", "graph", "settings")}


def test_commands_edit_the_result_as_a_new_run_does(result: Path, tmp_path: Path, command: Command) -> None:
    for words, says in (
        (("rename", result, "1", "Kitchen"), "room 1 is now named Kitchen"),
        (("rename", result, at(4), "Küche 2"), "room 4 is now named Küche 2"),
        (("rename", result, "Kitchen", "Galley"), "room 1 is now named Galley"),
        (("merge", result, "1", "2"), "rooms 1 and 2 are now room 1 ("),
        (("split", result, "7.3,4.3", "7.3,4.5"), "room 3 is now rooms 3 ("),
        (("door", "remove", result, "2"), "door removed: room "),
        (("door", "add", result, "2.9,1.5", "2.9,4.3"), "room 4 is now rooms 4 ("),
    ):
        done = command(*words)
        assert (done.code, done.out.startswith(says)) == (0, True), (done.out, done.err)
        assert f"vdoor run MAP --edits {result / 'edits.toml'}" in done.err
    again = tmp_path / "again"
    options = ("--edits", result / "edits.toml", "--out", again, "--mcap", tmp_path / "a.mcap")
    assert "note" not in command("run", FLAT, "--preset", "paper", *options).err  # progress, if the machine is slow
    assert told(again) == told(result)
    assert (again / "rooms.png").read_bytes() == (result / "rooms.png").read_bytes()
    assert command("rooms", again).out == command("rooms", result).out == command("rooms", tmp_path / "a.mcap").out
    assert command("verify", tmp_path / "a.mcap").code == 0
    assert command("check", tmp_path / "a.mcap").code == 0
    assert '"name 2.9,6.5 Kitchen"' in command("info", tmp_path / "a.mcap").out
    assert "Galley" in command("show", tmp_path / "a.mcap", "--stage", "map").out
    shown = command("show", tmp_path / "a.mcap", "--stage", "edits").out
    assert "7 done" in shown
    assert [line.split()[:2] for line in shown.splitlines()[-7:]][3] == ["3", "merge"]
    assert command("replay", tmp_path / "a.mcap", "--save", tmp_path / "a.rrd").code == 0
    assert command("export", tmp_path / "a.mcap", "--to", "report", "-o", tmp_path / "a.html").code == 0
    assert command("room-at", result, at(1)).out == "room 1  Galley\n"


def test_edits_of_the_run_come_first(tmp_path: Path, command: Command) -> None:
    mine, kept = tmp_path / "mine.toml", tmp_path / "r" / "edits.toml"
    mine.write_bytes(appended(mine, [parse(f"name {at(1)} Kitchen")]))
    command("run", FLAT, "--preset", "paper", "--edits", mine, "--out", tmp_path / "r", "--mcap", tmp_path / "r.mcap")
    command("rename", tmp_path / "r", "2", "Hall")
    assert [edit.name for edit in read_edits(kept)] == ["Kitchen", "Hall"]
    command("rename", tmp_path / "r", "2", "Den", "--edits", mine)
    assert [edit.name for edit in read_edits(mine)] == ["Kitchen", "Den"]
    done = command("rename", tmp_path / "r", "2", "Hall")
    assert "made with other edits than those in this file" in done.err
    done = command("rename", tmp_path / "r.mcap", "2", "Hall")
    assert "r.edits.toml" in done.err
    assert [edit.name for edit in read_edits(tmp_path / "r.edits.toml")] == ["Kitchen", "Hall"]


def test_edits_of_a_run_are_in_its_folder(result: Path, tmp_path: Path, command: Command) -> None:
    words = ("run", FLAT, "--preset", "paper", "--out", result, "--force")
    command("rename", result, "1", "Kitchen")
    mine = (result / "edits.toml").read_text() + "# my own words\n"
    (result / "edits.toml").write_text(mine)
    assert command(*words, "--edits", result / "edits.toml").err == ""
    assert (result / "edits.toml").read_text() == mine
    assert "were not applied (--edits applies them)" in command(*words).err
    assert (result / "edits.toml").read_text() == mine
    (tmp_path / "other.toml").write_bytes(appended(tmp_path / "other.toml", [parse(f"name {at(1)} Hall")]))
    assert "which are kept" in command(*words, "--edits", tmp_path / "other.toml").err
    assert (result / "before.edits.toml").read_text() == mine
    assert [edit.name for edit in read_edits(result / "edits.toml")] == ["Hall"]
    assert command("rename", result, "2", "Bath").err.count("\n") == 1


def test_edit_that_is_done_already_is_not_kept(result: Path, command: Command) -> None:
    command("rename", result, "1", "Kitchen")
    before = {path.name: path.read_bytes() for path in result.iterdir()}
    done = command("rename", result, "1", "Kitchen")
    assert (done.code, "nothing to change" in done.err) == (0, True)
    assert {path.name: path.read_bytes() for path in result.iterdir()} == before


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (("rename", "R", "9", "Hall"), "one of 1, 2, 3, 4, 5, found 9"),
        (("rename", "R", "Den", "Hall"), "room: wanted a room's id, its name or X,Y, found 'Den'"),
        (("rename", "R", "0000000001", "Hall"), "X,Y, found '0000000001'"),
        (("rename", "R", "-90,1", "Hall"), "none at -90,1"),
        (("rename", "R", "1", ""), "1 to 100 characters"),
        (("rename", "R", "1", "a\nb"), "one line"),
        (("merge", "R", "1", "4"), "rooms do not touch"),
        (("merge", "R", "1", at(1)), "wanted two rooms, found room 1 twice"),
        (("split", "R", "-9,1", "-9,2"), "no room there"),
        (("split", "R", "1", "1,2"), "wanted X,Y, found '1'"),
        (("door", "add", "R", "2,2", "2.1,2.1"), "parts nothing"),
        (("door", "add", "R", "2,2"), "wanted X,Y X,Y"),
        (("door", "remove", "R", "9"), "4 doors, found 9"),
        (("door", "remove", "R", "2,2"), "no door there"),
        (("door", "remove", "R", "Den"), "door: wanted a door's id or X,Y, found 'Den'"),
        (("door", "open", "R", "1"), "wanted add or remove, found 'open'"),
        (("rename", "NONE", "1", "A"), "found none"),
    ],
)
def test_edit_that_cannot_be_done_is_one_line_and_2(
    words: tuple[str, ...], says: str, result: Path, command: Command
) -> None:
    before = {path.name: path.read_bytes() for path in result.iterdir()}
    done = command(*({"R": str(result), "NONE": str(result / "none.mcap")}.get(word, word) for word in words))
    assert (done.code, done.out) == (2, "")
    (line,) = done.err.splitlines()
    assert says in line
    assert {path.name: path.read_bytes() for path in result.iterdir()} == before


def test_edit_that_cannot_be_written_leaves_all_files_as_they_were(result: Path, command: Command) -> None:
    # Python reads NaN in JSON, also where no command looks at it, but JSON does not have it.
    text = (result / "map.json").read_text()
    (result / "map.json").write_text(text.replace('"seed": 0', '"seed": NaN'))
    before = {path.name: path.read_bytes() for path in result.iterdir()}
    done = command("merge", result, "1", "2")
    assert (done.code, done.err) == (2, f"vdoor: map.json: wanted finite numbers, found others: {result}\n")
    assert {path.name: path.read_bytes() for path in result.iterdir()} == before


@pytest.mark.parametrize(
    ("words", "code", "says"),
    [
        (("--edits", "none.toml"), 2, "wanted edits as TOML, found none"),
        (("--edits", "bad.toml"), 2, "edit 1: wanted do = one of"),
        (("--closed-door", "2.9,6.5"), 2, "wanted a wall of at most 1 m between free cells, found none at 2.9,6.5"),
        (("--closed-door", "a"), 2, "--closed-door: wanted X,Y, found 'a'"),
        (("--set", "edit.edits=3"), 2, "--set: edit.edits: wanted a list of strings, found 3"),
        (("--set", "edit.edits=['name 1,1']"), 2, "edit.edits: wanted name X,Y NAME"),
        (("--set", "edit.edits=['merge 1,1 900,1']"), 0, "note: an edit could not be applied, no room there: merge"),
        (("--set", "edit.edits=['merge 1,1 900,1']", "--quiet"), 0, ""),
    ],
)
def test_run_says_what_is_wrong_with_edits(
    words: tuple[str, ...], code: int, says: str, tmp_path: Path, command: Command
) -> None:
    (tmp_path / "bad.toml").write_text("[[edit]]\ndo = 'paint'\n")
    done = command("run", FLAT, "--preset", "paper", *words, cwd=tmp_path)
    assert done.returncode == code
    assert len(done.stderr.splitlines()) == bool(says)
    assert says in done.stderr
    assert (done.stdout == "") == (code == 2)


# In all outputs


def test_ids_and_names_agree_over_all_exports() -> None:
    topology = vdoor.edited(flat(), [f"number {at(2)} 300", f"name {at(2)} Bad & <Küche>", f"number {at(5)} 90"])
    assert topology.room_ids == (1, 3, 4, 90, 300)
    names = {room.id: room.name for room in topology.rooms}
    collection = json.loads(export.to_geojson(topology))["features"]
    assert {each["properties"]["room"]: each["properties"]["name"] for each in collection[:5]} == names
    document = json.loads(export.to_json(topology))
    jsonschema.validate(document, schema())
    assert {node["id"]: node["name"] for node in document["nodes"]} == names
    graph = nx.read_graphml(io.BytesIO(export.to_graphml(topology).encode()), node_type=int, force_multigraph=True)
    assert dict(graph.nodes(data="name")) == names
    assert set(np.unique(export.to_labels(topology).cells)) == {0, *names}
    assert (export.to_keepout(topology, [300]).cells == 254).sum() == (topology.labels == 300).sum()
    svg = ET.fromstring(export.to_svg(topology))  # noqa: S314  # our own
    shown = {each.get("id"): each[0].text for each in svg.iter("{http://www.w3.org/2000/svg}path")}
    assert set(shown) == {f"room-{room}" for room in names}
    assert (shown["room-300"] or "").startswith("Bad & <Küche>, room 300: ")
    report = export.to_report(topology)
    assert "Bad \\u0026 " in report or "Bad & \\u003cK" in report
    route = json.loads(export.to_nav2_route(topology))["features"]
    about = [each["properties"]["metadata"] for each in route if each["geometry"]["type"] == "Point"]
    assert {each["room"]: each["name"] for each in about if each["class"] == "room"} == names
    assert len(json.loads(export.to_virtual_walls(topology, [300]))["virtualWalls"]) == 2


def test_fleets_know_rooms_by_their_names() -> None:
    lines = [f"name {at(1)} Küche", f"name {at(2)} Hall", f"name {at(3)} Hall", f"name {at(4)} door_1"]
    vertices = yaml.safe_load(export.to_rmf(vdoor.edited(flat(), lines)))["levels"]["L1"]["vertices"]
    names = [about["name"] for _, _, about in vertices]
    assert names[:5] == ["Küche", "room_2", "room_3", "room_4", "room_5"]
    assert len(set(names)) == len(names)


def test_folder_gives_ids_and_names_back(tmp_path: Path) -> None:
    topology = vdoor.edited(flat(), [f"number {at(2)} 300", f"name {at(2)} Küche"])
    info = dataclasses.replace(small_recording.small_run()[0], source=finished_maps.grid("flat").source)
    write_result(tmp_path / "r", finished_maps.grid("flat"), topology, document_of(topology, info, {}))
    back = read_finished(tmp_path / "r").topology
    assert back.rooms == topology.rooms
    assert back.doors == topology.doors
    too_high = vdoor.edited(topology, [f"number {at(1)} 65535"])
    write_result(tmp_path / "s", finished_maps.grid("flat"), too_high, document_of(too_high, info, {}))
    assert read_finished(tmp_path / "s").topology.room_ids[-1] == 65_535
