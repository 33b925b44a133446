"""Simplification: what goes, what stays, and the reason given."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from maps import CELL_M, Cells, cells_drawn, drawn, law, simplifying, small_maps, text_of
from scipy import ndimage

from vdoor.errors import MapError
from vdoor.grid import FREE, OCCUPIED, UNKNOWN, OccupancyGrid
from vdoor.method.simplify import REASONS, SimplifiedGrid, SimplifyGrid, working_frame

NEVER = {"passes": 0}


def simplified(text: str, map_m: float = CELL_M, **settings: Any) -> SimplifiedGrid:
    return simplifying(**settings).simplify(drawn(text, map_m))


def assert_becomes(before: str, after: str, **settings: Any) -> SimplifiedGrid:
    found = simplified(before, **settings)
    assert text_of(found.cells) == text_of(cells_drawn(after))
    return found


def reasons(found: SimplifiedGrid) -> dict[str, int]:
    return {
        name: int((found.reason == code).sum())
        for code, name in enumerate(REASONS)
        if code and (found.reason == code).any()
    }


def test_the_largest_component_stays_and_all_it_does_not_touch_becomes_unknown() -> None:
    found = assert_becomes(
        """
        ##########
        #...#....#
        #...#....#
        ##########
        ??????####
        """,
        """
        ????######
        ????#....#
        ????#....#
        ????######
        ??????????
        """,
    )
    assert reasons(found) == {"unreachable": 3 * 4 + 4 + 4}


def test_components_are_4_connected() -> None:
    found = assert_becomes("..#\n..#\n##.", "..#\n..#\n##?")
    assert reasons(found) == {"unreachable": 1}


def test_the_robot_says_which_component_is_reachable() -> None:
    text = "#####\n#.#.#\n#.#.#\n#.###\n#####"
    assert_becomes(text, "??###\n??#.#\n??#.#\n??###\n?????", robot_m=(0.7, 0.7))
    assert_becomes(text, "###??\n#.#??\n#.#??\n#.#??\n###??", robot_m=(0.3, 0.3))


def test_a_robot_in_a_wall_takes_the_free_cell_within_half_a_metre() -> None:
    text = "...####\n...####\n...####"
    assert simplified(text, robot_m=(0.9, 0.3)).cells[0, 0] == FREE
    with pytest.raises(MapError, match=r"robot at 1\.3,0\.3: wanted a free cell within 0\.5 m, found none"):
        simplified(text, robot_m=(1.3, 0.3))


@pytest.mark.parametrize("place", ["before", "beside"])
def test_a_jut_of_one_cell_is_flattened_at_20_cm(place: str) -> None:
    wall = "...#.." if place == "before" else "..##.."
    found = simplified(f"......\n......\n{wall}\n######\n######")
    assert reasons(found).get("jut", 0) == (1 if place == "before" else 0)


def test_a_notch_of_one_cell_is_filled_at_20_cm() -> None:
    found = assert_becomes(
        "......\n......\n###.##\n######",
        "......\n......\n######\n??????",
    )
    assert reasons(found) == {"notch": 1, "unreachable": 6}


@pytest.mark.parametrize(("length", "flattened"), [(1, 1), (2, 2), (3, 3), (4, 0)])
def test_runs_of_three_are_flattened_at_5_cm(length: int, flattened: int) -> None:
    jut = "....." + "#" * length + "." * (9 - length)
    notch = jut.translate(str.maketrans(".#", "#."))
    row = "." * 14
    assert reasons(simplified(f"{row}\n{row}\n{jut}\n{'#' * 14}", 0.05, cell_m=0.05)).get("jut", 0) == flattened
    assert reasons(simplified(f"{row}\n{row}\n{notch}\n{'#' * 14}", 0.05, cell_m=0.05)).get("notch", 0) == flattened


@pytest.mark.parametrize("cell_m", [0.2, 0.05])
@pytest.mark.parametrize("thick", [1, 2])
def test_door_jambs_are_never_eaten(cell_m: float, thick: int) -> None:
    """Jambs one cell long at the side walls, and a wall end in the middle of the room."""
    wall = "#" + "." * 4 + "#######" + "." * 4 + "#"
    jamb = "##" + "." * 4 + "#####" + "." * 4 + "##"
    room = "#" + "." * 15 + "#"
    text = "\n".join(["#" * 17, *[room] * 4, *[jamb] * thick, *[room] * 3, *[wall] * thick, *[room] * 4, "#" * 17])
    found = simplified(text, cell_m, cell_m=cell_m)
    inner = found.cells[5 : 8 + 2 * thick]
    before = drawn(text, cell_m).cells[5 : 8 + 2 * thick]
    assert (inner[:, 4:13] == before[:, 4:13]).all()


def test_a_jut_at_the_end_of_a_wall_stays() -> None:
    """The wall must go on past both ends of the run."""
    text = "......\n......\n....##\n....##\n######"
    assert "jut" not in reasons(simplified(text))


@pytest.mark.parametrize(("most_m", "gone"), [(0.0, 0), (0.4, 0), (0.6, 6), (1.0, 6)])
def test_islands_are_removed_by_the_longer_side_of_their_box(most_m: float, gone: int) -> None:
    text = "........\n........\n..###...\n..###...\n........\n........"
    assert reasons(simplified(text, max_island_m=most_m)).get("island", 0) == gone


def test_what_touches_the_outer_wall_is_no_island_even_by_a_corner() -> None:
    text = "########\n#......#\n#......#\n#..#...#\n#.#....#\n########"
    assert_becomes(text, text, max_island_m=1.0, passes=0)


def test_an_island_takes_the_free_cells_it_encloses_with_it() -> None:
    text = "........\n.####...\n.#..#...\n.#..#...\n.####...\n........"
    found = simplified(text, max_island_m=0.8)
    assert (found.cells == FREE).all()
    assert reasons(found) == {"island": 12}  # the free cells inside are what they were


@pytest.mark.parametrize(
    ("cell_m", "map_m", "factor"), [(0.2, 0.05, 4), (0.2, 0.2, 1), (0.0, 0.05, 1), (0.05, 0.2, 1), (0.2, 0.07, 3)]
)
def test_the_working_cell_is_the_nearest_multiple_of_the_maps(cell_m: float, map_m: float, factor: int) -> None:
    grid = OccupancyGrid.from_array(np.zeros((12, 13), np.int8), map_m)
    found = SimplifyGrid(cell_m=cell_m)(grid)
    assert found.factor == factor
    assert found.cells.shape == (-(-12 // factor), -(-13 // factor))
    assert found.frame.resolution_m == pytest.approx(map_m * factor)


@pytest.mark.parametrize(
    ("block", "wanted"), [("..\n..", "."), ("#.\n..", "#"), ("?.\n??", "."), ("??\n??", "?"), ("#?\n??", "#")]
)
def test_a_working_cell_is_occupied_if_any_cell_is_else_free_if_any_is(block: str, wanted: str) -> None:
    lines = block.split()
    text = "\n".join(line + ".." * 3 for line in lines) + "\n" + "\n".join(["........"] * 2)
    found = simplifying(**NEVER).simplify(drawn(text, 0.1))
    assert text_of(found.cells)[0] == wanted


def test_thresholds_are_nav2s() -> None:
    cells = np.array([[0, 19, 20, 64, 65, 100, -1, 0], [0] * 8], np.int8)
    found = simplifying(**NEVER).simplify(OccupancyGrid.from_array(cells, CELL_M))
    assert text_of(found.cells).splitlines()[0] == "..??##?."


def test_the_working_frame_covers_the_same_ground() -> None:
    grid = OccupancyGrid.from_array(np.zeros((10, 11), np.int8), 0.05, x_m=1.0, y_m=2.0, yaw_rad=0.3)
    coarse = working_frame(grid.frame, 4)
    upper_left = np.array([[-0.5, -0.5]])
    np.testing.assert_allclose(grid.frame.world_from_cell(upper_left), coarse.world_from_cell(upper_left), atol=1e-12)
    one, other = np.array([[7.5, 7.5]]), np.array([[1.5, 1.5]])
    np.testing.assert_allclose(grid.frame.world_from_cell(one), coarse.world_from_cell(other), atol=1e-12)


@law
@given(cells=small_maps(), island_m=st.sampled_from([0.0, 0.6]), factor=st.sampled_from([1, 2]))
def test_what_is_free_hangs_together_is_walled_and_has_reasons(cells: Cells, island_m: float, factor: int) -> None:
    grid = OccupancyGrid.from_array(cells, CELL_M / factor)
    try:
        found = simplifying(max_island_m=island_m).simplify(grid)
    except MapError:
        return  # no working cell is free
    free = found.cells == FREE
    assert ndimage.label(free)[1] == 1
    near = ndimage.binary_dilation(free, np.ones((3, 3), np.bool_))
    assert (near[found.cells == OCCUPIED]).all()
    untouched = simplifying(passes=0).simplify(grid)
    same = (found.reason == 0) & (untouched.reason == 0)
    assert (found.cells[same] == untouched.cells[same]).all()
    assert (found.cells[found.reason == REASONS.index("unreachable")] == UNKNOWN).all()
    assert (found.cells[found.reason == REASONS.index("notch")] != FREE).all()
    for name in ("jut", "island"):
        assert (found.cells[found.reason == REASONS.index(name)] == FREE).all()
