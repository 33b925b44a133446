"""What Nav2's route server and Open-RMF are told of the ways between rooms."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import finished_maps
import nav2_loader
import networkx as nx
import numpy as np
import pytest
import rmf_loader
import shapely
from hypothesis import given
from labelled_maps import bent, labelled, with_doors
from maps import CELL_M, Cells, law, small_maps
from nav2_loader import RefusedError

import vdoor
from vdoor.errors import VdoorError
from vdoor.export import to_nav2_route, to_rmf
from vdoor.grid import OccupancyGrid
from vdoor.synth import Home, synthesize
from vdoor.topology import TopologicalMap

MM = 0.001
"""To which coordinates are written."""


def space(topology: TopologicalMap, *rooms: int) -> shapely.Geometry:
    """All places in some rooms."""
    polygons = [topology.polygon_m(room) for room in rooms]
    return shapely.union_all([shapely.Polygon(outer, holes) for outer, *holes in polygons])


def outside_m(line: tuple[tuple[float, float], ...], place: shapely.Geometry) -> float:
    return float(shapely.LineString(line).difference(place).length)


def test_rmf_robots_wait_half_a_metre_before_a_door_or_where_a_wall_leaves_them() -> None:
    topology = labelled("11011122222222\n11111100000000", ((1, 2), (0, 5.5)), cell_m=0.1)
    graph = rmf_loader.load(to_rmf(topology))
    places = topology.frame.cell_from_world(
        np.array([graph.places[graph.names[f"door_1_room_{room}"]] for room in (1, 2)])
    )
    assert places == pytest.approx(np.array([(0, 3), (0, 10)]))


@with_doors
def test_rmf_lanes_stay_in_the_rooms_they_name(name: str) -> None:
    check_rmf(finished_maps.topology(name))


def test_rmf_lanes_go_around_a_bend() -> None:
    graph = check_rmf(bent(16, 60, 60))
    assert any("_bend_" in name for name in graph.names)


@law
@given(small_maps(most=16))
def test_lanes_stay_in_their_rooms_on_any_map(cells: Cells) -> None:
    topology = vdoor.run(OccupancyGrid.from_array(cells, CELL_M), "default")
    check_rmf(topology)


def test_lanes_stay_in_the_bent_rooms_of_a_home() -> None:
    home = synthesize(Home(), np.random.default_rng(4))
    check_rmf(vdoor.run(home.grid, "default"))


def check_rmf(topology: TopologicalMap) -> rmf_loader.Graph:
    """Lanes keep to their rooms' cells, and lead from every room to every door of it."""
    graph = rmf_loader.load(to_rmf(topology))
    rooms = dict.fromkeys(range(len(graph.places)), 0)
    for name, index in graph.names.items():
        rooms[index] = int(name.split("room_")[1].split("_")[0])
    for start, end, door in graph.lanes:
        assert (rooms[start] != rooms[end]) == (door is not None)
        free = space(topology, rooms[start], rooms[end]).buffer(MM)
        assert outside_m((graph.places[start], graph.places[end]), free) == pytest.approx(0, abs=1e-9)
    for room in topology.rooms:
        within: nx.Graph[int] = nx.Graph([(a, b) for a, b, door in graph.lanes if not door and rooms[a] == room.id])
        within.add_node(graph.names[f"room_{room.id}"])
        waiting = {index for name, index in graph.names.items() if name.endswith(f"_room_{room.id}")}
        assert waiting <= set(nx.node_connected_component(within, graph.names[f"room_{room.id}"]))
    return graph


@pytest.mark.parametrize("name", finished_maps.NAMES)
def test_the_route_server_takes_the_graph(name: str) -> None:
    topology = finished_maps.topology(name)
    graph = nav2_loader.load(to_nav2_route(topology))
    rooms = {room.id: room for room in topology.rooms}
    doors = {node.metadata["door"] for node in graph.nodes.values() if node.metadata["class"] == "door"}
    assert len(set(graph.ids)) == len(graph.ids)
    assert {node.frame for node in graph.nodes.values()} == {"map"}
    assert doors == {door.id for door in topology.doors}
    own = {number: node for number, node in graph.nodes.items() if node.metadata["class"] == "room"}
    assert {number: node.metadata["room"] for number, node in own.items()} == {number: number for number in rooms}
    for number, node in own.items():
        assert math.dist(node.place, rooms[number].centre_m) < 0.5
    assert {(edge.end, edge.start, edge.cost) for edge in graph.edges} == {
        (edge.start, edge.end, edge.cost) for edge in graph.edges
    }
    for edge in graph.edges:  # what the default scorer makes of it
        assert edge.cost == round(math.dist(graph.nodes[edge.start].place, graph.nodes[edge.end].place), 3)
        assert edge.overridable
        place = space(topology, edge.metadata["room"]).buffer(1e-3)
        assert outside_m((graph.nodes[edge.start].place, graph.nodes[edge.end].place), place) == pytest.approx(0)


def test_points_are_whole_millimetres() -> None:
    for node in nav2_loader.load(to_nav2_route(finished_maps.topology("pillars"))).nodes.values():
        assert [round(value, 3) for value in node.place] == [*node.place]


def test_edges_say_what_they_are_for_the_semantic_scorer() -> None:
    topology = labelled("1111111111\n" * 6 + "0000100000\n" + "2222222222\n" * 6, ((1, 2), (6.5, 4)), cell_m=0.2)
    graph = nav2_loader.load(to_nav2_route(topology, radius_m=0.09))
    doors = {number for number, node in graph.nodes.items() if node.metadata["class"] == "door"}
    for edge in graph.edges:
        assert edge.metadata["class"] == ("door" if {edge.start, edge.end} & doors else "room")
    narrow = nav2_loader.load(to_nav2_route(topology, radius_m=0.3))
    told = {edge.metadata["class"]: edge.metadata["clearance_m"] for edge in narrow.edges}
    assert told == {"room": 0.3, "narrow": pytest.approx(0.1)}


def test_where_a_room_is_slow_every_edge_has_a_speed_limit_as_a_decimal_number() -> None:
    topology = finished_maps.topology("pillars")
    graph = nav2_loader.load(to_nav2_route(topology, speed_percent={2: 40}))
    assert {edge.metadata["room"]: edge.metadata["speed_limit"] for edge in graph.edges} == {
        1: 100.0,
        2: 40.0,
        3: 100.0,
    }
    plain = nav2_loader.load(to_nav2_route(topology))
    assert not any("speed_limit" in edge.metadata for edge in plain.edges)


def test_doors_are_opened_by_the_edges_that_lead_to_them() -> None:
    topology = finished_maps.topology("pillars")
    graph = nav2_loader.load(to_nav2_route(topology, door_service="/doors/{door}/open"))
    for edge in graph.edges:
        door = graph.nodes[edge.end].metadata.get("door")
        told = {"service_name": f"/doors/{door}/open", "door": door}
        assert edge.operations == ([("TriggerEvent", "ON_ENTER", told)] if door else [])


def test_a_map_in_which_the_robot_has_no_two_places_has_no_route_graph() -> None:
    with pytest.raises(VdoorError, match=r"two places for a robot of radius 0\.22 m, found one"):
        to_nav2_route(labelled("111\n111\n111", cell_m=0.05))


def test_a_route_between_rooms_takes_the_nearer_of_two_doors() -> None:
    graph = nav2_loader.load(to_nav2_route(finished_maps.topology("pillars")))
    routes: nx.DiGraph[int] = nx.DiGraph()
    routes.add_weighted_edges_from((edge.start, edge.end, edge.cost) for edge in graph.edges)
    passed = [graph.nodes[node].metadata for node in nx.dijkstra_path(routes, 1, 3, "weight")]
    assert [told["door"] for told in passed if told["class"] == "door"] in ([1, 2], [3, 2])
    rooms = [told["room"] for told in passed if "room" in told]
    assert [room for room, after in zip(rooms, [*rooms[1:], 0], strict=True) if room != after] == [1, 2, 3]


@pytest.mark.parametrize(
    "spoil",
    [
        lambda graph: graph.edges.clear(),
        lambda graph: graph.nodes.clear(),
        lambda graph: graph.nodes.pop(0),
        lambda graph: graph.nodes[0]["properties"].pop("id"),
        lambda graph: graph.nodes[0]["properties"].update(id=-1),
        lambda graph: graph.nodes[0]["properties"]["metadata"].update(name=None),
        lambda graph: graph.nodes[0]["properties"]["metadata"].update(polygon=[[0.0, 1.0]]),
        lambda graph: graph.nodes[0]["geometry"].update(coordinates=["x", "y"]),
        lambda graph: graph.edges[0]["properties"].pop("startid"),
        lambda graph: graph.edges[0]["properties"].update(endid=10**6),
        lambda graph: graph.edges[0]["properties"].update(cost=0.0, overridable=False),
        lambda graph: graph.edges[0]["properties"].update(cost=math.nan),
        lambda graph: graph.edges[0]["properties"]["metadata"].update(speed_limit=50),
        lambda graph: graph.nodes[0]["properties"]["metadata"].update({"class": 3}),
        lambda graph: graph.edges[0]["properties"].update(operations=[{"type": "TriggerEvent"}]),
        lambda graph: graph.edges[0]["properties"].update(operations=[{"type": "Open", "trigger": "ON_ENTER"}]),
        lambda graph: graph.edges[0]["properties"].update(operations=[{"type": "TriggerEvent", "trigger": "ENTER"}]),
        lambda graph: graph.edges[0]["properties"].update(
            operations=[{"type": "TriggerEvent", "trigger": "ON_ENTER", "metadata": {"service_name": ""}}]
        ),
    ],
)
def test_the_reader_refuses_what_the_route_server_refuses(spoil: Callable[[Any], None]) -> None:
    features = json.loads(to_nav2_route(finished_maps.topology("flat")))["features"]
    nodes = [feature for feature in features if feature["geometry"]["type"] == "Point"]
    edges = [feature for feature in features if feature["geometry"]["type"] == "LineString"]
    graph = SimpleNamespace(nodes=nodes, edges=edges)
    nav2_loader.load(json.dumps({"features": nodes + edges}))
    spoil(graph)
    with pytest.raises(RefusedError):
        nav2_loader.load(json.dumps({"features": nodes + edges}))
