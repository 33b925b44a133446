"""Exports: what goes out reads back, with the readers of those who take it, equal to what went in."""

from __future__ import annotations

import dataclasses
import io
import itertools
import json
import math
import re
import xml.etree.ElementTree as ET
from collections.abc import Callable
from pathlib import Path
from typing import Any

import finished_maps
import jsonschema
import networkx as nx
import numpy as np
import pytest
import rmf_loader
import shapely
import yaml
from hypothesis import given, settings
from maps import CELL_M, Cells, law, small_maps, with_search
from PIL import Image

import vdoor
from vdoor import export
from vdoor.errors import SettingError, VdoorError
from vdoor.export import WRITERS, Export, Finished, Raster, Writer, graphs, writer_named
from vdoor.export.geometry import line_m
from vdoor.grid import FREE, OCCUPIED, OccupancyGrid
from vdoor.method.search.optimisers import AnnealingSearch
from vdoor.pipeline import PRESETS
from vdoor.topology import TopologicalMap

example = pytest.mark.parametrize("name", finished_maps.NAMES)
SVG = "{http://www.w3.org/2000/svg}"
HALF_MM = 0.0005 + 1e-9
"""What a coordinate may be off in text."""


def text(topology: TopologicalMap, to: str, **beside: Any) -> str:
    content = Export(writer_named(to)).content(Finished(topology, **beside))
    assert isinstance(content, str)
    return content


def features(topology: TopologicalMap, kind: str) -> list[dict[str, Any]]:
    found = json.loads(text(topology, "geojson"))["features"]
    return [feature for feature in found if feature["properties"]["type"] == kind]


def graph_of(graphml: str) -> nx.MultiGraph[int]:
    graph: nx.MultiGraph[int] = nx.read_graphml(io.BytesIO(graphml.encode()), node_type=int, force_multigraph=True)
    return graph


def ids(to: str, topology: TopologicalMap) -> tuple[set[int], dict[int, set[int]]]:
    """Ids of the rooms that an export names, and of the doors with their rooms."""
    if to == "graphml":
        graph = graph_of(text(topology, to))
        return set(graph), {door: {one, other} for one, other, door in graph.edges(keys=True)}
    if to == "json":
        document = json.loads(text(topology, to))
        doors = {edge["key"]: {edge["source"], edge["target"]} for edge in document["edges"]}
        return {node["id"] for node in document["nodes"]}, doors
    if to == "geojson":
        told = [feature["properties"] for feature in features(topology, "door")]
        rooms = {feature["properties"]["room"] for feature in features(topology, "room")}
        return rooms, {door["door"]: set(door["rooms"]) for door in told}
    if to == "rmf":
        graph = rmf_loader.load(text(topology, to))
        sides = [re.fullmatch(r"door_(\d+)_room_(\d+)", name) for name in graph.names]
        doors = {int(door.removeprefix("door_")): set[int]() for door in graph.doors}
        for side in filter(None, sides):
            doors[int(side[1])].add(int(side[2]))
        return {int(name[5:]) for name in graph.names if name.startswith("room_")}, doors
    if to == "svg":
        root = ET.fromstring(text(topology, to))  # noqa: S314  # our own
        told = {element.get("id", ""): element.findtext(f"{SVG}title", "") for element in root.iter()}
        doors = {int(name[5:]): told[name] for name in told if name.startswith("door-")}
        pairs = {door: set(map(int, re.findall(r"\d+", title.split("rooms")[1]))) for door, title in doors.items()}
        return {int(name[5:]) for name in told if name.startswith("room-")}, pairs
    places = [one for one in json.loads(text(topology, to))["features"] if one["geometry"]["type"] == "Point"]
    route = [place["properties"]["metadata"] for place in places]
    rooms = {told["room"] for told in route if told["class"] == "room"}
    return rooms, {told["door"]: set(told["rooms"]) for told in route if told["class"] == "door"}


@example
@pytest.mark.parametrize("to", ["graphml", "json", "geojson", "rmf", "svg", "nav2-route"])
def test_ids_of_rooms_and_doors_are_the_same_in_every_format(name: str, to: str) -> None:
    topology = finished_maps.topology(name)
    assert ids(to, topology) == ({room.id for room in topology.rooms}, {d.id: set(d.rooms) for d in topology.doors})


@example
def test_graphml_reads_back_as_the_graph_with_each_point_in_two_columns(name: str) -> None:
    topology = finished_maps.topology(name)
    graph, source = graph_of(text(topology, "graphml")), topology.to_networkx()
    for room, told in graph.nodes(data=True):
        wanted = source.nodes[room]
        assert told["area_m2"] == wanted["area_m2"]
        assert (told["centre_x_m"], told["centre_y_m"]) == wanted["centre_m"]
    for one, other, door, told in graph.edges(keys=True, data=True):
        wanted = source.edges[one, other, door]
        for end in ("start", "end"):
            assert (told.pop(f"{end}_x_m"), told.pop(f"{end}_y_m")) == wanted[f"{end}_m"]
        assert told == {key: wanted[key] for key in ("kind", "width_m", "length_m", "tilt_deg")}


@example
def test_json_follows_its_schema_and_networkx_reads_all_of_it(name: str) -> None:
    topology = finished_maps.topology(name)
    document = json.loads(text(topology, "json"))
    jsonschema.Draft202012Validator.check_schema(graphs.schema())
    jsonschema.validate(document, graphs.schema())
    assert document["version"] == graphs.VERSION
    graph = nx.node_link_graph(document, edges="edges")
    source = topology.to_networkx()
    assert isinstance(graph, nx.MultiGraph)
    assert sorted(graph.edges(keys=True)) == sorted(source.edges(keys=True))
    for one, other, door, told in graph.edges(keys=True, data=True):
        points = {end: tuple(told[end]) for end in ("start_m", "end_m")}
        assert told | points == source.edges[one, other, door]
    for room in topology.rooms:
        told = graph.nodes[room.id]
        assert tuple(tuple(map(tuple, ring)) for ring in told["polygon_m"]) == room.polygon_m
        assert (tuple(told["neighbours"]), len(told["corners"])) == (room.neighbours, len(room.corners))
    lies = document["graph"]
    assert (lies["resolution_m"], lies["size"]["width"]) == (topology.frame.resolution_m, topology.frame.width)
    assert lies["origin"]["yaw_rad"] == topology.frame.yaw_rad


@pytest.mark.parametrize(
    "spoil",
    [
        lambda document: document.update(version=2),
        lambda document: document["nodes"][0].pop("polygon_m"),
        lambda document: document["nodes"][0].update(id="1"),
        lambda document: document["nodes"][0]["centre_m"].append(0.0),
        lambda document: document["edges"][0].update(kind=None),
        lambda document: document["edges"][0].update(key=0),
        lambda document: document["graph"].update(resolution_m=0),
    ],
)
def test_schema_refuses_what_no_export_looks_like(spoil: Callable[[Any], None]) -> None:
    document = json.loads(text(finished_maps.topology("pillars"), "json"))
    spoil(document)
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate(document, graphs.schema())


@example
def test_polygons_are_valid_turn_as_geojson_wants_and_hold_just_their_rooms_cells(name: str) -> None:
    topology = finished_maps.topology(name)
    x_m, y_m = topology.frame.world_from_cell(np.indices(topology.labels.shape).reshape(2, -1).T).T
    for told, room in zip(features(topology, "room"), topology.rooms, strict=True):
        polygon = shapely.geometry.shape(told["geometry"])
        assert polygon.is_valid
        assert polygon.area == pytest.approx(room.area_m2, abs=polygon.length * HALF_MM)
        assert polygon.exterior.is_ccw
        assert not any(hole.is_ccw for hole in polygon.interiors)
        inside = shapely.contains_xy(polygon, x_m, y_m).reshape(topology.labels.shape)
        assert np.array_equal(inside, topology.labels == room.id)
        assert told["id"] == f"room-{room.id}"
        assert told["properties"]["centre_m"] == pytest.approx(room.centre_m, abs=HALF_MM)


def test_pillars_are_holes() -> None:
    holes = [
        len(feature["geometry"]["coordinates"]) - 1 for feature in features(finished_maps.topology("pillars"), "room")
    ]
    assert holes == [1, 0, 2]


@example
def test_doors_are_lines_as_long_as_they_say(name: str) -> None:
    topology = finished_maps.topology(name)
    for told, door in zip(features(topology, "door"), topology.doors, strict=True):
        line = shapely.geometry.shape(told["geometry"])
        assert line.is_valid
        assert line.length == pytest.approx(door.length_m, abs=4 * HALF_MM)
        if door.kind != "passage":
            assert np.array(line.coords) == pytest.approx(np.array([door.start_m, door.end_m]), abs=HALF_MM)
            assert np.array_equal(np.array(line.coords), np.array(line.coords).round(3))


def test_a_slit_of_one_cell_is_a_line_across_it() -> None:
    topology = finished_maps.topology("slit")
    slit = topology.doors[2]
    assert (slit.kind, slit.start_m) == ("passage", slit.end_m)
    (x_m, y_m), (to_x_m, to_y_m) = line_m(topology, slit)
    assert x_m == pytest.approx(to_x_m)
    assert abs(to_y_m - y_m) == pytest.approx(slit.width_m)


@example
@pytest.mark.parametrize("suffix", [".png", ".pgm"])
def test_label_image_and_yaml_read_back(name: str, suffix: str, tmp_path: Path) -> None:
    topology = finished_maps.topology(name)
    image, about = export.save(topology, tmp_path / f"rooms{suffix}", "labels")
    assert np.array_equal(np.asarray(Image.open(image)), topology.labels)
    told = yaml.safe_load(about.read_text())
    frame = topology.frame
    assert (told["image"], told["resolution"]) == (image.name, frame.resolution_m)
    assert told["origin"] == [frame.x_m, frame.y_m, frame.yaw_rad]


def test_map_server_reads_room_ids_from_a_pgm(tmp_path: Path) -> None:
    topology = finished_maps.topology("flat")
    export.save(topology, tmp_path / "rooms.pgm", "labels")
    assert np.array_equal(vdoor.read_map(tmp_path / "rooms.yaml").cells, topology.labels)


def test_more_rooms_than_raw_mode_has_values_take_16_bits(tmp_path: Path) -> None:
    labels = np.arange(1, 121, dtype=np.uint16).reshape(10, 12)
    grid = OccupancyGrid.from_array(np.zeros((10, 12), np.int8), 0.1)
    files = dict(Raster(labels, grid, "raw").files(tmp_path / "rooms.pgm"))
    assert files[tmp_path / "rooms.pgm"].startswith(b"P5\n12 10\n65535\n")
    assert np.array_equal(np.asarray(Image.open(io.BytesIO(files[tmp_path / "rooms.pgm"]))), labels)


@pytest.mark.filterwarnings("ignore::vdoor.MapWarning")  # a mask is hardly free, which a map seldom is
@pytest.mark.filterwarnings("ignore:origin")
@pytest.mark.parametrize("suffix", [".png", ".pgm"])
@pytest.mark.parametrize(("name", "rooms"), [("flat", (2, 3)), ("pillars", (3,)), ("one room", (1,))])
def test_keepout_mask_is_free_in_the_chosen_rooms_and_shut_elsewhere(
    name: str, rooms: tuple[int, ...], suffix: str, tmp_path: Path
) -> None:
    topology = finished_maps.topology(name)
    image, about = export.save(topology, tmp_path / f"mask{suffix}", "keepout", rooms=rooms)
    mask = vdoor.read_map(about)
    wanted = np.where(np.isin(topology.labels, rooms), FREE, OCCUPIED)
    assert image.suffix == suffix
    assert np.array_equal(mask.cells, wanted)
    assert mask.frame == topology.frame


def walls(topology: TopologicalMap, *rooms: int) -> list[tuple[tuple[int, int], ...]]:
    content = Export(writer_named("virtual-walls"), rooms=rooms).content(Finished(topology))
    assert isinstance(content, str)
    document = json.loads(content)
    assert document["restrictedZones"] == []
    ends = (wall["points"] for wall in document["virtualWalls"])
    return [tuple((end["x"], end["y"]) for end in (points["pA"], points["pB"])) for points in ends]


def test_virtual_walls_count_centimetres_down_from_the_images_corner() -> None:
    topology = finished_maps.topology("flat")
    door = topology.doors[0]
    height_cm = topology.frame.height * 20
    wanted = tuple((round(100 * x_m), height_cm - round(100 * y_m)) for x_m, y_m in (door.start_m, door.end_m))
    assert walls(topology)[0] == wanted
    assert len(walls(topology)) == len(topology.doors)


def test_virtual_walls_of_a_robots_own_map_are_in_its_own_frame() -> None:
    topology = finished_maps.topology("flat")
    (at, _), height_cm = walls(topology)[0], topology.frame.height * 20
    own_origin_cm = (1000.0, 2000.0 + height_cm)
    known = dataclasses.replace(topology, own_origin_cm=own_origin_cm)
    (moved, _) = walls(known)[0]
    assert moved == (at[0] + 1000, at[1] + 2000)
    assert export.to_virtual_walls(topology, own_origin_cm=own_origin_cm) == export.to_virtual_walls(known)


def test_virtual_walls_do_not_depend_on_where_the_map_frame_lies() -> None:
    askew = finished_maps.grid("pillars")
    straight = OccupancyGrid.from_array(askew.cells, CELL_M)
    assert walls(finished_maps.topology("pillars")) == walls(vdoor.run(straight, "paper"))


def test_virtual_walls_around_rooms_leave_the_doors_between_them_open() -> None:
    topology = finished_maps.topology("pillars")
    every = walls(topology)
    assert [door.rooms for door in topology.doors] == [(1, 2), (2, 3), (1, 2)]
    assert walls(topology, 1) == [every[0], every[2]]
    assert walls(topology, 1, 2) == [every[1]]
    assert walls(topology, 1, 2, 3) == []


@pytest.mark.parametrize("to", ["keepout", "virtual-walls"])
def test_rooms_that_are_not_there_are_refused(to: str) -> None:
    with pytest.raises(SettingError, match="5 rooms, found 9"):
        Export(writer_named(to), Path("x.png"), (1, 9)).content(Finished(finished_maps.topology("flat")))


@example
def test_rmf_lanes_through_a_door_name_it_and_no_others_do(name: str) -> None:
    graph = rmf_loader.load(text(finished_maps.topology(name), "rmf"))
    bends = sum("_bend_" in name for name in graph.names)
    assert len(graph.lanes) == 6 * len(graph.doors) + 2 * bends
    assert {(end, start, door) for start, end, door in graph.lanes} == set(graph.lanes)
    for start, end, door in graph.lanes:
        lane = shapely.LineString([graph.places[start], graph.places[end]])
        assert {other for other, ends in graph.doors.items() if lane.intersects(shapely.LineString(ends))} == (
            {door} if door else set()
        )


@example
def test_rmf_waypoints_are_in_their_rooms(name: str) -> None:
    topology = finished_maps.topology(name)
    graph = rmf_loader.load(text(topology, "rmf"))
    cells = np.rint(topology.frame.cell_from_world(np.array(graph.places))).astype(int)
    rooms = [int(waypoint.split("room_")[1].split("_")[0]) for waypoint in graph.names]
    assert topology.labels[tuple(cells.T)].tolist() == rooms


@pytest.mark.parametrize("writer", [writer for writer in WRITERS if not writer.image], ids=lambda writer: writer.name)
@pytest.mark.parametrize("field", ["area_m2", "start_m", "width_m", "vertex_m", "feature_m"])
@pytest.mark.parametrize("number", [math.nan, math.inf])
def test_numbers_that_are_not_finite_are_refused(writer: Writer, field: str, number: float) -> None:
    topology = finished_maps.topology("flat")
    values = getattr(topology, field).copy()
    values.flat[0] = number
    with pytest.raises(VdoorError, match=f"wanted finite numbers, found {number} in {field}"):
        writer.write(dataclasses.replace(topology, **{field: values}))


@example
def test_svg_draws_each_room_where_its_cells_are_in_the_image(name: str) -> None:
    topology = finished_maps.topology(name)
    root = ET.fromstring(text(topology, "svg"))  # noqa: S314  # our own
    left, top, width, height = map(float, root.get("viewBox", "").split())
    centre_m = (np.indices(topology.labels.shape).reshape(2, -1).T[:, ::-1] + 0.5) * topology.frame.resolution_m
    for room in topology.rooms:
        path = root.find(f".//{SVG}path[@id='room-{room.id}']")
        assert path is not None
        rings = [
            [tuple(map(float, point.split(","))) for point in ring.split()]
            for ring in path.get("d", "").removesuffix("Z").removeprefix("M").split("Z M")
        ]
        drawn = shapely.Polygon(rings[0], rings[1:])
        inside = shapely.contains_xy(drawn, *centre_m.T).reshape(topology.labels.shape)
        assert np.array_equal(inside, topology.labels == room.id)
        assert shapely.box(left, top, left + width, top + height).contains(drawn)


@example
def test_exports_from_a_result_folder_are_those_of_the_map_itself(name: str, tmp_path: Path) -> None:
    source = Finished(finished_maps.topology(name))
    again = export.read_finished(finished_maps.result(name, tmp_path / "result"))
    for writer in WRITERS:
        path = tmp_path / f"{writer.name}.png"
        wanted = Export(writer, path, (1,) if writer.needs_rooms else ())
        before = [file.read_bytes() for file in wanted.write(source)]
        assert [file.read_bytes() for file in wanted.write(again)] == before, writer.name


@pytest.mark.parametrize("cell_m", [0.2, 0.05, 0.004])
def test_rounding_a_map_once_more_changes_nothing_and_keeps_every_cell(cell_m: float) -> None:
    grid = finished_maps.grid("pillars")
    askew = dataclasses.replace(grid, frame=dataclasses.replace(grid.frame, resolution_m=cell_m))
    topology = dataclasses.replace(finished_maps.topology("pillars"), frame=askew.frame)
    points_m = askew.frame.world_from_cell(np.arange(26).reshape(13, 2) / 2)
    drawn = dataclasses.replace(topology, feature_m=np.resize(points_m, topology.feature_m.shape))
    once = drawn.written
    for name in ("start_m", "length_m", "area_m2", "tilt_rad", "vertex_m", "feature_m"):
        assert np.array_equal(getattr(once.written, name), getattr(once, name)), name
    apart_cells = askew.frame.cell_from_world(once.feature_m) - askew.frame.cell_from_world(drawn.feature_m)
    assert 0 < np.abs(apart_cells).max() < 0.05


@settings(law, max_examples=12)
@given(small_maps())
def test_any_map_comes_out_and_reads_back(cells: Cells) -> None:
    grid = OccupancyGrid.from_array(cells, CELL_M, x_m=3.0, y_m=-70.0, yaw_rad=2.5)
    topology = vdoor.run(grid, with_search(PRESETS["default"], AnnealingSearch()))
    wanted = {room.id for room in topology.rooms}, {door.id: set(door.rooms) for door in topology.doors}
    for to in ("graphml", "json", "geojson", "rmf", "svg", *(["nav2-route"] if topology.doors else [])):
        assert ids(to, topology) == wanted, to
    jsonschema.validate(json.loads(text(topology, "json")), graphs.schema())
    for told, room in zip(features(topology, "room"), topology.rooms, strict=True):
        polygon = shapely.geometry.shape(told["geometry"])
        assert polygon.is_valid
        assert polygon.area == pytest.approx(room.area_m2, abs=0.0005 * polygon.length + 1e-9)
    for told in features(topology, "door"):
        assert shapely.geometry.shape(told["geometry"]).is_valid
    assert len(walls(topology)) == len(topology.doors)


def test_formats_are_told_apart_and_wrong_ones_refused() -> None:
    names = [writer.name for writer in WRITERS]
    assert len(set(names)) == len(names)
    with pytest.raises(SettingError, match="did you mean 'graphml'"):
        writer_named("gml")
    for wrong in ("svg", "svg=", "=x.svg", ""):
        with pytest.raises(SettingError):
            Export.parse(wrong)
    assert Export.parse("labels=a/b.pgm").files == [Path("a/b.pgm"), Path("a/b.yaml")]


def test_pairs_of_rooms_may_have_two_doors() -> None:
    doors = finished_maps.topology("pillars").doors
    assert any(one.rooms == other.rooms for one, other in itertools.combinations(doors, 2))
