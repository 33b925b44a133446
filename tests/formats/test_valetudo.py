"""Maps of robot vacuums are read cell for cell, with what they say beside the cells."""

from __future__ import annotations

import copy
import json
import warnings
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from damaged_maps import corrupted, outcome, refused
from maps import cells_drawn
from numpy.typing import NDArray
from real_maps import real_maps
from vacuum import CELL_CM, FLAT, LEFT, TOP, centre_cm, home, rows_of

from vdoor.errors import MapError, MapWarning
from vdoor.formats import read_annotations, read_map, read_source
from vdoor.frame import Frame
from vdoor.grid import Annotations, OccupancyGrid, Segment, Source

MARGIN = 2


def source(table: Any, **options: Any) -> Source:
    return Source((("home.json", json.dumps(table).encode()),), options)


def said(table: Any) -> Annotations:
    found = read_annotations(source(table))
    assert found is not None
    return found


def with_margin(drawing: str) -> NDArray[np.int8]:
    plain = "".join("." if sign.isalpha() else sign for sign in drawing)
    return np.pad(cells_drawn(plain), MARGIN, constant_values=-1)


@pytest.mark.parametrize("version", [1, 2])
def test_both_versions_give_the_drawn_cells_and_a_margin(version: int) -> None:
    grid = read_source(source(home(version=version)))
    assert np.array_equal(grid.cells, with_margin(FLAT))
    assert grid.frame == Frame(*with_margin(FLAT).shape, 0.05)


def test_walls_hold_where_layers_overlap_whatever_their_order() -> None:
    table = home("a#b\n...")
    for layer in table["layers"]:
        if layer["type"] != "wall":
            layer["compressedPixels"] += [LEFT, TOP, 3]
    for layers in (table["layers"], table["layers"][::-1]):
        turned = table | {"layers": layers}
        assert read_source(source(turned)).cells[MARGIN, MARGIN:-MARGIN].tolist() == [0, 100, 0]
        labels = said(turned).labels
        assert labels is not None
        assert labels[MARGIN, MARGIN + 1] == 0


def test_places_are_brought_into_the_map_frame() -> None:
    robot, charger = (3, 7), (7, 1)
    wall = [*centre_cm(1, 11), *centre_cm(6, 11)]
    area = [*centre_cm(1, 5), *centre_cm(1, 7), *centre_cm(3, 7)]
    table = home(
        robot_position=centre_cm(*robot), charger_location=centre_cm(*charger), virtual_wall=wall, no_go_area=area
    )
    found, frame = said(table), read_source(source(table)).frame

    def cells(points_m: Any) -> list[list[float]]:
        found: list[list[float]] = (frame.cell_from_world(np.array(points_m)) - MARGIN).round(9).tolist()
        return found

    assert cells(found.places_m) == [[*robot], [*charger]]
    assert [cells(line) for line in found.virtual_walls_m] == [[[1, 11], [6, 11]]]
    assert [cells(line) for line in found.no_go_areas_m] == [[[1, 5], [1, 7], [3, 7]]]
    assert found.no_mop_areas_m == ()


def test_points_go_back_to_the_robots_own_coordinates() -> None:
    robot_cm = centre_cm(3, 7)
    found = said(home(robot_position=robot_cm))
    assert found.robot_m is not None
    (left_cm, bottom_cm), (x_m, y_m) = found.own_origin_cm, found.robot_m
    assert (left_cm + 100 * x_m, bottom_cm - 100 * y_m) == pytest.approx(robot_cm)
    assert (left_cm, bottom_cm) == ((LEFT - MARGIN) * CELL_CM, (TOP + len(rows_of(FLAT)) + MARGIN) * CELL_CM)


def test_segments_are_known_by_their_ids_since_names_repeat() -> None:
    found = said(home())
    assert found.segments == (Segment(label=1, id="97", name="Flur "), Segment(label=2, id="98", name="Flur "))
    signs = np.array([[*row] for row in rows_of(FLAT)])
    assert found.labels is not None
    inner = found.labels[MARGIN:-MARGIN, MARGIN:-MARGIN]
    assert np.array_equal(inner, (signs == "a") + 2 * (signs == "b"))
    assert said(home("#.#")).labels is None


def test_other_formats_say_nothing_beside_their_cells() -> None:
    assert read_annotations(Source((("map.pgm", b"P5 1 1 255 \xfe"),))) is None
    assert read_annotations(Source()) is None


def test_what_is_not_understood_is_left_aside_and_doubtful_counts_are_said() -> None:
    table = home(path=[1, 2, 3, 4], obstacle=[1, 2], new_thing=["?"])  # type: ignore[list-item]  # of a kind to come
    table["layers"][0]["dimensions"] = {"x": {}, "pixelCount": 3}
    with pytest.warns(MapWarning, match=r"layers\[0\]\.dimensions: 3 cells declared, 66 found: home\.json"):
        grid = read_source(source(table))
    assert np.array_equal(grid.cells, with_margin(FLAT))


# --- refused


def changed(*keys: Any, to: Any = None) -> dict[str, Any]:
    """The flat with one value changed, or gone."""
    table = copy.deepcopy(home(robot_position=centre_cm(3, 7), virtual_wall=[1, 2, 3, 4]))
    inner = table
    for key in keys[:-1]:
        inner = inner[key]
    if to is None:
        del inner[keys[-1]]
    else:
        inner[keys[-1]] = to
    return table


@pytest.mark.parametrize("key", ["metaData", "size", "pixelSize", "layers", "entities"])
def test_every_required_key_is_missed_and_of_its_kind(key: str) -> None:
    refused(source(changed(key)), f"{key}: wanted the key, found none")
    for value in ("x", True, float("nan"), -5):
        refused(source(changed(key, to=value)), f"{key}: wanted a ")


CELLS = ("layers", 0, "compressedPixels")
REFUSED: list[tuple[tuple[Any, ...], Any, str]] = [
    (("metaData", "version"), None, "metaData.version: wanted the key"),
    (("metaData", "version"), 3, "metaData.version: wanted 1 or 2, found 3"),
    (("metaData", "version"), True, "metaData.version: wanted 1 or 2, found True"),
    (("size", "x"), None, "size.x: wanted the key"),
    (("size", "y"), 0, "size.y: wanted a number above 0"),
    (("size", "x"), 500, "layers[0]: wanted cells within the map's size, found x 600 to 623, y 540 to 548"),
    (("pixelSize",), 10**400, "pixelSize: wanted a number above 0"),
    (("pixelSize",), 100_000, "resolution: wanted 0.0001 to 100 m per cell, found 1000.0"),
    (("layers",), [], "layers: wanted at least one cell, found none"),
    (("layers",), [{}] * 10_001, "layers: wanted at most 10000, found 10001"),
    (("layers", 0), 5, "layers[0]: wanted a table, found 5"),
    (("layers", 0, "type"), "ceiling", "layers[0].type: wanted floor, segment, wall, found 'ceiling'"),
    (("layers", 0, "type"), None, "layers[0].type: wanted the key"),
    (CELLS, [1, 2], "layers[0].compressedPixels: wanted whole numbers in runs of x, y, count, found a list of 2"),
    (CELLS, [1, 2, 3.5], "layers[0].compressedPixels: wanted whole numbers"),
    (CELLS, [1, 2, True], "layers[0].compressedPixels: wanted whole numbers"),
    (CELLS, [1, 2, 10**30], "layers[0].compressedPixels: wanted whole numbers"),
    (CELLS, ["x" * 1000, 2, 3], "layers[0].compressedPixels: wanted whole numbers"),
    (CELLS, [600, 540, 0], "layers[0].compressedPixels: wanted counts of at least 1"),
    (CELLS, [600, 540, 10**9], "layers[0].compressedPixels: wanted counts of at least 1 and numbers up to 1000000"),
    (CELLS, [-1, 540, 3], "layers[0]: wanted cells within the map's size, found x -1 to 1"),
    (("layers", 2, "metaData"), None, "layers[2].metaData: wanted the key"),
    (("layers", 2, "metaData", "segmentId"), None, "layers[2].metaData.segmentId: wanted the key"),
    (("layers", 2, "metaData", "segmentId"), [1], "layers[2].metaData.segmentId: wanted a string or number"),
    (("entities", 0), "robot", "entities[0]: wanted a table"),
    (("entities", 0, "points"), None, "entities[0].points: wanted the key"),
    (("entities", 0, "points"), [1], "entities[0].points: wanted x, y of 1 or more points, found a list of 1"),
    (("entities", 0, "points"), [1, "2"], "entities[0].points: wanted x, y"),
    (("entities", 0, "points"), [1, float("inf")], "entities[0].points: wanted x, y"),
    (("entities", 1, "points"), [1, 2], "entities[1].points: wanted x, y of 2 or more points"),
]


@pytest.mark.parametrize(("keys", "to", "match"), REFUSED)
def test_a_wrong_value_is_named(keys: tuple[Any, ...], to: Any, match: str) -> None:
    refused(source(changed(*keys, to=to)), match)


def test_layers_without_cells_are_named() -> None:
    table = home()
    del table["layers"][0]["compressedPixels"], table["layers"][0]["pixels"]
    refused(source(table), "layers[0].compressedPixels: wanted the layer's cells, found none")


@pytest.mark.parametrize("data", [b"[]", b"5", b"", b"{", b"\xff\xfe", b"[" * 100_000, b"1" * 5000, b"null"])
def test_what_is_no_map_is_refused(data: bytes) -> None:
    refused(Source((("home.json", data),)), "wanted a")


def test_what_the_file_says_itself_is_not_said_again() -> None:
    refused(source(home(), resolution_m=0.1), "resolution: wanted 0.1 m per cell as requested, found 0.05 m")
    refused(source(home(), unknown_value=205), "unknown value: wanted none for a Valetudo map")
    assert read_source(source(home(), resolution_m=0.05)).frame.resolution_m == 0.05


def test_small_files_of_many_cells_are_refused_before_anything_is_made() -> None:
    far = home("a")
    far["size"] = {"x": 900_000, "y": 900_000}
    far["layers"][0]["compressedPixels"] = [0, 0, 1, 800_000, 800_000, 1]
    refused(source(far), "size: wanted at most 100000000 cells, found 800005 x 800005")
    often = home("a")
    often["layers"][0]["compressedPixels"] = [0, 0, 6000] * 20_000
    refused(source(often), "size: wanted at most 100000000 cells, found 120000000 x 1")
    assert read_source(source(home()), max_cells=24 * 13 + 100).cells.size < 24 * 13 + 100
    refused(source(home()), "size: wanted at most 300 cells, found 28 x 13", max_cells=300)
    refused(Source((("home.json", b" " * (1 << 24) + b"{}"),)), "JSON: wanted at most 16777216 bytes")


# --- damage


def mutated(table: Any, rng: np.random.Generator) -> bytes:
    """A copy with up to three values gone, doubled or odd."""
    table = copy.deepcopy(table)
    odd: list[Any] = [
        None,
        True,
        -1,
        0,
        2,
        5.5,
        1e300,
        float("nan"),
        10**30,
        "",
        "wall",
        [],
        {},
        [[]],
        [1, 2, 3],
        {"x": 1},
    ]
    for _ in range(rng.integers(1, 4)):
        places = [*nested(table)]
        holder, key = places[rng.integers(len(places))]
        what: Callable[[], Any] = lambda: copy.deepcopy(odd[rng.integers(len(odd))])  # noqa: E731  # used thrice
        match rng.integers(3):
            case 0:
                del holder[key]
            case 1 if isinstance(holder, list):
                holder.insert(key, what())
            case _:
                holder[key] = what()
        if not table:
            break
    return json.dumps(table).encode()


def nested(value: Any) -> Any:
    """All places in tables and lists, as the holder and the key."""
    for key in [*value] if isinstance(value, dict) else range(len(value)) if isinstance(value, list) else ():
        yield value, key
        yield from nested(value[key])


@pytest.mark.parametrize("version", [1, 2])
def test_damage_gives_a_grid_or_one_line(version: int) -> None:
    rng = np.random.default_rng(version)
    table = home("ab#\n.??", version=version, robot_position=centre_cm(0, 0), virtual_wall=[1, 2, 3, 4])
    outcomes: set[type] = set()
    for at in range(200):
        data = mutated(table, rng) if at % 2 else corrupted(json.dumps(table).encode(), rng)
        damaged = Source((("home.json", data),))
        outcomes.add(outcome(damaged))
        if outcome(damaged) is OccupancyGrid:
            assert read_annotations(damaged) is not None
    assert outcomes == {MapError, OccupancyGrid}


# --- real ones


def test_every_real_home_goes_in() -> None:
    for path in real_maps("homes/*.json"):
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            grid = read_map(path)
        found = read_annotations(grid.source)
        assert found is not None
        assert len(found.places_m) == 2
        layers = json.loads(path.read_text())["layers"]
        walls = sum(layer["dimensions"].get("pixelCount", 0) for layer in layers if layer["type"] == "wall")
        assert grid.occupied.sum() == walls or walls == 0
        known = np.argwhere(grid.cells >= 0)
        assert (known.min(axis=0) == MARGIN).all()
        assert (known.max(axis=0) == np.array(grid.cells.shape) - 1 - MARGIN).all()


def test_every_real_map_of_another_format_goes_in() -> None:
    for path in real_maps("ros/*.yaml", "layouts/*.png"):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", MapWarning)
            assert read_map(path).free.any()
