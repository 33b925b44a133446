"""Coverage: the clearance along its paths, what they sweep, and what stands in the way."""

from __future__ import annotations

import dataclasses
import functools
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
import shapely
from maps import Cells
from numpy.typing import NDArray
from scipy import ndimage
from scipy.spatial import cKDTree

import vdoor
from vdoor.errors import SettingError, VdoorError
from vdoor.experiments.cover_benchmark import least_changes
from vdoor.grid import Annotations, OccupancyGrid
from vdoor.navigate.cover_floor import Coverage, CoverFloor
from vdoor.navigate.coverage.floor import floor_of
from vdoor.navigate.coverage.sweep import Tool
from vdoor.navigate.coverage.tour import tour_of
from vdoor.navigate.space import Space
from vdoor.record import equal
from vdoor.synth import PRESETS, synthesize
from vdoor.topology import TopologicalMap

CELL_M = 0.05
RADIUS_M, TOOL_M = 0.17, 0.30
ROOM_1, ROOM_2 = "1.0,1.0", "4.0,1.0"
"""Places in the rooms of the house."""
Mapped = tuple[OccupancyGrid, TopologicalMap]


def walled(rows: int, cols: int) -> Cells:
    """An empty room of so many cells within walls of three."""
    cells = np.full((rows + 6, cols + 6), 100, np.int8)
    cells[3:-3, 3:-3] = 0
    return cells


def two_rooms(door: int, thick: int = 2) -> Cells:
    """Rooms of 50 x 50 cells side by side, with a door of so many cells between."""
    cells = walled(50, 100 + thick)
    cells[:, 53 : 53 + thick] = 100
    cells[25 : 25 + door, 53 : 53 + thick] = 0
    return cells


def mapped(cells: Cells) -> Mapped:
    grid = OccupancyGrid.from_array(cells, CELL_M)
    return grid, vdoor.run(grid)


@functools.cache
def home(seed: int) -> Mapped:
    """A synthetic home of a robot vacuum: furniture, ragged walls, several rooms."""
    grid = synthesize(PRESETS["home"], np.random.default_rng(seed)).grid
    return grid, vdoor.run(grid)


@functools.cache
def house() -> Mapped:
    """Two rooms with a door of 0.9 m."""
    return mapped(two_rooms(18))


def covered(where: Mapped, **asked: Any) -> Coverage:
    return CoverFloor(**{"unit": "room", "end": "start", **asked})(*where)


def driven_m(found: Coverage, step_m: float = 0.005) -> NDArray[np.float64]:
    """Points of a path, a step apart."""
    point = found.point_m
    pieces = [
        a + np.linspace(0, 1, int(np.ceil(np.hypot(*(b - a)) / step_m)) + 1)[:, None] * (b - a)
        for a, b in pairwise(point)
    ]
    return np.concatenate(pieces)


def least_clearance_m(found: Coverage, blocked: NDArray[np.bool_]) -> float:
    """The least distance from a path, looked at every 5 mm, to the edge of a blocked cell or of the map."""
    cell = np.argwhere(np.pad(blocked, 1, constant_values=True)) - 1
    frame = found.frame
    centre_m = frame.world_from_cell(cell)
    at_m = driven_m(found)
    _, near = cKDTree(centre_m).query(at_m, k=min(16, len(cell)))
    gap_m = np.maximum(np.abs(at_m[:, None] - centre_m[near]) - frame.resolution_m / 2, 0)
    return float(np.sqrt((gap_m**2).sum(axis=2)).min())


def swept_share(found: Coverage, grid: OccupancyGrid, labels: NDArray[np.int32], cell_m: float) -> float:
    """The share that is swept, counted anew on a raster of another cell size, with no code of ours.

    The robot's centre may be where a lattice of 5 mm keeps the radius to the edges of cells, joined to the start.
    """
    times = round(grid.frame.resolution_m / 0.005)
    free = np.kron(grid.free, np.ones((times, times), np.bool_))
    clear_m = (ndimage.distance_transform_edt(free) - 0.5) * 0.005  # exact along walls, which is where it counts
    label, _ = ndimage.label(clear_m >= found.radius_m - 1e-9, np.ones((3, 3)))
    start = np.rint((found.frame.cell_from_world(found.point_m[:1])[0] + 0.5) * times - 0.5).astype(int)
    near = label[start[0] - 2 : start[0] + 3, start[1] - 2 : start[1] + 3]
    reached = label == np.bincount(near[near > 0]).argmax()
    reach_m = ndimage.distance_transform_edt(~reached) * 0.005
    step = round(cell_m / 0.005)
    own = np.kron(labels > 0, np.ones((times, times), np.bool_)) & free & (reach_m <= found.tool_m / 2)
    place = np.argwhere(own[step // 2 :: step, step // 2 :: step]) * step + step // 2
    at_m = found.frame.world_from_cell((place + 0.5) / times - 0.5)
    apart_m, _ = cKDTree(driven_m(found)).query(at_m)
    return float(np.mean(apart_m <= found.tool_m / 2 + 1e-4))


@pytest.mark.parametrize("unit", ["room", "map"])
@pytest.mark.parametrize("seed", [0, 3])
def test_nothing_is_nearer_than_the_radius_along_any_path(seed: int, unit: str) -> None:
    grid, topology = home(seed)
    found = covered((grid, topology), unit=unit)
    least_m = least_clearance_m(found, ~grid.free)
    assert least_m >= RADIUS_M - 1e-6
    assert found.clear_m == pytest.approx(least_m, abs=2e-4)


def test_the_clearance_holds_where_cell_centres_are_exactly_as_far_from_walls_as_the_radius() -> None:
    """At 2 cm a radius of 0.17 m is 8.5 cells, which leaves no room for rounding."""
    cells = walled(70, 90)
    row, col = np.indices(cells.shape)
    cells[np.hypot(row - 40, col - 50) < 9] = 100
    cells[2 * row + 5 * col < 150] = 100
    grid = OccupancyGrid.from_array(cells, 0.02)
    found = covered((grid, vdoor.run(grid)))
    assert least_clearance_m(found, ~grid.free) >= RADIUS_M - 1e-6
    assert found.covered >= 0.97


@pytest.mark.parametrize("seed", [0, 3])
def test_homes_are_covered_and_a_count_with_smaller_cells_agrees(seed: int) -> None:
    grid, topology = home(seed)
    found = covered((grid, topology))
    assert found.covered >= 0.98
    assert found.excess <= 1.5
    for cell_m, apart in ((0.025, 0.003), (0.01, 0.004)):  # half the map's cells, and a fifth
        assert swept_share(found, grid, topology.labels, cell_m) == pytest.approx(found.covered, abs=apart)


@pytest.mark.parametrize(("rows", "cols"), [(80, 120), (100, 200), (120, 121)])
def test_an_empty_rectangle_is_covered_almost_without_overlap(rows: int, cols: int) -> None:
    found = covered(mapped(walled(rows, cols)))
    assert found.covered >= 0.995
    assert found.excess <= 1.09
    assert covered(mapped(walled(rows, cols)), end="").excess <= 1.04


def test_equal_input_gives_equal_records() -> None:
    assert equal(covered(home(0)), covered(home(0)))


def test_the_dial_moves_between_coverage_and_length() -> None:
    found = [covered(home(0), trade=trade, leave=1.0) for trade in (0.0, 0.1, 0.4)]
    assert found[0].covered > found[1].covered > found[2].covered
    assert found[0].length_m > found[1].length_m > found[2].length_m


def test_no_more_than_the_given_share_stays_uncovered_for_a_shorter_path() -> None:
    for leave in (0.01, 0.03):
        assert 1 - leave <= covered(home(0), trade=1.0, leave=leave).covered <= 1 - 0.9 * leave


def test_rooms_are_swept_one_after_the_other_with_few_changes_of_room() -> None:
    grid, topology = home(0)
    found = covered((grid, topology))
    assert found.room_changes <= 1.2 * least_changes(topology, set(found.visit_room.tolist()))
    assert covered((grid, topology), unit="map").room_changes > found.room_changes
    assert (np.diff(found.visit) >= 0).all()
    assert (np.diff(found.visit_done_s) >= 0).all()
    assert found.visit_done_s[-1] == found.at_s[-1]


def test_a_tool_wider_than_the_robot_does_not_sweep_through_walls() -> None:
    grid, topology = mapped(two_rooms(18, thick=1))
    found = covered((grid, topology), rooms=("1",), closed=("1",), start="1", tool_m=0.8)
    assert (found.swept[topology.labels == 1] > 0).mean() > 0.9
    assert not found.swept[topology.labels == 2].any()
    narrow = CoverFloor(unit="room", rooms=("1",), start="1", tool_m=0.3)(grid, topology)
    assert narrow.covered >= 0.98


@pytest.mark.parametrize("fine", [1, 2])
def test_what_a_tool_reaches_is_what_lies_near_its_floor(fine: int) -> None:
    ring = np.array([(8.0, 8.0), (8.0, 30.0), (20.5, 33.2), (30.0, 9.0), (8.0, 8.0)])
    hole = np.array([(15.0, 15.0), (22.0, 15.0), (22.0, 24.0), (15.0, 15.0)])
    floor = shapely.Polygon(ring, [hole])
    start, end = np.concatenate([ring[:-1], hole[:-1]]), np.concatenate([ring[1:], hole[1:]])
    tool = Tool.on(np.zeros((40, 44), np.bool_), fine, reach=1.7, radius=2.0)
    reached = tool.reachable(start, end)
    at = tool.on_map(np.argwhere(np.ones_like(reached)).astype(float))
    apart = shapely.distance(floor, shapely.points(at)).reshape(reached.shape)
    sure = np.abs(apart - 1.7) > 1e-6
    assert (reached == (apart <= 1.7))[sure].all()


def test_a_tool_sweeps_the_cells_of_its_stadium() -> None:
    rng = np.random.default_rng(1)
    row, col = np.mgrid[0:40, 0:50]
    for reach in (0.4, 1.0, 3.0, 7.3):
        tool = Tool(reach, reach, np.zeros(row.shape, np.bool_))
        ends = rng.uniform((-3, -3), (43, 53), (30, 2, 2))
        swept = tool.swept(ends[:, 0], ends[:, 1])
        for number, (a, b) in enumerate(ends):
            at = np.stack([row, col], axis=2) - a
            share = np.clip((at * (b - a)).sum(axis=2) / ((b - a) ** 2).sum(), 0, 1)
            apart = np.hypot(*np.moveaxis(at - share[..., None] * (b - a), 2, 0))
            own = np.zeros(row.size, np.bool_)
            own[swept.cell[swept.segment == number]] = True
            sure = np.abs(apart - reach) > 1e-6
            assert (own.reshape(row.shape) == (apart <= reach))[sure].all()


def test_a_room_behind_a_door_narrower_than_the_robot_is_named_and_left_out() -> None:
    found = covered(mapped(two_rooms(6)), start="1")
    assert found.missed.tolist() == [2]
    assert found.visit_room.tolist() == [1]
    assert found.covered >= 0.98


def test_both_parts_of_a_room_that_is_in_two_parts_for_the_robot_are_swept() -> None:
    cells = walled(40, 160)
    cells[3:43, 60:62] = cells[3:43, 102:104] = 100
    cells[10:28, 60:62] = cells[10:28, 102:104] = 0
    grid, topology = mapped(cells)
    parted = dataclasses.replace(topology, labels=np.where(topology.labels == 3, 1, topology.labels))
    parted = dataclasses.replace(
        parted, area_m2=topology.area_m2[:2], centre=topology.centre[:2], name=topology.name[:2]
    )
    found = covered((grid, parted), start="1")
    assert sorted(found.visit_room.tolist()) == [1, 1, 2]
    for columns in (slice(3, 60), slice(62, 102), slice(104, 163)):
        assert (found.swept[6:40, columns] > 0).mean() > 0.9


def test_a_passage_one_cell_wide_is_passed_by_a_robot_that_fits() -> None:
    grid = OccupancyGrid.from_array(two_rooms(1), CELL_M)
    topology = house()[1]
    labels = np.where(grid.free, topology.labels, 0).astype(np.int32)
    narrow = dataclasses.replace(topology, labels=labels)
    found = covered((grid, narrow), radius_m=0.02, tool_m=0.2)
    assert sorted(found.visit_room.tolist()) == [1, 2]
    assert found.missed.tolist() == []
    assert least_clearance_m(found, ~grid.free) >= 0.02 - 1e-6


@pytest.mark.parametrize("asked", [{"avoid": ("2",)}, {"avoid": (ROOM_2,)}, {"rooms": (ROOM_1,)}, {"closed": ("1",)}])
def test_avoided_rooms_and_rooms_behind_closed_doors_are_not_swept(asked: dict[str, tuple[str, ...]]) -> None:
    grid, topology = house()
    found = covered((grid, topology), start="1", **asked)
    assert found.visit_room.tolist() == [1]
    assert found.missed.tolist() == ([2] if "closed" in asked else [])
    assert not found.swept[:, 60:].any()


def test_no_go_areas_are_kept_clear_of_and_no_mop_areas_by_robots_that_mop() -> None:
    grid, topology = house()
    left, low = grid.frame.world_from_cell(np.array([[40, 15]]))[0]
    area = ((left, low), (left + 0.8, low), (left + 0.8, low + 0.8), (left, low + 0.8))
    go = Annotations(own_origin_cm=(0, 0), no_go_areas_m=(area,))
    mop = Annotations(own_origin_cm=(0, 0), no_mop_areas_m=(area,))
    task = CoverFloor(unit="room")
    inside = (slice(26, 40), slice(17, 30))
    assert not task.found(grid, topology, go).swept[inside].any()
    assert task.found(grid, topology, mop).swept[inside].all()
    assert not dataclasses.replace(task, mops=True).found(grid, topology, mop).swept[inside].any()


def test_the_threshold_of_a_door_is_swept() -> None:
    grid, topology = house()
    found = covered((grid, topology))
    assert (found.swept[26:42, 52:56] > 0).all()  # the door, two cells deep, and a cell on both sides


def test_a_table_leg_gets_a_ring_and_does_not_split_the_lanes() -> None:
    cells = walled(80, 120)
    bare = covered(mapped(cells))
    cells[45:47, 60:62] = 100
    found = covered(mapped(cells))
    assert found.covered >= 0.98
    assert found.length_m <= bare.length_m + 3.0
    around = found.swept[42:50, 57:65] > 0
    assert around[cells[42:50, 57:65] == 0].mean() > 0.9


def test_the_given_order_is_kept() -> None:
    where = house()
    for rooms in (("1", "2"), ("2", "1")):
        found = covered(where, rooms=rooms, ordered=True, start="1")
        assert found.visit_room.tolist() == [int(room) for room in rooms]


@pytest.mark.parametrize("start", ["0.7,0.7", "2", "2.6,1.7"])
def test_a_path_begins_at_the_start_and_ends_there_or_anywhere(start: str) -> None:
    where = house()
    found = covered(where, start=start)
    assert found.point_m[0] == pytest.approx(found.point_m[-1], abs=1e-9)
    if "," in start:
        assert found.point_m[0] == pytest.approx([float(part) for part in start.split(",")], abs=RADIUS_M)
    assert covered(where, start=start, end="").length_m < found.length_m


@pytest.mark.parametrize(
    ("asked", "says"),
    [
        ({"start": "0.01,0.01"}, "start: wanted a place within 0.17 m of where the robot fits"),
        ({"rooms": ("7",)}, "rooms: "),
        ({"rooms": ("0.01,0.01",)}, "rooms: wanted a point in a room, found none"),
        ({"radius_m": 2.0}, "radius_m: wanted a robot that fits into a room"),
        ({"unit": "house"}, "unit: wanted room or map, found 'house'"),
    ],
)
def test_what_cannot_be_is_refused(asked: dict[str, Any], says: str) -> None:
    with pytest.raises(SettingError, match=says.replace(".", r"\.")):
        covered(house(), **asked)


def test_a_map_turned_by_30_degrees_is_covered_as_well() -> None:
    cells = walled(70, 100)
    cells[30:36, 40:70] = 100
    upright = covered(mapped(cells))
    # a cell of the turned map is what is at its centre in the upright one
    angle_rad, size = np.radians(30), 150
    row, col = np.mgrid[0:size, 0:size] - size / 2
    at = np.stack(
        [np.cos(angle_rad) * row - np.sin(angle_rad) * col, np.sin(angle_rad) * row + np.cos(angle_rad) * col]
    )
    place = np.rint(at + np.array([38, 53])[:, None, None]).astype(int)
    inside = (place >= 0).all(axis=0) & (place[0] < cells.shape[0]) & (place[1] < cells.shape[1])
    turned = np.full((size, size), -1, np.int8)
    turned[inside] = cells[place[0][inside], place[1][inside]]
    found = covered(mapped(turned))
    assert found.covered == pytest.approx(upright.covered, abs=0.015)
    assert found.length_m == pytest.approx(upright.length_m, rel=0.06)


def test_the_floor_lies_where_the_robot_fits_and_holds_all_centres_but_for_a_margin() -> None:
    grid, _ = home(0)
    space = Space.of(~grid.free, grid.frame, RADIUS_M)
    part = space.parts == np.bincount(space.parts[space.parts > 0]).argmax()
    floor = floor_of(space, part)
    assert floor.is_valid
    area = floor.area
    assert 0.85 * np.count_nonzero(part) <= area <= 1.25 * np.count_nonzero(part)


def test_a_tour_of_few_pieces_is_the_shortest_or_nearly_so() -> None:
    rng = np.random.default_rng(5)
    ratios = []
    for _ in range(40):
        point = rng.uniform(0, 10, (12, 2))  # five pieces, the start and the end
        distance = np.hypot(*(point[:, None] - point[None]).transpose(2, 0, 1))
        piece = np.arange(10).reshape(-1, 2)
        tour = tour_of(distance, piece, 10, 11)
        assert sorted(tour.piece[1:-1].tolist()) == list(range(5))
        length = float(distance[tour.leave[:-1], tour.enter[1:]].sum())
        ratios.append(length / _shortest(distance, piece, 10, 11))
    assert min(ratios) > 1 - 1e-9
    assert np.mean(ratios) < 1.02


def _shortest(distance: NDArray[np.float64], piece: NDArray[np.intp], start: int, end: int) -> float:
    """The length of the shortest tour, by trying all."""

    def rest(here: int, todo: frozenset[int]) -> float:
        if not todo:
            return float(distance[here, end])
        ways = ((number, side) for number in todo for side in (0, 1))
        return min(
            float(distance[here, piece[number, side]]) + rest(int(piece[number, 1 - side]), todo - {number})
            for number, side in ways
        )

    return rest(start, frozenset(range(len(piece))))


def test_a_path_begins_at_the_charger_that_the_map_has() -> None:
    grid, topology = house()
    charger_m = (1.0, 1.3)
    own = Annotations(own_origin_cm=(0, 0), charger_m=charger_m, robot_m=(4.0, 1.0))
    found = CoverFloor(unit="room", end="start").found(grid, topology, own)
    assert found.point_m[[0, -1]] == pytest.approx(np.array([charger_m] * 2), abs=CELL_M)
    in_wall = dataclasses.replace(own, charger_m=(0.0, 0.0))  # then from where the robot is
    assert CoverFloor(unit="room").found(grid, topology, in_wall).point_m[0] == pytest.approx([4.0, 1.0], abs=CELL_M)


def test_a_start_on_a_line_between_rooms_is_taken_and_one_outside_all_rooms_refused() -> None:
    grid, topology = house()
    on_line_m = topology.doors[0].start_m
    middle_m = np.mean([on_line_m, topology.doors[0].end_m], axis=0)
    found = covered((grid, topology), start=f"{middle_m[0]},{middle_m[1]}")
    assert found.point_m[0] == pytest.approx(middle_m, abs=RADIUS_M)
    assert sorted(found.visit_room.tolist()) == [1, 2]
    cells = np.pad(grid.cells, ((0, 0), (0, 30)), constant_values=100)
    cells[20:34, 112:126] = 0  # a closet that is no room
    apart = mapped(cells)
    assert not apart[1].labels[27, 119]
    place_m = apart[0].frame.world_from_cell(np.array([(27, 119)]))[0]
    with pytest.raises(SettingError, match="wanted a room that the robot can reach, found none"):
        covered(apart, start=f"{place_m[0]},{place_m[1]}")


def test_a_map_without_rooms_is_refused() -> None:
    with pytest.raises(VdoorError, match="no free cell"):
        mapped(np.full((30, 30), 100, np.int8))
