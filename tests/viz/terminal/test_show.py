"""`vdoor show`: plain text in a pipe, and the screen of a real pseudo-terminal."""

from __future__ import annotations

import io
from collections import Counter
from pathlib import Path

import numpy as np
import pytest
from commands import call
from maps import drawn
from rich.console import Console
from terminals import Screen, history, recorded, terminal
from two_rooms import PROVEN, TWO_ROOMS

from vdoor.grid import OccupancyGrid
from vdoor.method.doors import VERDICTS, VirtualDoors
from vdoor.method.simplify import SimplifyGrid
from vdoor.pipeline import Pipeline
from vdoor.synth import PRESETS, synthesize
from vdoor.viz.terminal.canvas import CODE, INKS, Canvas
from vdoor.viz.terminal.picture import Picture, colour

PAPER = [record.topic for record in Pipeline().records]


@pytest.fixture(scope="module")
def two_rooms(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return recorded(tmp_path_factory.mktemp("two"), drawn(TWO_ROOMS), PROVEN)


@pytest.fixture(scope="module")
def apartment(tmp_path_factory: pytest.TempPathFactory) -> Path:
    made = synthesize(PRESETS["paper"], np.random.default_rng(3))
    return recorded(tmp_path_factory.mktemp("apartment"), made.grid)


def hex_of(ink: str) -> str:
    return INKS[CODE[ink]].colour.removeprefix("#")


def pixels(screen: Screen) -> Counter[str]:
    """Colours of all half blocks on the screen, two to a character."""
    cells = [screen.seen.buffer[row][col] for row in range(screen.seen.lines) for col in range(screen.seen.columns)]
    return Counter(part for cell in cells if cell.data == "▀" for part in (cell.fg, cell.bg))


def test_grid_in_a_pipe_is_the_drawing_with_two_letters_a_cell(two_rooms: Path) -> None:
    lines = call("show", two_rooms, "--stage", "simplified").stdout.splitlines()
    wanted = ["".join(sign * 2 for sign in row) for row in TWO_ROOMS.split()]
    at = lines.index(wanted[0])
    assert lines[at : at + len(wanted)] == wanted


def test_rooms_in_a_pipe_are_their_numbers_and_the_door_lies_between(two_rooms: Path) -> None:
    lines = call("show", two_rooms, "--stage", "map").stdout.splitlines()
    wanted = [row.replace(".", "1") for row in TWO_ROOMS.split()]
    rows = [row[:11] + row[11:].replace("1", "2") for row in wanted]
    rows[5:9] = [row[:10] + "=" + row[11:] for row in rows[5:9]]
    at = next(number for number, line in enumerate(lines) if line.startswith("####"))
    assert lines[at : at + len(rows)] == ["".join(sign * 2 for sign in row) for row in rows]


def test_pipe_gets_no_escape_codes_and_every_stage(apartment: Path) -> None:
    text = call("show", apartment, "--stage", "all").stdout
    assert "\x1b" not in text
    assert [line.split()[0] for line in text.splitlines() if "(step " in line] == PAPER


def test_every_door_is_a_row_with_its_verdict_and_length(apartment: Path) -> None:
    doors = history(apartment).doors
    lines = call("show", apartment, "--stage", "doors").stdout.splitlines()
    rows = {
        int(line.split()[0]): line for line in lines if line.split() and line.split()[0].isdigit() and "pair" in line
    }
    for door, verdict in enumerate(doors.verdict.tolist()):
        if door in rows:
            assert VERDICTS[verdict] in rows[door]
            assert f" {doors.length_m[door]:.2f} " in rows[door]
    assert len(rows) == (doors.kind == 0).sum() > 10


def test_one_generation_is_drawn_and_reckoned_up_by_its_step(apartment: Path) -> None:
    run = history(apartment)
    generation = run.search[5]
    text = call("show", apartment, "--step", str(run.steps["generation"] + 5)).stdout
    assert f"cost {generation.best_cost:.6f} = " in text
    assert "".join("01"[bit] for bit in generation.removed.astype(int)) in text
    assert call("show", apartment, "--step", str(run.steps["corners"])).stdout.splitlines()[1].startswith("corners ")


def test_search_lists_the_generations_in_which_the_best_string_changed(apartment: Path) -> None:
    run = history(apartment)
    strings = [generation.removed.tobytes() for generation in run.search]
    changed = [0] + [at for at in range(1, len(strings)) if strings[at] != strings[at - 1]]
    lines = call("show", apartment, "--stage", "generation").stdout.splitlines()
    begin = next(number for number, line in enumerate(lines) if line.startswith("generation  evaluations"))
    assert [int(line.split()[0]) for line in lines[begin + 1 :]] == changed
    assert f"best string, 1 = removed: {''.join('01'[bit] for bit in run.search[-1].removed.astype(int))}" in lines


@pytest.mark.parametrize(("columns", "lines"), [(80, 24), (120, 40)])
def test_terminal_shows_the_map_in_colour_within_its_size(two_rooms: Path, columns: int, lines: int) -> None:
    with terminal(["show", two_rooms, "--stage", "simplified"], columns=columns, lines=lines) as screen:
        assert screen.end() == 0
        zoom = min(columns // 21, (lines - 6) * 2 // 14, 4)
        count = TWO_ROOMS.count("#")
        assert pixels(screen) == {hex_of("wall"): count * zoom**2, hex_of("free"): (21 * 14 - count) * zoom**2}
        assert "simplified grid" in screen.text
        assert "wall" in screen.text


def test_terminal_shows_rooms_doors_and_their_numbers(two_rooms: Path) -> None:
    with terminal(["show", two_rooms, "--stage", "map"], columns=80, lines=40) as screen:
        assert screen.end() == 0
        seen = pixels(screen)
        zoom = 3
        assert seen[hex_of("door")] == 4 * zoom**2
        rooms = [seen[colour(len(INKS) + room).removeprefix("#")] for room in (1, 2)]
        hidden = 4  # a number covers pixels
        assert all(9 * 12 * zoom**2 - hidden <= room <= 9 * 12 * zoom**2 for room in rooms)
        assert [line.split()[:2] for line in screen.text.splitlines() if " pair " in line] == [["1", "1"]]


def test_big_map_is_reduced_with_its_walls_and_doors_and_says_so(tmp_path: Path) -> None:
    cells = np.zeros((400, 600), np.int8)
    cells[[0, -1], :] = cells[:, [0, -1]] = cells[:, 299] = 100
    cells[190:210, 299] = 0
    path = recorded(tmp_path, OccupancyGrid.from_array(cells, 0.05), Pipeline(simplify=SimplifyGrid(cell_m=0.05)))
    with terminal(["show", path, "--stage", "map"], columns=80, lines=40) as screen:
        assert screen.end() == 0
        assert "one pixel is 8 x 8 cells" in screen.text
        seen = pixels(screen)
        assert seen[hex_of("door")] >= 2
        assert seen[hex_of("wall")] >= 2 * 75 + 2 * 48 + 44
    assert "one letter is 5 x 10 cells" in call("show", path, "--stage", "map").stdout


def test_overview_says_what_was_recorded_and_where_it_ends(tmp_path: Path, apartment: Path) -> None:
    text = call("show", apartment).stdout
    for topic in PAPER:
        assert f" {topic} " in text
    short = recorded(tmp_path, drawn(TWO_ROOMS), PROVEN, until=VirtualDoors)
    done = call("show", short)
    assert "ends before the final map" in done.stderr
    assert "incomplete" in done.stdout
    assert "doors  virtual doors" in done.stdout


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (["--stage", "cellar"], "'cellar'"),
        (["--step", "999"], "0 to"),
        (["--stage", "doors", "--step", "0"], "belongs to input"),
    ],
)
def test_wrong_use_is_one_line_and_exit_code_2(two_rooms: Path, words: list[str], says: str) -> None:
    error = call("show", two_rooms, *words, code=2).stderr
    assert says in error
    assert len(error.splitlines()) == 1


def test_what_tells_more_stays_whatever_is_drawn_first() -> None:
    ground = np.zeros((3, 3), np.int8)
    one = Canvas.of(ground).paint("door", np.array([[1, 1]])).paint("wall", np.array([[1, 1], [0, 0], [-1, 5]]))
    other = Canvas.of(ground).paint("wall", np.array([[1, 1], [0, 0]])).paint("door", np.array([[1, 1]]))
    assert np.array_equal(one.inks, other.inks)
    assert one.inks[1, 1] == CODE["door"]


def test_letter_for_two_cells_is_the_more_telling_one() -> None:
    canvas = Canvas.of(np.array([[0, 100, 0], [100, 0, 0]], np.int8)).paint("door", np.array([[1, 1]]))
    printed = io.StringIO()
    Console(file=printed, width=3).print(Picture(canvas, most_lines=5))
    assert printed.getvalue().splitlines()[0] == "#=."
