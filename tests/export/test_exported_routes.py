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
from vdoor.export import to_nav2_route, to_rmf
from vdoor.export.routes import doorways
from vdoor.grid import OccupancyGrid
from vdoor.synth import Home, synthesize
from vdoor.topology import TopologicalMap


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
def test_lanes_and_edges_stay_in_their_rooms_on_any_map(cells: Cells) -> None:
    topology = vdoor.run(OccupancyGrid.from_array(cells, CELL_M), "default")
    check_rmf(topology)
    if topology.doors:
        check_chains(topology)


def test_lanes_and_edges_stay_in_the_bent_rooms_of_a_home() -> None:
    home = synthesize(Home(), np.random.default_rng(4))
    topology = vdoor.run(home.grid, "default")
    check_rmf(topology)
    graph = check_chains(topology)
    assert any(node.metadata["kind"] == "waypoint" for node in graph.nodes.values())


def check_rmf(topology: TopologicalMap) -> rmf_loader.Graph:
    """Lanes keep to their rooms' cells, and lead from every room to every door of it."""
    graph = rmf_loader.load(to_rmf(topology))
    rooms = dict.fromkeys(range(len(graph.places)), 0)
    for name, index in graph.names.items():
        rooms[index] = int(name.split("room_")[1].split("_")[0])
    for start, end, door in graph.lanes:
        assert (rooms[start] != rooms[end]) == (door is not None)
        free = space(topology, rooms[start], rooms[end])
        assert outside_m((graph.places[start], graph.places[end]), free) == pytest.approx(0, abs=1e-9)
    for room in topology.rooms:
        within: nx.Graph[int] = nx.Graph([(a, b) for a, b, door in graph.lanes if not door and rooms[a] == room.id])
        within.add_node(graph.names[f"room_{room.id}"])
        waiting = {index for name, index in graph.names.items() if name.endswith(f"_room_{room.id}")}
        assert waiting <= set(nx.node_connected_component(within, graph.names[f"room_{room.id}"]))
    return graph


@with_doors
def test_the_route_server_takes_the_graph(name: str) -> None:
    topology = finished_maps.topology(name)
    graph = nav2_loader.load(to_nav2_route(topology))
    rooms, ways = {room.id: room for room in topology.rooms}, {way.door.id: way for way in doorways(topology)}
    assert len(set(graph.ids)) == len(graph.ids)
    assert {node.frame for node in graph.nodes.values()} == {"map"}
    kinds = [node.metadata["kind"] for node in graph.nodes.values()]
    assert (kinds.count("room"), kinds.count("door")) == (len(rooms), len(ways))
    for number, node in graph.nodes.items():
        if node.metadata["kind"] == "room":
            assert (number, node.place) == (node.metadata["room"], rooms[number].centre_m)
        elif node.metadata["kind"] == "door":
            way = ways[node.metadata["door"]]
            assert (node.place, tuple(node.metadata["rooms"])) == (way.middle_m, way.door.rooms)
    assert {(edge.end, edge.start, edge.cost) for edge in graph.edges} == {
        (edge.start, edge.end, edge.cost) for edge in graph.edges
    }
    for edge in graph.edges:  # what the default scorer makes of it
        assert edge.cost == math.dist(graph.nodes[edge.start].place, graph.nodes[edge.end].place)
        assert edge.overridable


@with_doors
def test_edges_lead_from_each_door_to_its_rooms_at_what_the_way_costs(name: str) -> None:
    check_chains(finished_maps.topology(name))


def test_edges_lead_around_a_bend() -> None:
    graph = check_chains(bent(16, 60, 60))
    assert any(node.metadata["kind"] == "waypoint" for node in graph.nodes.values())


def check_chains(topology: TopologicalMap) -> nav2_loader.Graph:
    """Edges of a way are one chain from its door to its room, within the room, as long as the way is."""
    graph = nav2_loader.load(to_nav2_route(topology))
    doors = {node.metadata["door"]: number for number, node in graph.nodes.items() if node.metadata["kind"] == "door"}
    used = 0
    for way in doorways(topology):
        for side in way.sides:
            told = {"kind": "way", "door": way.door.id, "room": side.room}
            own = [edge for edge in graph.edges if edge.metadata == told]
            chain = nx.DiGraph([(edge.start, edge.end, {"cost": edge.cost}) for edge in own])
            route = nx.shortest_path(chain, doors[way.door.id], side.room)
            assert len(own) == 2 * (len(route) - 1)
            assert nx.path_weight(chain, route, "cost") == pytest.approx(side.cost_m)
            places = tuple(graph.nodes[node].place for node in route)
            assert places == pytest.approx(np.array(side.points_m))
            assert outside_m(places, space(topology, side.room)) == pytest.approx(0, abs=1e-9)
            bends = [graph.nodes[node].metadata for node in route[1:-1]]
            assert bends == [told | {"kind": "waypoint"}] * len(bends)
            used += len(own)
    assert used == len(graph.edges)
    return graph


def test_a_route_between_rooms_takes_the_nearer_of_two_doors() -> None:
    graph = nav2_loader.load(to_nav2_route(finished_maps.topology("pillars")))
    routes: nx.DiGraph[int] = nx.DiGraph()
    routes.add_weighted_edges_from((edge.start, edge.end, edge.cost) for edge in graph.edges)
    passed = [graph.nodes[node].metadata for node in nx.dijkstra_path(routes, 1, 3, "weight")]
    assert [told["door"] for told in passed if told["kind"] == "door"] in ([1, 2], [3, 2])
    assert [told["room"] for told in passed if told["kind"] == "room"] == [1, 2, 3]


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
