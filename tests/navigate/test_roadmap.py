"""Roadmaps: what they keep from walls, what they reach, and how short their ways are."""

from __future__ import annotations

import math
import textwrap

import finished_maps
import networkx as nx
import numpy as np
import pytest
import scipy
import shapely
from hypothesis import given, settings
from labelled_maps import labelled
from maps import CELL_M, Cells, law, small_maps

import vdoor
from vdoor.errors import VdoorError
from vdoor.grid import Annotations, OccupancyGrid
from vdoor.navigate.roadmap import Roadmap, roadmap_of
from vdoor.navigate.roadmap_cover import REACH_M
from vdoor.topology import TopologicalMap

RADIUS_M = 0.22
PILLARS = """
    ################################
    #..............................#
    #..............................#
    #......##..............##......#
    #......##..............##......#
    #..............................#
    #..............................#
    #...............................
    #...........########...........#
    #...........########...........#
    #..............................#
    #..............................#
    ################################
"""


HALL_M = 0.4
"""The cells of the hall with pillars."""


def hall() -> TopologicalMap:
    return labelled(textwrap.dedent(PILLARS).replace("#", "0").replace(".", "1"), cell_m=HALL_M)


def squares(cells: np.ndarray[tuple[int, int], np.dtype[np.bool_]]) -> shapely.Geometry:
    rows, cols = np.nonzero(cells)
    return shapely.union_all(shapely.box(rows - 0.5, cols - 0.5, rows + 0.5, cols + 0.5))


def walls(topology: TopologicalMap) -> shapely.Geometry:
    """All that is no room, with a border around the map."""
    return shapely.affinity.translate(squares(np.pad(topology.labels == 0, 1, constant_values=True)), -1, -1)


def lines(graph: Roadmap) -> list[shapely.LineString]:
    return [shapely.LineString([graph.nodes[end].place for end in edge.ends]) for edge in graph.edges]


def check(topology: TopologicalMap, graph: Roadmap) -> None:
    """Edges keep what they claim, stay in their rooms, to a cell, and join what the floor joins."""
    cell_m, blocked = topology.frame.resolution_m, walls(topology)
    for edge, line in zip(graph.edges, lines(graph), strict=True):
        kept_m = line.distance(blocked) * cell_m
        assert kept_m >= edge.clearance_m - 1e-9
        assert 0 < edge.clearance_m <= RADIUS_M
        if edge.clearance_m < RADIUS_M:
            assert kept_m == pytest.approx(edge.clearance_m)
        room = squares(scipy.ndimage.binary_dilation(topology.labels == edge.room, np.ones((3, 3))))
        assert line.difference(room).length == pytest.approx(0, abs=1e-9)
    joined: nx.Graph[int] = nx.Graph(edge.ends for edge in graph.edges)
    joined.add_nodes_from(range(len(graph.nodes)))
    floors = shapely.get_parts(squares(topology.labels > 0)).tolist()
    found = {frozenset(part) for part in nx.connected_components(joined)}
    at = [shapely.Point(node.place) for node in graph.nodes]
    on_floor = {frozenset(i for i, place in enumerate(at) if floor.covers(place)) for floor in floors}
    assert found == on_floor - {frozenset()}  # parts of a room that were seen as single rays have no node


def test_it_joins_what_the_map_joins_on_the_example_maps() -> None:
    for name in ("pillars", "slit", "one room"):
        check(finished_maps.topology(name), roadmap_of(finished_maps.topology(name), clearance_m=RADIUS_M))


@settings(law, max_examples=25)
@given(small_maps(most=16))
def test_it_joins_what_the_map_joins_on_any_map(cells: Cells) -> None:
    topology = vdoor.run(OccupancyGrid.from_array(cells, CELL_M), "default")
    check(topology, roadmap_of(topology, clearance_m=RADIUS_M))


def test_every_place_that_keeps_the_clearance_sees_a_node_within_reach() -> None:
    topology = hall()
    blocked, floor = walls(topology), np.argwhere(topology.labels > 0)
    places = [place.tolist() for place in floor if shapely.Point(place).distance(blocked) * HALL_M >= RADIUS_M]
    graph = roadmap_of(topology, clearance_m=RADIUS_M)
    for place in places:
        ways = [shapely.LineString([place, node.place]) for node in graph.nodes]
        near = [way for way in ways if way.length * HALL_M <= REACH_M + 1e-9]
        assert any(way.distance(blocked) * HALL_M >= RADIUS_M - 1e-9 for way in near), place
    assert len(graph.nodes) < len(places) / 5


def test_ways_over_it_are_at_most_a_tenth_longer_than_over_the_grid() -> None:
    topology = hall()
    graph = roadmap_of(topology, clearance_m=RADIUS_M)
    ways = nx.Graph()
    for edge, line in zip(graph.edges, lines(graph), strict=True):
        ways.add_edge(*edge.ends, weight=line.length)
    blocked = walls(topology)
    cells = {tuple(cell) for cell in np.argwhere(topology.labels > 0).tolist()}
    cells = {cell for cell in cells if shapely.Point(cell).distance(blocked) * HALL_M >= RADIUS_M}
    steps = [
        ((row, col), (row + down, col + right), math.hypot(down, right))
        for row, col in cells
        for down, right in ((0, 1), (1, 0), (1, 1), (1, -1))
    ]
    grid = nx.Graph()
    grid.add_weighted_edges_from(
        (one, other, length)
        for one, other, length in steps
        if other in cells and shapely.LineString([one, other]).distance(blocked) * HALL_M >= RADIUS_M - 1e-9
    )
    on_cells = [at for at, node in enumerate(graph.nodes) if node.place in grid]
    over = dict(nx.all_pairs_dijkstra_path_length(ways))
    ratios = []
    for one in on_cells:
        optimum = nx.single_source_dijkstra_path_length(grid, graph.nodes[one].place)
        ratios += [over[one][other] / optimum[graph.nodes[other].place] for other in on_cells if other != one]
    assert len(on_cells) > 5
    assert np.mean(ratios) <= 1.1


def test_a_door_too_narrow_for_the_robot_is_joined_and_says_what_it_leaves() -> None:
    topology = labelled("1111111111\n" * 6 + "0000100000\n" + "2222222222\n" * 6, ((1, 2), (6.5, 4)), cell_m=0.2)
    graph = roadmap_of(topology, clearance_m=RADIUS_M)
    check(topology, graph)
    narrow = [edge for edge in graph.edges if edge.clearance_m < RADIUS_M]
    assert [edge.clearance_m for edge in narrow] == pytest.approx([0.1] * len(narrow))
    (door,) = [at for at, node in enumerate(graph.nodes) if node.door]
    assert graph.nodes[door].place == (6.5, 4)
    assert {edge.room for edge in graph.edges if door in edge.ends} == {1, 2}


def test_a_wide_door_has_further_nodes() -> None:
    topology = labelled("1111111111\n" * 6 + "2222222222\n" * 6, ((1, 2), (5.5, 4)), cell_m=0.5)
    graph = roadmap_of(topology, clearance_m=RADIUS_M)
    check(topology, graph)
    doors = [node for node in graph.nodes if node.door]
    assert [node.main for node in doors] == [True] + [False] * (len(doors) - 1)
    cols = sorted(node.place[1] for node in doors)
    assert len(doors) > 1
    assert all((col - cols[0]) % 1 == 0 for col in cols)
    assert max(np.diff(cols)) * 0.5 <= 3.0


def test_ways_to_a_door_askew_run_along_it_as_if_it_were_straight() -> None:
    size = 40
    labels = np.fromfunction(lambda row, col: np.where(2 * row + col < 1.5 * size, 1, 2), (size, size)).astype(np.int32)
    topology = labelled(labels, ((1, 2), (size / 2 - 0.5, size / 2)), cell_m=0.1)
    graph = roadmap_of(topology, clearance_m=RADIUS_M)
    check(topology, graph)
    ways = nx.Graph()
    for edge, line in zip(graph.edges, lines(graph), strict=True):
        ways.add_edge(*edge.ends, weight=line.length)
    over = dict(nx.all_pairs_dijkstra_path_length(ways))
    places = [node.place for node in graph.nodes]
    far = [(a, b) for a in over for b in over if math.dist(places[a], places[b]) > 1 / 0.1]
    assert {graph.nodes[a].room for a, _ in far} >= {1, 2}
    assert np.mean([over[a][b] / math.dist(places[a], places[b]) for a, b in far]) <= 1.1


def test_it_keeps_clear_of_no_go_areas() -> None:
    topology = hall()
    graph = roadmap_of(topology, clearance_m=RADIUS_M)
    row, col = np.mean([graph.nodes[end].place for end in graph.edges[0].ends], axis=0)
    ((x_m, y_m),) = topology.frame.world_from_cell(np.array([(row, col)])).tolist()
    area_m = ((x_m - 0.3, y_m - 0.3), (x_m + 0.3, y_m - 0.3), (x_m + 0.3, y_m + 0.3), (x_m - 0.3, y_m + 0.3))
    own = Annotations(own_origin_cm=(0.0, 0.0), no_go_areas_m=(area_m,))
    area = shapely.Polygon(topology.frame.cell_from_world(np.array(area_m)))
    with_it, without = (lines(roadmap_of(topology, given, clearance_m=RADIUS_M)) for given in (own, None))
    assert min(line.distance(area) for line in with_it) * HALL_M >= RADIUS_M - 1e-9
    assert min(line.distance(area) for line in without) == 0


@pytest.mark.parametrize(("low_m", "high_m", "rooms"), [(-1.0, 2.6, {1}), (-1.0, 2.4, {1}), (2.1, 2.6, {1, 2})])
def test_no_edge_leads_into_a_no_go_area_that_holds_a_room_or_a_door(
    low_m: float, high_m: float, rooms: set[int]
) -> None:
    rows = ["1" * 20] * 9 + ["0" * 4 + "1" + "0" * 15] + ["2" * 20] * 6
    topology = labelled("\n".join(rows), ((1, 2), (9.5, 4)), cell_m=0.4)
    area_m = ((-1.0, low_m), (9.0, low_m), (9.0, high_m), (-1.0, high_m))  # room 2 lies below 2.4, the door up to 2.8
    own = Annotations(own_origin_cm=(0.0, 0.0), no_go_areas_m=(area_m,))
    graph = roadmap_of(topology, own, clearance_m=RADIUS_M)
    area = shapely.Polygon(topology.frame.cell_from_world(np.array(area_m))).buffer(-1e-6)
    assert {edge.room for edge in graph.edges} == rooms
    assert not any(line.intersects(area) for line in lines(graph))
    assert [node.room for node in graph.nodes if node.main] == [1, 2, 0]


def test_a_door_whose_rooms_do_not_touch_is_refused() -> None:
    with pytest.raises(VdoorError, match="door 1: wanted rooms 1 and 2 to touch"):
        roadmap_of(labelled("11011\n10201\n11011", ((1, 2), (0.5, 2))), clearance_m=RADIUS_M)
