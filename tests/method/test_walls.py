"""Walls stay walls, however they are drawn: in dashes, hollow, with holes; and furniture still goes."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from maps import Cells, law, small_maps
from numpy.typing import NDArray
from scipy import ndimage

import vdoor
from vdoor.grid import FREE, OCCUPIED, UNKNOWN, OccupancyGrid
from vdoor.method.search.generation import Generation
from vdoor.method.simplify import REASONS, SimplifiedGrid, narrower
from vdoor.method.spaces import Spaces, disc, in_line, opened, square
from vdoor.pipeline import PRESETS, Pipeline
from vdoor.raster import morphology
from vdoor.synth import Apartment, Home, Office, synthesize

DEFAULT = PRESETS["default"]
assert isinstance(DEFAULT, Pipeline)
CELL_M = 0.05
GREY = 40
"""Between free and occupied."""
DASHES = [(5, 1), (8, 2), (12, 3), (13, 4), (22, 1), (26, 4), (40, 2), (70, 4)]
DOORS = [(4.2, 4.325, 0.9), (7.225, 3.45, 0.85)]
"""Middle as x, y, and width of the doors of `three_rooms`."""


def three_rooms(wall: Callable[[Cells, tuple[slice, slice]], None], thick: int) -> Cells:
    """A room on the left of a wall, two on its right; `wall` draws the stretches of wall between doors."""
    cells = np.full((150, 220), UNKNOWN, np.int8)
    cells[7:143, 7:213] = OCCUPIED
    cells[8:142, 8:212] = FREE
    left = slice(84 - thick // 2, 84 - thick // 2 + thick)
    below = slice(81 - thick // 2, 81 - thick // 2 + thick)
    for place in ((slice(8, 54), left), (slice(72, 142), left)):
        wall(cells, place)
    for place in ((below, slice(left.stop, 136)), (below, slice(153, 212))):
        wall(cells, place)
    return cells


def solid(cells: Cells, place: tuple[slice, slice]) -> None:
    cells[place] = OCCUPIED


def dashed(piece: int, gap: int) -> Callable[[Cells, tuple[slice, slice]], None]:
    """Walls with a gap after each piece; those at doors and at other walls are at least half as long as a piece."""

    def wall(cells: Cells, place: tuple[slice, slice]) -> None:
        solid(cells, place)
        part = cells[place] if place[0].stop - place[0].start > place[1].stop - place[1].start else cells[place].T
        for begin in range(piece, len(part) - gap - piece // 2, piece + gap):
            part[begin : begin + gap] = FREE

    return wall


def hollow(inside: int, holes: float, seed: int) -> Callable[[Cells, tuple[slice, slice]], None]:
    """Outlines of one cell; a share of their cells is as what is inside."""
    rng = np.random.default_rng(seed)

    def wall(cells: Cells, place: tuple[slice, slice]) -> None:
        part = cells[place]
        part[:] = OCCUPIED
        part[rng.random(part.shape) < holes] = inside
        part[1:-1, 1:-1] = inside

    return wall


def simplified(cells: Cells, cell_m: float = CELL_M) -> SimplifiedGrid:
    return DEFAULT.simplify(OccupancyGrid.from_array(cells, cell_m))


@pytest.mark.parametrize(("piece", "gap"), DASHES)
@pytest.mark.parametrize("turns", [0, 1])
def test_a_dashed_wall_is_simplified_as_a_solid_one(piece: int, gap: int, turns: int) -> None:
    found, wanted = (simplified(np.rot90(three_rooms(wall, 2), turns)) for wall in (dashed(piece, gap), solid))
    differ = np.argwhere((found.cells == FREE) != (wanted.cells == FREE))
    assert len(differ) <= 2, differ.tolist()  # a corner is filled where a gap ends in it


@pytest.mark.parametrize("inside", [FREE, UNKNOWN, GREY])
@pytest.mark.parametrize(("thick", "holes"), [(4, 0.0), (9, 0.0), (10, 0.12), (12, 0.05)])
def test_a_hollow_wall_is_filled_whatever_is_inside(inside: int, thick: int, holes: float) -> None:
    free = simplified(three_rooms(hollow(inside, holes, thick), thick)).cells == FREE
    wanted = simplified(three_rooms(solid, thick)).cells == FREE
    assert not (free & ~ndimage.binary_dilation(wanted)).any()  # at most holes in the face itself are left
    assert (free | ~wanted).all()


def kinds() -> list[Any]:
    walls = [(f"dashed {piece} {gap}", dashed(piece, gap), 2) for piece, gap in DASHES]
    walls += [
        (f"hollow {inside} {holes}", hollow(inside, holes, 1), 9) for inside in (FREE, GREY) for holes in (0, 0.1)
    ]
    return [pytest.param(three_rooms(wall, thick), id=name) for name, wall, thick in walls]


@pytest.mark.parametrize("cells", kinds())
@pytest.mark.parametrize("laid", ["as drawn", "turned", "mirrored", "coarse"])
def test_rooms_and_doors_behind_such_walls_are_found(cells: Cells, laid: str) -> None:
    width_m, height_m, cell_m = cells.shape[1] * CELL_M, cells.shape[0] * CELL_M, CELL_M
    wanted = np.array(DOORS)
    if laid == "turned":
        cells = np.rot90(cells)
        wanted = np.stack([height_m - wanted[:, 1], wanted[:, 0], wanted[:, 2]], axis=1)
    elif laid == "mirrored":
        cells, wanted = cells[:, ::-1], wanted * [-1, 1, 1] + [width_m, 0, 0]
    elif laid == "coarse":
        cells, cell_m = coarse(cells), 0.1
    found = vdoor.run(OccupancyGrid.from_array(np.ascontiguousarray(cells), cell_m))
    assert len(found.rooms) == 3
    doors = np.array([[*np.mean([door.start_m, door.end_m], axis=0), door.width_m] for door in found.doors])
    assert len(doors) == len(wanted), doors
    apart = np.hypot(*(doors[:, None, :2] - wanted[None, :, :2]).transpose(2, 0, 1))
    assert sorted(apart.argmin(axis=1).tolist()) == [0, 1]
    assert (apart.min(axis=1) <= 0.25 + cell_m / 2).all()  # a door may lie at either face of a wall
    assert (np.abs(doors[:, 2] - wanted[apart.argmin(axis=1), 2]) < 0.2).all()


def coarse(cells: Cells) -> Cells:
    """Cells twice as large: occupied where any is, else free where any is."""
    blocks = cells.reshape(cells.shape[0] // 2, 2, cells.shape[1] // 2, 2)
    free = np.where((blocks == FREE).any(axis=(1, 3)), FREE, UNKNOWN)
    return np.where((blocks == OCCUPIED).any(axis=(1, 3)), OCCUPIED, free).astype(np.int8)


def room_with(*things: tuple[slice, slice]) -> Cells:
    """A room of 5 m by 4 m with things in it."""
    cells = np.full((84, 104), OCCUPIED, np.int8)
    cells[2:82, 2:102] = FREE
    for thing in things:
        cells[thing] = OCCUPIED
    return cells


@pytest.mark.parametrize(
    "thing",
    [
        np.s_[40:46, 50:56],  # free in the room
        np.s_[40:52, 5:13],  # 0.15 m from a wall
        np.s_[5:13, 5:13],  # in a corner, with a pocket behind it
        np.s_[5:21, 40:58],  # a table of 0.9 m by 0.8 m near a wall
    ],
)
def test_furniture_goes_though_no_robot_fits_behind_it(thing: tuple[slice, slice]) -> None:
    found = simplified(room_with(thing))
    assert (found.reason[thing] == REASONS.index("island")).all()
    assert np.array_equal(found.cells == FREE, simplified(room_with()).cells == FREE)


def test_furniture_stays_where_it_bars_the_way() -> None:
    """Chairs across a corridor with gaps of 0.15 m: what is behind is apart for a robot."""
    cells = np.full((30, 144), OCCUPIED, np.int8)
    cells[2:28, 2:142] = FREE
    chairs = [np.s_[5:11, 70:76], np.s_[13:19, 70:76], np.s_[21:25, 70:76]]
    for chair in chairs:
        cells[chair] = OCCUPIED
    barred = simplified(cells).cells
    assert all((barred[chair] != FREE).all() for chair in chairs)
    assert ndimage.label(barred == FREE)[1] == 2
    cells[chairs[1]] = FREE  # one less, and the way is open
    assert ndimage.label(simplified(cells).cells == FREE)[1] == 1


@pytest.mark.parametrize("robot_m", [(), (1.0, 1.5)])
def test_the_room_behind_an_unseen_sill_is_joined_wherever_the_robot_is(robot_m: tuple[float, ...]) -> None:
    """A doorway of one unknown column."""
    cells = np.full((64, 126), OCCUPIED, np.int8)
    cells[2:62, 2:62] = FREE
    cells[2:62, 64:124] = FREE
    cells[24:40, 62] = UNKNOWN
    cells[24:40, 63] = FREE
    settings = dataclasses.replace(DEFAULT.simplify, robot_m=robot_m, sill_m=0.2)
    free = settings(OccupancyGrid.from_array(cells, CELL_M)).cells == FREE
    assert ndimage.label(free)[1] == 1
    assert free[30, 30]
    assert free[30, 90]


def test_gaps_are_closed_at_any_angle() -> None:
    """A wall at 30 degrees with a gap of 0.15 m and a door of 0.9 m: the gap is closed, and is no door."""
    row, col = np.indices((200, 200)) - 100.0
    along, across = col * np.cos(np.pi / 6) + row * np.sin(np.pi / 6), row * np.cos(np.pi / 6) - col * np.sin(np.pi / 6)
    cells = np.where(np.maximum(np.abs(along), np.abs(across)) < 70, FREE, OCCUPIED).astype(np.int8)
    wall = (np.abs(across) < 1.5) & (np.abs(along) < 70)
    cells[wall & ~((along > -40) & (along < -37)) & ~((along > 20) & (along < 38))] = OCCUPIED
    grid = OccupancyGrid.from_array(cells, CELL_M)
    gap = grid.free & (np.abs(across) < 0.5) & (along > -39.5) & (along < -37.5)
    assert (DEFAULT.simplify(grid).cells[gap] != FREE).all()
    found = vdoor.run(grid)
    assert [round(door.width_m, 1) for door in found.doors] == [0.9]


@pytest.mark.parametrize(("width", "doors"), [(5, 0), (6, 1), (9, 1)])
def test_gaps_narrower_than_a_robot_are_no_doors(width: int, doors: int) -> None:
    cells = np.full((60, 124), OCCUPIED, np.int8)
    cells[2:58, 2:122] = FREE
    cells[2:58, 61:63] = OCCUPIED
    cells[26 : 26 + width, 61:63] = FREE
    found = vdoor.run(OccupancyGrid.from_array(cells, CELL_M))
    assert len(found.doors) == doors


Kind = Apartment | Home | Office
SHARES: dict[str, dict[str, Any]] = {"solid": {}} | {
    f"all {name}": {f"{name}_chance": 1.0} for name in ("hollow", "dashed", "antialiased")
}


def synthetic_maps() -> list[Any]:
    made: list[tuple[str, Kind]] = [("apartment", Apartment(rooms=5, rooms_spread=1, cell_m=0.05))]
    made += [(f"home {share}", Home(**settings)) for share, settings in SHARES.items()]
    made += [(f"office {share}", Office(cell_m=0.1, **settings)) for share, settings in SHARES.items()]
    return [pytest.param(kind, seed, id=f"{name} {seed}") for name, kind in made for seed in range(3)]


def spaces_of(free: NDArray[np.bool_], gap: int, least: float) -> NDArray[np.int64]:
    """Number (h, w) of the space that a cell is in for a round robot that does not fit through `gap` cells, or 0.

    By distances and labels of centres alone, and so in another way than the method finds them.
    """
    away = np.arange(gap + 1) - gap / 2
    robot = np.hypot(away[:, None], away) <= (gap + 1) / 2
    centre, count = ndimage.label(ndimage.binary_erosion(np.pad(free, gap + 1), robot))
    found = np.zeros(centre.shape, np.int64)
    for number in range(1, count + 1):
        own = ndimage.binary_dilation(centre == number, robot[::-1, ::-1], origin=-(gap % 2))
        if own.sum() >= least:
            found[own] = number
    return found[gap + 1 : -gap - 1, gap + 1 : -gap - 1]


@pytest.mark.parametrize(("kind", "seed"), synthetic_maps())
def test_no_two_spaces_join_that_were_apart(kind: Kind, seed: int) -> None:
    grid = synthesize(kind, np.random.default_rng([7, seed])).grid
    cell_m = grid.frame.resolution_m
    gap = int(DEFAULT.simplify.gap_m / cell_m + 1e-9)
    space = spaces_of(grid.free, gap, 0.3 / cell_m**2)
    part, count = ndimage.label(DEFAULT.simplify(grid).cells == FREE)
    for number in range(1, count + 1):
        own, cells = np.unique(space[(part == number) & (space > 0)], return_counts=True)
        # Two robots can touch in the mouth of a gap from both sides: a few cells there say nothing.
        assert (cells > 0.1 / cell_m**2).sum() <= 1, (own.tolist(), cells.tolist())


@pytest.mark.parametrize(("kind", "seed"), synthetic_maps())
def test_the_final_map_is_what_the_search_chose(kind: Kind, seed: int) -> None:
    grid = synthesize(kind, np.random.default_rng([8, seed])).grid
    records: list[Any] = []
    found = vdoor.run(grid, emit=lambda record: records.append(record) or record)
    last = [record for record in records if isinstance(record, Generation)][-1]
    assert np.unique(found.edge).tolist() == np.flatnonzero(~last.removed).tolist()
    assert "passage" not in {door.kind for door in found.doors}
    assert {door.rooms for door in found.doors} <= touching(found.labels)


def touching(labels: NDArray[np.int32]) -> set[tuple[int, int]]:
    """Pairs of rooms with cells side by side."""
    pairs = set()
    for one, other in ((labels[1:], labels[:-1]), (labels[:, 1:], labels[:, :-1])):
        at = (one != other) & (one > 0) & (other > 0)
        pairs |= {(min(pair), max(pair)) for pair in zip(one[at].tolist(), other[at].tolist(), strict=True)}
    return pairs


@law
@given(small_maps(), st.integers(1, 5))
def test_spaces_turn_and_mirror_with_the_map(cells: Cells, wide: int) -> None:
    free = cells == FREE
    found = Spaces.of(free, wide)
    for move in (np.rot90, np.fliplr):
        moved = Spaces.of(np.ascontiguousarray(move(free)), wide)
        assert (moved.gap == move(found.gap)).all()
        assert (moved.narrow == move(found.narrow)).all()
        assert (moved.runs.mask() == move(found.runs.mask())).all()


@law
@given(small_maps(), st.integers(1, 3), st.integers(1, 40))
def test_a_map_worked_on_in_bands_gives_what_it_gives_as_a_whole(cells: Cells, wide: int, band: int) -> None:
    free = cells == FREE

    def found() -> tuple[NDArray[np.bool_], ...]:
        spaces = Spaces.of(free, wide)
        return spaces.gap, spaces.narrow, narrower(free, wide), in_line(free, wide=wide, thick=2, least=3)

    whole = found()
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(morphology, "BAND_CELLS", band)
        assert all((one == other).all() for one, other in zip(whole, found(), strict=True))


@law
@given(small_maps(), st.integers(1, 6))
def test_opening_is_that_of_scipy(cells: Cells, side: int) -> None:
    free = cells == FREE
    for element in (disc(side), square(side), square(side)[:1]):
        wanted = ndimage.binary_opening(np.pad(free, side), element)[side:-side, side:-side]
        assert (opened(free, element) == wanted).all()


@law
@given(small_maps(), st.integers(1, 4))
def test_closing_gaps_leaves_each_part_of_the_free_space_one_space(cells: Cells, wide: int) -> None:
    spaces = Spaces.of(cells == FREE, wide)
    part, _ = ndimage.label((cells == FREE) & ~spaces.gap)
    label = spaces.runs.image()
    pairs = np.unique(np.stack([part[label > 0], label[label > 0]]), axis=1)
    assert len(np.unique(pairs[0])) == pairs.shape[1]


def test_settings_say_what_is_closed() -> None:
    free = np.full((40, 60), OCCUPIED, np.int8)
    free[2:38, 2:58] = FREE
    free[2:38, 29:31] = OCCUPIED
    free[18:22, 29:31] = FREE  # 0.2 m
    for gap_m, parts in ((0.2, 2), (0.15, 1), (0.0, 1)):
        settings = dataclasses.replace(DEFAULT.simplify, gap_m=gap_m, channel_m=0.0)
        found = settings(OccupancyGrid.from_array(free, CELL_M))
        assert ndimage.label(found.cells == FREE)[1] == parts
