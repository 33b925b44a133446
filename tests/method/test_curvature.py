"""Curvature by eq. 1 to 5 against plain loops and by hand."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from maps import CELL_M, Cells, drawn, law, simplifying, small_maps

from vdoor.grid import OccupancyGrid
from vdoor.method.boundary import BoundaryPath, TraceBoundary
from vdoor.method.curvature import Curvature, EstimateCurvature

SQUARE = "######\n#....#\n#....#\n#....#\n#....#\n######"
WALL_TIP = "\n".join(["#########", *["#.......#"] * 4, *["#...#...#"] * 6, "#########"])


def path_of(cells: Cells, cell_m: float) -> BoundaryPath:
    return TraceBoundary()(simplifying(cell_m=cell_m).simplify(OccupancyGrid.from_array(cells, cell_m)))


def drawn_path(text: str) -> BoundaryPath:
    return TraceBoundary()(simplifying().simplify(drawn(text)))


def at(path: BoundaryPath, *cell: int) -> int:
    """The one sample at a cell."""
    (sample,) = np.flatnonzero((path.cell == cell).all(axis=1))
    return int(sample)


def plain_reach(ring: list[list[int]], start: int, direction: int, *, straightness: float, reach: float) -> int:
    """The largest K whose straight distance is over U_k times the path length, in half cells (eq. 1, 2)."""
    best, length, at_ = 0, 0.0, start
    for k in range(1, len(ring) // 2 + 1):
        after = (start + direction * k) % len(ring)
        length += math.dist(ring[at_], ring[after])
        at_ = after
        if length <= reach + 1e-7 and math.dist(ring[start], ring[after]) > straightness * length + 1e-12:
            best = k
    return best


@law
@given(
    cells=small_maps(),
    cell_m=st.sampled_from([0.2, 0.05]),
    straightness=st.sampled_from([0.9, 0.8, 0.95]),
    reach_m=st.sampled_from([0.3, 1.0, 100.0]),
)
def test_neighbours_and_vectors_follow_the_equations(
    cells: Cells, cell_m: float, straightness: float, reach_m: float
) -> None:
    path = path_of(cells, cell_m)
    found = EstimateCurvature(straightness=straightness, reach_m=reach_m)(path)
    reach = 2 * reach_m / cell_m
    for group in np.split(np.arange(len(path.cell)), path.first[1:]):
        ring = path.half[group].tolist()
        for index, sample in enumerate(group.tolist()):
            ahead, back = (plain_reach(ring, index, way, straightness=straightness, reach=reach) for way in (1, -1))
            assert (found.k_forward[sample], found.k_backward[sample]) == (ahead, back)
            forward = np.subtract(ring[(index + ahead) % len(ring)], ring[index])  # eq. 3
            backward = np.subtract(ring[(index - back) % len(ring)], ring[index])  # eq. 4
            assert found.forward[sample].tolist() == forward.tolist()
            assert found.backward[sample].tolist() == backward.tolist()
            assert found.angle_rad[sample] == pytest.approx(plain_angle(forward.tolist(), backward.tolist()), abs=1e-7)


def plain_angle(forward: list[int], backward: list[int]) -> float:
    """Eq. 5 by the cosine, from rationals; a sample without neighbours does not bend."""
    size = Fraction(sum(x * x for x in forward) * sum(x * x for x in backward))
    if size == 0:
        return math.pi
    product = Fraction(sum(a * b for a, b in zip(forward, backward, strict=True)))
    if product**2 == size:
        return 0.0 if product > 0 else math.pi
    return math.acos(float(product) / math.sqrt(size))


def test_a_corner_of_a_square_room_is_as_computed_by_hand() -> None:
    """At the west end of the north wall of 4 cells, walking east; samples cut the corners: (0, 4), then (1, 5).

    Ahead: 3 cells of wall, then (1, 5): 4.12 cells apart by a path of 4.41, over 0.9; one more would be over 1 m.
    Behind: (1, 0), (2, 0), (3, 0), (4, 0): 4.12 cells apart by a path of 4.41.
    """
    path = drawn_path(SQUARE)
    found = EstimateCurvature()(path)
    sample = at(path, 0, 1)
    assert (found.k_forward[sample], found.k_backward[sample]) == (4, 4)
    assert found.forward[sample].tolist() == [2, 8]
    assert found.backward[sample].tolist() == [8, -2]
    assert found.angle_rad[sample] == pytest.approx(math.pi / 2)
    assert found.rho_per_deg[sample] == pytest.approx(1 / 90)


def test_the_tip_of_a_thin_wall_has_angle_0_and_infinite_rho() -> None:
    path = drawn_path(WALL_TIP)
    found = EstimateCurvature()(path)
    sample = at(path, 5, 4)
    assert found.forward[sample].tolist() == [10, 0]
    assert found.forward[sample].tolist() == found.backward[sample].tolist()
    assert found.angle_rad[sample] == 0
    assert found.rho_per_deg[sample] == np.inf


def test_a_straight_wall_has_angle_pi() -> None:
    path = drawn_path("\n".join(["#" * 24, *["#" + "." * 22 + "#"] * 12, "#" * 24]))
    found: Curvature = EstimateCurvature()(path)
    middle = (path.cell[:, 0] == 0) & (path.cell[:, 1] > 7) & (path.cell[:, 1] < 16)
    assert middle.any()
    assert (found.angle_rad[middle] == np.pi).all()
    assert found.rho_per_deg[middle].tolist() == pytest.approx([1 / 180] * int(middle.sum()))
    assert (found.k_forward[middle] == 5).all()  # 1 m of 20 cm


def test_a_contour_of_one_sample_does_not_bend() -> None:
    path = drawn_path(".....\n.....\n..#..\n.....\n.....")
    found = EstimateCurvature()(path)
    pillar = at(path, 2, 2)
    assert found.k_forward[pillar] == found.k_backward[pillar] == 0
    assert found.angle_rad[pillar] == np.pi


def test_a_contour_of_two_samples_folds_back_at_both() -> None:
    path = drawn_path("......\n......\n..##..\n......\n......")
    found = EstimateCurvature()(path)
    for col in (2, 3):
        assert found.angle_rad[at(path, 2, col)] == 0


@pytest.mark.parametrize("slope", [Fraction(1, 7), Fraction(2, 5), Fraction(3, 4), Fraction(1)])
def test_digital_lines_of_any_slope_are_straight(slope: Fraction) -> None:
    """Away from its ends a slanting wall has no sample below 155 degrees."""
    rows, cols = np.indices((60, 60))
    cells = np.where(rows > 8 + cols * float(slope) * 0.7, 100, 0).astype(np.int8)
    path = path_of(cells, CELL_M)
    found = EstimateCurvature()(path)
    inner = (path.cell[:, 1] > 8) & (path.cell[:, 1] < 50) & (path.cell[:, 0] > 1)
    assert inner.sum() > 30
    assert np.degrees(found.angle_rad[inner]).min() >= 155
