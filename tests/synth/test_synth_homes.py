"""Synthetic homes: what holds for any of them."""

from __future__ import annotations

import dataclasses
import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import ndimage
from true_plans import SOLID, cells_on, contacts, reached, touch_near

from vdoor.errors import SettingError
from vdoor.synth import PRESETS, Home, SyntheticMap, synthesize, write_synthetic

HOME = PRESETS["home"]
PERFECT = Home(
    furniture=False, shafts=0.0, windows=0.0, holes_chance=0.0, rough_chance=0.0, corners_chance=0.0,
    unknown_max=0.0, pockets_chance=0.0, left_out_chance=0.0, leaf_chance=0.0, niche_chance=0.0, specks=0.0,
    hollow_chance=0.0, dashed_chance=0.0, antialiased_chance=0.0,
)  # fmt: skip
"""As built: nothing inside, everything seen."""
OFTEN = dataclasses.replace(
    HOME, holes_chance=1.0, corners_chance=1.0, pockets_chance=1.0, left_out_chance=1.0, windows=4.0, jog_chance=1.0
)

seeds = st.integers(0, 2**32 - 1)
kinds = st.sampled_from([HOME, OFTEN, PERFECT])
law = settings(max_examples=8, deadline=None, derandomize=True)


def made(kind: Home, seed: int) -> SyntheticMap:
    return synthesize(kind, np.random.default_rng(seed))


@law
@given(kind=kinds, seed=seeds)
def test_labels_cover_what_is_free_and_in_reach_and_nothing_else(kind: Home, seed: int) -> None:
    home = made(dataclasses.replace(kind, **SOLID), seed)
    np.testing.assert_array_equal(home.rooms > 0, reached(home))
    assert ndimage.label(home.rooms > 0)[1] == 1
    assert set(np.unique(home.rooms[home.rooms > 0])) == set(range(1, home.rooms.max() + 1))


@law
@given(kind=kinds, seed=seeds)
def test_doors_lie_where_two_labels_meet(kind: Home, seed: int) -> None:
    home = made(kind, seed)
    for door in home.doors:
        assert 1 <= door.rooms[0] < door.rooms[1] <= home.rooms.max()
        assert touch_near(home, door, 0.4)


@law
@given(kind=kinds, seed=seeds)
def test_labels_meet_nowhere_but_at_doors_and_small_holes(kind: Home, seed: int) -> None:
    home = made(kind, seed)
    listed = {door.rooms for door in home.doors}
    assert all(sides * 0.05 <= 0.3 for pair, sides in contacts(home.rooms).items() if pair not in listed)


@law
@given(kind=kinds, seed=seeds)
def test_doors_are_as_wide_as_the_settings_say_and_only_wide_openings_are_unsure(kind: Home, seed: int) -> None:
    for door in made(kind, seed).doors:
        assert np.hypot(*np.subtract(door.end_m, door.start_m)) == pytest.approx(door.width_m, abs=1e-5)
        assert 0.45 <= door.width_m <= 3.0
        assert door.unsure == (door.width_m >= kind.unsure_from_m - 1e-9)


@law
@given(seed=seeds)
def test_in_a_home_as_built_doors_are_free_between_jambs_and_all_rooms_are_joined(seed: int) -> None:
    home = made(dataclasses.replace(PERFECT, jog_chance=0.0), seed)
    np.testing.assert_array_equal(home.rooms > 0, home.grid.free)
    assert len(home.doors) >= home.rooms.max() - 1
    for pair, sides in contacts(home.rooms).items():  # one line across each door, and steps in it where it is turned
        width_m = sum(door.width_m for door in home.doors if door.rooms == pair)
        assert sides * 0.05 <= 1.5 * width_m + 0.1
    for door in home.doors:
        cells = cells_on(home, door)[8:-8]  # a cell whose middle is in the jamb may begin 4 cm before it
        assert home.grid.free[tuple(cells.T)].all()
        assert set(home.rooms[tuple(cells.T)]) <= set(door.rooms)


@law
@given(seed=seeds)
def test_walls_are_one_or_two_cells_seen_from_inside_and_no_more(seed: int) -> None:
    home = made(PERFECT, seed)
    seen = ndimage.binary_dilation(home.grid.free, np.ones((3, 3)), iterations=2)
    assert not (home.grid.occupied & ~seen).any()
    first = ndimage.binary_dilation(home.grid.free, np.ones((3, 3))) & ~home.grid.free
    assert home.grid.occupied[first].all()


@law
@given(seed=seeds)
def test_furniture_and_artefacts_leave_the_plan_alone(seed: int) -> None:
    kind = dataclasses.replace(PERFECT, rotated_chance=0.0)
    bare = made(kind, seed)
    lived_in = made(dataclasses.replace(kind, furniture=True, clutter_max_per_m2=2.0), seed)
    widths = {door.width_m for door in bare.doors}
    assert {door.width_m for door in lived_in.doors} <= widths
    assert lived_in.grid.free.sum() < bare.grid.free.sum()


def test_most_homes_have_as_many_doors_as_a_tree_of_their_rooms_needs() -> None:
    homes = [made(HOME, seed) for seed in range(20)]
    enough = [len(home.doors) >= home.rooms.max() - 1 for home in homes]
    assert np.mean(enough) == 1.0
    assert any(door.unsure for home in homes for door in home.doors)


def test_homes_are_not_all_boxes_and_stay_whole() -> None:
    boxes, bays = (
        [made(dataclasses.replace(PERFECT, outside_chance=chance), seed) for seed in range(8)] for chance in (0.0, 0.9)
    )
    fewer = [int(box.rooms.max() - bay.rooms.max()) for box, bay in zip(boxes, bays, strict=True)]
    assert sum(fewer) >= 8
    assert all(len(bay.doors) >= bay.rooms.max() - 1 for bay in bays)


def test_where_walls_are_set_back_some_doors_are_aslant() -> None:
    slanting = straight = 0
    for seed in range(12):
        for door in made(dataclasses.replace(PERFECT, rotated_chance=0.0, jog_chance=1.0), seed).doors:
            x, y = np.abs(np.subtract(door.end_m, door.start_m))
            slanting += bool(min(x, y) > 0.1)
            straight += bool(min(x, y) < 1e-6)
    assert slanting >= 5
    assert straight > slanting


def test_the_same_seed_gives_the_same_bytes_and_another_seed_others() -> None:
    one, again, other = made(HOME, 1), made(HOME, 1), made(HOME, 2)
    assert one.grid.cells.tobytes() == again.grid.cells.tobytes()
    assert one.rooms.tobytes() == again.rooms.tobytes()
    assert one.doors == again.doors
    assert one.grid.cells.tobytes() != other.grid.cells.tobytes()


def test_unsure_openings_are_written_as_such_and_sure_doors_as_ever(tmp_path: Path) -> None:
    home = next(home for home in (made(HOME, seed) for seed in range(50)) if any(door.unsure for door in home.doors))
    write_synthetic(home, tmp_path / "home", seed=0)
    told = json.loads((tmp_path / "home_truth.json").read_text())["doors"]
    assert [entry.get("unsure", False) for entry in told] == [door.unsure for door in home.doors]
    assert all("unsure" not in entry or entry["unsure"] is True for entry in told)


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"door_min_m": 0.2}, "Home.door_min_m: wanted 0.5 to 1.2, found 0.2"),
        ({"door_min_m": 1.0, "door_max_m": 0.8}, "Home.door_max_m: wanted at least door_min_m = 1, found 0.8"),
        ({"wall_min_m": 0.05}, "Home.wall_min_m: wanted 0.075 to 0.6, found 0.05"),
        ({"area_min_m2": float("nan")}, "area_min_m2: wanted 8 to 1000, found nan"),
        ({"dashed_chance": -0.1}, "Home.dashed_chance: wanted 0 to 1, found -0.1"),
        ({"hollow_wall_min_m": 0.5, "hollow_wall_max_m": 0.3}, "hollow_wall_max_m: wanted at least hollow_wall_min_m"),
        ({"leaf_chance": 1.5}, "leaf_chance: wanted 0 to 1, found 1.5"),
    ],
)
def test_settings_no_home_can_have_are_refused(change: dict[str, float], says: str) -> None:
    with pytest.raises(SettingError, match=says):
        Home(**change)  # type: ignore[arg-type]  # wrong on purpose
