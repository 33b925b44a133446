"""Synthetic homes mapped by laser: what holds for any of them, and what each part of the simulation shows."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from maps import law
from scipy import ndimage
from true_plans import reached, touch_near

from vdoor.errors import SettingError
from vdoor.synth import PRESETS, LaserHome, SyntheticMap, synthesize

SMALL = dataclasses.replace(PRESETS["laser-home"], area_max_m2=40.0)
PERFECT = dataclasses.replace(
    SMALL, furniture=False, shafts=0.0, leaf_chance=0.0, niche_chance=0.0, left_out_chance=0.0, unvisited_chance=0.0,
    rotated_chance=0.0, jog_chance=0.0, noise_max_m=0.0, drift_max_m=0.0, drift_max_deg=0.0, glass=0.0, people=0.0,
    range_min_m=12.0, range_max_m=12.0, scans_min_per_m2=2.0, scans_max_per_m2=2.0, rays=720,
)  # fmt: skip
"""An exact scanner that sees all of an empty home."""
seeds = st.integers(0, 2**32 - 1)


def made(kind: LaserHome, seed: int) -> SyntheticMap:
    return synthesize(kind, np.random.default_rng(seed))


@settings(law, max_examples=5)
@given(seed=seeds)
def test_labels_lie_on_free_cells_in_reach(seed: int) -> None:
    home = made(SMALL, seed)
    assert home.rooms.max() > 0
    assert not ((home.rooms > 0) & ~home.grid.free).any()
    assert not ((home.rooms > 0) & ~reached(home)).any()
    for door in home.doors:
        assert touch_near(home, door, 0.4)


@settings(law, max_examples=5)
@given(seed=seeds)
def test_an_exact_scanner_shows_the_plan_with_walls_around_it(seed: int) -> None:
    home = made(PERFECT, seed)
    inside = home.rooms > 0
    assert (inside[home.grid.free]).mean() > 0.95
    ring = ndimage.binary_dilation(inside, iterations=2) & ~ndimage.binary_dilation(inside)
    shown = ndimage.binary_dilation(home.grid.occupied, np.ones((3, 3)))
    assert shown[ring].mean() > 0.95
    assert len(home.doors) >= home.rooms.max() - 1


def beside(home: SyntheticMap) -> float:
    """Occupied cells for each cell of the rooms' edges."""
    inside = home.rooms > 0
    return float(home.grid.occupied.sum() / (inside & ~ndimage.binary_erosion(inside)).sum())


def test_drift_makes_walls_thicker() -> None:
    drifting = dataclasses.replace(PERFECT, drift_max_m=0.2)
    still, moved = (np.mean([beside(made(kind, seed)) for seed in range(3)]) for kind in (PERFECT, drifting))
    assert moved > 1.3 * still


def test_through_glass_one_sees_what_is_no_room() -> None:
    outside = [
        np.count_nonzero(home.grid.free & (home.rooms == 0))
        for glass in (0.0, 10.0)
        for home in [made(dataclasses.replace(PERFECT, glass=glass), 3)]
    ]
    assert outside[1] > outside[0] + 200


def test_a_room_that_was_not_visited_is_seen_less_of() -> None:
    least = [
        min(np.bincount(home.rooms.ravel())[1:].min() for home in [made(kind, 7)])
        for kind in (PERFECT, dataclasses.replace(PERFECT, unvisited_chance=1.0))
    ]
    assert least[1] < least[0]


def test_equal_seeds_give_equal_maps_and_others_do_not() -> None:
    one, same, other = made(SMALL, 1), made(SMALL, 1), made(SMALL, 2)
    assert (one.grid.cells == same.grid.cells).all()
    assert one.doors == same.doors
    assert one.grid.cells.shape != other.grid.cells.shape or (one.grid.cells != other.grid.cells).any()


@pytest.mark.parametrize(
    ("name", "value"), [("rays", 2), ("range_min_m", 13.0), ("hit_share_max", 1.0), ("glass", -1.0)]
)
def test_settings_that_no_scanner_has_are_refused(name: str, value: float) -> None:
    with pytest.raises(SettingError, match=r"LaserHome\."):
        LaserHome(**{name: value})
