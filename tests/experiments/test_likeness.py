"""What a map looks like in figures: exact on drawings."""

from __future__ import annotations

import json

import pytest
from commands import call, one_line
from maps import drawn

from vdoor.experiments.likeness import Statistics, statistics
from vdoor.train import default_pipeline

ROOM = """
    ##############
    #............#
    #............#
    #...##.......#
    #...##....#..#
    #............#
    #............#
    ##############
"""


def found() -> Statistics:
    return statistics(drawn(ROOM), default_pipeline())


def test_of_a_room_with_two_islands() -> None:
    free = 12 * 6 - 5
    assert found().free_m2 == pytest.approx(free * 0.04)
    assert found().islands_per_m2 == pytest.approx(2 / (free * 0.04))
    assert found().wall_cells_thick == 1
    assert found().wall_run_m == pytest.approx(14 * 0.2)


def test_of_what_lies_beside_walls() -> None:
    wall, inner = 2 * 14 + 2 * 6, 5
    # Each of the 2 * (12 + 6) wall cells beside the floor has three free neighbours, but for the two next to each
    # corner, which have two, and the corners, which have one; each island cell has eight without its fellows.
    sides = 2 * (12 - 2) * 3 + 2 * (6 - 2) * 3 + 8 * 2 + 4 * 1
    assert found().free_beside_walls == pytest.approx((sides + 4 * 5 + 8) / (8 * (wall + inner)))
    assert found().unknown_beside_walls == 0


def test_the_command_sets_synthetic_maps_beside_others() -> None:
    done = call("map-statistics", "--kind", "laser-home", "--kind", "home", "--count", "2", "--json")
    table = json.loads(done.stdout)
    assert list(table) == ["laser-home", "home"]
    assert all(low <= middle <= high for kind in table.values() for low, middle, high in kind.values())


def test_a_kind_that_is_none_and_no_maps_at_all_are_refused() -> None:
    assert "castle" in one_line(call("map-statistics", "--kind", "castle", code=2))
    assert "neither MAP nor --kind" in one_line(call("map-statistics", code=2))
