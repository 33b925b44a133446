"""Doors in a short passage lie in its middle, and their rooms follow."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from maps import MOVES, Cells, Move, cells_drawn

import vdoor
from vdoor.grid import FREE
from vdoor.method.centred_doors import in_middle
from vdoor.method.moved_doors import Ends
from vdoor.pipeline import PRESETS, Pipeline

PASSAGE = """
    ####################
    #....##########....#
    #....##########....#
    #..................#
    #..................#
    #..................#
    #....##########....#
    #....##########....#
    ####################
"""
AT_ITS_LEFT = Ends(np.array([2, 5], np.int32), np.array([6, 5], np.int32))
DEFAULT = PRESETS["default"]
assert isinstance(DEFAULT, Pipeline)
AS_FOUND = dataclasses.replace(DEFAULT, merge=dataclasses.replace(DEFAULT.merge, centre_m=0.0))


def ends(free: object, old: Ends, *, wall: float = 4.0, most: float = 12.0, step: float = 1.0) -> list[list[int]]:
    found = in_middle(np.asarray(free, np.bool_), old, wall=wall, most=most, step=step)
    return [[*end.start.tolist(), *end.end.tolist()] for end in found]


def test_a_door_at_the_end_of_a_passage_goes_to_its_middle() -> None:
    free = cells_drawn(PASSAGE) == FREE
    assert ends(free, AT_ITS_LEFT) == [[2, 9, 6, 9]]
    at_its_right = Ends(np.array([2, 14], np.int32), np.array([6, 14], np.int32))
    assert ends(free, at_its_right) == [[2, 10, 6, 10]]


@pytest.mark.parametrize(("wall", "most"), [(10.0, 12.0), (4.0, 8.0)], ids=["a wall", "a corridor"])
def test_a_door_in_a_wall_or_a_corridor_stays(wall: float, most: float) -> None:
    assert ends(cells_drawn(PASSAGE) == FREE, AT_ITS_LEFT, wall=wall, most=most) == []


def test_a_passage_ends_where_it_widens() -> None:
    cells = cells_drawn(PASSAGE)
    cells[1:8, 10:15] = FREE
    assert ends(cells == FREE, AT_ITS_LEFT, wall=3.0) == [[2, 7, 6, 7]]


def test_a_door_in_the_middle_stays() -> None:
    middle = Ends(np.array([2, 9], np.int32), np.array([6, 9], np.int32))
    assert ends(cells_drawn(PASSAGE) == FREE, middle) == []


def home(deep: int = 16) -> Cells:
    """Two rooms with ragged walls, joined by a passage of 0.9 m, in cells of 5 cm."""
    cells = np.full((84, 160 + deep), 100, np.int8)
    cells[4:80, 4:80] = cells[4:80, 80 + deep : 156 + deep] = FREE
    cells[30:48, 80 : 80 + deep] = FREE
    for room in (4, 80 + deep):
        for at in range(6, 76, 8):
            cells[at : at + 3, room : room + 2] = cells[at : at + 3, room + 74 : room + 76] = 100
            cells[4:6, room + at - 4 : room + at - 1] = cells[78:80, room + at - 4 : room + at - 1] = 100
    cells[24:54, 74:80] = cells[24:54, 80 + deep : 86 + deep] = FREE
    return cells


@pytest.mark.parametrize("move", [move for move in MOVES if move.finer == 1], ids=lambda move: move.name)
def test_in_a_home_the_door_of_a_deep_passage_is_in_the_middle(move: Move) -> None:
    grid = vdoor.OccupancyGrid.from_array(move.cells(home()), 0.05)
    (door,) = vdoor.run(grid, DEFAULT).doors
    free = np.argwhere(grid.free)
    (middle_m,) = grid.frame.world_from_cell((free.min(axis=0) + free.max(axis=0))[None] / 2)
    assert abs(np.add(door.start_m, door.end_m) / 2 - middle_m).min() <= 0.05


def test_the_rooms_follow() -> None:
    grid = vdoor.OccupancyGrid.from_array(home(), 0.05)
    before, after = (sorted(room.area_m2 for room in vdoor.run(grid, each).rooms) for each in (AS_FOUND, DEFAULT))
    assert before[1] - before[0] > 0.5
    assert after[1] - after[0] < 0.1
    assert sum(before) == pytest.approx(sum(after))
