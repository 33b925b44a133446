"""The topological map: labels, doors and rooms say the same, and apartments come out as they were drawn."""

from __future__ import annotations

import dataclasses
from collections import deque
from typing import Any

import numpy as np
import pytest
import shapely  # type: ignore[import-untyped]  # publishes no types
from hypothesis import given
from hypothesis import strategies as st
from maps import CELL_M, Cells, cells_drawn, drawn, law, simplifying, small_maps, text_of, with_search
from numpy.typing import NDArray
from scipy import ndimage
from scipy.optimize import linear_sum_assignment

from vdoor.api import run
from vdoor.errors import MapError
from vdoor.grid import FREE, OccupancyGrid
from vdoor.method.search.optimisers import AnnealingSearch
from vdoor.method.simplify import SimplifyGrid
from vdoor.pipeline import PRESETS, Pipeline
from vdoor.raster.components import contacts
from vdoor.raster.labels import flooded
from vdoor.synth import PRESETS as KINDS
from vdoor.synth import SyntheticMap, synthesize
from vdoor.topology import TopologicalMap

QUICK = AnnealingSearch(evaluations=300)
ISLANDS_OUT = simplifying(max_island_m=1.0)
MATCH_M = 0.5
TWO_ROOMS = """
    #############
    #.....#.....#
    #.....#.....#
    #.....#.....#
    #...........#
    #...........#
    #...........#
    #...........#
    #.....#.....#
    #.....#.....#
    #.....#.....#
    #############
"""


def two_rooms(cell_m: float = CELL_M) -> TopologicalMap:
    return run(drawn(TWO_ROOMS, cell_m))


def test_a_one_room_map_is_one_node_and_no_edge() -> None:
    found = run(drawn("#####\n#...#\n#...#\n#####"))
    graph = found.to_networkx()
    assert (graph.number_of_nodes(), graph.number_of_edges()) == (1, 0)
    assert found.labels.tolist() == [[0] * 5, [0, 1, 1, 1, 0], [0, 1, 1, 1, 0], [0] * 5]
    (room,) = found.rooms
    assert room.neighbours == ()
    assert room.area_m2 == pytest.approx(0.24)


def test_a_one_cell_map_is_a_room() -> None:
    (room,) = run(drawn(".")).rooms
    assert room.centre_m == pytest.approx((0.1, 0.1))
    assert room.polygon_m[0][0] == room.polygon_m[0][-1]


@pytest.mark.parametrize("preset", PRESETS)
def test_every_preset_and_search_takes_a_map_without_doors(preset: str) -> None:
    assert len(run(drawn("####\n#..#\n#..#\n####"), preset).rooms) == 1


def test_two_rooms_are_joined_by_one_door_of_known_place_and_size() -> None:
    found = run(drawn(TWO_ROOMS), with_search(Pipeline(), QUICK))
    (door,) = found.doors
    assert (door.rooms, door.kind, door.id) == ((1, 2), "pair", 1)
    assert sorted([door.start_m, door.end_m]) == [pytest.approx((1.3, 0.7)), pytest.approx((1.3, 1.7))]
    assert door.length_m == pytest.approx(1.0)
    assert door.width_m == pytest.approx(0.8)
    assert door.tilt_deg == 0
    assert found.to_networkx().edges[1, 2, 1]["width_m"] == door.width_m
    assert [room.neighbours for room in found.rooms] == [(2,), (1,)]
    assert sum(room.area_m2 for room in found.rooms) == pytest.approx(104 * 0.04)


@pytest.mark.parametrize("text", ["####\n####", "??\n??", "#?\n?#"])
def test_a_map_without_free_cells_is_refused(text: str) -> None:
    with pytest.raises(MapError, match="no free cell"):
        run(drawn(text))


def test_a_robot_far_from_free_space_is_refused() -> None:
    grid = drawn("........########\n........########")
    with pytest.raises(MapError, match=r"robot at 2\.8,0\.1: wanted a free cell within 0\.5 m"):
        run(grid, simplifying(robot_m=(2.8, 0.1)))
    assert len(run(grid, simplifying(robot_m=(1.9, 0.1))).rooms) == 1


def plain_flood(labels: NDArray[np.int32], free: NDArray[np.bool_]) -> NDArray[np.int32]:
    """Breadth first, a whole step at a time: the lowest label of the neighbours that were reached before."""
    found = labels.copy()
    front = deque(sorted(map(tuple, np.argwhere(labels > 0).tolist())))
    while front:
        offers: dict[tuple[int, int], list[int]] = {}
        for row, col in front:
            for place in ((row - 1, col), (row + 1, col), (row, col - 1), (row, col + 1)):
                inside = 0 <= place[0] < free.shape[0] and 0 <= place[1] < free.shape[1]
                if inside and free[place] and not found[place]:
                    offers.setdefault(place, []).append(int(found[row, col]))
        for place, labels_near in offers.items():
            found[place] = min(labels_near)
        front = deque(offers)
    return found


@law
@given(cells=small_maps(), seeds=st.lists(st.tuples(st.integers(0, 30), st.integers(0, 30)), max_size=6))
def test_flooding_is_a_breadth_first_search_with_the_lower_label_at_a_tie(
    cells: Cells, seeds: list[tuple[int, int]]
) -> None:
    free = cells == FREE
    labels = np.zeros(free.shape, np.int32)
    for label, (row, col) in enumerate(seeds, start=1):
        place = row % free.shape[0], col % free.shape[1]
        labels[place] = label if free[place] else 0
    np.testing.assert_array_equal(flooded(labels, free), plain_flood(labels, free))


@law
@given(cells=small_maps(most=30), factor=st.sampled_from([1, 1, 2, 3]))
def test_labels_are_whole_numbers_in_reading_order_on_all_that_can_be_reached(cells: Cells, factor: int) -> None:
    grid = OccupancyGrid.from_array(cells, CELL_M / factor)
    try:
        found = run(grid, with_search(Pipeline(), QUICK))
    except MapError:
        return  # no working cell is free
    labels, free = found.labels, grid.free
    assert labels.shape == cells.shape
    component, count = ndimage.label(free)
    for number in range(1, count + 1):
        inside = labels[component == number]
        assert (inside > 0).all() or (inside == 0).all()
    assert (labels[~free] == 0).all()
    present, first = np.unique(labels[labels > 0], return_index=True)
    assert present.tolist() == list(range(1, len(found.area_m2) + 1))
    assert (np.diff(first) > 0).all()
    np.testing.assert_allclose(found.area_m2, np.bincount(labels.ravel())[1:] * grid.frame.resolution_m**2)
    assert (labels[tuple(found.centre.T)] == present).all()
    assert (found.room_a < found.room_b).all()
    if factor == 1:
        assert "passage" not in {door.kind for door in found.doors}
        assert_polygons_cover_rooms(found)


def assert_polygons_cover_rooms(found: TopologicalMap) -> None:
    for room in found.rooms:
        outer, *holes = room.polygon_m
        polygon = shapely.Polygon(outer, holes)
        assert polygon.is_valid
        assert polygon.area == pytest.approx(room.area_m2)
        assert polygon.contains(shapely.Point(room.centre_m))


@law
@given(cells=small_maps(most=30, framed=True))
def test_rooms_hang_together_and_touch_where_doors_say_so(cells: Cells) -> None:
    grid = OccupancyGrid.from_array(cells, CELL_M)
    found = run(grid, with_search(Pipeline(), QUICK))
    pairs = {tuple(pair) for pair in contacts(found.labels)[1].tolist()}
    assert {door.rooms for door in found.doors} == pairs
    for room in range(1, len(found.area_m2) + 1):
        assert ndimage.label(found.labels == room)[1] == 1


def apartment(seed: int, **changes: Any) -> SyntheticMap:
    return synthesize(dataclasses.replace(KINDS["paper"], **changes), np.random.default_rng(seed))


def off_segment_m(point_m: NDArray[Any], start_m: NDArray[Any], end_m: NDArray[Any]) -> NDArray[np.float64]:
    """Distance (k,) of points (k, 2) to a segment."""
    return np.asarray(shapely.distance(shapely.points(point_m), shapely.LineString([start_m, end_m])))


@pytest.mark.parametrize("furniture", [False, True], ids=["plain", "furnished"])
@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize(("map_m", "working_m"), [(0.2, 0.2), (0.05, 0.2), (0.05, 0.05)])
def test_doors_and_contacts_between_labels_agree_within_a_working_cell(
    map_m: float, working_m: float, seed: int, *, furniture: bool
) -> None:
    grid = apartment(seed, cell_m=map_m, furniture=furniture).grid
    pipeline = with_search(simplifying(cell_m=working_m, max_island_m=1.0 if furniture else 0.0), QUICK)
    found = run(grid, pipeline)
    place, pair = contacts(found.labels)
    place_m = grid.frame.world_from_cell(place)
    explained = np.zeros(len(place), np.bool_)
    for door, start_m, end_m in zip(found.doors, found.start_m, found.end_m, strict=True):
        own = (pair == door.rooms).all(axis=1)
        near = own & (off_segment_m(place_m, start_m, end_m) <= working_m + 1e-9)
        assert near.any(), f"no contact at door {door.id} between {door.rooms}"
        explained |= near
    assert len(found.doors) > 0
    assert explained.all(), f"contacts without a door at {place[~explained].tolist()}"


def test_an_opening_too_narrow_for_the_working_resolution_is_a_passage() -> None:
    """A wall with a gap of 10 cm: closed at 20 cm, open at 5 cm; both sides are reached from elsewhere."""
    cells = cells_drawn("#" * 60 + ("\n#" + "." * 58 + "#") * 58 + "\n" + "#" * 60)
    cells[28:32, :48] = 100
    cells[28:32, 9:11] = FREE
    found = run(OccupancyGrid.from_array(cells, 0.05), with_search(Pipeline(), QUICK))
    narrow = [door for door in found.doors if door.kind == "passage"]
    assert len(narrow) == 1
    assert narrow[0].width_m == pytest.approx(0.1)
    assert narrow[0].tilt_deg == 0
    assert found.edge[narrow[0].id - 1] == -1
    middle_m = np.add(narrow[0].start_m, narrow[0].end_m) / 2
    assert middle_m == pytest.approx((0.5, 1.5), abs=0.1 + 1e-9)
    assert text_of(cells[28:32, 9:11]) == "..\n..\n..\n.."


def matches(made: SyntheticMap, found: TopologicalMap) -> tuple[int, int, int]:
    """How many doors are true, found, and matched one to one with middles within `MATCH_M`."""
    true_m = np.array([np.add(door.start_m, door.end_m) / 2 for door in made.doors]).reshape(-1, 2)
    found_m = (found.start_m + found.end_m) / 2
    off_m = np.hypot(*(true_m[:, None] - found_m[None]).transpose(2, 0, 1))
    row, col = linear_sum_assignment(np.where(off_m <= MATCH_M, off_m, 1e6))
    return len(true_m), len(found_m), int((off_m[row, col] <= MATCH_M).sum())


@pytest.mark.parametrize("furniture", [False, True], ids=["plain", "furnished"])
def test_the_doors_of_apartments_of_the_papers_kind_are_found(*, furniture: bool) -> None:
    """Six apartments with four seeds each, as the paper has them, and furnished with islands taken out."""
    pipeline = ISLANDS_OUT if furniture else PRESETS["paper"]
    counts = []
    for number in range(24):
        made = apartment(1000 + number, rooms=4 + number % 3, furniture=furniture)
        counts.append(matches(made, run(made.grid, pipeline, seed=number % 4)))
    true, found, matched = np.sum(counts, axis=0).tolist()
    assert true > 80
    assert matched >= 0.98 * true
    assert matched >= 0.98 * found


def test_the_maps_place_in_the_world_moves_its_points_and_nothing_else() -> None:
    plain = run(drawn(TWO_ROOMS))
    there = run(OccupancyGrid.from_array(cells_drawn(TWO_ROOMS), CELL_M, x_m=3.0, y_m=-2.0, yaw_rad=np.pi / 2))
    np.testing.assert_array_equal(plain.labels, there.labels)
    for name in ("start_m", "end_m", "feature_m", "vertex_m"):
        x_m, y_m = getattr(plain, name).T
        np.testing.assert_allclose(getattr(there, name), np.stack([3.0 - y_m, -2.0 + x_m], axis=1), atol=1e-9)
    np.testing.assert_allclose(plain.tilt_rad, there.tilt_rad)


def test_a_size_that_is_no_multiple_of_the_working_cell_is_filled_up() -> None:
    cells = np.pad(cells_drawn(TWO_ROOMS).repeat(4, axis=0).repeat(4, axis=1), ((0, 3), (0, 2)), constant_values=-1)
    found = run(OccupancyGrid.from_array(cells, 0.05), PRESETS["paper"])
    whole = run(OccupancyGrid.from_array(cells[:-3, :-2], 0.05), PRESETS["paper"])
    np.testing.assert_array_equal(found.labels[:-3, :-2], whole.labels)
    np.testing.assert_allclose(found.start_m, whole.start_m + np.array([0, 0.15]), atol=1e-9)
    assert SimplifyGrid().cell_m == CELL_M


def test_a_room_is_one_part_at_the_input_although_working_cells_bridge_a_gap() -> None:
    cells = np.full((40, 80), 100, np.int8)
    cells[4:36, 4:76] = 0
    cells[:, 58] = -1  # a line of unknown cells, thinner than a working cell
    topology = run(OccupancyGrid.from_array(cells, 0.05), "paper")
    assert len(topology.rooms) == 1
    assert (topology.labels[4:36, 4:58] == 1).all()
    assert (topology.labels[:, 58:] == 0).all()
    assert topology.rooms[0].area_m2 == pytest.approx(32 * 54 * 0.05**2)
    assert len(topology.rooms[0].polygon_m) == 1
