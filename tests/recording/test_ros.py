"""A recording as ROS 2 tools take it: a bag of standard types, each message such that RViz and Foxglove draw it.

Neither those two nor `ros2 bag` can run here, so that what they ask of a message is asked in their place.
"""

from __future__ import annotations

import functools
from collections import Counter
from pathlib import Path
from typing import Any

import mcap.reader
import numpy as np
import pytest
from project import FLAT
from rosbags.highlevel import AnyReader
from rosbags.typesys import Stores, get_typestore

import vdoor
from vdoor.config import settings_of
from vdoor.emit import Recorder, RunInfo
from vdoor.pipeline import METHODS, PRESETS
from vdoor.recording.mcap import McapSink, time_ns

DRAWN = {
    "/vdoor/input/cells": "nav_msgs/msg/OccupancyGrid",
    "/vdoor/simplified/cells": "nav_msgs/msg/OccupancyGrid",
    "/vdoor/corners/corner": "sensor_msgs/msg/PointCloud2",
    "/vdoor/markers": "visualization_msgs/msg/MarkerArray",
    "/vdoor/map/picture": "sensor_msgs/msg/CompressedImage",
    "/rosout": "rcl_interfaces/msg/Log",
}
"""Topics that the two have a display for, with what it takes."""
LINE_LIST, CUBE_LIST, TEXT, DELETE_ALL = 5, 6, 9, 3
SIZES = np.array([0, 1, 1, 2, 2, 4, 4, 4, 8])
"""Bytes of PointField's types, by their numbers."""
presets = pytest.mark.parametrize("preset", ["paper", "default"])


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("ros")
    grid = vdoor.read_map(FLAT)
    for preset in ("paper", "default"):
        settings = settings_of(PRESETS[preset], METHODS)
        info = RunInfo(version="0.1.0", preset=preset, seed=0, settings=settings, source=grid.source)
        sink = McapSink(folder / f"{preset}.mcap", info)
        vdoor.run(grid, preset, emit=Recorder([sink]))
        sink.close()
    return folder


@functools.cache
def messages(path: Path) -> list[tuple[str, int, Any]]:
    """Topic, time and message of all, by the definitions that the file itself holds."""
    with AnyReader([path]) as reader:
        return [(c.topic, time, reader.deserialize(data, c.msgtype)) for c, time, data in reader.messages()]


def of_type(path: Path, name: str) -> list[Any]:
    found = [message for _, _, message in messages(path) if message.__msgtype__ == name]
    assert found
    return found


@presets
def test_a_recording_is_a_bag_of_ros_2(preset: str, folder: Path) -> None:
    with (folder / f"{preset}.mcap").open("rb") as stream:
        reader = mcap.reader.make_reader(stream, validate_crcs=True)
        summary = reader.get_summary()
        assert reader.get_header().profile == "ros2"
        assert summary
        assert summary.statistics
        assert {schema.encoding for schema in summary.schemas.values()} == {"ros2msg"}
        assert {channel.message_encoding for channel in summary.channels.values()} == {"cdr"}
        found = [(schema.name, channel.topic, message) for schema, channel, message in reader.iter_messages()]
    assert len(found) == summary.statistics.message_count == len(messages(folder / f"{preset}.mcap"))
    assert {topic: name for name, topic, _ in found if topic in DRAWN} == DRAWN
    times = [message.log_time for _, _, message in found]
    assert times == sorted(times) == [message.publish_time for _, _, message in found]


@pytest.mark.parametrize("release", [Stores.ROS2_HUMBLE, Stores.ROS2_JAZZY, Stores.ROS2_KILTED])
def test_all_types_are_those_of_the_release(release: Stores, folder: Path) -> None:
    own = get_typestore(release)
    with AnyReader([folder / "default.mcap"]) as reader:
        for connection in reader.connections:
            name = connection.msgtype
            assert reader.typestore.hash_rihs01(name) == own.hash_rihs01(name)


@presets
def test_everything_is_in_the_map_frame_at_the_time_of_its_record(preset: str, folder: Path) -> None:
    first = time_ns(0)
    for topic, time, message in messages(folder / f"{preset}.mcap"):
        assert (time - first) % (time_ns(1) - first) == 0
        stamped = message.markers if topic == "/vdoor/markers" else [message]
        for header in (part.header for part in stamped if hasattr(part, "header")):
            assert header.frame_id == "map"
            assert header.stamp.sec * 10**9 + header.stamp.nanosec == time


@presets
def test_grids_have_the_cells_they_claim_and_a_pose(preset: str, folder: Path) -> None:
    for grid in of_type(folder / f"{preset}.mcap", "nav_msgs/msg/OccupancyGrid"):
        assert len(grid.data) == grid.info.width * grid.info.height > 0
        assert grid.info.resolution > 0
        assert set(np.unique(grid.data)) <= {-1, *range(101)}
        assert norm(grid.info.origin.orientation) == pytest.approx(1)


@presets
def test_point_clouds_have_the_bytes_they_claim(preset: str, folder: Path) -> None:
    for cloud in of_type(folder / f"{preset}.mcap", "sensor_msgs/msg/PointCloud2"):
        assert [(field.name, field.offset, field.datatype) for field in cloud.fields[:3]] == [
            ("x", 0, 7),
            ("y", 4, 7),
            ("z", 8, 7),
        ]
        ends = [field.offset + SIZES[field.datatype] * field.count for field in cloud.fields]
        assert all(end <= after.offset for end, after in zip(ends, cloud.fields[1:], strict=False))
        assert ends[-1] <= cloud.point_step
        assert cloud.row_step == cloud.width * cloud.point_step
        assert len(cloud.data) == cloud.row_step * cloud.height
        assert not cloud.is_bigendian


@presets
def test_markers_are_such_as_rviz_draws(preset: str, folder: Path) -> None:
    arrays = of_type(folder / f"{preset}.mcap", "visualization_msgs/msg/MarkerArray")
    for array in arrays:
        delete, *shapes = array.markers  # what was drawn of the graph before goes
        assert delete.action == DELETE_ALL
        assert Counter((marker.ns, marker.id) for marker in shapes).most_common(1)[0][1] == 1
        for marker in shapes:
            assert (marker.action, marker.color.a) == (0, 1)
            assert marker.scale.x > 0 < marker.scale.z
            assert norm(marker.pose.orientation) == 1
            assert marker.type in (LINE_LIST, CUBE_LIST, TEXT)
            assert marker.type != LINE_LIST or len(marker.points) % 2 == 0
            assert bool(marker.text) == (marker.type == TEXT)
    final = [marker for marker in arrays[-1].markers if marker.ns == "map"]
    rooms, doors = 5, 4
    assert [len(marker.points) for marker in final[:3]] == [2 * doors, 4 * doors, rooms]
    assert len(final[3:]) == rooms


@presets
def test_the_picture_is_a_png_of_the_maps_size(preset: str, folder: Path) -> None:
    (picture,) = of_type(folder / f"{preset}.mcap", "sensor_msgs/msg/CompressedImage")
    assert picture.format == "png"
    assert picture.data[:8].tobytes() == b"\x89PNG\r\n\x1a\n"


def norm(turn: Any) -> float:
    return float(np.hypot(np.hypot(turn.x, turn.y), np.hypot(turn.z, turn.w)))
