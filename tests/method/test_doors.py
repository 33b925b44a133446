"""Virtual doors: which segments are proposed, how they are measured, and why others are not."""

from __future__ import annotations

import math
from collections import Counter
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from maps import CELL_M, Cells, drawn, law, long_law, small_maps, stages
from numpy.typing import NDArray

from vdoor.errors import MapError
from vdoor.grid import FREE, OccupancyGrid
from vdoor.method import doors
from vdoor.method.corners import gaps_m
from vdoor.method.doors import PROPOSED, VERDICTS, ProposeDoors, VirtualDoors
from vdoor.pipeline import Pipeline
from vdoor.raster.lines import lines_between
from vdoor.topology import KINDS

LONG_DOORS = Pipeline(doors=ProposeDoors(max_length_m=2.4))
Ends = frozenset[tuple[int, int]]


def doors_of(text: str, pipeline: Pipeline | None = None) -> VirtualDoors:
    return stages(drawn(text), pipeline).doors


def by_verdict(doors: VirtualDoors) -> dict[str, set[Ends]]:
    found: dict[str, set[Ends]] = {}
    for start, end, verdict in zip(doors.start.tolist(), doors.end.tolist(), doors.verdict.tolist(), strict=True):
        found.setdefault(VERDICTS[verdict], set()).add(frozenset({tuple(start), tuple(end)}))
    return found


def ends(*cells: tuple[int, int]) -> Ends:
    return frozenset(cells)


def two_rooms(gap: int, *, side: int = 9, thick: int = 1) -> str:
    """Two square rooms and an opening of `gap` cells in the middle of the wall between them."""
    closed = (side - gap) // 2
    wall = ["#" * thick] * closed + ["." * thick] * gap + ["#" * thick] * (side - gap - closed)
    edge = "#" * (2 * side + 2 + thick)
    return "\n".join([edge, *["#" + "." * side + part + "." * side + "#" for part in wall], edge])


def test_two_rooms_with_a_gap_have_exactly_one_door() -> None:
    found = doors_of(two_rooms(3))
    assert by_verdict(found) == {"proposed": {ends((3, 10), (7, 10))}}
    assert KINDS[found.kind[0]] == "pair"
    assert found.length_m.tolist() == pytest.approx([0.8])
    assert found.width_m.tolist() == pytest.approx([0.6])
    assert found.tilt_rad.tolist() == [0]
    assert found.line_cell.tolist() == [[4, 10], [5, 10], [6, 10]]
    assert found.line_door.tolist() == [0, 0, 0]


@pytest.mark.parametrize(("gap", "doors"), [(1, 1), (3, 1), (5, 1), (7, 0)])
def test_doors_reach_1_2_m_between_the_middles_of_their_end_cells(gap: int, doors: int) -> None:
    assert len(by_verdict(doors_of(two_rooms(gap))).get("proposed", ())) == doors


def test_a_thick_wall_has_doors_at_both_faces_and_across() -> None:
    found = doors_of(two_rooms(3, thick=2))
    assert by_verdict(found) == {
        "proposed": {ends((3, a), (7, b)) for a in (10, 11) for b in (10, 11)},
        "no gap": {ends((row, 10), (row, 11)) for row in (3, 7)},
    }
    slanting = found.tilt_rad > 0
    assert found.length_m[slanting].tolist() == pytest.approx([0.2 * math.hypot(4, 1)] * 2)
    assert found.tilt_rad[slanting].tolist() == pytest.approx([math.atan2(1, 4)] * 2)
    # A slanting segment leaves its end cells after half a cell of its longer axis.
    assert found.width_m[slanting].tolist() == pytest.approx([0.2 * math.hypot(4, 1) * 3 / 4] * 2)


def test_a_single_corner_is_joined_to_the_closest_boundary() -> None:
    found = doors_of(
        """
        ###############
        #......#......#
        #......#......#
        #......#......#
        #......#......#
        #......#......#
        #......#......#
        #.............#
        #.............#
        #.............#
        ###############
        """
    )
    assert by_verdict(found) == {"proposed": {ends((6, 7), (10, 7))}}
    assert KINDS[found.kind[0]] == "single"
    assert found.corner_end.tolist() == [-1]
    assert found.width_m.tolist() == pytest.approx([0.6])


def test_a_pair_across_a_wall_is_blocked() -> None:
    """Four jambs around the end of a cross of walls: those that do not see each other are no doors."""
    found = doors_of(
        """
        ###################
        #.................#
        #.................#
        #.................#
        #.................#
        #######.#.#########
        #.......#.........#
        #.......#.........#
        #.......#.........#
        #.......#.........#
        #.......#.........#
        ###################
        """
    )
    verdicts = by_verdict(found)
    assert ends((5, 6), (5, 8)) in verdicts["proposed"]
    assert ends((5, 8), (5, 10)) in verdicts["proposed"]
    assert ends((5, 6), (5, 10)) in verdicts["blocked"]


def test_corners_along_one_wall_are_no_door() -> None:
    """The two corners of a bay seen from inside: the way along the wall is not much longer than across."""
    found = doors_of(
        """
        #################
        #...............#
        #...............#
        #...............#
        #...............#
        #...............#
        ######.....######
        ######.....######
        #################
        #################
        """
    )
    assert ends((6, 5), (6, 11)) in by_verdict(found)["same wall"]
    assert "proposed" not in by_verdict(found)


def test_a_door_found_from_both_its_ends_is_kept_once() -> None:
    found = stages(drawn(two_rooms(3)), Pipeline(doors=ProposeDoors(pair_detour=100.0))).doors
    assert Counter(VERDICTS[verdict] for verdict in found.verdict.tolist()) == {
        "same wall": 1,
        "proposed": 1,
        "duplicate": 1,
    }
    assert len(found.line_cell) == 3


@pytest.mark.parametrize("text", ["####\n#..#\n#..#\n####", "."])
def test_no_convex_corner_no_door(text: str) -> None:
    found = doors_of(text)
    assert len(found.start) == len(found.line_cell) == 0


def test_doors_may_end_outside_the_map() -> None:
    """Free space up to the map's edge: the cells beyond it are its wall."""
    found = doors_of("...........\n" * 6 + ".....#.....\n" * 6)
    assert ends((6, 5), (-1, 5)) not in by_verdict(found).get("proposed", set())
    near = doors_of("...........\n" * 4 + ".....#.....\n" * 6)
    assert by_verdict(near)["proposed"] == {ends((4, 5), (-1, 5))}
    assert sorted(near.line_cell.tolist()) == [[row, 5] for row in range(4)]


def plain_line(start: list[int], end: list[int]) -> list[list[tuple[int, int]]]:
    """Each step's cell, or the two cells it is halfway between, in rational numbers."""
    span = [b - a for a, b in zip(start, end, strict=True)]
    steps = max(map(abs, span))
    line = []
    for step in range(1, steps):
        exact = [a + Fraction(s * step, steps) for a, s in zip(start, span, strict=True)]
        options = [
            {math.floor(x), math.ceil(x)} if x - math.floor(x) == Fraction(1, 2) else {math.floor(x + Fraction(1, 2))}
            for x in exact
        ]
        line.append([(row, col) for row in sorted(options[0]) for col in sorted(options[1])])
    return line


cell_pairs = st.lists(st.tuples(*[st.integers(-1, 9)] * 4), min_size=1, max_size=20)


@long_law
@given(seed=st.integers(0, 2**32), pairs=cell_pairs)
def test_line_cells_are_those_of_rational_arithmetic(seed: int, pairs: list[tuple[int, ...]]) -> None:
    free = np.random.default_rng(seed).random((9, 9)) < 0.9
    cells = np.array(pairs, np.int32)
    clear, cell, owner = lines_between(free, cells[:, :2], cells[:, 2:])

    def is_free(place: tuple[int, int]) -> bool:
        return bool(min(place) >= 0 and max(place) < 9 and free[place])

    for index, pair in enumerate(cells.tolist()):
        line = plain_line(pair[:2], pair[2:])
        good = len(line) > 0 and all(any(map(is_free, step)) for step in line)
        assert clear[index] == good
        expected = {place for step in line for place in step if is_free(place)} if good else set()
        assert set(map(tuple, cell[owner == index].tolist())) == expected


def plain_doors(found: Any, settings: ProposeDoors) -> tuple[set[Ends], set[Ends]]:
    """Proposed pairs and singles by plain loops over corners and samples."""
    path, corners, free = found.path, found.corners, found.simplified.cells == FREE
    convex = np.flatnonzero(corners.convex).tolist()

    def is_door(a: int, b: int, detour: float) -> str:
        one, other = path.cell[a].tolist(), path.cell[b].tolist()
        gap = gaps_m(path, np.array([a], np.int32), np.array([b], np.int32))[0]
        own = path.contour[a] == path.contour[b] and gap <= detour * math.dist(one, other) * CELL_M + 1e-9
        if own or max(abs(x - y) for x, y in zip(one, other, strict=True)) <= 1:
            return "own"
        return "clear" if lines_between(free, path.cell[[a]], path.cell[[b]])[0][0] else "hidden"

    def reaches(a: int, b: int) -> bool:
        return math.dist(path.cell[a].tolist(), path.cell[b].tolist()) * CELL_M <= settings.max_length_m + 1e-9

    def segment(a: int, b: int) -> Ends:
        return frozenset({tuple(path.cell[a].tolist()), tuple(path.cell[b].tolist())})

    sample = corners.sample.tolist()
    both = [(i, k) for i in convex for k in convex if i < k and reaches(sample[i], sample[k])]
    pairs = [(i, k) for i, k in both if is_door(sample[i], sample[k], settings.pair_detour) == "clear"]
    alone = set(convex) - {corner for pair in pairs for corner in pair}
    singles = set()
    for corner in alone:
        state: dict[tuple[int, ...], tuple[str, int]] = {}
        for other in range(len(path.cell)):
            if reaches(sample[corner], other):
                kind, cell = is_door(sample[corner], other, settings.single_detour), tuple(path.cell[other].tolist())
                if state.get(cell, ("", 0))[0] != "own":
                    state[cell] = (kind, other)
        clear = [other for kind, other in state.values() if kind == "clear"]
        length = {other: math.dist(path.cell[sample[corner]].tolist(), path.cell[other].tolist()) for other in clear}
        singles |= {segment(sample[corner], other) for other in clear if length[other] == min(length.values())}
    return {segment(sample[i], sample[k]) for i, k in pairs}, singles


@law
@given(cells=small_maps(most=16))
def test_doors_are_those_of_plain_loops_over_corners_and_boundary(cells: Cells) -> None:
    found = stages(OccupancyGrid.from_array(cells, CELL_M), LONG_DOORS)
    pairs, singles = plain_doors(found, LONG_DOORS.doors)
    doors = found.doors
    good = doors.verdict == PROPOSED
    ours = [
        frozenset({tuple(a), tuple(b)})
        for a, b in zip(doors.start[good].tolist(), doors.end[good].tolist(), strict=True)
    ]
    assert len(ours) == len(set(ours))
    assert set(ours) == pairs | singles
    kinds = doors.kind[good]
    assert {door for door, kind in zip(ours, kinds, strict=True) if kind == KINDS.index("pair")} == pairs


@law
@given(cells=small_maps())
def test_doors_lie_on_free_cells_and_are_measured_from_their_ends(cells: Cells) -> None:
    found = stages(OccupancyGrid.from_array(cells, CELL_M), LONG_DOORS)
    doors, free = found.doors, found.simplified.cells == FREE
    assert (doors.line_cell >= 0).all()
    assert free[tuple(doors.line_cell.T)].all()
    assert set(doors.line_door.tolist()) == set(np.flatnonzero(doors.verdict == PROPOSED).tolist())
    assert (doors.start == found.corners.cell[doors.corner_start]).all()
    pair = doors.corner_end >= 0
    assert (pair == (doors.kind == KINDS.index("pair"))).all()
    assert (doors.end[pair] == found.corners.cell[doors.corner_end[pair]]).all()
    span: NDArray[np.float64] = np.abs(doors.end - doors.start).astype(float)
    np.testing.assert_allclose(doors.length_m, np.hypot(*span.T) * CELL_M)
    assert (doors.length_m <= LONG_DOORS.doors.max_length_m + 1e-9).all()
    assert (doors.width_m <= doors.length_m).all()
    np.testing.assert_allclose(np.tan(doors.tilt_rad) * span.max(axis=1), span.min(axis=1), atol=1e-9)


def test_more_pairs_of_corners_than_a_building_has_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    pairs = int((doors_of(two_rooms(3)).kind == KINDS.index("pair")).sum())
    monkeypatch.setattr(doors, "MOST_PAIRS", pairs)
    doors_of(two_rooms(3))
    monkeypatch.setattr(doors, "MOST_PAIRS", pairs - 1)
    with pytest.raises(MapError, match=f"wanted at most {pairs - 1} pairs of corners .* found {pairs}; the map"):
        doors_of(two_rooms(3))
