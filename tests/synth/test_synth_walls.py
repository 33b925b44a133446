"""Walls that synthetic homes and offices draw as outlines, in pieces, or with grey edges: the truth stays the truth."""

from __future__ import annotations

import dataclasses
import hashlib

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy import ndimage
from true_plans import SOLID, contacts, reached

from vdoor.grid import OccupancyGrid
from vdoor.synth import Home, Office, SyntheticMap, synthesize
from vdoor.synth.wall_style import Style, drawn_style, planned

STRAIGHT_HOME = Home(
    rotated_chance=0.0, furniture=False, shafts=0.0, windows=0.0, holes_chance=0.0, rough_chance=0.0,
    corners_chance=0.0, unknown_max=0.0, pockets_chance=0.0, left_out_chance=0.0, leaf_chance=0.0, niche_chance=0.0,
    specks=0.0, jog_chance=0.0, **SOLID,
)  # fmt: skip
STRAIGHT_OFFICE = Office(
    length_min_m=12.0, length_max_m=20.0, rotated_chance=0.0, rough_chance=0.0, faded_chance=0.0, furniture=False,
    **SOLID,
)  # fmt: skip
COARSE_OFFICE = dataclasses.replace(STRAIGHT_OFFICE, cell_m=0.1)
LIVELY_OFFICE = Office(length_min_m=12.0, length_max_m=20.0, rough_chance=1.0, **SOLID)
STRAIGHT = [STRAIGHT_HOME, STRAIGHT_OFFICE, COARSE_OFFICE]
WHOLE = [Home(**SOLID), LIVELY_OFFICE, dataclasses.replace(LIVELY_OFFICE, cell_m=0.1)]
NAMES = ["hollow_chance", "dashed_chance", "antialiased_chance"]
SQUARE = np.ones((3, 3), np.bool_)

Mask = NDArray[np.bool_]
seeds = st.integers(0, 2**32 - 1)
law = settings(max_examples=8, deadline=None, derandomize=True)


def made(kind: Home | Office, seed: int) -> SyntheticMap:
    return synthesize(kind, np.random.default_rng(seed))


def style_of(kind: Home | Office, seed: int) -> Style:
    """In what style the map of a seed is drawn."""
    return drawn_style(kind, np.random.default_rng(seed).spawn(7 if isinstance(kind, Home) else 6)[-2])


def pair(kind: Home | Office, seed: int, **chances: float) -> tuple[SyntheticMap, SyntheticMap]:
    """A map with its walls drawn anew, and the same one with walls that are solid but as thick."""
    styled = dataclasses.replace(kind, **chances)
    return made(styled, seed), made(planned(kind, style_of(styled, seed)), seed)


def on_common_cells(drawn: SyntheticMap, solid: SyntheticMap) -> tuple[NDArray[np.int8], NDArray[np.int8], Mask]:
    """Cells of both, and where there are rooms, laid so that the rooms coincide: maps end where knowledge ends."""
    tops = [np.argwhere(one.rooms > 0).min(axis=0) for one in (drawn, solid)]
    pad = int(max(top.max() for top in tops)) + 20
    laid = []
    for one, top in zip((drawn, solid), tops, strict=True):
        before = pad - top
        shape = np.array([max(m.rooms.shape[k] for m in (drawn, solid)) + 2 * pad for k in (0, 1)])
        after = shape - before - one.rooms.shape
        width = list(zip(before.tolist(), after.tolist(), strict=True))
        laid.append((np.pad(one.grid.cells, width, constant_values=-1), np.pad(one.rooms, width)))
    np.testing.assert_array_equal(laid[0][1], laid[1][1])
    return laid[0][0], laid[1][0], np.asarray(laid[0][1] > 0)


def runs(cells: NDArray[np.bool_]) -> NDArray[np.intp]:
    """Lengths of the runs of true cells along rows."""
    flat = np.diff(np.pad(cells, ((0, 0), (1, 1))).astype(np.int8), axis=1).ravel()
    return np.asarray(np.flatnonzero(flat == -1) - np.flatnonzero(flat == 1))


@pytest.mark.parametrize(
    ("kind", "seed", "said"),
    [
        (Home(**SOLID), 0, "9fd4b5b6e1f344fa736fc1b555fff24dd7ce6df7a18d5243881d349e213f9690"),
        (Home(**SOLID), 1, "b78555535a81b4c3fbf336aea44cbe0b143017eacadb0e74299c208795437c2e"),
        (Home(**SOLID), 2, "dff09d75599d67a7371e97f1f89c880210b964e081cc7d618a2b69df6971ffdc"),
        (Office(**SOLID), 0, "3bba94d941b5cdae5cfacc825240b316c10956f3f9c0e153d479290fc099b819"),
        (Office(**SOLID), 1, "3af41809f9e171cd7b4a4e9dc217e0fedeb1bc5606afc83c6e3bf8bb04bb52ec"),
        (Office(cell_m=0.1, **SOLID), 2, "15f4f0d6d57ae62b0726c2397e9e46c686b758f943c6f56faebb2ce524028d6e"),
    ],
)
def test_with_no_chance_of_other_walls_maps_are_as_before_there_were_any(
    kind: Home | Office, seed: int, said: str
) -> None:
    found = made(kind, seed)
    assert hashlib.sha256(found.grid.cells.tobytes() + found.rooms.tobytes()).hexdigest() == said


@pytest.mark.parametrize("kind", WHOLE)
def test_equal_seeds_give_equal_maps(kind: Home | Office) -> None:
    often = dataclasses.replace(kind, **dict.fromkeys(NAMES, 1.0))
    one, again, other = made(often, 1), made(often, 1), made(often, 2)
    assert one.grid.cells.tobytes() == again.grid.cells.tobytes()
    assert one.rooms.tobytes() == again.rooms.tobytes()
    assert one.grid.cells.tobytes() != other.grid.cells.tobytes()


def test_the_chance_of_one_kind_of_wall_leaves_the_others_alone() -> None:
    for seed in range(20):
        one = style_of(Office(dashed_chance=1.0, antialiased_chance=1.0, hollow_chance=0.0), seed)
        assert one == dataclasses.replace(style_of(Office(**dict.fromkeys(NAMES, 1.0)), seed), hollow=None)


@law
@given(kind=st.sampled_from(WHOLE), seed=seeds, chances=st.lists(st.sampled_from(NAMES), min_size=1, unique=True))
def test_rooms_and_doors_are_those_of_the_same_map_with_solid_walls(
    kind: Home | Office, seed: int, chances: list[str]
) -> None:
    kind = dataclasses.replace(kind, **({"specks": 0.0, "holes_chance": 0.0} if isinstance(kind, Home) else {}))
    drawn, solid = pair(kind, seed, **dict.fromkeys(chances, 1.0))
    on_common_cells(drawn, solid)
    assert [(door.rooms, door.width_m) for door in drawn.doors] == [(door.rooms, door.width_m) for door in solid.doors]
    assert not ((drawn.rooms > 0) & ~reached(drawn)).any()
    assert contacts(drawn.rooms) == contacts(solid.rooms)


@law
@given(kind=st.sampled_from(STRAIGHT), seed=seeds, name=st.sampled_from(NAMES))
def test_only_walls_are_drawn_otherwise(kind: Home | Office, seed: int, name: str) -> None:
    drawn, solid, rooms = on_common_cells(*pair(kind, seed, **{name: 1.0}))
    assert (drawn[rooms] == 0).all()
    assert (drawn != solid).any() or (name != "dashed_chance" and style_of(kind, seed).part != "all")


@law
@given(kind=st.sampled_from(STRAIGHT), seed=seeds)
def test_hollow_walls_are_free_or_unknown_between_two_faces(kind: Home | Office, seed: int) -> None:
    thick_m = 0.45
    kind = dataclasses.replace(kind, hollow_wall_min_m=thick_m, hollow_wall_max_m=thick_m, hollow_chance=1.0)
    style = style_of(kind, seed)
    assert style.hollow is not None
    home = made(kind, seed)
    free = home.grid.free & (home.rooms == 0)
    if style.hollow.fill:
        return
    inside = ndimage.binary_opening(free, np.ones((1, 8))) | ndimage.binary_opening(free, np.ones((8, 1)))
    assert inside.sum() * kind.cell_m**2 > 0.3
    # Whatever lies beside a room, gaps apart, is the outline.
    beside = ndimage.binary_dilation(home.rooms > 0, SQUARE) & (home.rooms == 0)
    assert np.mean(home.grid.occupied[beside]) > (0.7 if style.gaps else 0.99)


def test_about_half_of_hollow_drawings_are_free_inside_and_some_are_broken() -> None:
    styles = [style_of(Office(hollow_chance=1.0, dashed_chance=0.0), seed) for seed in range(100)]
    fills = [style.hollow.fill for style in styles if style.hollow]
    assert len(fills) == 100
    assert 40 < sum(fill == 0 for fill in fills) < 75
    assert 25 < sum(style.gaps is not None for style in styles) < 55
    assert 35 < sum(style.part == "all" for style in styles) < 65


@law
@given(kind=st.sampled_from(STRAIGHT), seed=seeds)
def test_dashes_have_gaps_of_one_to_three_cells_and_pieces_between(kind: Home | Office, seed: int) -> None:
    style = style_of(dataclasses.replace(kind, dashed_chance=1.0), seed)
    assert style.gaps is not None
    drawn, solid, rooms = on_common_cells(*pair(kind, seed, dashed_chance=1.0))
    gone = (solid == 100) & (drawn != 100)
    widest = max(1, round(0.2 / kind.cell_m + 1e-6)) if kind.cell_m > 0.05 else 3
    # Along a face, cells of a gap lie side by side; a gap's depth is that of the wall, so each face is looked at alone.
    for turned in (False, True):
        lost, room = (gone.T, rooms.T) if turned else (gone, rooms)
        for shift in (1, -1):
            face = lost & np.roll(room, shift, axis=0) & ~np.roll(room, 1, axis=1) & ~np.roll(room, -1, axis=1)
            widths = runs(face)
            assert not widths.size or widths.max() <= widest
    labels, count = ndimage.label(gone, SQUARE)
    assert labels.max() == count
    faces_m = (ndimage.binary_dilation(rooms) & ~rooms).sum() * kind.cell_m
    if style.part == "all":
        assert 0.2 < count / faces_m * style.gaps.piece_m < 1.5


@law
@given(kind=st.sampled_from(STRAIGHT), seed=seeds)
def test_walls_beside_doors_are_whole(kind: Home | Office, seed: int) -> None:
    drawn, _ = pair(kind, seed, dashed_chance=1.0)
    solid = dataclasses.replace(kind, **SOLID)
    bare = made(solid, seed)
    for door, same in zip(drawn.doors, bare.doors, strict=True):
        for end, other in ((door.start_m, door.end_m), (door.end_m, door.start_m)):
            out = np.subtract(end, other) / door.width_m
            moved = np.subtract(same.start_m, door.start_m)
            for away_m in np.arange(0.5 * kind.cell_m, 0.15, 0.01):
                point = np.array([np.add(end, out * away_m)])
                row, col = np.rint(drawn.grid.frame.cell_from_world(point))[0].astype(int)
                top, left = np.rint(bare.grid.frame.cell_from_world(point + moved))[0].astype(int)
                if all(inside(*at) for at in ((drawn.grid, row, col), (bare.grid, top, left))):
                    assert drawn.grid.cells[row, col] == bare.grid.cells[top, left]


def inside(grid: OccupancyGrid, row: int, col: int) -> bool:
    """Whether a cell is on the map: a door may stand at its edge."""
    return 0 <= row < grid.frame.height and 0 <= col < grid.frame.width


@law
@given(kind=st.sampled_from(STRAIGHT), seed=seeds, name=st.sampled_from(NAMES[1:]))
def test_no_robot_fits_through_what_is_free_in_a_wall(kind: Home | Office, seed: int, name: str) -> None:
    drawn, _, rooms = on_common_cells(*pair(kind, seed, **{name: 1.0}))
    _, solid, _ = on_common_cells(*pair(kind, seed, **{name: 1.0}))
    opened = (drawn == 0) & (solid != 0)
    side = max(3, round(0.2 / kind.cell_m)) + 1
    through = ndimage.binary_opening(opened | rooms, np.ones((side, side))) & opened
    assert not through.any()


@law
@given(kind=st.sampled_from(STRAIGHT), seed=seeds)
def test_grey_edges_leave_a_core(kind: Home | Office, seed: int) -> None:
    drawn, solid, rooms = on_common_cells(*pair(kind, seed, antialiased_chance=1.0))
    lost = (solid == 100) & (drawn != 100)
    assert (drawn[lost] == -1).all()
    near = ndimage.binary_dilation(drawn == 100, np.ones((5, 5)))
    assert near[lost].all()
    assert not (ndimage.binary_dilation(rooms, SQUARE) & (drawn == 0) & ~rooms & (solid != 0)).any()


def test_many_maps_with_grey_edges_have_unknown_cells_between_rooms_and_walls() -> None:
    kind = Office(length_min_m=12.0, length_max_m=20.0, faded_chance=0.0, **SOLID)
    share = []
    for seed in range(12):
        office, solid = pair(kind, seed, antialiased_chance=1.0)
        beside = ndimage.binary_dilation(office.rooms > 0) & (office.rooms == 0)
        share.append(1 - office.grid.occupied[beside].mean())
        assert solid.grid.occupied[ndimage.binary_dilation(solid.rooms > 0) & (solid.rooms == 0)].mean() > 0.95
    assert np.mean(np.array(share) > 0.1) > 0.5
