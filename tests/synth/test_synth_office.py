"""Synthetic offices: what holds for any of them."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import ndimage
from true_plans import SOLID, cells_on, contacts, reached, touch_near

from vdoor.errors import SettingError
from vdoor.synth import PRESETS, Office, SyntheticMap, synthesize
from vdoor.synth.office_parts import BLOCK_GAP_M

SMALL = dataclasses.replace(PRESETS["office"], length_min_m=12.0, length_max_m=24.0)
PLAIN = dataclasses.replace(SMALL, furniture=False, rough_chance=0.0, **SOLID)
FULL = dataclasses.replace(SMALL, furnished_chance=1.0, rough_chance=1.0, corridor_door_chance=1.0)

seeds = st.integers(0, 2**32 - 1)
kinds = st.sampled_from([SMALL, PLAIN, FULL])
law = settings(max_examples=6, deadline=None, derandomize=True)


def made(kind: Office, seed: int) -> SyntheticMap:
    return synthesize(kind, np.random.default_rng(seed))


@law
@given(kind=kinds, seed=seeds)
def test_labels_cover_what_is_free_and_in_reach_and_nothing_else(kind: Office, seed: int) -> None:
    office = made(dataclasses.replace(kind, **SOLID), seed)
    np.testing.assert_array_equal(office.rooms > 0, reached(office))
    assert ndimage.label(office.rooms > 0)[1] == 1
    assert set(np.unique(office.rooms[office.rooms > 0])) == set(range(1, office.rooms.max() + 1))


@law
@given(kind=kinds, seed=seeds)
def test_labels_meet_at_doors_and_nowhere_else(kind: Office, seed: int) -> None:
    office = made(kind, seed)
    listed = {door.rooms for door in office.doors}
    assert all(touch_near(office, door, 0.3) for door in office.doors)
    assert all(sides * 0.05 <= 0.3 for pair, sides in contacts(office.rooms).items() if pair not in listed)
    assert len(office.doors) >= office.rooms.max() - 1


@law
@given(seed=seeds)
def test_a_door_is_a_free_gap_of_its_width(seed: int) -> None:
    office = made(PLAIN, seed)
    for door in office.doors:
        assert np.hypot(*np.subtract(door.end_m, door.start_m)) == pytest.approx(door.width_m, abs=1e-5)
        # Some are the mouths of corridors, some are left between blocks that part a hall.
        assert BLOCK_GAP_M[0] - 1e-6 <= door.width_m <= PLAIN.corridor_max_m + 1e-6
        assert door.unsure == (door.width_m >= PLAIN.unsure_from_m - 1e-9)
        cells = cells_on(office, door)[8:-8]  # a cell whose middle is in the jamb may begin 4 cm before it
        assert office.grid.free[tuple(cells.T)].all()
        assert set(office.rooms[tuple(cells.T)]) <= set(door.rooms)


def test_a_corridor_between_two_open_halls_has_one_mouth() -> None:
    open_ = dataclasses.replace(PRESETS["office"], open_hall_chance=1.0, furniture=False, rough_chance=0.0)
    for seed in range(40):
        middles = np.array([np.add(door.start_m, door.end_m) / 2 for door in made(open_, seed).doors])
        assert len(np.unique(middles.round(3), axis=0)) == len(middles)


def test_screens_part_nothing() -> None:
    bare = dataclasses.replace(PLAIN, screen_chance=0.0)
    full = dataclasses.replace(PLAIN, screen_chance=1.0)
    pairs = [(made(bare, seed), made(full, seed)) for seed in range(12)]
    assert all(len(one.doors) == len(other.doors) for one, other in pairs)
    assert all(one.rooms.max() == other.rooms.max() for one, other in pairs)
    assert sum(other.grid.occupied.sum() > one.grid.occupied.sum() for one, other in pairs) > 6


@law
@given(seed=seeds)
def test_no_two_doors_lie_on_each_other(seed: int) -> None:
    middles = np.array([np.add(door.start_m, door.end_m) / 2 for door in made(SMALL, seed).doors])
    apart = np.hypot(*(middles[:, np.newaxis] - middles).T) + 9 * np.eye(len(middles))
    assert apart.min() > 0.5


@law
@given(seed=seeds)
def test_furniture_changes_neither_rooms_nor_doors(seed: int) -> None:
    bare = made(PLAIN, seed)
    furnished = made(dataclasses.replace(PLAIN, furniture=True, furnished_chance=1.0), seed)
    assert [door.width_m for door in bare.doors] == [door.width_m for door in furnished.doors]
    assert [door.rooms for door in bare.doors] == [door.rooms for door in furnished.doors]
    # The map ends where knowledge ends: a shelf in the outermost corner moves all doors by the same way.
    moved = np.array([np.subtract(a.start_m, b.start_m) for a, b in zip(bare.doors, furnished.doors, strict=True)])
    np.testing.assert_allclose(moved, np.broadcast_to(moved[0], moved.shape), atol=2e-6)
    assert furnished.grid.free.sum() < bare.grid.free.sum()


def test_floors_are_as_varied_as_wanted() -> None:
    plain = dataclasses.replace(PRESETS["office"], furniture=False, rough_chance=0.0)
    offices = [made(plain, seed) for seed in range(40)]
    rooms = [int(office.rooms.max()) for office in offices]
    widths = [door.width_m for office in offices for door in office.doors]
    assert max(rooms) > 30
    assert min(rooms) < 20
    assert np.mean(np.array(widths) <= 1.2) > 0.6
    assert max(widths) > 1.8


def test_the_same_seed_gives_the_same_bytes_and_another_seed_others() -> None:
    one, again, other = made(SMALL, 1), made(SMALL, 1), made(SMALL, 2)
    assert one.grid.cells.tobytes() == again.grid.cells.tobytes()
    assert one.rooms.tobytes() == again.rooms.tobytes()
    assert one.doors == again.doors
    assert one.grid.cells.tobytes() != other.grid.cells.tobytes()


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"corridors_max": 0}, "Office.corridors_max: wanted 1 to 12, found 0"),
        ({"length_min_m": 50.0}, "Office.length_max_m: wanted at least length_min_m = 50, found 48"),
        ({"dash_gap_max_m": 0.5}, "Office.dash_gap_max_m: wanted 0 to 0.3, found 0.5"),
        ({"hollow_wall_min_m": 0.5, "hollow_wall_max_m": 0.3}, "hollow_wall_max_m: wanted at least hollow_wall_min_m"),
        ({"cell_m": 0.2}, "Office.cell_m: wanted 0.025 to 0.1, found 0.2"),
    ],
)
def test_settings_no_office_can_have_are_refused(change: dict[str, float], says: str) -> None:
    with pytest.raises(SettingError, match=says):
        Office(**change)  # type: ignore[arg-type]  # wrong on purpose
