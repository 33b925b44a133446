"""What other programs take of a coverage: fields and lanes for opennav_coverage, zones for Valetudo."""

from __future__ import annotations

import json
from itertools import pairwise
from pathlib import Path

import commands
import numpy as np
import pytest
import shapely
import yaml

import vdoor
from vdoor.frame import Frame

FLAT = Path(__file__).parents[2] / "recordings" / "flat.yaml"


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the exports of a coverage of some rooms of the example map, and its JSON."""
    folder = tmp_path_factory.mktemp("files")
    exports = [f"--export={name}={folder / name}" for name in ("fields", "lanes", "zones", "csv")]
    words = ["cover", FLAT, "--room", "4", "--room", "2", "--order", "--start", "4", "--json", *exports]
    done = commands.Command()(*words)
    assert done.code == 0, done
    (folder / "json").write_text(done.out)
    return folder


def test_fields_are_the_outlines_of_the_rooms_in_their_order(files: Path) -> None:
    topology = vdoor.run(vdoor.read_map(FLAT))
    goals = list(yaml.safe_load_all((files / "fields").read_text()))
    assert [goal["frame_id"] for goal in goals] == ["map"] * 2
    for goal, room in zip(goals, (4, 2), strict=True):
        rings = [[(at["axis1"], at["axis2"]) for at in ring["coordinates"]] for ring in goal["polygons"]]
        assert all(ring[0] == ring[-1] for ring in rings)
        field = shapely.Polygon(rings[0], rings[1:])
        assert field.area == pytest.approx(topology.room(room).area_m2)
        assert field.covers(shapely.Point(topology.room(room).centre_m))


def test_lanes_are_those_of_the_path_with_the_ways_between_them(files: Path) -> None:
    path = json.loads((files / "json").read_text())["path"]
    wanted = [[(end["x_m"], end["y_m"]) for end in ends] for ends in pairwise(path) if ends[1]["purpose"] == "lane"]
    lanes = yaml.safe_load((files / "lanes").read_text())
    assert lanes["swaths_ordered"]
    assert lanes["contains_turns"]
    found = [[(lane[end]["x"], lane[end]["y"]) for end in ("start", "end")] for lane in lanes["swaths"]]
    assert found == wanted
    assert len(found) > 5
    for (before, after), turn in zip(pairwise(found), lanes["turns"], strict=True):
        ends = [turn["poses"][row]["pose"]["position"] for row in (0, -1)]
        assert [(at["x"], at["y"]) for at in ends] == [before[1], after[0]]


def test_zones_cover_the_rooms_in_their_order(files: Path) -> None:
    topology = vdoor.run(vdoor.read_map(FLAT))
    requests = [json.loads(line) for line in (files / "zones").read_text().splitlines()]
    assert len(requests) == 2
    frame: Frame = topology.frame
    for request, room in zip(requests, (4, 2), strict=True):
        inside = np.zeros(topology.labels.shape, np.bool_)
        for zone in request["zones"]:
            x_cm, y_cm = (np.array([zone["points"][name][axis] for name in ("pA", "pC")]) for axis in "xy")
            cols = (x_cm / 100 / frame.resolution_m).round().astype(int)
            rows = (y_cm / 100 / frame.resolution_m).round().astype(int)  # without a robot's frame, y down from the top
            inside[rows[0] : rows[1], cols[0] : cols[1]] = True
        assert inside[topology.labels == room].all()
        assert (inside & (topology.labels != room)).mean() < 0.1


def test_a_route_has_no_lanes(tmp_path: Path) -> None:
    done = commands.Command()("route", FLAT, "1", "2", f"--export=lanes={tmp_path / 'lanes'}")
    assert done.code == 2
    assert "--export: no format 'lanes'; wanted one of csv, geojson, waypoints" in done.err
