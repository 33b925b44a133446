"""Maps in the forms that people have: packed, piped, cut short, in the wrong mode; read, noted, or named."""

from __future__ import annotations

import base64
import gzip
import io
import json
import sqlite3
import subprocess
import sys
import warnings
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import zstandard
from bags import ROS1, bare_mcap, file_of, grid_message, packed, ros1_bag, ros2_bag
from mcap.writer import Writer as McapWriter
from numpy.typing import NDArray
from PIL import Image, PngImagePlugin
from rosbags.rosbag2 import StoragePlugin
from vacuum import home

from vdoor.api import run
from vdoor.errors import MapError, MapWarning, say
from vdoor.formats import read_map, read_piped, read_source
from vdoor.grid import FREE, OCCUPIED, UNKNOWN, OccupancyGrid

YAML = "image: {}\nresolution: 0.05\norigin: [0, 0, 0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n{}"
JSON = json.dumps(home()).encode()


def two_rooms() -> NDArray[np.int8]:
    """Two rooms of 1.6 m by 1.5 m with a doorway, within walls, in the unknown."""
    cells = np.full((40, 76), UNKNOWN, np.int8)
    cells[4:36, 4:72] = OCCUPIED
    cells[5:35, 5:37] = cells[5:35, 39:71] = cells[11:29, 37:39] = FREE
    return cells


def greys(free: int, unknown: int, occupied: int) -> NDArray[np.uint8]:
    cells = two_rooms()
    return np.choose(np.select([cells == FREE, cells == OCCUPIED], [0, 1], 2), [free, occupied, unknown]).astype(
        np.uint8
    )


def pgm(image: NDArray[np.uint8], line_end: bytes = b"\n") -> bytes:
    return b"P5\n%d %d\n255" % image.shape[::-1] + line_end + image.tobytes()


def read(path: Path, **options: Any) -> tuple[OccupancyGrid, list[str]]:
    """The grid, and its notes without the path that each ends with."""
    with warnings.catch_warnings(record=True) as found:
        warnings.simplefilter("always", MapWarning)
        grid = read_map(path, **options)
    return grid, [str(note.message) for note in found]


def refused(path: Path, **options: Any) -> str:
    with pytest.raises(MapError) as caught:
        read_map(path, **options)
    text = str(caught.value)
    assert "\n" not in text
    return text


# --- a container is not its suffix


def png_with(chunk: str, text: str) -> bytes:
    info, stream = PngImagePlugin.PngInfo(), io.BytesIO()
    if chunk == "iTXt":
        info.add_itxt("ValetudoMap", text, zip=True)
    else:
        info.add_text("ValetudoMap", text, zip=chunk == "zTXt")
    Image.new("L", (16, 9), 254).save(stream, "PNG", pnginfo=info)
    return stream.getvalue()


WRAPPED: dict[str, bytes] = {
    "plain.txt": JSON,
    "deflated.json": zlib.compress(JSON),
    "raw.json": zlib.compress(JSON, wbits=-15),
    "gzip.json": gzip.compress(JSON),
    "zstd.bin": zstandard.compress(JSON),
    "base64.json": base64.encodebytes(zlib.compress(JSON)),
    "quoted.json": b'"' + base64.b64encode(zlib.compress(JSON)) + b'"',
    "address.txt": b"data:application/json;base64," + base64.b64encode(JSON),
    "mark.json": b"\xef\xbb\xbf" + JSON,
    "state.json": json.dumps({"attributes": [], "map": home()}).encode(),
    "deep.json": json.dumps({"state": {"robot": {"map": home()}}}).encode(),
    "zTXt.png": png_with("zTXt", JSON.decode()),
    "tEXt.png": png_with("tEXt", JSON.decode()),
    "iTXt.png": png_with("iTXt", JSON.decode()),
    "packed.png.gz": gzip.compress(png_with("zTXt", JSON.decode())),
}


@pytest.mark.parametrize("name", WRAPPED)
def test_a_vacuums_map_is_found_in_whatever_is_around_it(name: str, tmp_path: Path) -> None:
    (tmp_path / "plain.json").write_bytes(JSON)
    (tmp_path / name).write_bytes(WRAPPED[name])
    plain, found = read_map(tmp_path / "plain.json"), read_map(tmp_path / name)
    assert np.array_equal(found.cells, plain.cells)
    assert found.source.files[0][0].endswith(".json")
    assert np.array_equal(read_source(found.source).cells, plain.cells)
    assert np.array_equal(read_piped(io.BytesIO(WRAPPED[name])).cells, plain.cells)


@pytest.mark.parametrize("pack", [zstandard.compress, gzip.compress, bytes], ids=["zstd", "gzip", "plain"])
def test_a_bag_is_read_packed_or_piped(pack: Callable[[bytes], bytes], tmp_path: Path) -> None:
    path = bare_mcap(tmp_path / "bag.mcap", [("/map", 1, grid_message(two_rooms()))])
    data = pack(path.read_bytes())
    (tmp_path / "bag.mcap.packed").write_bytes(data)
    assert np.array_equal(read_map(tmp_path / "bag.mcap.packed").cells, two_rooms())
    assert np.array_equal(read_piped(io.BytesIO(data)).cells, two_rooms())


@pytest.mark.parametrize(
    ("data", "named"),
    [
        (b"PK\x03\x04 and more", "a ZIP archive"),
        (b"version https://git-lfs.github.com/spec/v1\n", "Git LFS"),
        (b"\xff\xd8\xff\xe0 JFIF", "a JPEG picture"),
        (b"<!DOCTYPE html><html>", "a web page"),
        (b"\x01\x02 nothing known", "bytes that are none of them: stdin"),
    ],
)
def test_what_is_no_map_is_named_also_from_a_pipe(data: bytes, named: str, tmp_path: Path) -> None:
    (tmp_path / "map.bin").write_bytes(data)
    with pytest.raises(MapError) as caught:
        read_piped(io.BytesIO(data))
    assert named in str(caught.value)
    assert ".pgm: " not in str(caught.value)
    assert str(caught.value).endswith("stdin")
    assert named.removesuffix(": stdin") in refused(tmp_path / "map.bin")


def test_a_piped_yaml_is_told_that_its_image_is_missing() -> None:
    with pytest.raises(MapError, match=r"a YAML that names an image \(give the YAML's path\): stdin"):
        read_piped(io.BytesIO(YAML.format("map.pgm", "").encode()))


def test_packed_data_unpacks_to_a_limit(tmp_path: Path) -> None:
    (tmp_path / "bomb.zst").write_bytes(zstandard.compress(bytes(40_000_000)))
    assert "--max-cells" in refused(tmp_path / "bomb.zst", max_cells=1000)


# --- flags that say that this is no map


@pytest.mark.parametrize(
    ("change", "match"),
    [
        ({"metaData": {"version": 2, "defaultMap": True}}, "the placeholder of a robot that has none"),
        ({"layers": []}, "the robot has no map yet"),
        ({"size": {"x": 0, "y": 0}}, "size.x: wanted a number above 0"),
    ],
)
def test_a_robot_without_a_map_is_said(change: dict[str, Any], match: str, tmp_path: Path) -> None:
    (tmp_path / "map.json").write_text(json.dumps(home() | change))
    assert match in refused(tmp_path / "map.json")


# --- legal, but hardly meant


def probabilities() -> NDArray[np.int8]:
    """The two rooms as a mapper that publishes probabilities has them."""
    rng, cells = np.random.default_rng(0), two_rooms()
    cells[cells == FREE] = rng.integers(15, 45, np.count_nonzero(cells == FREE))
    cells[cells == OCCUPIED] = rng.integers(56, 95, np.count_nonzero(cells == OCCUPIED))
    return cells


@pytest.mark.parametrize("name", ["bag.mcap", "map.npy"])
def test_probabilities_are_read_by_what_is_likelier(name: str, tmp_path: Path) -> None:
    path = tmp_path / name
    if name == "map.npy":
        np.save(path, probabilities())
    else:
        bare_mcap(path, [("/map", 1, grid_message(probabilities()))])
    grid, found = read(path, **({"resolution_m": 0.05} if name == "map.npy" else {}))
    count = np.count_nonzero((probabilities() >= 20) & (probabilities() < 65))
    assert found[0].startswith(f"occupancy: {count} of 2176 known cells")
    assert "--free-below 20 --occupied-from 65" in found[0]
    assert np.array_equal(grid.cells, two_rooms())
    assert len(run(grid).rooms) == 2
    assert (grid.source.options["free_below"], grid.source.options["occupied_from"]) == (50, 51)
    assert np.array_equal(read_source(grid.source).cells, grid.cells)
    asked, _ = read(path, free_below=20, occupied_from=65)
    assert np.count_nonzero(asked.cells == UNKNOWN) == count + np.count_nonzero(two_rooms() == UNKNOWN)


def test_values_of_a_planner_stay_as_they_are(tmp_path: Path) -> None:
    cells = two_rooms()
    cells[5, 5:30] = 50  # 1.1 % of the known cells
    grid, found = read(bare_mcap(tmp_path / "bag.mcap", [("/map", 1, grid_message(cells))]))
    assert np.array_equal(grid.cells, cells)
    assert not found


def yaml_map(folder: Path, image: NDArray[np.uint8], more: str = "") -> Path:
    (folder / "map.pgm").write_bytes(pgm(image))
    (folder / "map.yaml").write_text(YAML.format("map.pgm", more))
    return folder / "map.yaml"


def test_raw_mode_on_a_savers_image_is_said(tmp_path: Path) -> None:
    path = yaml_map(tmp_path, greys(254, 205, 0), "mode: raw\n")
    grid, found = read(path)
    assert set(np.unique(grid.cells)) == {UNKNOWN, FREE}
    assert found[0].startswith(f"mode raw: {np.count_nonzero(two_rooms() != OCCUPIED)} of 3040 cells")


def test_scale_mode_says_what_is_neither(tmp_path: Path) -> None:
    path = yaml_map(tmp_path, greys(160, 255, 0), "mode: scale\n")
    assert any("neither free nor occupied (--free-below 50" in note for note in read(path)[1])


def test_greys_of_another_mapper_are_said_with_what_to_set(tmp_path: Path) -> None:
    path = yaml_map(tmp_path, greys(178, 89, 0))
    grid, found = read(path)
    free = np.count_nonzero(two_rooms() == FREE)
    assert f"greys: {free} of 3040 cells other than 205" in found[0]
    assert "--free-below 31 reads 178 as free, --unknown-value 89 keeps 89 unknown" in found[0]
    with pytest.raises(MapError) as caught:
        run(grid)
    assert f"free 0, occupied {3040 - free}, unknown {free} cells; commonest greys 178 in {free}" in str(caught.value)
    assert str(caught.value).endswith(": map.yaml")
    assert np.array_equal(read_map(path, free_below=31, unknown_value=89).cells, two_rooms())


def test_the_usual_greys_need_no_note(tmp_path: Path) -> None:
    assert read(yaml_map(tmp_path, greys(254, 205, 0)))[1] == []


def test_black_and_white_the_wrong_way_round_is_said(tmp_path: Path) -> None:
    cells = two_rooms()
    inverted = np.select([cells == FREE, cells == OCCUPIED], [0, 254], 205).astype(np.uint8)
    assert any(note.startswith("occupied: ") for note in read(yaml_map(tmp_path, inverted))[1])


def test_colours_are_said(tmp_path: Path) -> None:
    image = Image.fromarray(greys(254, 205, 0)).convert("RGB")
    image.paste((0, 160, 255), (5, 5, 37, 35))
    image.quantize(8).save(tmp_path / "map.png")
    assert any("colours: 960 of 3040 cells" in note for note in read(tmp_path / "map.png", resolution_m=0.05)[1])


@pytest.mark.parametrize("value", [-1, 101, float("nan"), "20", True])
def test_limits_that_are_no_per_cent_are_refused(value: Any, tmp_path: Path) -> None:
    path = yaml_map(tmp_path, greys(254, 205, 0))
    assert "free below: wanted 0 to 100 per cent" in refused(path, free_below=value)
    assert "free below: wanted at most the 40 per cent" in refused(path, free_below=50, occupied_from=40)


# --- bags


def test_neither_the_profile_nor_other_topics_matter(tmp_path: Path) -> None:
    with (tmp_path / "mixed.mcap").open("wb") as stream:
        writer = McapWriter(stream)
        writer.start(profile="")
        other = writer.register_channel("/note", "protobuf", writer.register_schema("own.Note", "protobuf", b""))
        schema = writer.register_schema("nav_msgs/msg/OccupancyGrid", "ros2msg", b"")
        grid = writer.register_channel("/map", "cdr", schema)
        writer.add_message(other, 0, b"x", 0)
        writer.add_message(grid, 1, packed(grid_message(two_rooms())), 1)
        writer.finish()  # type: ignore[no-untyped-call]
    assert np.array_equal(read_map(tmp_path / "mixed.mcap").cells, two_rooms())


def test_messages_of_ros_1_in_mcap(tmp_path: Path) -> None:
    message = grid_message(two_rooms(), store=ROS1)
    with (tmp_path / "old.mcap").open("wb") as stream:
        writer = McapWriter(stream)
        writer.start(profile="ros1")
        schema = writer.register_schema("nav_msgs/OccupancyGrid", "ros1msg", b"")
        channel = writer.register_channel("/map", "ros1", schema)
        writer.add_message(channel, 1, bytes(ROS1.serialize_ros1(message, message.__msgtype__)), 1)
        writer.finish()  # type: ignore[no-untyped-call]
    assert np.array_equal(read_map(tmp_path / "old.mcap").cells, two_rooms())


def test_a_folder_needs_no_metadata(tmp_path: Path) -> None:
    folder = ros2_bag(tmp_path / "bag", [("/map", 1, grid_message(two_rooms()))], StoragePlugin.MCAP)
    (folder / "metadata.yaml").unlink()
    assert np.array_equal(read_map(folder).cells, two_rooms())


OLDER = np.full((40, 76), FREE, np.int8)


@pytest.mark.parametrize("kind", [".mcap", ".bag", ".db3"])
def test_of_a_bag_that_is_cut_short_the_last_whole_map_is_read(kind: str, tmp_path: Path) -> None:
    """Cut anywhere, a bag gives the newer map, the older one, or an error of one line; each of the three somewhere."""
    messages = [("/map", 1, OLDER), ("/map", 2, two_rooms())]
    if kind == ".bag":
        path = ros1_bag(tmp_path / "whole.bag", [(t, at, grid_message(cells, store=ROS1)) for t, at, cells in messages])
    elif kind == ".db3":
        path = file_of(
            ros2_bag(tmp_path / "bag", [(t, at, grid_message(c)) for t, at, c in messages], StoragePlugin.SQLITE3)
        )
    else:
        path = bare_mcap(tmp_path / "whole.mcap", [(t, at, grid_message(c)) for t, at, c in messages], chunk_size=1000)
    data, cut, outcomes = path.read_bytes(), tmp_path / f"cut{kind}", set()
    for size in range(100, len(data), max(1, len(data) // 60)):
        cut.write_bytes(data[:size])
        try:
            grid, found = read(cut)
        except MapError as error:
            outcomes.add("refused" if "\n" not in str(error) else "two lines")
            continue
        assert any("cut short" in note for note in found)
        outcomes.add("older" if np.array_equal(grid.cells, OLDER) else "newer")
        assert np.array_equal(grid.cells, OLDER) or np.array_equal(grid.cells, two_rooms())
    assert "two lines" not in outcomes
    assert {"refused", "older"} <= outcomes if kind != ".bag" else "newer" in outcomes


def test_the_newest_map_is_read_from_the_log_beside_a_database(tmp_path: Path) -> None:
    path = file_of(ros2_bag(tmp_path / "bag", [("/map", 1, grid_message(OLDER))], StoragePlugin.SQLITE3))
    bag = sqlite3.connect(path)
    bag.execute("PRAGMA journal_mode=WAL")
    bag.execute("PRAGMA wal_autocheckpoint=0")
    bag.execute(
        "INSERT INTO messages (topic_id, timestamp, data) SELECT topic_id, 2, ? FROM messages",
        (packed(grid_message(two_rooms())),),
    )
    bag.commit()
    before = {place.name: place.read_bytes() for place in path.parent.iterdir()}
    assert f"{path.name}-wal" in before
    assert np.array_equal(read_map(path).cells, two_rooms())
    assert {place.name: place.read_bytes() for place in path.parent.iterdir()} == before
    bag.close()


# --- limits and names


def test_our_limit_of_cells_is_the_only_one(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    Image.fromarray(greys(254, 205, 0)).save(tmp_path / "map.png")
    monkeypatch.setattr(Image, "MAX_IMAGE_PIXELS", 100)
    assert np.array_equal(read_map(tmp_path / "map.png", resolution_m=0.05).cells, two_rooms())
    assert Image.MAX_IMAGE_PIXELS == 100
    assert "wanted at most 3039 cells" in refused(tmp_path / "map.png", max_cells=3039)


def test_a_missing_image_is_named_with_who_names_it_and_where_it_lies(tmp_path: Path) -> None:
    (tmp_path / "home.pgm").write_bytes(pgm(greys(254, 205, 0)))
    (tmp_path / "home.yaml").write_text(YAML.format("maps/home.pgm", ""))
    text = refused(tmp_path / "home.yaml")
    assert f"wanted the image that {tmp_path / 'home.yaml'} names, found none; home.pgm lies there" in text
    assert text.endswith(f": {tmp_path / 'maps' / 'home.pgm'}")


def test_windows_line_ends_in_a_header_shift_nothing(tmp_path: Path) -> None:
    (tmp_path / "map.pgm").write_bytes(pgm(greys(254, 205, 0), b"\r\n"))
    grid, found = read(tmp_path / "map.pgm", resolution_m=0.05)
    assert np.array_equal(grid.cells, two_rooms())
    assert "CR LF" in found[0]


def test_the_command_takes_a_packed_map_from_a_pipe_and_names_the_chargers_place() -> None:
    table = home(charger_location=[3050.0, 2725.0])
    done = subprocess.run(
        [Path(sys.executable).with_name("vdoor"), "run", "-"],
        input=zlib.compress(json.dumps(table).encode()),
        capture_output=True,
        check=False,
    )
    assert done.returncode == 0
    assert b"robot taken to be at its charger" in done.stderr


def test_text_of_a_file_stays_one_line_without_control_codes(capsys: pytest.CaptureFixture[str]) -> None:
    say("file: found none: \x1b[31mred\nvdoor: all is well.pgm")
    assert capsys.readouterr().err == "vdoor: file: found none: ?[31mred vdoor: all is well.pgm\n"


def test_a_shape_with_a_truth_value_is_refused(tmp_path: Path) -> None:
    stream = io.BytesIO()
    np.save(stream, np.zeros((1, 60), np.int8))
    (tmp_path / "map.npy").write_bytes(stream.getvalue().replace(b"(1, 60), }   ", b"(True, 60), }"))
    assert "array: wanted a shape of whole numbers" in refused(tmp_path / "map.npy")
