"""Maps of all formats through the command, as its users meet it: real processes, files and pipes."""

from __future__ import annotations

import dataclasses
import json
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from bags import bare_mcap, grid_message
from commands import call, one_line
from maps import cells_drawn
from project import VDOOR
from real_maps import real_maps
from rerun.chunk import RrdReader
from vacuum import centre_cm, home, write_home

import vdoor
from vdoor.api import run
from vdoor.formats import read_annotations
from vdoor.method.simplify import SimplifyGrid
from vdoor.pipeline import PRESETS, RECORDS
from vdoor.record import equal
from vdoor.recording.mcap import read_recording
from vdoor.results.writing import greys

MARGIN = 2
TWO_FLATS = """
    #####################?###########
    #aaaaaaaaaaaaaaaaaaa#?#.........#
    #aaaaaaaaaaaaaaaaaaa#?#.........#
    #aaaaaaaaaaaaaaaaaaa#?#.........#
    #aaaaaaaaaaaaaaaaaaa#?#.........#
    #aaaaaaaaaaaaaaaaaaa#?#.........#
    #aaaaaaaaaaaaaaaaaaa#?#.........#
    #####################?###########
"""
LARGE, SMALL, UNKNOWN = centre_cm(3, 5), centre_cm(3, 27), centre_cm(40, 40)


def piped(data: bytes, *words: str | Path) -> subprocess.CompletedProcess[bytes]:
    return subprocess.run([VDOOR, *map(str, words)], input=data, capture_output=True, timeout=120, check=False)


def pgm(grid: vdoor.OccupancyGrid) -> bytes:
    return b"P5 %d %d 255 " % grid.cells.shape[::-1] + greys(grid).tobytes()


def document(*words: str | Path) -> Any:
    return json.loads(call("run", *words, "--json", "-q").stdout)


@pytest.mark.parametrize("kind", ["json", "pgm", "npy"])
def test_a_map_may_come_out_of_a_pipe(tmp_path: Path, kind: str) -> None:
    grid = vdoor.read_map(write_home(tmp_path / "map.json", home(TWO_FLATS)))
    (tmp_path / "map.pgm").write_bytes(pgm(grid))
    np.save(tmp_path / "map.npy", grid.cells)
    path = tmp_path / f"map.{kind}"
    done = piped(path.read_bytes(), "run", "-", "--json", "-q")
    assert done.returncode == 0, done.stderr
    found, wanted = json.loads(done.stdout), document(path)
    assert [file.pop("name") for file in found["source"]["files"]] == [f"stdin.{kind}"]
    assert [file.pop("name") for file in wanted["source"]["files"]] == [f"map.{kind}"]
    for table in (found, wanted):
        del table["timings_s"]
    assert found == wanted


@pytest.mark.parametrize("data", [b"", b"{", b"nothing", b"image: map.pgm\n"])
def test_what_is_piped_and_no_map_is_refused_in_one_line(data: bytes) -> None:
    done = piped(data, "run", "-")
    assert done.returncode == 2
    assert len(done.stderr.splitlines()) == 1
    assert done.stderr.startswith(b"vdoor: ")
    assert piped(data, "run", "-", "--topic", "/map").returncode == 2


@pytest.mark.parametrize(
    ("entities", "words", "area_m2"),
    [
        ({}, (), 114 * 0.0025),
        ({"robot_position": SMALL, "charger_location": LARGE}, (), 54 * 0.0025),
        ({"charger_location": SMALL}, (), 54 * 0.0025),
        ({"robot_position": UNKNOWN, "charger_location": SMALL}, (), 54 * 0.0025),
        ({"robot_position": UNKNOWN}, (), 114 * 0.0025),
        ({"robot_position": SMALL}, ("--robot", "0.35,0.35"), 114 * 0.0025),
        ({"robot_position": SMALL}, ("--set", "simplify.robot_m=[0.35, 0.35]"), 114 * 0.0025),
    ],
    ids=["nobody", "robot", "charger", "robot lost", "all lost", "said", "set"],
)
def test_the_robots_place_chooses_what_can_be_reached(
    tmp_path: Path, entities: Any, words: tuple[str, ...], area_m2: float
) -> None:
    path = write_home(tmp_path / "home.json", home(TWO_FLATS, **entities))
    found = document(path, *words)
    assert sum(room["area_m2"] for room in found["rooms"]) == pytest.approx(area_m2)
    assert bool(found["settings"]["simplify"]["robot_m"]) == (area_m2 < 0.2 or bool(words))


def test_where_the_robot_is_taken_to_be_is_said(tmp_path: Path) -> None:
    path = write_home(tmp_path / "home.json", home(TWO_FLATS, robot_position=SMALL))
    assert "note: robot at 1.475,0.325, from the map's file" in call("run", path).stderr
    path = write_home(tmp_path / "home.json", home(TWO_FLATS, robot_position=UNKNOWN))
    assert "the robot's position in the map file is not free" in call("run", path).stderr


def test_what_the_map_says_is_in_the_result(tmp_path: Path) -> None:
    wall = [*centre_cm(1, 5), *centre_cm(6, 5)]
    path = write_home(tmp_path / "home.json", home(TWO_FLATS, robot_position=LARGE, virtual_wall=wall))
    call("run", path, "--out", tmp_path / "out", "-q")
    found = json.loads((tmp_path / "out" / "map.json").read_text())["annotations"]
    assert found["robot_m"] == [0.375, 0.325]
    assert found["charger_m"] is None
    assert found["virtual_walls_m"] == [[[0.375, 0.425], [0.375, 0.175]]]
    assert found["own_origin_cm"] == [2990, 2750]
    assert [{**segment, "runs": 0} for segment in found["segments"]] == [
        {"label": 1, "id": "97", "name": "Flur ", "runs": 0}
    ]
    (tmp_path / "map.pgm").write_bytes(b"P5 5 5 255 " + b"\xfe" * 25)
    assert document(tmp_path / "map.pgm", "--resolution", "0.05")["annotations"] is None


# --- the same cells in another format


@pytest.mark.parametrize("robot_m", [(0.375, 0.325), (1.475, 0.325)])
def test_a_home_and_the_same_cells_as_pgm_give_the_same_result(tmp_path: Path, robot_m: tuple[float, float]) -> None:
    same_result(write_home(tmp_path / "home.json", home(TWO_FLATS)), tmp_path, robot_m)


def test_a_real_home_and_the_same_cells_as_pgm_give_the_same_result(tmp_path: Path) -> None:
    for path in real_maps("homes/roborock*.json"):
        said = read_annotations(vdoor.read_map(path).source)
        assert said is not None
        same_result(path, tmp_path, said.places_m[0])


def same_result(path: Path, folder: Path, robot_m: tuple[float, float]) -> None:
    """Claim that the cells of a home give the same final map when they come as a PGM."""
    grid = vdoor.read_map(path)
    image = folder / "same.pgm"
    image.write_bytes(pgm(grid))
    there = vdoor.read_map(image, resolution_m=grid.frame.resolution_m)
    pipeline = dataclasses.replace(PRESETS["default"], simplify=SimplifyGrid(cell_m=0.0, robot_m=robot_m))
    assert equal(run(grid, pipeline), run(there, pipeline))


def test_a_bag_and_the_same_cells_as_an_array_give_the_same_rooms(tmp_path: Path) -> None:
    plain = TWO_FLATS.replace("a", ".")
    np.save(tmp_path / "map.npy", cells_drawn(plain))
    message = grid_message(cells_drawn(plain), at_m=(0.0, 0.0))
    bare_mcap(tmp_path / "bag.mcap", [("/map", 1, message), ("/costmap", 2, message)])
    from_bag = document(tmp_path / "bag.mcap", "--topic", "/map")
    from_array = document(tmp_path / "map.npy", "--resolution", "0.05")
    assert from_bag["source"]["options"] == {"topic": "/map"}
    for name in ("rooms", "doors", "graph", "size", "origin", "resolution_m"):
        assert from_bag[name] == from_array[name]


# --- recordings


def test_runs_on_new_formats_verify_and_run_again_alike(tmp_path: Path) -> None:
    home_path = write_home(tmp_path / "home.json", home(TWO_FLATS, robot_position=SMALL))
    bag = bare_mcap(tmp_path / "bag.mcap", [("/map", 1, grid_message(cells_drawn(TWO_FLATS.replace("a", "."))))])
    for path in (home_path, bag):
        first, second = tmp_path / f"{path.stem}_1.mcap", tmp_path / f"{path.stem}_2.mcap"
        call("run", path, "--mcap", first, "-q")
        path.unlink()
        call("verify", first)
        call("run", first, "--mcap", second, "-q")
        assert first.read_bytes() == second.read_bytes()
        call("replay", first, "--save", tmp_path / f"{path.stem}.rrd")


def test_a_recording_is_not_overwritten_by_a_run_on_it(tmp_path: Path) -> None:
    path = write_home(tmp_path / "home.json", home(TWO_FLATS))
    call("run", path, "--mcap", tmp_path / "a.mcap", "-q")
    done = call("run", tmp_path / "a.mcap", "--mcap", tmp_path / "a.mcap", "--force", code=2)
    assert "wanted a different name from the input's" in one_line(done)
    assert len([*read_recording(tmp_path / "a.mcap", types=RECORDS)]) > 5


# --- the maker's segments


def test_the_makers_segments_serve_as_a_reference(tmp_path: Path) -> None:
    path = write_home(tmp_path / "home.json", home(TWO_FLATS))
    said = read_annotations(vdoor.read_map(path).source)
    assert said is not None
    assert said.labels is not None
    np.save(tmp_path / "home.npy", said.labels)
    done = call("evaluate", tmp_path / "home.npy", "--map", path, "--reference", path, "--json")
    figures = json.loads(done.stdout)["summary"]
    assert (figures["rooms_true"], figures["iou"]) == (1, 1)


def test_references_without_segments_or_of_another_home_are_named(tmp_path: Path) -> None:
    path = write_home(tmp_path / "home.json", home(TWO_FLATS))
    call("run", path, "--out", tmp_path / "out", "-q")
    for table, match in (
        (home(TWO_FLATS.replace("a", ".")), "reference: wanted segments, found none"),
        (home("a"), "reference: wanted 37 x 12 cells like the map, found 5 x 5 cells"),
        (home(TWO_FLATS) | {"entities": 5}, "reference: entities: wanted a list, found 5"),
    ):
        other = write_home(tmp_path / "other.json", table)
        assert match in one_line(call("evaluate", tmp_path / "out", "--reference", other, code=2))


# --- drawn


def drawn(path: Path) -> list[dict[str, Any]]:
    """Lines on the input map in a Rerun recording of a run."""
    chunks = [chunk.to_record_batch().to_pylist() for chunk in RrdReader(path).stream().filter(content="/input/map/**")]
    return [row for rows in chunks for row in rows if row.get("LineStrips2D:strips")]


def test_virtual_walls_and_areas_are_drawn_where_they_are(tmp_path: Path) -> None:
    wall = [*centre_cm(1, 5), *centre_cm(6, 5)]
    area = [*centre_cm(1, 1), *centre_cm(1, 3), *centre_cm(4, 3)]
    path = write_home(tmp_path / "home.json", home(TWO_FLATS, virtual_wall=wall, no_go_area=area))
    call("run", path, "--save", tmp_path / "live.rrd", "--mcap", tmp_path / "home.mcap", "-q")
    call("replay", tmp_path / "home.mcap", "--save", tmp_path / "replayed.rrd")
    for name in ("live.rrd", "replayed.rrd"):
        found = {
            label: (np.array(line) - 0.5 - MARGIN).round(5).tolist()
            for row in drawn(tmp_path / name)
            for label, line in zip(row["LineStrips2D:labels"], row["LineStrips2D:strips"], strict=True)
        }
        assert found == {"virtual wall": [[5, 1], [5, 6]], "no-go area": [[1, 1], [3, 1], [3, 4], [1, 1]]}


def test_a_map_without_any_is_drawn_as_it_is(tmp_path: Path) -> None:
    call("run", write_home(tmp_path / "home.json", home(TWO_FLATS)), "--save", tmp_path / "home.rrd", "-q")
    assert drawn(tmp_path / "home.rrd") == []
