"""Ways from doors to rooms: as long as they are to walk, and what Nav2's route server is told of them."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import finished
import nav2_loader
import networkx as nx
import numpy as np
import pytest
import rmf_loader
from hypothesis import given
from maps import CELL_M, Cells, law, small_maps
from nav2_loader import RefusedError

import vdoor
from vdoor.errors import VdoorError
from vdoor.export import to_nav2_route, to_rmf
from vdoor.export.reading import _assembled
from vdoor.export.ways import doorways
from vdoor.grid import OccupancyGrid
from vdoor.record import Frame
from vdoor.topology import Door, TopologicalMap

WITH_DOORS = [name for name in finished.NAMES if name != "one room"]
with_doors = pytest.mark.parametrize("name", WITH_DOORS)
DIAGONAL = math.sqrt(2)


def labelled(text: str, *doors: tuple[tuple[int, int], tuple[float, float]], cell_m: float = 1.0) -> TopologicalMap:
    """A map of digits, the rooms, with doors of one cell given by their two rooms and their row, col."""
    labels = np.array([[int(sign) for sign in line] for line in text.split()], np.int32)
    frame = Frame(*labels.shape, resolution_m=cell_m)
    made = []
    for number, (rooms, place) in enumerate(doors, start=1):
        ((x_m, y_m),) = frame.world_from_cell(np.array([place])).tolist()
        made.append(Door(number, rooms, (x_m, y_m), (x_m, y_m), cell_m, cell_m, 0.0, "passage"))
    return _assembled(labels, frame, made, [])


def costs(topology: TopologicalMap) -> list[tuple[float, float]]:
    return [(way.sides[0].cost_m, way.sides[1].cost_m) for way in doorways(topology)]


def test_a_straight_corridor_costs_its_length() -> None:
    assert costs(labelled("11111222", ((1, 2), (0, 4.5)))) == [(2.5, 1.5)]


def test_ways_go_around_walls() -> None:
    topology = labelled(
        """
        1111100
        1000100
        1111122
        """,
        ((1, 2), (2, 4.5)),
    )
    assert tuple(topology.centre[0]) == (0, 2)
    assert costs(topology)[0][0] == 4.5


def test_a_way_does_not_slip_between_two_cells_that_touch_at_a_corner() -> None:
    topology = labelled(
        """
        1111110
        1000010
        1001110
        1011011
        1010012
        1110111
        """,
        ((1, 2), (4, 5.5)),
    )
    centre, door = tuple(topology.centre[0].tolist()), (4, 5)
    around = nx.dijkstra_path_length(graph_of(topology.labels == 1), centre, door)
    through = nx.dijkstra_path_length(graph_of(topology.labels == 1, slip=True), centre, door)
    assert through < around
    assert costs(topology)[0][0] == pytest.approx(around + 0.5)


def test_diagonal_steps_are_taken_where_all_four_cells_are_free() -> None:
    topology = labelled("11100\n11100\n11122", ((1, 2), (2, 2.5)))
    assert tuple(topology.centre[0]) == (1, 1)
    assert costs(topology)[0][0] == pytest.approx(DIAGONAL + 0.5)


def test_a_way_stays_in_its_room_even_if_another_one_were_shorter() -> None:
    topology = labelled(
        """
        11111111
        10000001
        10222201
        10233201
        """,
        ((1, 2), (0.5, 2)),
    )
    with pytest.raises(VdoorError, match="touch"):
        doorways(topology)
    ring = labelled(
        """
        1111111
        1222221
        1222221
        1000001
        1111111
        """,
        ((1, 2), (2, 5.5)),
    )
    lengths = nx.single_source_dijkstra_path_length(graph_of(ring.labels == 1), tuple(ring.centre[0].tolist()))
    assert costs(ring)[0][0] == pytest.approx(lengths[2, 6] + 0.5)


def test_rmf_robots_wait_half_a_metre_before_a_door_or_where_a_wall_leaves_them() -> None:
    topology = labelled("11011122222222\n11111100000000", ((1, 2), (0, 5.5)), cell_m=0.1)
    graph = rmf_loader.load(to_rmf(topology))
    places = topology.frame.cell_from_world(
        np.array([graph.places[graph.names[f"door_1_room_{room}"]] for room in (1, 2)])
    )
    assert places == pytest.approx(np.array([(0, 3), (0, 10.5)]))


def test_a_room_in_two_parts_is_refused() -> None:
    with pytest.raises(VdoorError, match="room 1"):
        doorways(labelled("11101\n00002", ((1, 2), (0.5, 4))))


def graph_of(own: np.ndarray[Any, np.dtype[np.bool_]], *, slip: bool = False) -> nx.Graph[tuple[int, int]]:
    """Steps between the cells of a mask, by the rule as it is told, cell by cell."""
    graph: nx.Graph[tuple[int, int]] = nx.Graph()
    cells = {(int(row), int(col)) for row, col in np.argwhere(own)}
    graph.add_nodes_from(cells)
    for row, col in cells:
        for down, right in ((0, 1), (1, 0), (1, 1), (1, -1)):
            needed = {(row + down, col + right)}
            if not slip:
                needed |= {(row, col + right), (row + down, col)}
            if needed <= cells:
                graph.add_edge((row, col), (row + down, col + right), weight=math.hypot(down, right))
    return graph


def check_against_networkx(topology: TopologicalMap) -> None:
    for way in doorways(topology):
        for side in way.sides:
            centre = tuple(topology.centre[side.room - 1].tolist())
            graph = graph_of(topology.labels == side.room)
            steps = nx.dijkstra_path_length(graph, centre, side.cell)
            assert side.cost_m == pytest.approx((steps + 0.5) * topology.frame.resolution_m)


@with_doors
def test_costs_are_those_that_networkx_finds(name: str) -> None:
    check_against_networkx(finished.topology(name))


@law
@given(small_maps(most=14))
def test_costs_are_those_that_networkx_finds_on_any_map(cells: Cells) -> None:
    check_against_networkx(vdoor.run(OccupancyGrid.from_array(cells, CELL_M), "default"))


@with_doors
def test_a_doorway_lies_between_its_rooms_at_the_door(name: str) -> None:
    topology = finished.topology(name)
    for way in doorways(topology):
        one, other = (np.array(side.cell) for side in way.sides)
        assert [topology.labels[side.cell] for side in way.sides] == list(way.door.rooms)
        assert np.abs(one - other).sum() == 1
        middle = topology.frame.world_from_cell((one + other)[None] / 2)[0]
        assert middle == pytest.approx(way.middle_m)
        door_middle = np.add(way.door.start_m, way.door.end_m) / 2
        assert math.dist(middle, door_middle) <= 1.5 * CELL_M


@with_doors
def test_the_route_server_takes_the_graph(name: str) -> None:
    topology = finished.topology(name)
    graph = nav2_loader.load(to_nav2_route(topology))
    rooms, ways = {room.id: room for room in topology.rooms}, {way.door.id: way for way in doorways(topology)}
    assert len(set(graph.ids)) == len(graph.ids) == len(rooms) + 5 * len(ways)
    assert {node.frame for node in graph.nodes.values()} == {"map"}
    for number, node in graph.nodes.items():
        if node.metadata["kind"] == "room":
            assert (number, node.place) == (node.metadata["room"], rooms[number].centre_m)
        else:
            way = ways[node.metadata["door"]]
            assert (node.place, tuple(node.metadata["rooms"])) == (way.middle_m, way.door.rooms)
    assert {(edge.end, edge.start, edge.cost) for edge in graph.edges} == {
        (edge.start, edge.end, edge.cost) for edge in graph.edges
    }


@with_doors
def test_edges_join_each_door_to_its_rooms_at_what_the_way_costs(name: str) -> None:
    topology = finished.topology(name)
    graph = nav2_loader.load(to_nav2_route(topology))
    told = {
        (graph.nodes[edge.start].metadata["door"], edge.end): edge
        for edge in graph.edges
        if graph.nodes[edge.start].metadata["kind"] == "door"
    }
    wanted = {(way.door.id, side.room): side.cost_m for way in doorways(topology) for side in way.sides}
    assert {ends: edge.cost for ends, edge in told.items()} == wanted
    for (door, room), edge in told.items():
        assert not edge.overridable
        assert edge.metadata == {"kind": "way", "door": door, "room": room}
        # Between middles of cells a way is no shorter than the straight line; a door's middle is half a cell away.
        assert edge.cost >= math.dist(graph.nodes[edge.start].place, graph.nodes[edge.end].place) - CELL_M / 2


def test_a_route_between_rooms_takes_the_nearer_of_two_doors() -> None:
    graph = nav2_loader.load(to_nav2_route(finished.topology("pillars")))
    routes: nx.DiGraph[int] = nx.DiGraph()
    routes.add_weighted_edges_from((edge.start, edge.end, edge.cost) for edge in graph.edges)
    assert [graph.nodes[node].metadata.get("door") for node in nx.dijkstra_path(routes, 1, 3, "weight")] in (
        [None, 1, None, 2, None],
        [None, 3, None, 2, None],
    )


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
        lambda graph: graph.edges[0]["properties"].update(cost=0.0),
        lambda graph: graph.edges[0]["properties"].update(cost=math.nan),
    ],
)
def test_the_reader_refuses_what_the_route_server_refuses(spoil: Callable[[Any], None]) -> None:
    features = json.loads(to_nav2_route(finished.topology("flat")))["features"]
    nodes = [feature for feature in features if feature["geometry"]["type"] == "Point"]
    edges = [feature for feature in features if feature["geometry"]["type"] == "LineString"]
    graph = SimpleNamespace(nodes=nodes, edges=edges)
    nav2_loader.load(json.dumps({"features": nodes + edges}))
    spoil(graph)
    with pytest.raises(RefusedError):
        nav2_loader.load(json.dumps({"features": nodes + edges}))
