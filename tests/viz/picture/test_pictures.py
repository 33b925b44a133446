"""Pictures of `shot` and of the pages: what is drawn where, and that they show what they did."""

from __future__ import annotations

import io
import sys
from itertools import combinations
from pathlib import Path
from typing import Annotated, ClassVar

import numpy as np
import pytest
from commands import call
from numpy.typing import NDArray
from PIL import Image
from project import HOME

from vdoor.frame import Frame
from vdoor.history import History
from vdoor.history.records import RunRecords
from vdoor.method.boundary import BoundaryPath
from vdoor.pipeline import RECORDS
from vdoor.record import Record, Spec
from vdoor.recording.mcap import read_recording
from vdoor.viz.marks.kinds import Arrows, Cells, Chart, Curve, Dots, Lines, Mark, reduced, wrapped
from vdoor.viz.marks.plots import limits
from vdoor.viz.marks.table import marks_of
from vdoor.viz.picture.layout import MARGIN, Box, Wanted, flowed, free_places, laid_out
from vdoor.viz.picture.pictures import head_px, layout_of, picture_of, pictures
from vdoor.viz.picture.plan import Window, entries, fitted, round_length_m
from vdoor.viz.picture.views import Plan, View

sys.path.insert(0, str(HOME / "docs"))
import pictures as kept_pictures

GOLDEN = HOME / "recordings" / "golden" / "furnished.mcap"
FRAME = Frame(40, 60, 0.05, x_m=-3.0, y_m=7.0, yaw_rad=0.3)
RED, BLUE = (214, 50, 60), (36, 92, 230)


def pixels(png: bytes) -> NDArray[np.int16]:
    return np.asarray(Image.open(io.BytesIO(png)).convert("RGB"), np.int16)


def near(picture: NDArray[np.int16], colour: tuple[int, ...]) -> NDArray[np.intp]:
    """Rows and columns of the pixels (k, 2) of about a colour."""
    return np.argwhere(np.abs(picture - colour).max(axis=2) < 24)


def drawn(*marks: Mark, size: tuple[int, int] = (700, 500), frame: Frame = FRAME) -> NDArray[np.int16]:
    window = Window.around(frame, np.ones((frame.height, frame.width), np.bool_))
    return pixels(picture_of(View("", "", [Plan("", [*marks])]), window, size))


@pytest.fixture(scope="module")
def kept() -> dict[str, bytes]:
    return dict(kept_pictures.kept())


def test_kept_pictures_show_what_is_drawn_today(kept: dict[str, bytes]) -> None:
    """They are made by `python docs/pictures.py`, and looked at; text and edges may differ between versions."""
    for path, png in kept.items():
        seen, reference = pixels(png), pixels((HOME / path).read_bytes())
        assert seen.shape == reference.shape, path
        assert (np.abs(seen - reference).max(axis=2) > 48).mean() < 0.02, path


def test_kept_pictures_are_small_and_none_is_left_over(kept: dict[str, bytes]) -> None:
    paths = [HOME / kept_pictures.OVERVIEW, *(HOME / kept_pictures.REFERENCES).glob("*.png")]
    assert {path.name for path in paths} == {Path(path).name for path in kept}
    assert max(path.stat().st_size for path in paths) < 40_000


@pytest.mark.parametrize("charts", [0, 1, 2])
def test_headings_have_the_room_that_they_need(charts: int) -> None:
    """Whatever the map's shape: a picture narrower than it was when its heading was measured needs more lines."""
    view = View("Tab", "a sentence that says what is seen " * 4, [])
    for height in range(10, 90):
        window = Window.around(Frame(height, 60, 0.05), np.ones((height, 60), np.bool_))
        for plans in ([Plan("", [])], [Plan("One", []), Plan("Other", [])]):
            layout = layout_of(view, plans, [[]] * len(plans), charts, window=window, size=(1600, 1000))
            title_px = 19.0 if plans[0].title else 0.0
            assert layout.maps[0].top - title_px - MARGIN >= head_px(view, layout.width)


def test_arrows_of_the_walk_lie_along_the_walls() -> None:
    """At a turn they would point through one."""
    run = History.read(read_recording(HOME / "recordings" / "golden" / "default-home.mcap", types=RECORDS))
    (arrows,) = (mark for mark in marks_of(run, BoundaryPath) if isinstance(mark, Arrows))
    for end in (arrows.cell, arrows.cell + arrows.vector):
        away = np.linalg.norm(end[:, None] - (run.path.half / 2 - 0.5), axis=2).min(axis=1)
        assert np.quantile(away, 0.9) < 1


def test_marks_of_another_frame_lie_where_they_are_in_the_map() -> None:
    """The middle of four cells is that of a cell twice as large, in a frame of the same pose."""
    coarse = Frame(20, 30, 0.1, FRAME.x_m, FRAME.y_m, FRAME.yaw_rad)
    one = drawn(Dots(name="a", frame=FRAME, cell=np.array([[10.5, 20.5]]), colour=RED, wide_px=12))
    other = drawn(Dots(name="a", frame=coarse, cell=np.array([[5, 10]]), colour=RED, wide_px=12))
    assert len(near(one, RED)) > 80
    assert (one == other).all()


@pytest.mark.parametrize("cells", [20, 200, 2000])
def test_marks_are_as_large_on_maps_of_any_size(cells: int) -> None:
    frame = Frame(cells, cells, 0.05)
    middle = np.array([[cells / 2, cells / 2]])
    dot = near(drawn(Dots(name="a", frame=frame, cell=middle, colour=RED, wide_px=12), frame=frame), RED)
    assert np.ptp(dot, axis=0).tolist() == pytest.approx([11, 11], abs=1)


def test_walls_of_one_cell_are_seen_on_a_map_of_more_cells_than_pixels() -> None:
    codes = np.ones((1500, 1500), np.uint8)
    codes[733, 100:1400] = 3
    frame = Frame(1500, 1500, 0.05)
    wall = near(
        drawn(
            Cells(name="a", frame=frame, codes=codes, colours={1: ((250, 250, 250), ""), 3: (BLUE, "")}, listed=False),
            frame=frame,
        ),
        BLUE,
    )
    columns = np.unique(wall[:, 1])
    assert len(columns) > 300
    assert (np.diff(columns) == 1).all()


def test_reduced_rasters_keep_the_highest_code() -> None:
    codes = np.array([[0, 1, 0, 0, 2], [0, 0, 3, 0, 0], [1, 0, 0, 0, 0]])
    assert reduced(codes, 2).tolist() == [[1, 3, 2], [1, 0, 0]]


def test_labels_are_codes_of_the_smallest_type_and_wrap_around() -> None:
    assert wrapped(np.array([[0, 255]], np.int32)).dtype == np.uint8
    assert wrapped(np.array([[0, 256]], np.int32)).dtype == np.uint16
    assert wrapped(np.array([[0, 1, 65_535, 65_536]], np.int32)).tolist() == [[0, 1, 65_535, 1]]


def test_a_picture_is_cropped_to_the_floor() -> None:
    free = np.zeros((400, 300), np.bool_)
    free[100:140, 50:170] = True
    window = Window.around(Frame(400, 300, 0.05), free)
    assert (window.left, window.top) == pytest.approx((0.05 * (50 - 4.4), 0.05 * (100 - 4.4)))
    assert (window.width, window.height) == pytest.approx((0.05 * 128.8, 0.05 * 48.8))


def test_a_legend_has_a_line_for_each_meaning_that_is_there() -> None:
    colours = {0: ((1, 1, 1), "unknown"), 1: ((2, 2, 2), "free"), 2: ((3, 3, 3), "never")}
    place = np.zeros((1, 2))
    marks = [
        Cells(name="a", frame=FRAME, codes=np.array([[0, 1], [1, 1]], np.uint8), colours=colours),
        Dots(name="b", frame=FRAME, cell=place, colour=RED, meaning="corner (1)"),
        Dots(name="c", frame=FRAME, cell=place, colour=RED),
        Lines(name="d", frame=FRAME, strips=[np.zeros((2, 2))], colour=BLUE, meaning="door (1)"),
    ]
    assert [(entry.sign, entry.text) for entry in entries(marks)] == [
        ("s", "unknown"),
        ("s", "free"),
        ("o", "corner (1)"),
        ("-", "door (1)"),
    ]


@pytest.mark.parametrize(
    ("given", "wanted"), [(0.99, 0.5), (1.0, 1.0), (4.9, 2.0), (5.0, 5.0), (73.0, 50.0), (0.03, 0.02)]
)
def test_the_scale_is_a_round_length(given: float, wanted: float) -> None:
    assert round_length_m(given) == pytest.approx(wanted)


def test_no_label_covers_another_and_what_has_no_place_is_left_out() -> None:
    box = Box(0, 0, 100, 60)
    tries = [[(50.0, 30.0)], [(50.0, 30.0), (50.0, 42.0)], [(55.0, 35.0)], [(99.0, 30.0)]]
    assert free_places([(30, 10)] * 4, tries, box) == [(50.0, 30.0), (50.0, 42.0), None, None]


def test_legends_go_on_in_the_next_line() -> None:
    assert flowed([40, 40, 30, 90, 10], 100) == [(0, 0), (0, 40), (1, 0), (2, 0), (2, 90)]


@pytest.mark.parametrize("aspect", [0.2, 0.7, 1.0, 2.0, 8.0])
@pytest.mark.parametrize(("maps", "charts"), [(1, 0), (2, 0), (1, 1), (1, 2)])
def test_panels_stay_within_the_picture_and_apart(aspect: float, maps: int, charts: int) -> None:
    wanted = Wanted(aspect=aspect, maps=maps, charts=charts, head=60, above=20, below=70)
    layout = laid_out(wanted, (1600, 1000))
    boxes = [*layout.maps, *layout.charts]
    assert (len(layout.maps), len(layout.charts)) == (maps, charts)
    assert all(box.width / box.height == pytest.approx(aspect) for box in layout.maps)
    assert layout.width <= 1600
    assert layout.height <= 1000
    for box in boxes:
        assert box.left >= 0
        assert box.top >= wanted.head
        assert box.left + box.width <= layout.width
        assert box.top + box.height <= layout.height
    for one, other in combinations(boxes, 2):
        apart = one.left + one.width <= other.left or other.left + other.width <= one.left
        assert apart or one.top + one.height <= other.top or other.top + other.height <= one.top


def test_the_axis_of_costs_is_that_of_the_best_one() -> None:
    steep = Curve("worst", np.arange(2.0), np.array([1000.0, 5.0]), RED, "worst")
    best = Curve("best", np.arange(2.0), np.array([6.0, 4.0]), BLUE, "best")
    chart = Chart(name="cost", x_label="", y_label="", curves=[steep, best], high=8.0)
    assert limits(chart) == pytest.approx((4.0 - 0.05 * 4.0, 8.0))


def test_a_record_nobody_has_marks_for_is_still_drawn() -> None:
    class Heat(Record):
        topic: ClassVar[str] = "heat"

        warmth: Annotated[NDArray[np.int32], Spec("labels", "height width")]
        spot: Annotated[NDArray[np.int32], Spec("cell", "spot 2")]
        frame: Frame

    run = RunRecords()
    warmth = np.zeros((FRAME.height, FRAME.width), np.int32)
    run.records["heat"] = Heat(warmth=warmth, spot=np.array([[3, 4]], np.int32), frame=FRAME)
    cells, dots = marks_of(run, Heat)
    assert isinstance(cells, Cells)
    assert isinstance(dots, Dots)
    assert dots.cell.tolist() == [[3, 4]]


def test_pictures_are_always_the_same() -> None:
    run = History.read(read_recording(GOLDEN, types=RECORDS))
    one, other = ([picture.png for picture in pictures(run, tabs=["Doors"], size=(400, 300))] for _ in range(2))
    assert one == other


def test_shot_says_what_is_missing_and_draws_the_rest(tmp_path: Path) -> None:
    path = tmp_path / "cut.mcap"
    path.write_bytes(GOLDEN.read_bytes()[:34_000])
    done = call("shot", path, "-o", tmp_path / "out", "--size", "400x300", "--stage", "path", "--stage", "corners")
    assert "note: only the intact part was drawn" in done.stderr
    assert len(done.stderr.splitlines()) == 1
    names = ["1_path.png", "3_corners.png"]
    assert [Path(line).name for line in done.stdout.splitlines()] == names
    assert sorted(entry.name for entry in (tmp_path / "out").iterdir()) == names
    assert "found 'Overview'" in call("shot", path, "-o", tmp_path / "out", "--stage", "overview", code=2).stderr


def test_many_marks_are_smaller_and_empty_ones_are_neither_drawn_nor_in_the_legend() -> None:
    many = Dots(name="a", frame=FRAME, cell=np.zeros((200, 2)), colour=RED, meaning="corner", wide_px=10)
    others = Dots(name="b", frame=FRAME, cell=np.zeros((120, 2)), colour=BLUE, meaning="other corner", wide_px=10)
    none = Lines(name="c", frame=FRAME, strips=[], colour=BLUE, meaning="door (0)")
    shown = fitted([many, others, none])
    assert [(entry.text, entry.wide_px) for entry in entries(shown)] == [("corner", 6.0), ("other corner", 6.0)]


def test_rasters_lie_where_they_are_and_keep_their_opacity() -> None:
    codes = np.zeros((40, 60), np.uint8)
    codes[10:20, 30:50] = 1
    cells = Cells(name="a", frame=FRAME, codes=codes, colours={1: (RED, "")}, listed=False)
    rows, cols = near(drawn(cells), RED).T
    across = drawn(Lines(name="b", frame=FRAME, strips=[np.array([[14.5, 29.5], [14.5, 49.5]])], colour=RED))
    line = near(across, RED)
    assert [cols.min(), cols.max()] == pytest.approx([line[:, 1].min(), line[:, 1].max()], abs=2)
    assert (rows.min() + rows.max()) / 2 == pytest.approx(line[:, 0].mean(), abs=2)
    glass = Cells(name="a", frame=FRAME, codes=codes, colours={1: (RED, "")}, opacity=0.5, listed=False)
    ground = Cells(name="g", frame=FRAME, codes=codes, colours={1: ((0, 0, 0), "")}, listed=False)
    half = drawn(ground, glass)[(rows.min() + rows.max()) // 2, (cols.min() + cols.max()) // 2]
    assert half.tolist() == pytest.approx([value / 2 for value in RED], abs=8)


def test_curves_that_run_together_are_all_seen() -> None:
    x = np.arange(3.0)
    flat = [Curve(name, x, np.ones(3), colour, name) for name, colour in (("mean", BLUE), ("best", RED))]
    chart = Chart(name="cost", x_label="", y_label="", curves=flat)
    seen = pixels(picture_of(View("", "", [chart]), Window.around(FRAME, np.ones((40, 60), np.bool_))))
    both = [np.count_nonzero((np.abs(seen - colour).max(axis=2) < 90).sum(axis=1) > 1000) for colour in (BLUE, RED)]
    assert min(both) >= 1
