"""The boundary path against a walker that follows the three left-hand rules, and against scikit-image."""

from __future__ import annotations

import math
from collections import Counter

import numpy as np
import pytest
from hypothesis import given
from maps import CELL_M, Cells, drawn, law, long_law, simplifying, small_maps
from numpy.typing import NDArray
from scipy import ndimage
from skimage import measure

from vdoor.grid import FREE, OccupancyGrid
from vdoor.method.boundary import BoundaryPath, TraceBoundary
from vdoor.method.simplify import SimplifiedGrid
from vdoor.raster.contours import STEP, follow

State = tuple[int, int, int]


def simplified(cells: Cells, cell_m: float = CELL_M) -> SimplifiedGrid:
    return simplifying(cell_m=cell_m, passes=0).simplify(OccupancyGrid.from_array(cells, cell_m))


def path_of(text: str, cell_m: float = CELL_M) -> BoundaryPath:
    return TraceBoundary()(simplifying(cell_m=cell_m, passes=0).simplify(drawn(text, cell_m)))


def walk(free: NDArray[np.bool_]) -> list[list[tuple[State, bool]]]:
    """Every contour as states (row, col, heading) and whether the walker turns left there; step by step."""
    space = np.pad(free, 1)

    def is_free(row: int, col: int) -> bool:
        return bool(space[row + 1, col + 1])

    def beside(row: int, col: int, heading: int) -> tuple[int, int]:
        return row + int(STEP[heading % 4][0]), col + int(STEP[heading % 4][1])

    left: set[State] = set()
    for row, col in np.argwhere(free).tolist():
        left |= {(row, col, heading) for heading in range(4) if not is_free(*beside(row, col, heading + 1))}
    contours = []
    while left:
        state = start = min(left)
        contour: list[tuple[State, bool]] = []
        while not contour or state != start:
            left.remove(state)
            row, col, heading = state
            ahead = beside(row, col, heading)
            ahead_left = beside(*ahead, heading + 1)
            turns_left = is_free(*ahead) and is_free(*ahead_left)
            contour.append((state, turns_left))
            if not is_free(*ahead):
                state = (row, col, (heading - 1) % 4)
            elif not turns_left:
                state = (*ahead, heading)
            else:
                state = (*ahead_left, (heading + 1) % 4)
        contours.append(contour)
    return contours


def cyclic(items: list[State]) -> tuple[State, ...]:
    """A cycle told from its smallest element on."""
    begin = items.index(min(items))
    return tuple(items[begin:] + items[:begin])


def sampled(contour: list[tuple[State, bool]]) -> list[tuple[int, int]]:
    """The obstacle cells of a walk, consecutive repeats dropped, the last against the first as well."""
    cells = [(row + int(STEP[(h + 1) % 4][0]), col + int(STEP[(h + 1) % 4][1])) for (row, col, h), _ in contour]
    kept = [cell for cell, before in zip(cells, [cells[-1], *cells[:-1]], strict=True) if cell != before]
    return kept or cells[:1]


@long_law
@given(cells=small_maps())
def test_contours_are_those_of_a_walker_with_the_wall_on_the_left(cells: Cells) -> None:
    free = cells == FREE
    found = follow(free)
    states = np.column_stack([found.cell, found.heading]).tolist()
    groups = [
        [tuple(state) for state in states[first : first + length]]
        for first, length in zip(found.first.tolist(), found.length.tolist(), strict=True)
    ]
    plain = walk(free)
    assert {cyclic(group) for group in groups} == {cyclic([state for state, _ in contour]) for contour in plain}
    turns = dict(zip(map(tuple, states), (found.turn > 0).tolist(), strict=True))
    assert turns == {state: left for contour in plain for state, left in contour}
    assert len(turns) == sum(
        int((free & ~np.roll(np.pad(free, 1), by, axis)[1:-1, 1:-1]).sum()) for by in (1, -1) for axis in (0, 1)
    )


@law
@given(cells=small_maps())
def test_the_papers_samples_are_the_obstacle_cells_of_that_walk(cells: Cells) -> None:
    grid = simplified(cells)
    path = TraceBoundary()(grid)
    assert not path.on_cracks
    groups = np.split(path.cell, path.first[1:])
    found = Counter(frozenset(Counter(map(tuple, group.tolist())).items()) for group in groups)
    plain = walk(grid.cells == FREE)
    assert found == Counter(frozenset(Counter(sampled(contour)).items()) for contour in plain)
    for group in groups:
        if len(group) > 1:
            assert (group != np.roll(group, 1, axis=0)).any(axis=1).all()
    assert (grid.cells[tuple(path.free_cell.T)] == FREE).all()
    assert (np.abs(path.cell - path.free_cell).sum(axis=1) == 1).all()
    assert (path.half == 2 * path.cell + 1).all()


@law
@given(cells=small_maps())
def test_a_sample_is_marked_where_the_walker_turns_left_around_it(cells: Cells) -> None:
    """Both cracks beside a corner belong to it, so that the mark mirrors with the map."""
    for cell_m in (0.2, 0.05):
        grid = simplified(cells, cell_m)
        path = TraceBoundary()(grid)
        marked = Counter(map(tuple, path.cell[path.turned_left].tolist()))
        turned: Counter[tuple[int, ...]] = Counter()
        for contour in walk(grid.cells == FREE):
            for index, ((row, col, heading), _) in enumerate(contour):
                if contour[index][1] or contour[index - 1][1]:
                    turned[row + int(STEP[(heading + 1) % 4][0]), col + int(STEP[(heading + 1) % 4][1])] += 1
        if path.on_cracks:
            assert marked == turned
        else:
            assert set(marked) == set(turned)


@law
@given(cells=small_maps())
def test_arc_length_is_the_sum_of_euclidean_steps(cells: Cells) -> None:
    for cell_m in (0.2, 0.05):
        path = TraceBoundary()(simplified(cells, cell_m))
        assert path.on_cracks == (cell_m == 0.05)
        ends = np.append(path.first[1:], len(path.half)).tolist()
        for number, (first, end) in enumerate(zip(path.first.tolist(), ends, strict=True)):
            assert (path.contour[first:end] == number).all()
            ring = path.half[first:end].tolist()
            length_m = 0.0
            for index, place in enumerate(ring):
                assert path.arc_m[first + index] == pytest.approx(length_m, abs=1e-9)
                length_m += math.dist(place, ring[(index + 1) % len(ring)]) * cell_m / 2
            assert path.length_m[number] == pytest.approx(length_m, abs=1e-9)


@law
@given(cells=small_maps())
def test_there_is_one_outer_contour_and_one_for_each_island(cells: Cells) -> None:
    grid = simplified(cells)
    path = TraceBoundary()(grid)
    free = np.pad(grid.cells == FREE, 1)
    obstacles, count = ndimage.label(~free, np.ones((3, 3)))
    assert path.outer.sum() == 1
    assert len(path.first) == count
    of_contour = [np.unique(obstacles[tuple((group + 1).T)]) for group in np.split(path.cell, path.first[1:])]
    assert sorted(int(labels[0]) for labels in of_contour) == list(range(1, count + 1))
    assert all(len(labels) == 1 for labels in of_contour)
    assert (obstacles[0, 0] == of_contour[int(np.flatnonzero(path.outer)[0])]).all()


@law
@given(cells=small_maps())
def test_crack_contours_are_those_of_scikit_image(cells: Cells) -> None:
    """Marching squares at one half pass through the middle of every crack."""
    grid = simplified(cells, 0.05)
    path = TraceBoundary()(grid)
    free = np.pad(grid.cells == FREE, 1)
    lines = measure.find_contours(free.astype(float), 0.5, fully_connected="low")  # type: ignore[no-untyped-call]
    theirs = Counter(frozenset(map(tuple, (2 * line - 1).round().astype(int).tolist())) for line in lines)
    ours = Counter(frozenset(map(tuple, group.tolist())) for group in np.split(path.half, path.first[1:]))
    assert theirs == ours


def test_a_square_room_is_one_closed_contour() -> None:
    path = path_of("######\n#....#\n#....#\n#....#\n#....#\n######")
    assert len(path.cell) == 16
    assert path.first.tolist() == [0]
    assert path.outer.tolist() == [True]
    assert path.length_m.tolist() == pytest.approx([12 * 0.2 + 4 * 0.2 * math.sqrt(2)])
    assert not path.turned_left.any()
    assert path.cell[0].tolist() == [0, 1]


def test_a_pillar_has_a_closed_contour_of_its_own() -> None:
    path = path_of("......\n......\n..##..\n..##..\n......\n......")
    pillar = path.cell[path.contour == np.flatnonzero(~path.outer)[0]]
    assert sorted(map(tuple, pillar.tolist())) == [(2, 2), (2, 3), (3, 2), (3, 3)]


def test_a_pillar_of_one_cell_is_a_contour_of_one_sample() -> None:
    path = path_of("...\n.#.\n...")
    assert path.cell[path.contour == 1].tolist() == [[1, 1]] or path.cell[path.contour == 0].tolist() == [[1, 1]]
    assert sorted(path.outer.tolist()) == [False, True]


def test_a_thin_wall_is_sampled_from_both_sides() -> None:
    path = path_of("#######\n#.....#\n#.....#\n#..#..#\n#..#..#\n#######")
    visits = Counter(map(tuple, path.cell.tolist()))
    assert visits[4, 3] == 2
    assert visits[3, 3] == 1  # the tip: one stay, three cracks
    assert path.turned_left[(path.cell == [3, 3]).all(axis=1)].all()


def test_free_space_at_the_maps_edge_is_walled_by_cells_outside() -> None:
    path = path_of("..\n..")
    assert path.cell.min() == -1
    assert path.cell.max() == 2
    assert len(path.cell) == 8
