"""`vdoor export` as its users meet it: real processes, their files, streams and exit codes."""

from __future__ import annotations

import json
import re
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import finished_maps
import networkx as nx
import numpy as np
import pytest
import shapely  # type: ignore[import-untyped]  # publishes no types
import small_recording
from commands import Command, call
from PIL import Image
from project import FLAT

from vdoor.export import WRITERS
from vdoor.grid import FREE, OCCUPIED, UNKNOWN

Refused = Callable[..., str]


@pytest.fixture
def refused(command: Command) -> Refused:
    """Run `vdoor export` and give the one line that it refuses with."""

    def line(*words: str | Path) -> str:
        done = command("export", *words)
        assert (done.code, done.out) == (2, "")
        (said,) = done.err.splitlines()
        return said

    return line


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("runs")
    call("run", FLAT, "--preset", "paper", "--mcap", folder / "flat.mcap", "--out", folder / "flat")
    finished_maps.result("one room", folder / "one room")
    return folder


@pytest.fixture
def result(runs: Path, tmp_path: Path) -> Path:
    """A copy of a result folder, to be spoilt."""
    return shutil.copytree(runs / "flat", tmp_path / "flat")


@pytest.mark.parametrize(
    "writer", [writer for writer in WRITERS if "provenance" not in writer.takes], ids=lambda writer: writer.name
)
def test_recording_and_result_folder_give_the_same_files(writer: Any, runs: Path, tmp_path: Path) -> None:
    rooms = ["--room", "2"] if writer.needs_rooms else []
    files = []
    for source in ("flat.mcap", "flat"):
        out = tmp_path / source / "x.png"
        out.parent.mkdir()
        printed = call("export", runs / source, "--to", writer.name, "-o", out, *rooms).stdout.split()
        assert sorted(printed) == sorted(map(str, out.parent.iterdir()))
        files.append({path.name: path.read_bytes() for path in out.parent.iterdir()})
    assert files[0] == files[1]
    assert set(files[0]) == ({"x.png", "x.yaml"} if writer.image else {"x.png"})


def test_text_is_printed_without_a_file(runs: Path, tmp_path: Path) -> None:
    out = tmp_path / "route.geojson"
    call("export", runs / "flat", "--to", "nav2-route", "-o", out)
    assert call("export", runs / "flat", "--to", "nav2-route").stdout == out.read_text()


def test_robot_that_fits_nowhere_has_no_route_graph(runs: Path, tmp_path: Path, refused: Refused) -> None:
    source = runs / "one room"
    line = refused(source, "--to", "nav2-route", "--robot-radius", "9", "-o", tmp_path / "x.geojson")
    assert "two places for a robot of radius 9 m" in line
    assert line.endswith(str(source))
    assert not (tmp_path / "x.geojson").exists()
    assert "--robot-radius: wanted the format nav2-route" in refused(source, "--to", "svg", "--robot-radius", "1")


def test_map_without_doors_has_every_format(command: Command, runs: Path, tmp_path: Path) -> None:
    source = runs / "one room"
    for writer in WRITERS:
        rooms = ["--room", "1"] if writer.needs_rooms else []
        assert command("export", source, "--to", writer.name, "-o", tmp_path / f"{writer.name}.png", *rooms).code == 0


def test_help_lists_every_format() -> None:
    told = call("export", "--help").stdout
    assert re.findall(r"^  ([a-z0-9-]+)  +\w", told, re.MULTILINE)[: len(WRITERS)] == [w.name for w in WRITERS]
    assert "Example: vdoor export" in told


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (["--to", "gml"], "did you mean 'graphml'?"),
        (["--to", "labels"], "image"),
        (["--to", "labels", "-o", "x.bmp"], ".pgm"),
        (["--to", "keepout", "-o", "x.png"], "--room"),
        (["--to", "keepout", "-o", "x.png", "--room", "6"], "5, found 6"),
        (["--to", "virtual-walls", "--room", "0"], "found 0"),
        (["--to", "svg", "--room", "1"], "keepout or virtual-walls"),
        (["--to", "svg", "-o", "/dev/null", "--force"], "device"),
        (["--to", "svg", "-o", "missing/x.svg"], "missing"),
        (["--to", "svg", "-o", ""], "file name"),
    ],
)
def test_wrong_use_is_one_line(words: list[str], says: str, runs: Path, refused: Refused) -> None:
    assert says in refused(runs / "flat", *words)


def test_existing_files_are_kept_without_force(runs: Path, tmp_path: Path, refused: Refused) -> None:
    (tmp_path / "rooms.yaml").write_text("mine")
    words = (runs / "flat", "--to", "labels", "-o", tmp_path / "rooms.png")
    assert "--force" in refused(*words)
    assert (tmp_path / "rooms.yaml").read_text() == "mine"
    assert not (tmp_path / "rooms.png").exists()
    call("export", *words, "--force")
    assert (tmp_path / "rooms.yaml").read_text() != "mine"


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("map.json", ["json"]),
        ("sub/../map.json", ["svg"]),
        ("rooms.yaml", ["rmf"]),
        ("grid.png", ["labels"]),
        ("rooms.pgm", ["keepout", "--room", "1"]),  # its YAML would be rooms.yaml
    ],
)
def test_files_of_the_result_are_never_overwritten(name: str, words: list[str], result: Path, refused: Refused) -> None:
    (result / "sub").mkdir()
    before = {path.name: path.read_bytes() for path in result.iterdir() if path.is_file()}
    assert "input" in refused(result, "-o", result / name, "--force", "--to", *words)
    assert {path.name: path.read_bytes() for path in result.iterdir() if path.is_file()} == before


def test_recordings_are_never_overwritten(runs: Path, tmp_path: Path, refused: Refused) -> None:
    recording = tmp_path / "flat.mcap"
    shutil.copy(runs / "flat.mcap", recording)
    (tmp_path / "link").symlink_to(recording)
    before = recording.read_bytes()
    assert "input" in refused(recording, "--to", "json", "-o", recording, "--force")
    assert "input" in refused(tmp_path / "link", "--to", "json", "-o", recording, "--force")
    # What is being written has another name until it is whole: that of a recording which was cut short.
    partial = recording.rename(tmp_path / "flat.mcap.partial")
    assert "input" in refused(partial, "--to", "json", "-o", recording, "--force")
    assert partial.read_bytes() == before


def test_a_recording_that_ends_before_the_map_is_refused_by_what_it_ends_with(tmp_path: Path, refused: Refused) -> None:
    _, records = small_recording.small_run()
    unfinished = small_recording.write(tmp_path / "cut.mcap", records[:-1])
    line = refused(unfinished, "--to", "json")
    assert "generation" in line
    assert line.endswith(str(unfinished))


@pytest.mark.parametrize("name", ["", "empty", "image.png", "missing.mcap", "cut.mcap"])
def test_what_is_no_result_is_refused_by_name(name: str, runs: Path, tmp_path: Path, refused: Refused) -> None:
    (tmp_path / "empty").mkdir()
    Image.fromarray(np.zeros((3, 3), np.uint8)).save(tmp_path / "image.png")
    whole = (runs / "flat.mcap").read_bytes()
    (tmp_path / "cut.mcap").write_bytes(whole[: len(whole) // 2])
    assert refused(tmp_path / name, "--to", "json").endswith(str(tmp_path / name))


def drop(key: str) -> Callable[[Any], Any]:
    return lambda document: document.pop(key)


@pytest.mark.parametrize(
    ("spoil", "says"),
    [
        (drop("schema"), "schema"),
        (drop("rooms"), "rooms"),
        (drop("doors"), "doors"),
        (drop("resolution_m"), "resolution_m"),
        (drop("origin"), "origin"),
        (lambda document: document.update(schema=99), "schema 1, found 99"),
        (lambda document: document.update(resolution_m=-1), "resolution"),
        (lambda document: document.update(resolution_m=True), "resolution"),
        (lambda document: document["origin"].update(yaw_rad=None), "finite"),
        (lambda document: document["origin"].update(x_m=10**400), "something else"),
        (lambda document: document["size"].update(width=7), "7 x 46"),
        (lambda document: document.update(size=[1, 2]), "something else"),
        (lambda document: document["rooms"].pop(), "4 rooms"),
        (lambda document: document["rooms"][0].update(id=7), "same rooms in both"),
        (lambda document: document["rooms"].reverse(), "same rooms in both"),
        (lambda document: document["rooms"][0].update(corners=5), "something else"),
        (lambda document: document["doors"].reverse(), "doors 1, 2"),
        (lambda document: document["doors"][0].update(rooms=[1, 9]), "two rooms"),
        (lambda document: document["doors"][0].update(rooms=[2, 1]), "lower first"),
        (lambda document: document["doors"][0].update(rooms=[1]), "something else"),
        (lambda document: document["doors"][0].update(rooms=[[], {}]), "something else"),
        (lambda document: document["doors"][0].update(kind="gate"), "gate"),
        (lambda document: document["doors"][0].update(start_m=[0, 1, 2]), "something else"),
        (lambda document: document["doors"][0].update(width_m="wide"), "wide"),
        (lambda document: document.update(annotations=[1]), "something else"),
    ],
)
def test_a_spoilt_map_json_is_refused_by_what_is_wrong(
    spoil: Callable[[Any], Any], says: str, result: Path, refused: Refused
) -> None:
    document = json.loads((result / "map.json").read_text())
    spoil(document)
    (result / "map.json").write_text(json.dumps(document))
    line = refused(result, "--to", "json")
    assert says in line
    assert line.endswith(str(result))


def test_a_label_image_of_another_map_is_refused(result: Path, refused: Refused) -> None:
    labels = np.array(Image.open(result / "rooms.png"))

    def spoilt(change: np.ndarray[Any, Any]) -> str:
        Image.fromarray(change).save(result / "rooms.png")
        return refused(result, "--to", "json")

    assert "cells, found" in spoilt(labels[1:].copy())
    assert "in both" in spoilt(np.where(labels == 2, 0, labels).astype(np.uint16))
    assert "in both" in spoilt(np.zeros_like(labels))
    assert "16-bit" in spoilt(labels.astype(np.uint8))
    (result / "rooms.png").write_bytes(b"\x89PNG")
    assert "rooms.png" in refused(result, "--to", "json")


def test_a_room_in_several_parts_comes_out_as_that_many_polygons(tmp_path: Path, command: Command) -> None:
    cells = np.full((60, 80), OCCUPIED, np.int8)
    cells[5:55, 5:70] = FREE
    cells[5:55, 70:75] = UNKNOWN
    cells[20, 71] = cells[40, 72:74] = FREE  # rays
    np.save(tmp_path / "seen.npy", cells)
    command("run", tmp_path / "seen.npy", "--resolution", "0.05", "--out", tmp_path / "out")
    done = command("export", tmp_path / "out", "--to", "geojson")
    (room,) = json.loads(done.out)["features"]
    areas_m2 = [shapely.Polygon(outer, holes).area for outer, *holes in room["geometry"]["coordinates"]]
    assert room["geometry"]["type"] == "MultiPolygon"
    assert areas_m2 == pytest.approx([50 * 65 * 0.05**2, 2 * 0.05**2, 0.05**2])
    assert sum(areas_m2) == pytest.approx(room["properties"]["area_m2"], abs=1e-3)


def test_the_ids_that_are_printed_are_those_of_the_export(runs: Path, tmp_path: Path) -> None:
    printed = call("run", FLAT, "--preset", "paper").stdout
    call("export", runs / "flat", "--to", "graphml", "-o", tmp_path / "flat.graphml")
    graph = nx.read_graphml(tmp_path / "flat.graphml", node_type=int, force_multigraph=True)
    doors = re.findall(r"^door +(\d+) .* rooms (\d+) and (\d+)", printed, re.MULTILINE)
    assert sorted((int(a), int(b), int(door)) for door, a, b in doors) == sorted(graph.edges(keys=True))


def test_walls_for_a_vacuum_stand_in_the_doorway_of_its_own_map(tmp_path: Path) -> None:
    cells = finished_maps.house(2, (1, 6, 4))
    across, down, cell_cm = 100, 200, 20
    layers = [
        {
            "type": kind,
            "pixels": [at for row, col in np.argwhere(cells == state).tolist() for at in (col + across, row + down)],
            "metaData": {},
        }
        for kind, state in (("floor", FREE), ("wall", OCCUPIED))
    ]
    about = {"__class": "ValetudoMap", "metaData": {"version": 1}, "size": {"x": 5000, "y": 5000}}
    home = tmp_path / "home.json"
    home.write_text(json.dumps(about | {"pixelSize": cell_cm, "layers": layers, "entities": []}))
    call("run", home, "--preset", "paper", "--out", tmp_path / "home", "--mcap", tmp_path / "home.mcap")
    for source in ("home", "home.mcap"):
        told = json.loads(call("export", tmp_path / source, "--to", "virtual-walls").stdout)
        (wall,) = told["virtualWalls"]
        x_cells = [point["x"] / cell_cm - across for point in wall["points"].values()]
        y_cells = sorted(point["y"] / cell_cm - down for point in wall["points"].values())
        # The doorway is in columns 18 and 19 and rows 8 to 11; a door ends in the middles of the walls' cells.
        assert all(18 <= x <= 20 for x in x_cells)
        assert y_cells == [7.5, 12.5]
