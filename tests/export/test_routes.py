"""Ways from doors to rooms: through free cells of their room, off the walls, in few straight pieces."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Any

import finished_maps
import networkx as nx
import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st
from labelled_maps import Point, bent, labelled, with_doors
from maps import CELL_M, Cells, law, small_maps
from numpy.typing import NDArray

import vdoor
from vdoor.errors import VdoorError
from vdoor.export.path_simplification import SLACK, cost, crossed
from vdoor.export.routes import CLEAR_M, STEEP, Side, doorways, weights
from vdoor.grid import OccupancyGrid
from vdoor.topology import TopologicalMap

Cell = tuple[int, int]


def drawn(topology: TopologicalMap, side: Side) -> list[Point]:
    """Row, col of a way's bends, which are multiples of a half."""
    places = topology.frame.cell_from_world(np.array(side.points_m))
    halves = np.rint(2 * places)
    assert places == pytest.approx(halves / 2, abs=1e-6)
    return [(row, col) for row, col in (halves / 2).tolist()]


def sides(topology: TopologicalMap) -> list[Side]:
    return [side for way in doorways(topology) for side in way.sides]


def graph_of(own: NDArray[np.bool_], weight: NDArray[np.float64], *, slip: bool = False) -> nx.Graph[Cell]:
    """Steps between the cells of a mask, by the rule as it is told, cell by cell."""
    graph: nx.Graph[Cell] = nx.Graph()
    cells = {(int(row), int(col)) for row, col in np.argwhere(own)}
    graph.add_nodes_from(cells)
    for row, col in cells:
        for down, right in ((0, 1), (1, 0), (1, 1), (1, -1)):
            to = (row + down, col + right)
            if {to} | (set() if slip else {(row, to[1]), (to[0], col)}) <= cells:
                graph.add_edge((row, col), to, weight=math.hypot(down, right) * (weight[row, col] + weight[to]) / 2)
    return graph


def weights_told(topology: TopologicalMap) -> NDArray[np.float64]:
    """What a metre costs in every cell (h, w), from the distance to every wall and to the map's edge."""
    free = np.pad(topology.labels > 0, 1)
    walls = np.argwhere(~free)
    told = np.ones(free.shape)
    for cell in np.argwhere(free):
        near_m = (np.hypot(*(walls - cell).T).min() - 0.5) * topology.frame.resolution_m
        told[tuple(cell)] = max(1.0, CLEAR_M / near_m) ** STEEP
    return told[1:-1, 1:-1]


def check_it_stays(topology: TopologicalMap, side: Side) -> None:
    """All pieces lie in cells of the room, and pass corners only where all four cells are."""
    own = topology.labels == side.room
    rows, cols = np.nonzero(own)
    room = shapely.union_all(shapely.box(cols - 0.5, rows - 0.5, cols + 0.5, rows + 0.5))
    places = drawn(topology, side)
    outside = shapely.LineString([(col, row) for row, col in places]).difference(room)
    assert outside.length == pytest.approx(0, abs=1e-9)
    for start, end in pairwise(places):
        down, right = round(2 * (end[0] - start[0])), round(2 * (end[1] - start[1]))
        count = math.gcd(down, right)
        for step in range(1, count):
            twice_row, twice_col = (
                round(2 * start[0]) + down * step // count,
                round(2 * start[1]) + right * step // count,
            )
            if twice_row % 2 and twice_col % 2:
                row, col = twice_row // 2, twice_col // 2
                assert own[row : row + 2, col : col + 2].all(), (start, end)


def check_against_networkx(topology: TopologicalMap) -> None:
    """Weighted by what is told of walls, a way costs no more than the cheapest one from cell to cell, and its slack."""
    weight, cell_m = weights_told(topology), topology.frame.resolution_m
    for side in sides(topology):
        places = drawn(topology, side)
        graph = graph_of(topology.labels == side.room, weight)
        centre = (int(places[-1][0]), int(places[-1][1]))
        least = nx.dijkstra_path_length(graph, side.cell, centre) + weight[side.cell] / 2
        spent = sum(
            weight[cell] * shapely.LineString(ends).intersection(_square(cell)).length
            for ends in pairwise(places)
            for cell in graph
            if shapely.LineString(ends).intersects(_square(cell))
        )
        assert spent <= SLACK * least + 1e-9
        assert side.cost_m == pytest.approx(sum(math.dist(*ends) for ends in pairwise(places)) * cell_m)


def _square(cell: Cell) -> shapely.Polygon:
    row, col = cell
    return shapely.box(row - 0.5, col - 0.5, row + 0.5, col + 0.5)


def test_a_straight_corridor_costs_its_length() -> None:
    assert [side.cost_m for side in sides(labelled("11111222", ((1, 2), (0, 4.5))))] == [2.5, 1.5]


def test_ways_go_around_walls() -> None:
    topology = labelled(
        """
        1111100
        1000100
        1111122
        """,
        ((1, 2), (2, 4.5)),
    )
    assert drawn(topology, sides(topology)[0]) == [(2, 4.5), (0, 4), (0, 2)]


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
    side = sides(topology)[0]
    centre = (int(topology.centre[0][0]), int(topology.centre[0][1]))
    own, alike = topology.labels == 1, np.ones(topology.labels.shape)
    around = nx.dijkstra_path_length(graph_of(own, alike), centre, side.cell)
    through = nx.dijkstra_path_length(graph_of(own, alike, slip=True), centre, side.cell)
    assert through + 0.5 < side.cost_m <= around + 0.5
    check_it_stays(topology, side)


def test_a_way_is_straight_where_it_can_be() -> None:
    topology = labelled("11100\n11100\n11122", ((1, 2), (2, 2.5)))
    assert drawn(topology, sides(topology)[0]) == [(2, 2.5), (1, 1)]


def test_a_door_whose_rooms_do_not_touch_is_refused() -> None:
    with pytest.raises(VdoorError, match="door 1: wanted rooms 1 and 2 to touch"):
        doorways(labelled("11011\n10201\n11011", ((1, 2), (0.5, 2))))


def test_a_way_stays_in_its_room_even_if_another_one_were_shorter() -> None:
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
    side = sides(ring)[0]
    check_it_stays(ring, side)
    assert side.cost_m > 1.5 * math.dist(side.points_m[0], side.points_m[-1])


def test_a_room_in_two_parts_is_refused() -> None:
    with pytest.raises(VdoorError, match="room 1"):
        doorways(labelled("11101\n00002", ((1, 2), (0.5, 4))))


def test_a_door_is_no_wall() -> None:
    labels = np.repeat(np.array([[1, 2]], np.int32), 20, axis=0).repeat(20, axis=1)
    weight, corner = weights(labelled(labels, cell_m=0.05), 1, np.s_[0:20, 0:20])
    row, col = corner.tolist()
    assert weight[10 - row, 19 - col] == 1
    assert weight[10 - row, 0 - col] == pytest.approx((CLEAR_M / 0.025) ** STEEP)
    assert np.isinf(weight[10 - row, 20 - col])


@settings(law, max_examples=20)
@given(wide=st.integers(16, 30), down=st.integers(40, 80), right=st.integers(40, 80))
def test_around_a_bend_ways_stay_off_the_walls(wide: int, down: int, right: int) -> None:
    topology = bent(wide, down, right)
    walls = np.argwhere(topology.labels == 0)
    for side in (side for side in sides(topology) if side.room == 1):
        check_it_stays(topology, side)
        way = shapely.LineString(drawn(topology, side))
        # The middle of a bent room lies in the inner corner, so that the last of the way is along its wall.
        places = [way.interpolate(at).coords[0] for at in np.arange(0, way.length - 12, 0.5)]
        nearest = min(np.hypot(*(walls - place).T).min() - 0.5 for place in places)
        assert nearest * 0.05 >= 0.25
        assert len(side.points_m) <= 5


@with_doors
def test_ways_cost_what_networkx_finds(name: str) -> None:
    topology = finished_maps.topology(name)
    if topology.labels.size < 3000:
        check_against_networkx(topology)
    for side in sides(topology):
        check_it_stays(topology, side)


@law
@given(small_maps(most=14))
def test_ways_cost_what_networkx_finds_on_any_map(cells: Cells) -> None:
    topology = vdoor.run(OccupancyGrid.from_array(cells, CELL_M), "default")
    check_against_networkx(topology)
    for side in sides(topology):
        check_it_stays(topology, side)


@with_doors
def test_a_doorway_lies_between_its_rooms_at_the_door(name: str) -> None:
    topology = finished_maps.topology(name)
    for way in doorways(topology):
        one, other = (np.array(side.cell) for side in way.sides)
        assert [topology.labels[side.cell] for side in way.sides] == list(way.door.rooms)
        assert np.abs(one - other).sum() == 1
        middle = topology.frame.world_from_cell((one + other)[None] / 2)[0]
        assert middle == pytest.approx(way.middle_m)
        door_middle = np.add(way.door.start_m, way.door.end_m) / 2
        assert math.dist(middle, door_middle) <= 1.5 * CELL_M
        rooms = {room.id: room.centre_m for room in topology.rooms}
        for side in way.sides:
            assert side.points_m[0] == way.middle_m
            assert side.points_m[-1] == pytest.approx(rooms[side.room], abs=1e-3)


@pytest.mark.parametrize("wall", [(0, 1), (1, 0)])
def test_a_straight_piece_needs_all_four_cells_at_a_corner(wall: Cell) -> None:
    weight = np.ones((2, 2))
    assert cost(np.array([0, 0]), np.array([1, 1]), weight) == pytest.approx(math.sqrt(2))
    weight[wall] = np.inf
    assert cost(np.array([0, 0]), np.array([1, 1]), weight) == np.inf


@law
@given(st.tuples(*[st.integers(0, 24)] * 4), st.sampled_from([(0, 0), (1, 0), (0, 1)]))
def test_a_straight_piece_crosses_the_cells_that_shapely_finds(ends: tuple[int, ...], half: Any) -> None:
    start, end = np.array(ends[:2]) + np.array(half) / 2, np.array(ends[2:], np.float64)
    if np.array_equal(start, end):
        return
    cells, length = crossed(start, end)
    line = shapely.LineString([start, end])
    found: dict[Cell, float] = {}
    for (row, col), part in zip(cells.tolist(), length.tolist(), strict=True):
        found[row, col] = found.get((row, col), 0.0) + part
    for row in range(-1, 27):
        for col in range(-1, 27):
            inside = line.intersection(_square((row, col))).length
            assert found.get((row, col), 0.0) == pytest.approx(inside, abs=1e-9)
