"""Synthetic apartments keep what they promise: the truth beside them is the truth."""

from __future__ import annotations

import dataclasses
import json
from pathlib import Path

import numpy as np
import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from PIL import Image
from project import RECORDINGS
from scipy import ndimage

from vdoor.errors import SettingError, VdoorError
from vdoor.synth import PRESETS, Apartment, SyntheticMap, TrueDoor, synthesize, write_synthetic

FINE_M = 0.025
PAPER = PRESETS["paper"]
BUSY = dataclasses.replace(
    PAPER,
    furniture=True,
    wall_noise=0.1,
    juts_per_room=3.0,
    windows=20.0,
    margin_m=2.0,
    speckles=40.0,
    extra_door_chance=0.5,
)
CRAMMED = dataclasses.replace(
    PAPER, furniture=True, wall_pieces_per_m2=1.0, free_pieces_per_m2=1.0, aisle_m=0.5, wall_noise=0.1
)
MANY_ROOMS = dataclasses.replace(PAPER, area_m2=80.0, rooms=9, jamb_m=0.6)

seeds = st.integers(0, 2**32 - 1)
cell_sizes = st.sampled_from([0.05, 0.1, 0.2])
kinds = st.builds(
    dataclasses.replace,
    st.sampled_from([PAPER, BUSY, CRAMMED, MANY_ROOMS]),
    cell_m=cell_sizes,
    rotation_deg=st.sampled_from([0.0, 0.0, 5.0, 30.0, 45.0, 90.0, -17.0]),
    corridor_chance=st.sampled_from([0.0, 1.0]),
)
law = settings(max_examples=8, deadline=None, derandomize=True)


def made(kind: Apartment, seed: int) -> SyntheticMap:
    return synthesize(kind, np.random.default_rng(seed))


def count_rooms(apartment: SyntheticMap) -> int:
    return int(apartment.rooms.max())


def along(apartment: SyntheticMap, door: TrueDoor, *, step_m: float, beyond_m: float = 0.0) -> NDArray[np.intp]:
    """Cells (k, 2) on the door's line, and as much beyond each jamb as wished."""
    start, end = np.array(door.start_m), np.array(door.end_m)
    steps = np.arange(step_m / 2 - beyond_m, door.width_m + beyond_m, step_m)[:, np.newaxis]
    points = start + steps * (end - start) / door.width_m
    return np.rint(apartment.grid.frame.cell_from_world(points)).astype(np.intp)


def near_door(apartment: SyntheticMap, door: TrueDoor) -> NDArray[np.bool_]:
    """Cells whose centre is in the door's gap, or within a cell's diagonal of it."""
    grid, reach, wall = apartment.grid, 1.5 * apartment.settings.cell_m, apartment.settings.wall_max_m
    centres = grid.frame.world_from_cell(np.indices(grid.cells.shape).reshape(2, -1).T)
    start, end = np.array(door.start_m), np.array(door.end_m)
    direction = (end - start) / door.width_m
    run = (centres - start) @ direction
    off = np.abs((centres - start) @ np.array([-direction[1], direction[0]]))
    inside: NDArray[np.bool_] = (run > -reach) & (run < door.width_m + reach) & (off < wall / 2 + reach)
    return inside.reshape(grid.cells.shape)


def contacts(rooms: NDArray[np.int32]) -> set[tuple[int, int]]:
    """Pairs of labels that touch along a cell's side."""
    found = set()
    for one, other in ((rooms[1:], rooms[:-1]), (rooms[:, 1:], rooms[:, :-1])):
        differ = (one != other) & (one > 0) & (other > 0)
        found |= {(min(a, b), max(a, b)) for a, b in zip(one[differ].tolist(), other[differ].tolist(), strict=True)}
    return found


@law
@given(kind=kinds, seed=seeds)
def test_all_rooms_are_one_reach_and_doors_join_them(kind: Apartment, seed: int) -> None:
    apartment = made(kind, seed)
    parts, _ = ndimage.label(apartment.grid.free)
    assert np.unique(parts[apartment.rooms > 0]).size == 1
    assert set(np.unique(apartment.rooms[apartment.rooms > 0])) == set(range(1, count_rooms(apartment) + 1))
    assert kind.rooms - kind.rooms_spread <= count_rooms(apartment) <= kind.rooms + kind.rooms_spread
    assert len(apartment.doors) >= count_rooms(apartment) - 1
    assert {door.rooms for door in apartment.doors} == contacts(apartment.rooms)


@law
@given(kind=kinds, seed=seeds)
def test_without_the_door_cells_no_two_rooms_are_joined(kind: Apartment, seed: int) -> None:
    apartment = made(kind, seed)
    left = apartment.grid.free.copy()
    for door in apartment.doors:
        left &= ~near_door(apartment, door)
    parts, count = ndimage.label(left)
    for part in range(1, count + 1):
        assert np.unique(apartment.rooms[(parts == part) & (apartment.rooms > 0)]).size <= 1


@law
@given(kind=kinds, seed=seeds)
def test_labels_cover_what_is_free_and_in_reach_and_nothing_else(kind: Apartment, seed: int) -> None:
    apartment = made(kind, seed)
    parts, _ = ndimage.label(apartment.grid.free)
    reached = parts == parts[np.nonzero(apartment.rooms)][0]
    np.testing.assert_array_equal(apartment.rooms > 0, reached)


@law
@given(seed=seeds, cell_m=cell_sizes)
def test_a_tidy_apartment_has_a_label_on_every_free_cell(seed: int, cell_m: float) -> None:
    apartment = made(dataclasses.replace(PAPER, windows=0.0, speckles=0.0, wall_noise=0.0, cell_m=cell_m), seed)
    np.testing.assert_array_equal(apartment.rooms > 0, apartment.grid.free)


@law
@given(seed=seeds, kind=st.sampled_from([PAPER, BUSY]))
def test_a_door_is_a_free_gap_of_its_width_between_jambs(seed: int, kind: Apartment) -> None:
    apartment = made(dataclasses.replace(kind, cell_m=FINE_M), seed)
    for door in apartment.doors:
        assert 0.7 <= door.width_m <= 0.9
        assert np.hypot(*np.subtract(door.end_m, door.start_m)) == pytest.approx(door.width_m)
        rows, cols = along(apartment, door, step_m=FINE_M, beyond_m=0.1).T
        beyond = round(0.1 / FINE_M)
        free = apartment.grid.free[rows, cols]
        assert free[beyond:-beyond].all()
        assert free[beyond:-beyond].size * FINE_M == pytest.approx(door.width_m)
        assert not free[:beyond].any()
        assert not free[-beyond:].any()


@law
@given(seed=seeds, kind=st.sampled_from([PAPER, BUSY]))
def test_every_door_leaves_two_free_cells_at_20_cm(seed: int, kind: Apartment) -> None:
    apartment = made(kind, seed)
    for door in apartment.doors:
        cells = np.unique(along(apartment, door, step_m=0.01), axis=0)
        assert apartment.grid.free[tuple(cells.T)].sum() >= 2


@law
@given(seed=seeds)
def test_furniture_keeps_clear_of_both_sides_of_a_door(seed: int) -> None:
    apartment = made(dataclasses.replace(BUSY, cell_m=FINE_M), seed)
    for door in apartment.doors:
        rows, cols = along(apartment, door, step_m=FINE_M).T
        horizontal = door.start_m[1] == door.end_m[1]
        for away in range(-round(0.7 / FINE_M), round(0.7 / FINE_M)):
            moved = (rows + away, cols) if horizontal else (rows, cols + away)
            assert apartment.grid.free[moved].all()


@law
@given(seed=seeds)
def test_furniture_lets_a_robot_of_30_cm_radius_through_to_every_door(seed: int) -> None:
    kind = dataclasses.replace(CRAMMED, wall_noise=0.0, juts_per_room=0.0, windows=0.0, cell_m=FINE_M)
    apartment = made(kind, seed)
    walkable, _ = ndimage.label(ndimage.distance_transform_edt(apartment.grid.free) * FINE_M >= 0.3)
    middles = [along(apartment, door, step_m=FINE_M)[round(door.width_m / FINE_M / 2)] for door in apartment.doors]
    reached = {int(walkable[row, col]) for row, col in middles}
    assert len(reached) == 1
    assert reached != {0}


@law
@given(seed=seeds)
def test_furniture_changes_neither_rooms_nor_doors(seed: int) -> None:
    kind = dataclasses.replace(PAPER, windows=0.0, cell_m=0.05)
    bare, furnished = (made(dataclasses.replace(kind, furniture=on), seed) for on in (False, True))
    assert bare.doors == furnished.doors
    both = (bare.rooms > 0) & (furnished.rooms > 0)
    np.testing.assert_array_equal(bare.rooms[both], furnished.rooms[both])
    assert np.count_nonzero(furnished.rooms) < np.count_nonzero(bare.rooms)
    assert not (furnished.grid.free & ~bare.grid.free).any()


@law
@given(seed=seeds, kind=st.sampled_from([PAPER, CRAMMED]))
def test_at_20_cm_rays_open_no_wall(seed: int, kind: Apartment) -> None:
    blind, seeing = (made(dataclasses.replace(kind, windows=many), seed) for many in (0.0, 20.0))
    np.testing.assert_array_equal(blind.rooms, seeing.rooms)
    assert seeing.grid.free.sum() > blind.grid.free.sum()


@law
@given(seed=seeds, kind=st.sampled_from([PAPER, BUSY]))
def test_the_same_seed_draws_the_same_apartment_at_5_and_at_20_cm(seed: int, kind: Apartment) -> None:
    coarse, fine = made(kind, seed), made(dataclasses.replace(kind, cell_m=0.05), seed)
    assert coarse.doors == fine.doors
    height, width = (4 * length for length in coarse.rooms.shape)
    missing = height - fine.rooms.shape[0], width - fine.rooms.shape[1]
    occupied = np.pad(fine.grid.occupied, ((missing[0], 0), (0, missing[1])))
    blocks = occupied.reshape(height // 4, 4, width // 4, 4).any(axis=(1, 3))
    np.testing.assert_array_equal(coarse.grid.occupied, blocks)


@given(seed=seeds)
@settings(max_examples=5, deadline=None, derandomize=True)
def test_a_turned_apartment_keeps_its_areas_and_door_widths(seed: int) -> None:
    kind = dataclasses.replace(PAPER, windows=0.0, cell_m=FINE_M)
    flat, turned = made(kind, seed), made(dataclasses.replace(kind, rotation_deg=33.0), seed)
    areas = [np.bincount(apartment.rooms.ravel())[1:] for apartment in (flat, turned)]
    np.testing.assert_allclose(areas[1], areas[0], rtol=0.03)
    assert [door.width_m for door in turned.doors] == [door.width_m for door in flat.doors]
    for door in turned.doors:
        assert turned.grid.free[tuple(along(turned, door, step_m=FINE_M)[1:-1].T)].all()


def test_a_quarter_turn_turns_the_raster() -> None:
    kind = dataclasses.replace(BUSY, cell_m=FINE_M)
    flat, turned = made(kind, 4), made(dataclasses.replace(kind, rotation_deg=90.0), 4)
    height, width = flat.rooms.shape[::-1]
    np.testing.assert_array_equal(np.rot90(flat.rooms), turned.rooms[-height:, :width])


def test_the_same_seed_gives_the_same_bytes_and_another_seed_others() -> None:
    one, again, other = made(BUSY, 1), made(BUSY, 1), made(BUSY, 2)
    assert one.grid.cells.tobytes() == again.grid.cells.tobytes()
    assert one.rooms.tobytes() == again.rooms.tobytes()
    assert one.doors == again.doors
    assert one.grid.cells.tobytes() != other.grid.cells.tobytes()


def test_most_doors_are_near_a_corner_and_all_have_jambs() -> None:
    kind = dataclasses.replace(PAPER, cell_m=FINE_M, wall_noise=0.0, juts_per_room=0.0, windows=0.0)
    shortest = []
    for seed in range(12):
        apartment = made(kind, seed)
        for door in apartment.doors:
            rows, cols = along(apartment, door, step_m=FINE_M, beyond_m=0.3).T
            free = apartment.grid.free[rows, cols]
            stub = round(0.3 / FINE_M)
            assert not free[:stub].any()
            assert not free[-stub:].any()
            shortest.append(_jamb_m(apartment, door))
    assert np.mean(np.array(shortest) <= 0.55) > 0.6


def _jamb_m(apartment: SyntheticMap, door: TrueDoor) -> float:
    """How far one may move the door's side walls outwards, 0.3 m inside either room, before a corner comes."""
    start, end = np.array(door.start_m), np.array(door.end_m)
    ahead = (end - start) / door.width_m
    aside = np.array([-ahead[1], ahead[0]]) * 0.3
    runs = []
    for jamb, away, side in ((jamb, away, side) for jamb, away in ((start, -ahead), (end, ahead)) for side in (1, -1)):
        steps = np.arange(FINE_M / 2, 10.0, FINE_M)[:, np.newaxis]
        rows, cols = np.rint(apartment.grid.frame.cell_from_world(jamb + side * aside + steps * away)).astype(int).T
        inside = (rows >= 0) & (cols >= 0) & (rows < apartment.rooms.shape[0]) & (cols < apartment.rooms.shape[1])
        runs.append(float(np.argmin(apartment.grid.free[rows[inside], cols[inside]])) * FINE_M)
    return min(runs)


def test_one_room_is_an_apartment_without_doors() -> None:
    apartment = made(Apartment(rooms=1, area_m2=12.0), 0)
    assert apartment.doors == ()
    assert count_rooms(apartment) == 1


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"door_min_m": 0.5}, "Apartment.door_min_m: wanted 0.7 to 1.2, found 0.5"),
        ({"door_min_m": 0.9, "door_max_m": 0.8}, "door_max_m: wanted a multiple of 0.05 from door_min_m = 0.9 on"),
        ({"wall_min_m": 0.11, "wall_max_m": 0.14}, "wall_max_m: wanted a multiple of 0.05"),
        ({"cell_m": 0.03}, "cell_m: wanted a whole multiple of 0.025, found 0.03"),
        ({"rooms": 2, "rooms_spread": 2}, "rooms_spread: wanted less than rooms = 2, found 2"),
        ({"area_m2": float("nan")}, "area_m2: wanted 4 to 2000, found nan"),
    ],
)
def test_settings_no_apartment_can_have_are_refused(change: dict[str, float], says: str) -> None:
    with pytest.raises(SettingError, match=says):
        Apartment(**change)  # type: ignore[arg-type]  # wrong on purpose


def test_too_many_rooms_for_the_area_are_refused() -> None:
    with pytest.raises(SettingError, match=r"wanted 30 rooms of at least 1.8 m a side in 20 m2"):
        made(Apartment(rooms=30, area_m2=20.0), 0)


@pytest.mark.parametrize("preset", PRESETS)
def test_written_files_read_back_as_the_same_map_and_truth(preset: str, tmp_path: Path) -> None:
    apartment = made(dataclasses.replace(PRESETS[preset], furniture=True), 3)
    paths = write_synthetic(apartment, tmp_path / "new" / "flat.v1", seed=3)
    assert {path.name for path in paths} == {path.name for path in (tmp_path / "new").iterdir()}
    assert {path.name for path in paths} == {
        "flat.v1.pgm", "flat.v1.yaml", "flat.v1_truth.png", "flat.v1_truth.json"}  # fmt: skip

    described = yaml.safe_load((tmp_path / "new" / "flat.v1.yaml").read_text())
    assert described["resolution"] == apartment.settings.cell_m
    assert (described["occupied_thresh"], described["free_thresh"], described["negate"]) == (0.65, 0.196, 0)
    grey = np.asarray(Image.open(tmp_path / "new" / described["image"]))
    back = np.select([grey == 0, grey == 205, grey == 254], [100, -1, 0], default=7)
    np.testing.assert_array_equal(back, apartment.grid.cells)
    labels = Image.open(tmp_path / "new" / "flat.v1_truth.png")
    assert labels.mode == "I;16"
    np.testing.assert_array_equal(np.asarray(labels), apartment.rooms)

    told = json.loads((tmp_path / "new" / "flat.v1_truth.json").read_text())
    assert type(apartment.settings)(**told["settings"]) == apartment.settings
    assert told["seed"] == 3
    assert tuple(_door(entry) for entry in told["doors"]) == apartment.doors
    for entry in told["doors"]:
        ends = apartment.grid.frame.world_from_cell(np.array([entry["start_cell"], entry["end_cell"]]))
        np.testing.assert_allclose(ends, [entry["start_m"], entry["end_m"]], atol=1e-5)
    total_m2 = sum(room["area_m2"] for room in told["rooms"])
    assert total_m2 == pytest.approx(np.count_nonzero(apartment.rooms) * apartment.settings.cell_m**2, abs=1e-4)


def _door(entry: dict[str, list[float]]) -> TrueDoor:
    fields = {name: entry[name] for name in ("start_m", "end_m", "rooms")}
    assert entry.get("unsure", True), "is there only where it is true"
    return TrueDoor(width_m=entry["width_m"], unsure="unsure" in entry, **{k: tuple(v) for k, v in fields.items()})  # type: ignore[arg-type]


@pytest.mark.parametrize("name", ["flat", "furnished", "turned", "fine"])
def test_the_maps_in_the_repository_are_drawn_again_byte_for_byte(name: str, tmp_path: Path) -> None:
    told = json.loads((RECORDINGS / f"{name}_truth.json").read_text())
    for path in write_synthetic(made(Apartment(**told["settings"]), told["seed"]), tmp_path / name, seed=told["seed"]):
        if path.suffix == ".png":  # the packed bytes follow the library's version
            np.testing.assert_array_equal(np.asarray(Image.open(path)), np.asarray(Image.open(RECORDINGS / path.name)))
        else:
            assert path.read_bytes() == (RECORDINGS / path.name).read_bytes()


def test_a_place_that_cannot_be_written_to_is_one_clear_line(tmp_path: Path) -> None:
    (tmp_path / "taken").write_text("")
    with pytest.raises(VdoorError, match=r"cannot be created \(.*\): .*taken"):
        write_synthetic(made(PAPER, 0), tmp_path / "taken" / "flat")
