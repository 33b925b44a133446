"""Doors lie straight where the opening is straight, and their rooms stay the same rooms."""

from __future__ import annotations

import dataclasses
import itertools

import numpy as np
import pytest
from maps import cells_drawn
from numpy.typing import NDArray
from project import HOME

import vdoor
from vdoor.method.moved_doors import Ends, moved
from vdoor.method.straight_doors import straighter
from vdoor.pipeline import PRESETS, Pipeline
from vdoor.synth import Home, synthesize
from vdoor.topology import TopologicalMap

PRESET = PRESETS["default"]
assert isinstance(PRESET, Pipeline)
DEFAULT = dataclasses.replace(PRESET, merge=dataclasses.replace(PRESET.merge, centre_m=0.0))
AS_FOUND = dataclasses.replace(DEFAULT, merge=dataclasses.replace(DEFAULT.merge, straight_m=0.0))
DOORWAY = """
    ############
    #....##....#
    #....##....#
    #..........#
    #..........#
    #..........#
    #....##....#
    #....##....#
    ############
"""
FREE = cells_drawn(DOORWAY) == 0
ASKEW = Ends(np.array([2, 6], np.int32), np.array([6, 5], np.int32))


def plan(name: str) -> vdoor.OccupancyGrid:
    return vdoor.read_map(HOME / "recordings" / name)


def askew_deg(found: TopologicalMap) -> list[float]:
    """How far each door is from the axes of an upright map."""
    return [door.tilt_deg for door in found.doors]


def test_door_2_of_the_example_map_lies_straight() -> None:
    before, after = (vdoor.run(plan("flat.yaml"), pipeline) for pipeline in (AS_FOUND, DEFAULT))
    assert before.doors[1].tilt_deg == pytest.approx(11.3, abs=0.1)
    assert askew_deg(after) == [0, 0, 0, 0]
    assert [door.rooms for door in after.doors] == [door.rooms for door in before.doors]
    assert after.doors[1].length_m == pytest.approx(1.0)


def test_a_line_across_a_doorway_becomes_square_and_no_longer() -> None:
    best = next(straighter(FREE, ASKEW, reach=2, wall_rad=0.0))
    assert best.start[1] == best.end[1]
    assert (best.start[0], best.end[0]) == (2, 6)


def test_a_line_square_to_slanted_walls_stays() -> None:
    span = ASKEW.end - ASKEW.start
    along = float(np.arctan2(span[0], span[1]))
    assert list(straighter(FREE, ASKEW, reach=2, wall_rad=along)) == []


def test_a_line_without_reach_stays() -> None:
    assert list(straighter(FREE, ASKEW, reach=0, wall_rad=0.0)) == []


def test_the_rooms_follow_the_line() -> None:
    room = np.where(FREE, np.where(np.arange(12) < 6, 1, 2), 0).astype(np.int32)
    room[[3, 4, 5], [6, 6, 5]] = 0
    new = Ends(np.array([2, 6], np.int32), np.array([6, 6], np.int32))
    assert moved(FREE, room, (1, 2), ASKEW, new)
    assert room[4].tolist() == [0, 1, 1, 1, 1, 1, 0, 2, 2, 2, 2, 0]
    assert room[5].tolist() == [0, 1, 1, 1, 1, 1, 0, 2, 2, 2, 2, 0]


def test_a_line_that_parts_nothing_is_refused_and_changes_nothing() -> None:
    room = np.where(FREE, np.where(np.arange(12) < 6, 1, 2), 0).astype(np.int32)
    before = room.copy()
    across = Ends(np.array([2, 6], np.int32), np.array([2, 8], np.int32))
    assert not moved(FREE, room, (1, 2), ASKEW, across)
    assert (room == before).all()


@pytest.mark.parametrize("seed", range(6))
def test_rooms_keep_their_topology(seed: int) -> None:
    grid = synthesize(Home(), np.random.default_rng([16, seed])).grid
    before, after = (vdoor.run(grid, pipeline) for pipeline in (AS_FOUND, DEFAULT))
    old = [int(np.bincount(before.labels[after.labels == room]).argmax()) for room in after.room_ids]
    number = np.array([0, *old], np.int32)  # rooms are numbered in reading order, which a moved door can change
    assert sorted(old) == list(before.room_ids)
    assert [sorted(number[[*door.rooms]]) for door in after.doors] == [sorted(door.rooms) for door in before.doors]
    assert pairs(number[after.labels]) == pairs(before.labels)
    assert ((after.labels > 0) == (before.labels > 0)).all()
    assert all(a.length_m <= b.length_m + 1e-9 for a, b in zip(after.doors, before.doors, strict=True))


def pairs(labels: NDArray[np.int32]) -> set[tuple[int, int]]:
    """The pairs of rooms that touch."""
    found = set()
    for one, other in ((labels[:-1], labels[1:]), (labels[:, :-1], labels[:, 1:])):
        touch = (one != other) & (one > 0) & (other > 0)
        found |= {(min(pair), max(pair)) for pair in zip(one[touch].tolist(), other[touch].tolist(), strict=True)}
    return found


def test_homes_have_straighter_doors() -> None:
    """The mean angle to the true doors, of the doors that are hits."""
    tilt: dict[float, list[float]] = {0.0: [], 0.4: []}
    for seed, (reach_m, pipeline) in itertools.product(range(6), ((0.0, AS_FOUND), (0.4, DEFAULT))):
        made = synthesize(Home(), np.random.default_rng([777, seed]))
        for door in vdoor.run(made.grid, pipeline).doors:
            tilt[reach_m] += [turned_deg(door, true) for true in made.doors if apart_m(door, true) < 0.5]
    assert len(tilt[0.4]) == len(tilt[0.0]) > 10
    assert np.mean(tilt[0.4]) < 0.7 * np.mean(tilt[0.0])


def apart_m(one: object, other: object) -> float:
    middles = [np.add(door.start_m, door.end_m) / 2 for door in (one, other)]  # type: ignore[attr-defined]
    return float(np.hypot(*(middles[0] - middles[1])))


def turned_deg(one: object, other: object) -> float:
    spans = [np.subtract(door.end_m, door.start_m) for door in (one, other)]  # type: ignore[attr-defined]
    angle = np.degrees(np.subtract(*(np.arctan2(y, x) for x, y in spans)))
    return float(abs((angle + 90) % 180 - 90))
