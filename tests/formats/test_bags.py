"""Of a bag the last occupancy grid of a topic is read, and no more than that is kept."""

from __future__ import annotations

import math
import shutil
import tracemalloc
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from bags import (
    ROS1,
    ROS2,
    bare_mcap,
    file_of,
    grid_message,
    packed,
    ros1_bag,
    ros2_bag,
    text_message,
    turned,
)
from damaged_maps import corrupted, refused
from mcap.writer import CompressionType, IndexType
from project import GOLDEN
from rosbags.rosbag1 import Writer as Writer1
from rosbags.rosbag2 import CompressionMode, StoragePlugin
from small_recording import small_run, write

from vdoor.errors import MapError, MapWarning
from vdoor.formats import read_map, read_source
from vdoor.frame import Frame
from vdoor.grid import OccupancyGrid, Source
from vdoor.pipeline import RECORDS
from vdoor.record import equal
from vdoor.recording.mcap import read_recording

OLD = np.full((2, 3), 100, np.int8)
NEW = np.array([[-1, 0, 100, 50], [0, 0, 0, 0], [100, 19, 65, 1]], np.int8)
MCAP, SQLITE = StoragePlugin.MCAP, StoragePlugin.SQLITE3


def mapped(store: Any = ROS2, topic: str = "/map") -> list[tuple[str, int, Any]]:
    """A map that is made anew, beside much that is none."""
    chatter = text_message("far too much " * 1000, store=store)
    old, new = (grid_message(cells, store=store) for cells in (OLD, NEW))
    return [(topic, 10, old), ("/chatter", 15, chatter), (topic, 20, new), ("/chatter", 25, chatter)]


def check(grid: OccupancyGrid, topic: str = "/map") -> None:
    """Claim that it is the new map, that it was kept alone, and that it is read again from what was kept."""
    assert np.array_equal(grid.cells, NEW)
    assert grid.frame == Frame(3, 4, 0.05, -1.5, 2.25)
    assert grid.source.options == {"topic": topic}
    ((name, data),) = grid.source.files
    assert name.endswith(".cdr")
    assert len(data) < 200
    assert equal(read_source(grid.source), grid)


@pytest.mark.parametrize(
    ("plugin", "mode"),
    [
        (MCAP, CompressionMode.NONE),
        (MCAP, CompressionMode.MESSAGE),
        (MCAP, CompressionMode.STORAGE),
        (SQLITE, CompressionMode.NONE),
        (SQLITE, CompressionMode.MESSAGE),
    ],
)
def test_the_last_message_of_a_ros_2_bag(tmp_path: Path, plugin: StoragePlugin, mode: CompressionMode) -> None:
    folder = ros2_bag(tmp_path / "kitchen", mapped(), plugin, mode)
    for path in (folder, file_of(folder)):
        grid = read_map(path)
        check(grid)
        assert grid.source.files[0][0] == "kitchen.cdr"


@pytest.mark.parametrize("compression", [None, *Writer1.CompressionFormat])
def test_the_last_message_of_a_ros_1_bag(tmp_path: Path, compression: Writer1.CompressionFormat | None) -> None:
    check(read_map(ros1_bag(tmp_path / "kitchen.bag", mapped(ROS1), compression)))


@pytest.mark.parametrize(
    "how",
    [
        {"compression": CompressionType.NONE},
        {"compression": CompressionType.LZ4},
        {"compression": CompressionType.ZSTD},
        {"use_chunking": False},
        {"index_types": IndexType.NONE},
        {"index_types": IndexType.CHUNK},
        {"use_statistics": False, "use_summary_offsets": False, "repeat_channels": False, "repeat_schemas": False},
        {"encoding": "ros2idl"},
        {"definition": b"import os; os.abort()"},
    ],
    ids=str,
)
def test_mcap_of_other_writers_with_and_without_indexes_and_definitions(tmp_path: Path, how: dict[str, Any]) -> None:
    check(read_map(bare_mcap(tmp_path / "kitchen.mcap", mapped(), **how)))


def test_the_latest_message_wins_not_the_last_written(tmp_path: Path) -> None:
    messages = [("/map", 20, grid_message(NEW)), ("/map", 10, grid_message(OLD))]
    for name, chunks in (("chunks.mcap", True), ("bare.mcap", False)):
        check(read_map(bare_mcap(tmp_path / name, messages, use_chunking=chunks)))


def test_a_bag_of_several_files_is_one(tmp_path: Path) -> None:
    folder = ros2_bag(tmp_path / "kitchen", mapped(), MCAP)
    later = [("/map", 30, grid_message(OLD))]
    bare_mcap(folder / "kitchen_1.mcap", later)
    assert np.array_equal(read_map(folder).cells, OLD)


def test_names_that_mean_something_in_an_address_are_only_names(tmp_path: Path) -> None:
    path = tmp_path / "a#b?mode=rw%20&c.db3"
    shutil.copy(file_of(ros2_bag(tmp_path / "kitchen", mapped(), SQLITE)), path)
    check(read_map(path))


# --- topics


def test_a_topic_is_chosen_by_name(tmp_path: Path) -> None:
    path = bare_mcap(tmp_path / "bag.mcap", [*mapped(topic="/a"), ("/b", 99, grid_message(OLD))])
    check(read_map(path, topic="/a"), "/a")
    assert np.array_equal(read_map(path, topic="/b").cells, OLD)
    for topic, found in ((None, r"none selected \(--topic selects one\)"), ("/chatter", "'/chatter'"), ("/x", "'/x'")):
        with pytest.raises(MapError, match=rf"topic: wanted one of '/a', '/b', found {found}: {path}"):
            read_map(path, topic=topic)


def test_the_usual_topic_is_taken_and_said(tmp_path: Path) -> None:
    path = bare_mcap(tmp_path / "bag.mcap", [*mapped(), ("/costmap", 99, grid_message(OLD))])
    note = r"^topic: using /map of '/costmap', '/map' \(--topic selects another\): .*bag\.mcap$"
    with pytest.warns(MapWarning, match=note):
        check(read_map(path))


def test_a_topic_is_of_use_to_bags_alone(tmp_path: Path) -> None:
    (tmp_path / "map.pgm").write_bytes(b"P5 1 1 255 \xfe")
    with pytest.raises(MapError, match=r"--topic: wanted a bag, found a \.pgm: .*map\.pgm$"):
        read_map(tmp_path / "map.pgm", topic="/map")


# --- places


@pytest.mark.parametrize("yaw_rad", [0.5, -3.0, math.pi / 2])
@pytest.mark.parametrize("length", [1.0, 0.1, -2.0])
def test_the_turn_is_read_from_a_quaternion_of_any_length(tmp_path: Path, yaw_rad: float, length: float) -> None:
    x, y, z, w = (part * length for part in turned(yaw_rad))
    path = bare_mcap(tmp_path / "bag.mcap", [("/map", 1, grid_message(NEW, turn=(x, y, z, w)))])
    with pytest.warns(MapWarning, match="the map is rotated by"):
        assert read_map(path).frame.yaw_rad == pytest.approx(yaw_rad)


@pytest.mark.parametrize(
    ("turn", "note"),
    [((0.0, 0.0, 0.0, 0.0), "quaternion is all zeros, using no rotation"), ((0.1, 0.0, 0.0, 1.0), "the map is tilted")],
)
def test_odd_turns_are_said(tmp_path: Path, turn: tuple[float, float, float, float], note: str) -> None:
    path = bare_mcap(tmp_path / "bag.mcap", [("/map", 1, grid_message(NEW, turn=turn))])
    with pytest.warns(MapWarning, match=note):
        assert read_map(path).frame.yaw_rad == 0


@pytest.mark.parametrize("resolution_m", [0.05, 0.1, 0.025, 0.049999, 1 / 3])
def test_the_resolution_is_what_single_precision_was_made_of(tmp_path: Path, resolution_m: float) -> None:
    path = bare_mcap(tmp_path / "bag.mcap", [("/map", 1, grid_message(NEW, resolution_m=resolution_m))])
    found_m = read_map(path).frame.resolution_m
    assert np.float32(found_m) == np.float32(resolution_m)
    assert resolution_m in (found_m, 1 / 3)
    with pytest.raises(MapError, match=r"resolution: wanted 7 m per cell as requested, found"):
        read_map(path, resolution_m=7.0)


# --- recordings of our own


def test_a_recording_gives_the_files_it_was_made_of(tmp_path: Path) -> None:
    for path in sorted(GOLDEN.glob("*.mcap")):
        recorded = read_recording(path, types=RECORDS)
        grid = read_map(path)
        assert grid.source == recorded.info.source
        assert equal(grid, next(iter(recorded))[1])
    info, records = small_run()
    bare = write(tmp_path / "bare.mcap", records, info.__class__(**vars(info) | {"source": Source()}))
    grid, first = read_map(bare, topic="/vdoor/input/cells"), records[0]
    assert isinstance(first, OccupancyGrid)
    assert np.array_equal(grid.cells, first.cells)
    assert grid.frame == first.frame


def test_options_are_laid_over_those_of_a_recording() -> None:
    with pytest.raises(MapError, match=r"resolution: wanted 0.3 m per cell as requested, found 0.2 m: .*plain\.mcap$"):
        read_map(GOLDEN / "plain.mcap", resolution_m=0.3)
    assert read_map(GOLDEN / "crossing.mcap", resolution_m=0.3).frame.resolution_m == 0.3
    assert read_map(GOLDEN / "crossing.mcap", topic="/vdoor/simplified/cells").source.files[0][0] == "crossing.cdr"


# --- refused


def message_source(message: Any, **options: Any) -> Source:
    return Source((("map.cdr", packed(message)),), options)


def altered(**changes: Any) -> Any:
    message = grid_message(NEW)
    for name, value in changes.items():
        setattr(message.info if hasattr(message.info, name) else message, name, value)
    return message


@pytest.mark.parametrize(
    ("message", "match"),
    [
        (altered(width=5), "message: wanted 5 x 3 = 15 cells, found 12"),
        (altered(width=0), "size: wanted at least one cell, found 0 x 3"),
        (altered(width=2**31, height=2**31), "size: wanted at most 100000000 cells"),
        (altered(data=np.full(12, -2, np.int8)), "message: wanted values of -1 to 100, found -2 to -2"),
        (altered(data=np.full(12, 101, np.int8)), "message: wanted values of -1 to 100, found 101 to 101"),
        (altered(resolution=0.0), "resolution: wanted 0.0001 to 100 m per cell, found 0.0"),
        (altered(resolution=float("nan")), "resolution: wanted 0.0001 to 100 m per cell, found nan"),
        (grid_message(NEW, at_m=(float("inf"), 0.0)), "origin: wanted finite coordinates, found inf, 0"),
        (grid_message(NEW, turn=(0.0, 0.0, float("nan"), 1.0)), "origin: wanted a finite quaternion"),
    ],
    ids=lambda value: value if isinstance(value, str) else "message",
)
def test_what_is_no_map_is_named(message: Any, match: str) -> None:
    refused(message_source(message), match)


def test_damaged_messages_and_useless_options_are_named() -> None:
    refused(
        Source((("map.cdr", packed(grid_message(NEW))[:-1]),)), "message: wanted a complete nav_msgs/msg/OccupancyGrid"
    )
    refused(Source((("map.cdr", b"nothing"),)), "message: wanted a complete nav_msgs/msg/OccupancyGrid")
    refused(message_source(grid_message(NEW), unknown_value=205), "unknown value: wanted none for a message")
    refused(message_source(grid_message(NEW)), "size: wanted at most 11 cells, found 4 x 3", max_cells=11)
    refused(Source((("map.mcap", b"x"),)), "map: wanted the stored part of a bag, found a bag: map.mcap")


def says(path: Path, match: str, **options: Any) -> None:
    """Claim that reading fails with one line that has `match` and ends with the path."""
    with pytest.raises(MapError) as caught:
        read_map(path, **options)
    text = str(caught.value)
    assert match in text
    assert "\n" not in text
    assert text.endswith(f": {path}")


@pytest.mark.parametrize("suffix", [".mcap", ".db3", ".bag"])
def test_files_that_are_no_bags_are_named(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"kitchen{suffix}"
    says(path, "file: wanted a map, found none")
    for data in (b"", b"x", b"x" * 10_000):
        path.write_bytes(data)
        says(path, "found bytes that are none of them")


def test_bags_without_a_map_are_named(tmp_path: Path) -> None:
    none = "topic: wanted one of type nav_msgs/msg/OccupancyGrid, found none among 1 topics"
    says(bare_mcap(tmp_path / "chatter.mcap", [("/chatter", 1, text_message("x"))]), none)
    folder = ros2_bag(tmp_path / "packed", mapped(), MCAP, CompressionMode.FILE)
    check(read_map(folder))
    (tmp_path / "empty").mkdir()
    says(tmp_path / "empty", "file: wanted a map, found a folder without .mcap, .db3 or .bag files")
    (tmp_path / "empty" / "metadata.yaml").touch()
    says(tmp_path / "empty", "file: wanted a map, found a folder without .mcap, .db3 or .bag files")


BOMB = text_message("\0" * 60_000_000)
LITTLE = 1000


@pytest.mark.parametrize("kind", ["zstd.mcap", "lz4.mcap", "bz2.bag", "lz4.bag", "message.db3"])
def test_what_unpacks_to_very_much_is_refused(tmp_path: Path, kind: str) -> None:
    path, packing = tmp_path / kind, kind.partition(".")[0]
    if packing == "message":
        huge = [("/map", 1, grid_message(np.zeros((6000, 10_000), np.int8)))]
        path = file_of(ros2_bag(tmp_path / "bag", huge, SQLITE, CompressionMode.MESSAGE))
    elif path.suffix == ".mcap":
        bomb = [("/chatter", 1, BOMB), ("/map", 2, grid_message(NEW))]
        bare_mcap(path, bomb, compression=CompressionType[packing.upper()], chunk_size=1 << 30)
    else:
        bomb = [("/map", 1, grid_message(NEW, store=ROS1)), ("/chatter", 2, text_message(BOMB.data, store=ROS1))]
        ros1_bag(path, bomb, Writer1.CompressionFormat[packing.upper()])
    assert path.stat().st_size < 1_000_000
    tracemalloc.start()
    try:
        says(path, "wanted at most 33555432 bytes decompressed (--max-cells raises it), found more", max_cells=LITTLE)
        assert tracemalloc.get_traced_memory()[1] < 120_000_000
    finally:
        tracemalloc.stop()
    assert read_map(path, max_cells=100_000_000).cells.size


# --- damage


def samples(folder: Path) -> dict[str, bytes]:
    """One whole bag of each kind."""
    packed_mcap = ros2_bag(folder / "storage", mapped(), MCAP, CompressionMode.STORAGE)
    return {
        "plain.mcap": bare_mcap(folder / "plain.mcap", mapped(), use_chunking=False).read_bytes(),
        "zstd.mcap": file_of(packed_mcap).read_bytes(),
        "lz4.mcap": bare_mcap(folder / "lz4.mcap", mapped(), compression=CompressionType.LZ4).read_bytes(),
        "ours.mcap": (GOLDEN / "one-room.mcap").read_bytes(),
        "plain.db3": file_of(ros2_bag(folder / "sqlite", mapped(), SQLITE)).read_bytes(),
        "plain.bag": ros1_bag(folder / "plain.bag", mapped(ROS1)).read_bytes(),
        "bz2.bag": ros1_bag(folder / "bz2.bag", mapped(ROS1), Writer1.CompressionFormat.BZ2).read_bytes(),
        "map.cdr": packed(grid_message(NEW)),
    }


def outcome_of(path: Path) -> type:
    """What reading gave; anything but a sound grid or an error of one line fails."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", MapWarning)
        try:
            grid = read_map(path, max_cells=100_000)
        except MapError as error:
            return MapError if "\n" not in str(error) and str(error).endswith(f": {path}") else str
    return OccupancyGrid if grid.cells.min() >= -1 and grid.cells.max() <= 100 else int


def test_damage_gives_a_grid_or_one_line(tmp_path: Path) -> None:
    for name, data in samples(tmp_path).items():
        rng = np.random.default_rng(len(data))
        path, outcomes = tmp_path / f"damaged_{name}", set()
        for _ in range(200):
            path.write_bytes(corrupted(data, rng))
            outcomes.add(outcome_of(path))
        assert outcomes == {MapError, OccupancyGrid}, name
