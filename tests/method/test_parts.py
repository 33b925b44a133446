"""Parts of the free space that are not connected: rooms behind shut doors, sills, hollow furniture, rays."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from numpy.typing import NDArray

import vdoor
from vdoor.cli.run import _note_left_out
from vdoor.grid import FREE, OCCUPIED, UNKNOWN, OccupancyGrid
from vdoor.pipeline import PRESETS, Pipeline
from vdoor.topology import TopologicalMap

CELL_M = 0.05


def two_rooms(sill: int, width: int = 16) -> NDArray[np.int8]:
    """A room of 3 by 3 m beside one of 1.6 by 3 m, and between them a wall with a doorway of unknown cells."""
    cells = np.full((70, 110), UNKNOWN, np.int8)
    cells[4:66, 4 : 62 + sill + 34] = OCCUPIED
    cells[5:65, 5:65] = cells[5:65, 65 + sill : 65 + sill + 30] = FREE
    cells[5:65, 65 : 65 + sill] = OCCUPIED
    cells[20 : 20 + width, 65 : 65 + sill] = UNKNOWN
    return cells


def divided(cells: NDArray[np.int8]) -> TopologicalMap:
    """The map by `default`, with sills opened and half-seen cells handed to rooms."""
    default = PRESETS["default"]
    assert isinstance(default, Pipeline)
    simplify = dataclasses.replace(default.simplify, sill_m=0.2)
    merge = dataclasses.replace(default.merge, half_seen_m=0.25)
    pipeline = dataclasses.replace(default, simplify=simplify, merge=merge)
    return vdoor.run(OccupancyGrid.from_array(cells, CELL_M), pipeline)


@pytest.mark.parametrize("sill", [1, 4])
def test_a_doorway_whose_floor_is_unknown_is_a_door_of_its_own_kind(sill: int) -> None:
    found = divided(two_rooms(sill))
    assert [door.kind for door in found.doors] == ["sill"]
    assert abs(found.doors[0].width_m - 0.8) <= 2 * CELL_M
    assert len(found.rooms) == 2


@pytest.mark.parametrize(("sill", "width"), [(5, 16), (4, 7)])
def test_thicker_and_shorter_strips_are_no_doorway_but_both_rooms_stay(sill: int, width: int) -> None:
    found = divided(two_rooms(sill, width))
    assert (len(found.rooms), len(found.doors)) == (2, 0)


def test_a_room_of_the_least_size_behind_a_shut_door_stays_wherever_the_robot_is() -> None:
    cells = two_rooms(4, 0)
    cells[5:65, 69:99] = OCCUPIED
    cells[20:40, 69:90] = FREE  # 1.05 m2
    assert len(divided(cells).rooms) == 2
    cells[20:40, 87:90] = OCCUPIED  # 0.9 m2
    assert len(divided(cells).rooms) == 1


def test_hollow_furniture_is_no_room() -> None:
    cells = two_rooms(4, 0)
    cells[64 - 24 : 65, 20:54] = OCCUPIED  # a hollow bed with one side at the wall, 1.1 by 1.6 m
    cells[64 - 23 : 64, 21:53] = FREE
    assert len(divided(cells).rooms) == 2


def test_cells_that_only_single_rays_reach_get_the_room_they_came_from() -> None:
    cells = two_rooms(4, 0)
    cells[2, 10:60:4] = FREE  # beyond the outer wall
    cells[4, 8:62] = FREE  # a window
    found = divided(cells)
    assert set(found.labels[2, 10:60:4].tolist()) == {found.labels[10, 10]}


@pytest.mark.parametrize(("side", "noted"), [(12, True), (6, False)])
def test_what_has_no_room_is_noted_in_square_metres(side: int, noted: bool, capsys: pytest.CaptureFixture[str]) -> None:
    cells = two_rooms(4, 0)
    cells[5:65, 69:99] = OCCUPIED
    cells[20 : 20 + side, 72 : 72 + side] = FREE
    grid = OccupancyGrid.from_array(cells, CELL_M)
    _note_left_out(grid, vdoor.run(grid))
    assert ("0.4 m2 of free space (4%) have no room" in capsys.readouterr().err) is noted
