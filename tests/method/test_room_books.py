"""Exact books: regions, atoms, borders, rings and centres against plain loops."""

from __future__ import annotations

from collections import defaultdict
from itertools import pairwise
from typing import Any

import numpy as np
import shapely  # type: ignore[import-untyped]  # publishes no types
from hypothesis import given
from hypothesis import strategies as st
from maps import CELL_M, Cells, drawn, law, long_law, small_maps, stages
from numpy.typing import NDArray
from scipy import ndimage

from vdoor.grid import FREE, OccupancyGrid
from vdoor.method.doors import PROPOSED, ProposeDoors
from vdoor.method.final_map import merged
from vdoor.method.initial_map import InitialMap
from vdoor.method.search.problem import MergeProblem
from vdoor.pipeline import Pipeline
from vdoor.raster.polygons import centres, polygons
from vdoor.raster.runs import runs_of

LONG_DOORS = Pipeline(doors=ProposeDoors(max_length_m=2.4))
Labels = NDArray[Any]

label_images = st.integers(1, 9).flatmap(
    lambda width: st.lists(st.lists(st.integers(0, 3), min_size=width, max_size=width), min_size=1, max_size=9)
)


def covers(initial: InitialMap, line_cell: Labels, line_door: Labels) -> dict[tuple[int, int], frozenset[int]]:
    """Which edges each door cell lies on."""
    edge_of = {door: edge for edge, door in enumerate(initial.door.tolist())}
    found: dict[tuple[int, int], set[int]] = defaultdict(set)
    for (row, col), door in zip(line_cell.tolist(), line_door.tolist(), strict=True):
        if door in edge_of:
            found[row, col].add(edge_of[door])
    return {cell: frozenset(edges) for cell, edges in found.items()}


def opened(free: NDArray[np.bool_], cover: dict[tuple[int, int], frozenset[int]], kept: set[int]) -> Labels:
    """4-connected components (h, w) of the free cells that no kept edge covers."""
    space = free.copy()
    for cell, edges in cover.items():
        space[cell] = not edges & kept
    return np.asarray(ndimage.label(space)[0])


def ring_area(ring: Labels) -> float:
    """Area by the shoelace formula: positive if clockwise as seen, as outer rings run with the wall on the left."""
    row, col = ring.astype(float).T
    return float(np.sum(col[:-1] * row[1:] - col[1:] * row[:-1]) / 2)


def test_two_rooms_and_an_opening_are_two_regions_and_one_edge() -> None:
    found = stages(
        drawn("""
        ###########
        #....#....#
        #....#....#
        #.........#
        #.........#
        #.........#
        #....#....#
        #....#....#
        ###########
        """)
    ).initial
    assert found.area_m2.round(9).tolist() == [28 * 0.04, 28 * 0.04]
    assert found.start.tolist() == [[2, 5]]
    assert found.end.tolist() == [[6, 5]]
    assert found.border_edge.tolist() == [0, 0]
    assert found.border_region.tolist() == [0, 1]
    assert found.atom_area_m2.round(9).tolist() == [3 * 0.04]
    assert found.cover_atom.tolist() == found.cover_edge.tolist() == [0]
    assert list(zip(found.touch_a.tolist(), found.touch_b.tolist(), strict=True)) == [(0, 2), (1, 2)]
    assert found.vertex[found.vertex_region == 0].tolist() == [[1, 1], [1, 5], [8, 5], [8, 1], [1, 1]]
    for region in (0, 1):
        jambs = found.feature_cell[(found.feature_region == region) & found.feature_convex]
        assert sorted(jambs.tolist()) == [[2, 5], [6, 5]]


def test_a_room_without_doors_is_one_region_without_edges() -> None:
    found = stages(drawn("####\n#..#\n#..#\n####")).initial
    assert len(found.door) == len(found.border_edge) == len(found.atom_area_m2) == 0
    assert found.area_m2.round(9).tolist() == [0.16]


def test_a_door_that_parts_nothing_is_no_edge() -> None:
    """A pillar beside a wall: the door between them cuts the floor, but one may walk round the pillar."""
    found = stages(
        drawn("""
        ##########
        #........#
        #........#
        #...##...#
        #...##...#
        #........#
        #........#
        #........#
        #........#
        #........#
        ##########
        """)
    )
    assert (found.doors.verdict == PROPOSED).any()
    assert len(found.initial.idle_door) + len(found.initial.door) == (found.doors.verdict == PROPOSED).sum()


@law
@given(cells=small_maps())
def test_pieces_are_regions_and_atoms_as_a_plain_search_finds_them(cells: Cells) -> None:
    found = stages(OccupancyGrid.from_array(cells, CELL_M), LONG_DOORS)
    initial, free = found.initial, found.simplified.cells == FREE
    cover = covers(initial, found.doors.line_cell, found.doors.line_door)
    regions = len(initial.area_m2)
    np.testing.assert_array_equal(
        np.where(initial.piece <= regions, initial.piece, 0), opened(free, cover, set(range(len(initial.door))))
    )
    assert (initial.piece > 0).tolist() == free.tolist()
    atoms = 0
    for edges in set(cover.values()):
        mask = np.zeros(free.shape, np.bool_)
        mask[tuple(np.array([cell for cell, own in cover.items() if own == edges]).T)] = True
        label, count = ndimage.label(mask)
        for number in range(1, count + 1):
            piece = np.unique(initial.piece[label == number])
            assert len(piece) == 1
            atom = int(piece[0]) - 1 - regions
            assert set(initial.cover_edge[initial.cover_atom == atom].tolist()) == edges
            assert (initial.piece == piece[0]).sum() == (label == number).sum()
        atoms += count
    assert atoms == len(initial.atom_area_m2)
    areas = np.bincount(initial.piece[free] - 1, minlength=regions + atoms) * CELL_M**2
    np.testing.assert_allclose(np.append(initial.area_m2, initial.atom_area_m2), areas, rtol=0, atol=1e-9)


@law
@given(cells=small_maps())
def test_touches_and_borders_are_what_lies_side_by_side(cells: Cells) -> None:
    found = stages(OccupancyGrid.from_array(cells, CELL_M), LONG_DOORS).initial
    piece, regions = found.piece, len(found.area_m2)
    pairs = set()
    for one, other in ((piece[:-1], piece[1:]), (piece[:, :-1], piece[:, 1:])):
        differ = (one != other) & (one > 0) & (other > 0)
        pairs |= {
            (min(a, b) - 1, max(a, b) - 1) for a, b in zip(one[differ].tolist(), other[differ].tolist(), strict=True)
        }
    assert sorted(pairs) == list(zip(found.touch_a.tolist(), found.touch_b.tolist(), strict=True))
    assert (found.touch_b >= regions).all()
    for edge in range(len(found.door)):
        own = {int(atom) + regions for atom in found.cover_atom[found.cover_edge == edge]}
        beside = {a for a, b in pairs if b in own and a < regions}
        border = set(found.border_region[found.border_edge == edge].tolist())
        assert beside <= border
        assert len(border) >= 2
        if len(beside) >= 2:
            assert beside == border


@long_law
@given(cells=small_maps(most=26), data=st.data())
def test_merging_is_relabelling_with_the_kept_doors_closed(cells: Cells, data: st.DataObject) -> None:
    """Rooms are the open components that hold a region; crossing doors keep their common cell closed."""
    found = stages(OccupancyGrid.from_array(cells, CELL_M), LONG_DOORS)
    initial, free = found.initial, found.simplified.cells == FREE
    problem = MergeProblem(initial, Pipeline().cost)
    removed = np.array(data.draw(st.lists(st.booleans(), min_size=problem.edges, max_size=problem.edges)), np.bool_)
    cover = covers(initial, found.doors.line_cell, found.doors.line_door)
    room, is_open = problem.rooms(removed[None])
    kept = set(np.flatnonzero(~removed).tolist())
    plain = opened(free, cover, kept)
    node = np.append(np.arange(problem.regions), problem.node_of_atom)
    label_of_piece = np.where(is_open[0, node], room[0, node] + 1, 0)
    assert_same_parts(np.append(0, label_of_piece)[initial.piece], plain)

    in_region = (initial.piece > 0) & (initial.piece <= problem.regions)
    rooms = np.unique(plain[in_region])
    cells_of_room = np.array([(plain == label).sum() for label in rooms])
    area_m2 = cells_of_room * CELL_M**2
    costs = problem.evaluate(removed[None])
    assert costs.small_rooms[0] == (cells_of_room < 50).sum()
    np.testing.assert_allclose(costs.area_sd_m2[0], np.sqrt(np.mean((area_m2 - 2.0) ** 2)), atol=1e-9)
    tilt_deg = np.degrees(initial.tilt_rad[~removed])
    tilt_sd_deg = np.sqrt(np.mean(tilt_deg**2)) if len(tilt_deg) else 0.0
    np.testing.assert_allclose(costs.tilt_sd_deg[0], tilt_sd_deg, atol=1e-5)
    assert costs.cost[0] == costs.small_rooms[0] + 0.05 * costs.area_sd_m2[0] + 0.05 * costs.tilt_sd_deg[0]


def assert_same_parts(one: Labels, other: Labels) -> None:
    """Both label images divide the same cells in the same way, whatever the numbers."""
    np.testing.assert_array_equal(one > 0, other > 0)
    pairs = np.unique(np.stack([one[one > 0], other[one > 0]]), axis=1)
    assert len(np.unique(pairs[0])) == len(np.unique(pairs[1])) == pairs.shape[1]


@long_law
@given(cells=small_maps(most=26), data=st.data())
def test_every_door_that_stays_parts_two_rooms_and_says_which(cells: Cells, data: st.DataObject) -> None:
    """With all other doors that stay closed, opening one joins exactly the rooms that its rows name."""
    found = stages(OccupancyGrid.from_array(cells, CELL_M), LONG_DOORS)
    initial, free = found.initial, found.simplified.cells == FREE
    problem = MergeProblem(initial, Pipeline().cost)
    removed = np.array(data.draw(st.lists(st.booleans(), min_size=problem.edges, max_size=problem.edges)), np.bool_)
    room_of_piece, rows = merged(problem, removed)
    cover = covers(initial, found.doors.line_cell, found.doors.line_door)
    kept = {edge for edge, _, _ in rows}
    assert not kept & set(np.flatnonzero(removed).tolist())
    closed = opened(free, cover, kept)
    room_of_cell = np.append(0, room_of_piece)[initial.piece]
    in_room = room_of_cell > 0
    assert_same_parts(np.where(in_room, room_of_cell, 0), np.where(in_room, closed, 0))
    for edge in kept:
        joined = opened(free, cover, kept - {edge})
        together = defaultdict(set)
        for label, room in zip(joined[in_room].tolist(), room_of_cell[in_room].tolist(), strict=True):
            together[label].add(room)
        pairs = {(a, b) for rooms in together.values() for a in rooms for b in rooms if a < b}
        assert pairs == {(a, b) for other, a, b in rows if other == edge}
        assert pairs


@law
@given(image=label_images)
def test_rings_enclose_their_label_and_nothing_else(image: list[list[int]]) -> None:
    """For labels that are 4-connected, as regions and rooms are."""
    label = np.zeros(np.array(image).shape, np.int32)
    for value in (1, 2, 3):
        part, _ = ndimage.label(np.array(image) == value)
        label = np.where(part > 0, part + label.max(), label).astype(np.int32)
    vertex, owner, ring = polygons(runs_of(label))
    for number in np.unique(label[label > 0]).tolist():
        parts = [vertex[(owner == number) & (ring == part)] for part in np.unique(ring[owner == number])]
        assert all((part[0] == part[-1]).all() for part in parts)
        assert sum(map(ring_area, parts)) == (label == number).sum()
        for part in parts:
            assert shapely.LinearRing(part).is_simple
            steps = np.abs(np.diff(part, axis=0))
            assert (steps.min(axis=1) == 0).all()
            assert (steps.max(axis=1) > 0).all()
            assert (np.diff(steps.argmax(axis=1)) != 0).all()  # every vertex is a bend
    assert sorted(set(owner.tolist())) == np.unique(label[label > 0]).tolist()


@law
@given(image=label_images)
def test_rings_of_labels_in_several_parts_are_a_valid_polygon_for_each_part_the_largest_first(
    image: list[list[int]],
) -> None:
    label = np.array(image, np.int32)
    vertex, owner, ring = polygons(runs_of(label))
    for number in np.unique(label[label > 0]).tolist():
        rings = [vertex[(owner == number) & (ring == own)] for own in np.unique(ring[owner == number])]
        begins = [at for at, own in enumerate(rings) if ring_area(own) > 0]
        found = [shapely.Polygon(*rings_of_part(rings[a:b])) for a, b in pairwise([*begins, len(rings)])]
        part, _ = ndimage.label(label == number)
        assert begins[0] == 0
        assert all(polygon.is_valid for polygon in found)
        assert [polygon.area for polygon in found] == sorted(np.bincount(part.ravel())[1:].tolist(), reverse=True)
        assert shapely.union_all(found).area == (label == number).sum()


def rings_of_part(rings: list[Labels]) -> tuple[Labels, list[Labels]]:
    return rings[0], rings[1:]


@law
@given(cells=small_maps(), cut=st.booleans())
def test_polygons_with_holes_are_valid_and_cover_their_region(cells: Cells, cut: bool) -> None:
    found = stages(OccupancyGrid.from_array(cells, CELL_M), LONG_DOORS if cut else None).initial
    for region in range(len(found.area_m2)):
        own = found.vertex_region == region
        rings = [found.vertex[own & (found.vertex_ring == ring)] for ring in np.unique(found.vertex_ring[own])]
        polygon = shapely.Polygon(rings[0], rings[1:])
        assert polygon.is_valid
        assert polygon.area == (found.piece == region + 1).sum()
        row, col = found.centre[region].tolist()
        assert polygon.contains(shapely.Point(row + 0.5, col + 0.5))


@law
@given(image=label_images)
def test_a_centre_is_the_labels_own_cell_nearest_to_its_mean(image: list[list[int]]) -> None:
    label = np.array(image, np.int32)
    label = np.searchsorted(np.unique(np.append(0, label)), label).astype(np.int32)
    count = int(label.max())
    for number, centre in enumerate(centres(runs_of(label), count).tolist(), start=1):
        own = np.argwhere(label == number)
        off = np.hypot(*(own - own.mean(axis=0)).T)
        assert label[tuple(centre)] == number
        assert np.hypot(*(centre - own.mean(axis=0))) <= off.min() + 1e-9
