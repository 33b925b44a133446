"""Candidates and corner features: which way they bend, and one for each corner there is."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from maps import CELL_M, Cells, drawn, law, small_maps, stages
from numpy.typing import NDArray

from vdoor.grid import OccupancyGrid
from vdoor.method.corners import Candidates, Corners, FindCandidates, gaps_m
from vdoor.method.simplify import SimplifyGrid
from vdoor.pipeline import Pipeline

FINE = Pipeline(simplify=SimplifyGrid(cell_m=0.05))


def room(side: int, *changes: tuple[slice | int, slice | int]) -> NDArray[np.int8]:
    """A square room of `side` cells within its walls, with some cells built."""
    cells = np.full((side + 2, side + 2), 100, np.int8)
    cells[1:-1, 1:-1] = 0
    for change in changes:
        cells[change] = 100
    return cells


def corner_cells(cells: Cells, cell_m: float = CELL_M, *, convex: bool) -> list[tuple[int, ...]]:
    found = stages(OccupancyGrid.from_array(cells, cell_m), FINE if cell_m < CELL_M else None).corners
    return sorted(map(tuple, found.cell[found.convex == convex].tolist()))


@pytest.mark.parametrize(("side", "cell_m"), [(10, 0.2), (15, 0.2), (40, 0.05)])
def test_a_square_room_has_four_concave_corners_and_none_convex(side: int, cell_m: float) -> None:
    cells = room(side)
    assert corner_cells(cells, cell_m, convex=True) == []
    concave = np.array(corner_cells(cells, cell_m, convex=False))
    assert len(concave) == 4
    for end in ([0, 0], [0, side + 1], [side + 1, 0], [side + 1, side + 1]):
        assert np.abs(concave - end).max(axis=1).min() <= 1


@pytest.mark.parametrize("turns", range(4))
def test_the_end_of_a_wall_one_cell_thick_is_one_convex_corner(turns: int) -> None:
    """It folds back on itself: eq. 6 has no side there, the walker's left turn has."""
    cells = room(14, (slice(8, 15), 7))
    found = stages(OccupancyGrid.from_array(np.rot90(cells, turns), CELL_M)).corners
    (tip,) = np.flatnonzero(found.convex)
    expected = np.argwhere(np.rot90(np.arange(256).reshape(16, 16) == 8 * 16 + 7, turns))[0]
    assert found.cell[tip].tolist() == expected.tolist()
    assert found.angle_rad[tip] == 0
    assert found.quarter[tip].tolist() == (4 * expected + 2).tolist()


@pytest.mark.parametrize("turns", range(4))
def test_the_end_of_a_wall_two_cells_thick_is_two_convex_corners(turns: int) -> None:
    cells = room(14, (slice(8, 15), slice(7, 9)))
    mark = np.zeros((16, 16), np.bool_)
    mark[8, 7:9] = True
    expected = sorted(map(tuple, np.argwhere(np.rot90(mark, turns)).tolist()))
    assert corner_cells(np.rot90(cells, turns), convex=True) == expected


def test_a_thick_wall_has_a_convex_corner_at_each_side_of_its_end() -> None:
    assert corner_cells(room(16, (slice(9, 17), slice(7, 12))), convex=True) == [(9, 7), (9, 11)]


def test_every_cell_of_a_small_pillar_is_a_convex_corner() -> None:
    assert corner_cells(room(14, (slice(7, 9), slice(7, 9))), convex=True) == [(7, 7), (7, 8), (8, 7), (8, 8)]


def test_a_large_pillar_has_four_convex_corners() -> None:
    cells = room(24, (slice(9, 16), slice(9, 16)))
    assert corner_cells(cells, convex=True) == [(9, 9), (9, 15), (15, 9), (15, 15)]
    assert len(corner_cells(cells, convex=False)) == 4


@pytest.mark.parametrize("cell_m", [0.2, 0.05])
def test_concave_minus_convex_is_four_for_the_outer_wall_and_minus_four_for_each_island(cell_m: float) -> None:
    scale = round(CELL_M / cell_m)
    cells = room(40, (slice(10, 18), slice(8, 15)), (slice(24, 34), slice(24, 31)), (slice(1, 12), slice(30, 41)))
    large = cells.repeat(scale, axis=0).repeat(scale, axis=1)
    assert len(corner_cells(large, cell_m, convex=False)) - len(corner_cells(large, cell_m, convex=True)) == 4 - 4 * 2


def test_in_an_l_shaped_room_one_corner_is_convex() -> None:
    cells = room(20, (slice(1, 11), slice(11, 21)))
    assert corner_cells(cells, convex=True) == [(10, 11)]
    assert len(corner_cells(cells, convex=False)) == 5


@law
@given(cells=small_maps())
def test_candidates_are_the_samples_below_the_angle_on_the_side_atan2_says(cells: Cells) -> None:
    """Eq. 6 as read: the direction of f against that of b, turned into (-pi, pi]; the wall lies on the left."""
    for pipeline in (Pipeline(), FINE):
        cell_m = CELL_M if pipeline is not FINE else 0.05
        found = stages(OccupancyGrid.from_array(cells, cell_m), pipeline)
        bend, sample = found.curvature, found.candidates.sample
        below = (np.degrees(bend.angle_rad) < 155 - 1e-6) & (bend.k_forward > 0)
        assert np.flatnonzero(below).tolist() == sample.tolist()
        for row, index in enumerate(sample.tolist()):
            towards, back = (
                math.atan2(-vector[0], vector[1]) for vector in (bend.forward[index], bend.backward[index])
            )
            turn = math.remainder(towards - back, 2 * math.pi)  # from b to f, counter-clockwise
            if 1e-9 < abs(turn) < math.pi - 1e-9:
                assert found.candidates.convex[row] == (turn < 0)
            else:
                assert found.candidates.convex[row] == found.path.turned_left[index]


@law
@given(cells=small_maps())
def test_corners_are_candidates_that_no_candidate_of_their_kind_nearby_is_sharper_than(cells: Cells) -> None:
    found = stages(OccupancyGrid.from_array(cells, CELL_M))
    path, all_ = found.path, found.candidates
    convex_of = dict(zip(all_.sample.tolist(), all_.convex.tolist(), strict=True))
    for sample, convex, angle in zip(
        found.corners.sample.tolist(), found.corners.convex.tolist(), found.corners.angle_rad.tolist(), strict=True
    ):
        assert convex_of[sample] == convex
        own = np.flatnonzero((path.contour[all_.sample] == path.contour[sample]) & (all_.convex == convex))
        near = own[gaps_m(path, np.full(len(own), sample, np.int32), all_.sample[own]) <= 0.25 + 1e-9]
        sharper = near[all_.angle_rad[near] < angle - 1e-9]
        both_turn = convex & path.turned_left[sample] & path.turned_left[all_.sample[sharper]]
        assert both_turn.all()
    assert found.corners.sample.tolist() == sorted(found.corners.sample.tolist())


@law
@given(cells=small_maps())
def test_every_contour_with_candidates_of_a_kind_has_a_corner_of_that_kind(cells: Cells) -> None:
    found = stages(OccupancyGrid.from_array(cells, CELL_M))

    def kinds(table: Candidates | Corners) -> set[tuple[int, bool]]:
        return set(zip(found.path.contour[table.sample].tolist(), table.convex.tolist(), strict=True))

    assert kinds(found.corners) == kinds(found.candidates)
    assert set(found.corners.sample.tolist()) <= set(found.candidates.sample.tolist())


def test_the_threshold_is_compared_by_angle() -> None:
    found = stages(OccupancyGrid.from_array(room(14, (slice(8, 15), 7)), CELL_M))
    none = FindCandidates(angle_deg=0.0)(found.path, found.curvature)
    every = FindCandidates(angle_deg=180.0)(found.path, found.curvature)
    assert len(none.sample) == 0
    assert len(every.sample) == (found.curvature.angle_rad < math.pi).sum()


def test_a_map_without_candidates_has_no_corners() -> None:
    found = stages(drawn("."), Pipeline(candidates=FindCandidates(angle_deg=0.0)))
    assert len(found.candidates.sample) == len(found.corners.sample) == len(found.doors.start) == 0
