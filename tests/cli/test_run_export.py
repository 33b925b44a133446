"""`vdoor run --export` as its users meet it: real processes, their files, streams and exit codes."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import finished_maps
import numpy as np
import pytest
from commands import call
from PIL import Image
from project import FLAT

from vdoor.grid import FREE, OCCUPIED
from vdoor.results.writing import greys

FORMATS = {
    "nav2-route": "route.geojson",
    "graphml": "rooms.graphml",
    "json": "rooms.json",
    "geojson": "rooms.geojson",
    "labels": "labels.png",
    "virtual-walls": "walls.json",
    "rmf": "building.yaml",
    "svg": "rooms.svg",
    "report": "report.html",
}


def asked(folder: Path, *names: str) -> list[str]:
    return [word for name in names for word in ("--export", f"{name}={folder / FORMATS[name]}")]


@pytest.fixture
def flat(tmp_path: Path) -> Path:
    """A copy of the example map, to be put at risk."""
    folder = tmp_path / "maps"
    folder.mkdir()
    shutil.copy(FLAT.with_suffix(".pgm"), folder)
    return Path(shutil.copy(FLAT, folder))


def test_each_file_is_what_vdoor_export_makes_of_the_recording(tmp_path: Path) -> None:
    live, later = tmp_path / "live", tmp_path / "later"
    live.mkdir()
    later.mkdir()
    call("run", FLAT, "--preset", "paper", "--mcap", tmp_path / "flat.mcap", *asked(live, *FORMATS))
    assert {path.name for path in live.iterdir()} == {*FORMATS.values(), "labels.yaml"}
    for name, file in FORMATS.items():
        call("export", tmp_path / "flat.mcap", "--to", name, "-o", later / file)
    for path in later.iterdir():
        assert (live / path.name).read_bytes() == path.read_bytes(), path.name


def test_map_in_which_no_robot_fits_has_all_but_the_route_graph(tmp_path: Path) -> None:
    image = tmp_path / "one.png"
    Image.fromarray(greys(finished_maps.grid("one room"))).save(image)
    words = (
        "run",
        image,
        "--resolution",
        "0.02",
        "--set",
        "simplify.cell_m=0",
        "--unknown-value",
        "205",
        "--preset",
        "paper",
        "-q",
    )
    written = ("--mcap", tmp_path / "one.mcap", "--save", tmp_path / "one.rrd", "--out", tmp_path / "one")
    done = call(*words, *written, *asked(tmp_path, "nav2-route", "svg"), code=2)
    assert done.stdout.startswith("1 room, 0 doors")
    (line,) = done.stderr.splitlines()
    assert "two places for a robot" in line
    assert line.endswith(str(image))
    assert {path.name for path in tmp_path.iterdir()} == {"one.png", "one.mcap", "one.rrd", "one", "rooms.svg"}
    assert call("rooms", tmp_path / "one.mcap").stdout.count("\n") == 2


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (["--export", "svg"], "FORMAT=FILE"),
        (["--export", "svg="], "FORMAT=FILE"),
        (["--export", "gml={}/x.gml"], "did you mean 'graphml'?"),
        (["--export", "labels={}/x.bmp"], ".pgm"),
        (["--export", "keepout={}/x.png"], "--room"),
        (["--export", "svg={}/x.svg", "--export", "json={}/x.svg"], "twice"),
        (["--export", "svg={}/x.mcap"], "twice"),
        (["--export", "labels={}/rooms.png", "--out", "{}"], "twice"),
        (["--export", "svg=/dev/null", "--force"], "device"),
        (["--export", "svg={}/flat.yaml", "--force"], "input"),
        (["--export", "labels={}/flat.pgm", "--force"], "input"),
        (["--export", "svg={}/flat.pgm", "--force"], "input"),
        (["--export", "svg={}/flat.pgm"], "--force"),
    ],
)
def test_wrong_use_is_one_line_before_anything_is_run(words: list[str], says: str, flat: Path) -> None:
    before = {path: path.read_bytes() for path in flat.parent.iterdir()}
    filled = [word.format(flat.parent) for word in words]
    done = call("run", flat, "--preset", "paper", "--mcap", flat.parent / "x.mcap", *filled, code=2)
    assert says in done.stderr
    assert len(done.stderr.splitlines()) == 1
    assert done.stdout == ""
    assert {path: path.read_bytes() for path in flat.parent.iterdir()} == before


def test_a_folder_that_is_missing_is_refused_before_the_run(tmp_path: Path) -> None:
    words = ("--mcap", tmp_path / "flat.mcap", "--export", f"svg={tmp_path / 'missing' / 'x.svg'}")
    done = call("run", FLAT, "--preset", "paper", *words, code=2)
    assert "wanted an existing folder for it, found none" in done.stderr
    assert not list(tmp_path.iterdir())


def test_walls_for_a_vacuum_need_no_recording(tmp_path: Path) -> None:
    # What only the map's own file says, its place in the robot's frame, reaches the export as well.
    cells = finished_maps.house(2, (1, 6, 4))
    layers = [
        {"type": kind, "pixels": (np.argwhere(cells == state)[:, ::-1] + (9, 7)).ravel().tolist()}
        for kind, state in (("floor", FREE), ("wall", OCCUPIED))
    ]
    about = {"__class": "ValetudoMap", "metaData": {"version": 1}, "size": {"x": 900, "y": 900}, "pixelSize": 20}
    home = tmp_path / "home.json"
    home.write_text(json.dumps(about | {"layers": layers, "entities": []}))
    call("run", home, "--preset", "paper", "--out", tmp_path / "home", *asked(tmp_path, "virtual-walls"))
    later = call("export", tmp_path / "home", "--to", "virtual-walls").stdout
    assert (tmp_path / "walls.json").read_text() == later
