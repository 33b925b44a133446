"""`vdoor nav2`: a folder that Nav2's servers would take."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from pathlib import Path
from typing import Any

import finished_maps
import nav2_folder
import numpy as np
import pytest
import yaml
from commands import call, one_line
from nav2_loader import RefusedError
from project import HOME

from vdoor.cli import nav2
from vdoor.export import nav2_route, read_finished
from vdoor.export.nav2_folder import Nav2Options, nav2_files
from vdoor.grid import OCCUPIED, Annotations


@pytest.fixture
def result(tmp_path: Path) -> Path:
    return finished_maps.result("pillars", tmp_path / "result")


def test_the_servers_take_what_is_in_the_folder(result: Path, tmp_path: Path) -> None:
    out = tmp_path / "nav2"
    done = call("nav2", result, "--out", out, "--slow", "2=40", "--door-service", "/open_{door}")
    assert done.stdout.splitlines() == [str(out / name) for name in Nav2Options(speed_percent={2: 40}).names()]
    assert "askew" in one_line(done)
    folder, topology = nav2_folder.read(out), read_finished(result).topology
    keepout = folder.masks["nav2_costmap_2d::KeepoutFilter"]
    assert np.array_equal(keepout.cells == OCCUPIED, topology.labels == 0)
    speed = folder.masks["nav2_costmap_2d::SpeedFilter"]
    base, factor = folder.speed
    assert np.array_equal(base + factor * speed.cells, np.where(topology.labels == 2, 40.0, 0.0))
    assert {edge.metadata["speed_limit"] for edge in folder.graph.edges if edge.metadata["room"] == 2} == {40.0}
    assert folder.scorer["narrow"] == 0.1
    tables = yaml.safe_load((out / "nav2.yaml").read_text())
    assert folder.started == {*tables} - {"global_costmap"}
    assert f"start_id: 1, goal_id: {len(topology.rooms)}" in (out / "README.md").read_text()


def test_without_wishes_there_is_no_speed_mask_and_no_operation(result: Path, tmp_path: Path) -> None:
    call("nav2", result, "--out", tmp_path / "nav2")
    folder = nav2_folder.read(tmp_path / "nav2")
    assert [*folder.masks] == ["nav2_costmap_2d::KeepoutFilter"]
    assert not any(edge.operations for edge in folder.graph.edges)
    assert folder.scorer["narrow"] == 10.0


def test_closed_rooms_are_black_and_have_no_edges(result: Path, tmp_path: Path) -> None:
    call("nav2", result, "--out", tmp_path / "nav2", "--room", "1", "--room", "2")
    folder, labels = nav2_folder.read(tmp_path / "nav2"), read_finished(result).topology.labels
    keepout = folder.masks["nav2_costmap_2d::KeepoutFilter"]
    assert np.array_equal(keepout.cells == OCCUPIED, ~np.isin(labels, (1, 2)))
    assert {edge.metadata["room"] for edge in folder.graph.edges} == {1, 2}


def test_no_go_areas_are_black(tmp_path: Path) -> None:
    topology = finished_maps.topology("one room")
    area_m = ((1.0, 1.0), (2.0, 1.0), (2.0, 2.0), (1.0, 2.0))
    own = Annotations(own_origin_cm=(0.0, 0.0), no_go_areas_m=(area_m,))
    for name, data in nav2_files(topology, tmp_path, Nav2Options(), own).items():
        (tmp_path / name).write_bytes(data)
    keepout = nav2_folder.read(tmp_path).masks["nav2_costmap_2d::KeepoutFilter"]
    assert keepout.cells[topology.cell_at((1.5, 1.5))] == OCCUPIED
    assert keepout.cells[topology.cell_at((2.5, 2.5))] != OCCUPIED


def test_a_map_gives_what_its_result_gives(tmp_path: Path) -> None:
    flat = HOME / "recordings" / "flat.yaml"
    call("run", flat, "--out", tmp_path / "result", "-q")
    for source, out in ((tmp_path / "result", "one"), (flat, "other")):
        call("nav2", source, "--out", tmp_path / out)
    for name in ("route.geojson", "keepout.pgm", "keepout.yaml"):
        assert (tmp_path / "one" / name).read_bytes() == (tmp_path / "other" / name).read_bytes()


@pytest.mark.parametrize(
    ("words", "wanted"),
    [
        (("--slow", "2"), "--slow: wanted ROOM=PERCENT"),
        (("--slow", "2=0"), "--slow: wanted ROOM=PERCENT"),
        (("--slow", "9=50"), "--slow"),
        (("--room", "9"), "--room"),
    ],
)
def test_wrong_wishes_are_one_line_and_leave_nothing(
    words: tuple[str, str], wanted: str, result: Path, tmp_path: Path
) -> None:
    line = one_line(call("nav2", result, "--out", tmp_path / "nav2", *words, code=2))
    assert wanted in line
    assert not (tmp_path / "nav2").exists()


def test_files_are_not_overwritten_unasked(result: Path, tmp_path: Path) -> None:
    call("nav2", result, "--out", tmp_path / "nav2")
    assert "already exists" in one_line(call("nav2", result, "--out", tmp_path / "nav2", code=2))
    call("nav2", result, "--out", tmp_path / "nav2", "--force")


def test_the_default_radius_is_the_same_everywhere() -> None:
    of_command = inspect.signature(nav2.nav2).parameters["robot_radius"].default
    of_graph = inspect.signature(nav2_route.to_nav2_route).parameters["radius_m"].default
    assert of_command == of_graph == Nav2Options().radius_m


@pytest.mark.parametrize(
    "spoil",
    [
        lambda tables: tables["vdoor_keepout_info_server"]["ros__parameters"].update(multiplier=1),
        lambda tables: tables["vdoor_keepout_info_server"]["ros__parameters"].update(base=100.0),
        lambda tables: tables["vdoor_keepout_info_server"]["ros__parameters"].update(type=1),
        lambda tables: tables["route_server"]["ros__parameters"]["SemanticScorer"].update(narrow=10),
        lambda tables: tables["route_server"]["ros__parameters"].update(operations=["AdjustSpeedLimit"]),
    ],
)
def test_the_reader_refuses_what_the_servers_refuse(spoil: Callable[[Any], None], tmp_path: Path) -> None:
    options = Nav2Options(door_service="/open")
    for name, data in nav2_files(finished_maps.topology("pillars"), tmp_path, options).items():
        (tmp_path / name).write_bytes(data)
    nav2_folder.read(tmp_path)
    tables = yaml.safe_load((tmp_path / "nav2.yaml").read_text())
    spoil(tables)
    (tmp_path / "nav2.yaml").write_text(yaml.safe_dump(tables))
    with pytest.raises(RefusedError):
        nav2_folder.read(tmp_path)
