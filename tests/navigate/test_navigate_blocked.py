"""What the robot must not touch, and where it can stand."""

from __future__ import annotations

import numpy as np
import pytest
import shapely
from maps import Cells, cells_drawn

import vdoor
from vdoor.errors import SettingError
from vdoor.grid import Annotations, OccupancyGrid
from vdoor.navigate.blocked import Restrictions, blocked_cells, door_contacts, ruled_out
from vdoor.navigate.places import standing_at, standing_in
from vdoor.navigate.space import Space
from vdoor.raster.strips import near_segments
from vdoor.topology import TopologicalMap

CELL_M = 0.2


def two_rooms() -> Cells:
    """Rooms of 16 x 16 cells left and right of a wall of two cells, with a door of four."""
    cells = np.zeros((20, 38), np.int8)
    cells[[0, 1, -1, -2]] = cells[:, [0, 1, -1, -2]] = cells[:, 18:20] = 100
    cells[8:12, 18:20] = 0
    return cells


def mapped(cells: Cells) -> tuple[OccupancyGrid, TopologicalMap]:
    grid = OccupancyGrid.from_array(cells, CELL_M)
    return grid, vdoor.run(grid)


def squares(first: np.ndarray, begin: np.ndarray, end: np.ndarray) -> set[tuple[int, int]]:
    return {(first[0, 0] + row, col) for row in range(begin.shape[1]) for col in range(begin[0, row], end[0, row])}


@pytest.mark.parametrize("radius", [0.5, 1.0, 2.0, 3.4])
def test_cells_near_a_segment_are_those_that_shapely_finds(radius: float) -> None:
    rng = np.random.default_rng(0)
    row, col = np.mgrid[-14:15, -14:15]
    boxes = shapely.box(col - 0.5, row - 0.5, col + 0.5, row + 0.5)
    for corner in (0.0, 0.5):
        for start, end in rng.integers(-7, 8, (40, 2, 2)) + corner * rng.uniform(-1, 1, (40, 2, 2)):
            apart = shapely.distance(shapely.linestrings([start[::-1], end[::-1]]), boxes)
            found = squares(*near_segments(start[None], end[None], radius))
            sure = np.abs(apart - radius) > 1e-6
            near = set(zip(row[sure & (apart < radius)], col[sure & (apart < radius)], strict=True))
            assert near <= found
            assert found - near <= set(zip(row[~sure], col[~sure], strict=True))


def test_a_virtual_wall_blocks_the_cells_it_touches_and_an_area_those_inside() -> None:
    frame = OccupancyGrid.from_array(np.zeros((6, 8), np.int8), 1.0).frame
    wall = Annotations(own_origin_cm=(0, 0), virtual_walls_m=(((1.5, 4.5), (4.5, 4.5)),))
    area = Annotations(own_origin_cm=(0, 0), no_go_areas_m=(((2.5, 0.5), (5.5, 0.5), (5.5, 2.5), (2.5, 2.5)),))
    mop = Annotations(own_origin_cm=(0, 0), no_mop_areas_m=area.no_go_areas_m)
    assert np.argwhere(ruled_out(frame, wall, mops=False)).tolist() == [[1, col] for col in range(1, 5)]
    inside = [[row, col] for row in range(3, 6) for col in range(2, 6)]
    assert np.argwhere(ruled_out(frame, area, mops=False)).tolist() == inside
    assert np.argwhere(ruled_out(frame, mop, mops=True)).tolist() == inside
    assert not ruled_out(frame, mop, mops=False).any()


def test_a_closed_door_parts_the_rooms_and_an_avoided_room_is_blocked_whole() -> None:
    grid, topology = mapped(two_rooms())
    assert len(topology.doors) == 1
    assert set(door_contacts(topology)[1].tolist()) == {0}
    parts = [
        Space.of(blocked_cells(grid, topology, wanted), grid.frame, 0.17).parts
        for wanted in (Restrictions(), Restrictions(closed_doors=[1]))
    ]
    assert [part.max() for part in parts] == [1, 2]
    left, right = (parts[1][tuple(topology.centre[row])] for row in (0, 1))
    assert left != right
    avoided = blocked_cells(grid, topology, Restrictions(avoided_rooms=[2]))
    assert (avoided == (~grid.free | (topology.labels == 2))).all()
    with pytest.raises(SettingError, match="found 2"):
        blocked_cells(grid, topology, Restrictions(closed_doors=[2]))


def test_a_place_near_a_wall_is_moved_by_at_most_the_radius() -> None:
    cells = cells_drawn("#######\n" + "#.....#\n" * 5 + "#######")
    grid = OccupancyGrid.from_array(cells, CELL_M)
    space = Space.of(~grid.free, grid.frame, 0.25)  # two cells from a wall's cell to the first allowed one
    middle = standing_at(space, (0.7, 0.7), what="FROM")
    assert (middle.cell, middle.moved_m, middle.note("FROM")) == ((3, 3), 0.0, "")
    beside = standing_at(space, (0.3, 0.7), what="FROM")
    assert beside.cell == (3, 2)
    assert beside.moved_m == pytest.approx(0.2)
    assert beside.note("FROM") == "FROM: moved by 0.20 m to 0.50,0.70, where the robot fits"
    with pytest.raises(SettingError, match=r"TO: wanted a place within 0\.25 m"):
        standing_at(space, (0.1, 0.7), what="TO")
    with pytest.raises(SettingError, match="TO"):
        standing_at(space, (-5.0, 0.7), what="TO")


def test_the_robot_stands_in_the_largest_part_of_a_room_or_nowhere() -> None:
    grid, topology = mapped(two_rooms())
    blocked = blocked_cells(grid, topology)
    blocked[2:18, 12] = True  # nine columns to the left of it, three to the right
    space = Space.of(blocked, grid.frame, 0.17)
    standing = standing_in(space, topology, 1)
    assert standing is not None
    assert standing.cell[1] < 12
    assert standing_in(Space.of(blocked, grid.frame, 5.0), topology, 1) is None
