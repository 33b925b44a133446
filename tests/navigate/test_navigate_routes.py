"""Routes: the clearance along them, their length, and what stands in the way."""

from __future__ import annotations

import dataclasses
import math
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from maps import Cells
from scipy.sparse.csgraph import dijkstra

import vdoor
from vdoor.errors import SettingError
from vdoor.explain.routes import described
from vdoor.grid import Annotations, OccupancyGrid
from vdoor.navigate.blocked import blocked_cells
from vdoor.navigate.find_route import FindRoute, Route
from vdoor.navigate.obstacles import APART, AVOIDED, CLOSED, NARROW_DOOR, RULED_OUT
from vdoor.navigate.room_table import read_tables, write_tables
from vdoor.navigate.routes import Routes
from vdoor.navigate.sight import least_clearance
from vdoor.navigate.space import Space
from vdoor.synth import PRESETS, synthesize
from vdoor.topology import TopologicalMap

CELL_M = 0.1
ROOM = 30
"""Cells across a room of the drawn maps."""
HOME = Path(__file__).parents[2]


def rooms_in_a_ring(*doors: int) -> Cells:
    """Two by two rooms around a pillar of wall, with doors of nine cells where asked for.

    Doors: 0 between the upper two, 1 between the right two, 2 between the lower two, 3 between the left two.
    """
    side = 2 * ROOM + 6
    cells = np.zeros((side, side), np.int8)
    for wall in (slice(0, 2), slice(ROOM + 2, ROOM + 4), slice(side - 2, side)):
        cells[wall] = cells[:, wall] = 100
    near, far, wall = slice(12, 21), slice(ROOM + 14, ROOM + 23), slice(ROOM + 2, ROOM + 4)
    places = [(near, wall), (wall, far), (far, wall), (wall, near)]
    for door in doors:
        cells[places[door]] = 0
    return cells


def mapped(cells: Cells) -> tuple[OccupancyGrid, TopologicalMap]:
    grid = OccupancyGrid.from_array(cells, CELL_M)
    return grid, vdoor.run(grid)


def found(cells: Cells, start: str, goal: str, **settings: object) -> Route:
    return FindRoute(start=start, goal=goal, **settings)(*mapped(cells))  # type: ignore[arg-type]


def nearest_blocked_m(point_m: np.ndarray, blocked: np.ndarray, cell_m: float, *, reach_m: float) -> float:
    """The least distance from a path to the edge of a blocked cell, at steps of 5 mm, cell by cell: no code of ours.

    The map lies at 0, 0 without a turn. What is farther than `reach_m` counts as that.
    """
    margin = math.ceil(reach_m / cell_m) + 2
    walls = np.pad(blocked, margin, constant_values=True)
    least = reach_m
    for (ax, ay), (bx, by) in pairwise(point_m.tolist()):
        steps = max(math.ceil(math.hypot(bx - ax, by - ay) / 0.005), 1)
        for share in np.linspace(0, 1, steps + 1).tolist():
            x, y = ax + share * (bx - ax), ay + share * (by - ay)
            row, col = int(blocked.shape[0] - y / cell_m), int(x / cell_m)
            around = walls[row : row + 2 * margin + 1, col : col + 2 * margin + 1]
            down, right = np.nonzero(around)
            if not len(down):
                continue
            top, left = blocked.shape[0] * cell_m - (row - margin + down) * cell_m, (col - margin + right) * cell_m
            dx = np.maximum(np.maximum(left - x, x - left - cell_m), 0)
            dy = np.maximum(np.maximum(y - top, top - cell_m - y), 0)
            least = min(least, float(np.hypot(dx, dy).min()))
    return least


@pytest.fixture(scope="module")
def home() -> tuple[OccupancyGrid, TopologicalMap]:
    """A furnished synthetic apartment at 5 cm, moved to 0, 0."""
    settings = dataclasses.replace(PRESETS["paper-5cm"], furniture=True)
    grid = synthesize(settings, np.random.default_rng(4)).grid
    moved = OccupancyGrid.from_array(grid.cells, grid.frame.resolution_m)
    return moved, vdoor.run(moved)


@pytest.fixture(scope="module")
def routes(home: tuple[OccupancyGrid, TopologicalMap]) -> Routes:
    grid, topology = home
    return Routes(Space.of(blocked_cells(grid, topology), grid.frame, 0.17), topology)


def pairs(routes: Routes, count: int) -> list[tuple[tuple[int, int], tuple[int, int]]]:
    """Cells in rooms of the largest part of the space."""
    part = np.where(routes.topology.labels > 0, routes.space.parts, 0)
    cells = np.argwhere(part == np.argmax(np.bincount(part.ravel())[1:]) + 1)
    chosen = np.random.default_rng(0).choice(len(cells), (count, 2))
    return [((int(a[0]), int(a[1])), (int(b[0]), int(b[1]))) for a, b in cells[chosen]]


def test_nothing_is_nearer_to_a_path_than_the_radius(routes: Routes) -> None:
    frame = routes.space.frame
    for start, goal in pairs(routes, 30):
        path = routes.path(start, goal)
        assert path is not None
        assert (path[0], path[-1]) == (start, goal)
        point_m = frame.world_from_cell(np.array(path))
        least_m = nearest_blocked_m(point_m, routes.space.blocked, frame.resolution_m, reach_m=0.4)
        assert least_m >= 0.17 - 1e-9
        exact_m = least_clearance(routes.space, np.array(path, np.float64), most_m=0.4)
        assert exact_m - 1e-9 <= least_m <= exact_m + 0.0025


def test_lengths_are_close_to_the_optimum_and_never_below(routes: Routes) -> None:
    graph, node = routes.space.graph(routes.space.allowed)
    over = []
    for start, goal in pairs(routes, 60):
        best_m = dijkstra(graph, indices=node[start])[node[goal]]
        plan, path = routes.plan(start, goal), routes.path(start, goal)
        assert plan is not None
        assert path is not None
        over.append(plan.length * routes.unit_m / max(best_m, 1e-9))
        assert np.hypot(*np.diff(np.array(path), axis=0).T).sum() * routes.space.frame.resolution_m <= best_m * 1.0001
    assert min(over) > 0.99999
    assert np.mean(over) <= 1.002
    assert max(over) <= 1.015


def test_kept_distances_change_nothing(routes: Routes, tmp_path: Path) -> None:
    routes.fill()
    write_tables(tmp_path / "tables.npz", routes.tables)
    again = Routes(routes.space, routes.topology, tables=read_tables(tmp_path / "tables.npz"))
    fresh = Routes(routes.space, routes.topology)
    wanted = pairs(routes, 10)
    paths = [routes.path(*ends) for ends in wanted]
    assert [again.path(*ends) for ends in wanted] == paths
    assert [fresh.path(*ends) for ends in reversed(wanted)] == paths[::-1]
    assert again.tables.keys() == routes.tables.keys()  # nothing had to be computed
    rooms = list(routes.standing)
    for one, other in zip(rooms, reversed(rooms), strict=True):
        assert again.distance_m(one, other) == routes.distance_m(one, other) == routes.distance_m(other, one)


def test_a_damaged_file_of_distances_counts_as_none(tmp_path: Path) -> None:
    path = tmp_path / "tables.npz"
    table = np.array([[0, 408], [408, 0]], np.int32)
    write_tables(path, {b"a" * 16: table})
    assert read_tables(path).keys() == {b"a" * 16}
    whole = path.read_bytes()
    for cut in (0, 10, len(whole) // 2, len(whole) - 3):
        path.write_bytes(whole[:cut])
        assert read_tables(path) == {}
    np.savez(path, digest=np.zeros((2, 16), np.uint8), terminals=np.array([2]), distance=np.zeros(3))
    assert read_tables(path) == {}
    assert read_tables(tmp_path / "none.npz") == {}


def test_of_two_ways_round_the_shorter_is_taken_and_a_closed_door_sends_it_round_the_other() -> None:
    grid, topology = mapped(rooms_in_a_ring(0, 1, 2, 3))
    assert [door.rooms for door in topology.doors] == [(1, 2), (2, 4), (3, 4), (1, 3)]
    short = FindRoute(start="1", goal="2")(grid, topology)
    assert short.door.tolist() == [1]
    for settings in ({"closed": ("1",)}, {"avoid": ("4",)}):
        other = FindRoute(start="1", goal="2", **settings)(grid, topology)  # type: ignore[arg-type]
        assert other.door.tolist() == ([4, 3, 2] if "closed" in settings else [1])
    assert FindRoute(start="1", goal="4", avoid=("2",))(grid, topology).door.tolist() == [4, 3]
    assert FindRoute(start="1", goal="4", avoid=("3",))(grid, topology).door.tolist() == [1, 2]


def test_a_route_goes_to_the_rooms_on_the_way_in_their_order() -> None:
    grid, topology = mapped(rooms_in_a_ring(0, 1, 2, 3))
    route = FindRoute(start="1", goal="2", via=("3", "4"))(grid, topology)
    assert route.door.tolist() == [4, 3, 2]
    assert route.stop_room.tolist() == [1, 3, 4, 2]
    assert route.leg.tolist() == sorted(route.leg.tolist())
    ends = [np.flatnonzero(route.leg == leg)[0] for leg in (2, 3)]
    assert np.allclose(route.point_m[ends], route.stop_m[1:3])
    assert FindRoute(start="1", goal="1", via=("2",))(grid, topology).door.tolist() == [1, 1]


def test_what_is_in_the_way_is_named() -> None:
    grid, topology = mapped(rooms_in_a_ring(0, 1))  # room 3 below room 2, room 4 apart
    closed = FindRoute(start="1", goal="3", closed=("1",))(grid, topology)
    assert not closed.found
    assert (closed.obstacle.tolist(), closed.obstacle_id.tolist()) == ([CLOSED], [1])
    assert described(closed) == "no way with a clearance of 0.17 m: door 1 is closed"
    avoided = FindRoute(start="1", goal="3", avoid=("2",))(grid, topology)
    assert (avoided.obstacle.tolist(), avoided.obstacle_id.tolist()) == ([AVOIDED], [2])
    wide = FindRoute(start="1", goal="3", radius_m=0.5)(grid, topology)
    assert (wide.obstacle.tolist(), wide.obstacle_id.tolist()) == ([NARROW_DOOR] * 2, [1, 2])
    assert wide.obstacle_clear_m.tolist() == pytest.approx([0.45, 0.45])  # doors of 0.9 m
    assert "door 1 at" in described(wide)
    assert "leaves 0.450 m" in described(wide)
    assert math.isnan(wide.length_m)


def test_rooms_without_a_door_between_them_are_apart() -> None:
    route = found(rooms_in_a_ring(0, 2), "1", "3")
    assert route.obstacle.tolist() == [APART]
    assert described(route).endswith("no free cells lead out of room 1")


def test_virtual_walls_and_no_go_areas_hold() -> None:
    grid, topology = mapped(rooms_in_a_ring(0, 1, 2, 3))
    across = ((3.3, 4.0), (3.3, 6.6))  # the upper door
    route = FindRoute(start="1", goal="2")
    wall = Annotations(own_origin_cm=(0, 0), virtual_walls_m=(across,))
    assert route.found(grid, topology, wall).door.tolist() == [4, 3, 2]
    closed = dataclasses.replace(route, closed=("3",)).found(grid, topology, wall)
    assert sorted(zip(closed.obstacle.tolist(), closed.obstacle_id.tolist(), strict=True)) == [(RULED_OUT, -1)]
    area = Annotations(own_origin_cm=(0, 0), no_go_areas_m=(((3.2, 4.0), (3.4, 4.0), (3.4, 6.6), (3.2, 6.6)),))
    assert route.found(grid, topology, area).door.tolist() == [4, 3, 2]
    mop = Annotations(own_origin_cm=(0, 0), no_mop_areas_m=area.no_go_areas_m)
    assert route.found(grid, topology, mop).door.tolist() == [1]


def test_a_passage_one_cell_wide_is_passed_by_a_robot_that_fits_and_named_for_one_that_does_not() -> None:
    cells = rooms_in_a_ring(0)
    cells[12:21, ROOM + 2 : ROOM + 4] = 100
    cells[12:15, ROOM + 2 : ROOM + 4] = 0
    grid, topology = mapped(cells)
    assert len(topology.doors) == 1
    narrow = FindRoute(start="1", goal="2", radius_m=0.15)(grid, topology)
    assert narrow.found
    assert narrow.clear_m == pytest.approx(0.15)
    blocked = FindRoute(start="1", goal="2", radius_m=0.16)(grid, topology)
    assert (blocked.obstacle.tolist(), blocked.obstacle_id.tolist()) == ([NARROW_DOOR], [1])
    assert blocked.obstacle_clear_m.tolist() == pytest.approx([0.15])


def test_a_room_in_two_parts_is_crossed_through_another_room() -> None:
    grid, topology = mapped(rooms_in_a_ring(0, 3, 1, 2))
    wall = Annotations(own_origin_cm=(0, 0), virtual_walls_m=(((0.2, 5.0), (2.4, 5.0), (2.4, 6.6)),))
    # the wall parts room 1 in a corner with no door and the rest; then through the door as well
    inside = FindRoute(start="1.0,6.0", goal="2.8,4.0").found(grid, topology, wall)
    assert not inside.found
    both = Annotations(own_origin_cm=(0, 0), virtual_walls_m=(((0.2, 4.0), (2.2, 4.0), (3.4, 3.6)),))
    route = FindRoute(start="1.0,6.0", goal="1.0,3.6").found(grid, topology, both)
    assert route.stop_room.tolist() == [1, 1]
    assert route.door.tolist() == [1, 2, 3, 4]


def test_places_in_a_wall_are_moved_and_places_too_far_refused() -> None:
    grid, topology = mapped(rooms_in_a_ring(0))
    route = FindRoute(start="0.31,5.02", goal="5.0,5.0")(grid, topology)
    assert 0 < route.stop_moved_m[0] <= 0.17
    assert route.stop_m[0].tolist() == pytest.approx([0.45, 5.05])
    on_line = FindRoute(start="3.3,5.0", goal="5.0,5.0")(grid, topology)
    assert on_line.stop_moved_m[0] == 0
    with pytest.raises(SettingError, match=r"start: wanted a place within 0\.17 m"):
        FindRoute(start="0.05,5.0", goal="2")(grid, topology)
    with pytest.raises(SettingError, match="goal: wanted one of 1, 2"):
        FindRoute(start="1", goal="9")(grid, topology)
    with pytest.raises(SettingError, match=r"avoid: wanted a point in a room, found none at 3\.3,0\.1"):
        FindRoute(start="1", goal="2", avoid=("3.3,0.1",))(grid, topology)
    with pytest.raises(SettingError, match="closed: no door there"):
        FindRoute(start="1", goal="2", closed=("1,1",))(grid, topology)


def test_a_straight_way_is_straight_and_equal_ends_are_one_point() -> None:
    grid, topology = mapped(rooms_in_a_ring(0))
    straight = FindRoute(start="0.55,5.05", goal="5.05,5.05")(grid, topology)
    assert np.allclose(straight.point_m, [[0.55, 5.05], [5.05, 5.05]])
    assert straight.length_m == pytest.approx(4.5)
    assert straight.yaw_rad.tolist() == pytest.approx([0, 0])
    stay = FindRoute(start="0.55,5.05", goal="0.55,5.05")(grid, topology)
    assert (len(stay.point_m), stay.length_m) == (1, 0.0)
    one_room, alone = mapped(np.pad(np.zeros((20, 20), np.int8), 2, constant_values=100))
    assert FindRoute(start="1", goal="0.6,0.6")(one_room, alone).found


def test_equal_requests_give_equal_records_on_a_turned_map() -> None:
    grid = vdoor.read_map(HOME / "recordings" / "turned.yaml")
    topology = vdoor.run(grid)
    first, last = topology.room_ids[0], topology.room_ids[-1]
    one, other = (FindRoute(start=str(first), goal=str(last))(grid, topology) for _ in range(2))
    assert one.found
    assert vdoor.record.equal(one, other)
