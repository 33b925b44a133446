"""Bags for tests, written with rosbags and mcap."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from mcap.writer import Writer as McapWriter
from numpy.typing import NDArray
from rosbags.rosbag1 import Writer as Writer1
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin
from rosbags.rosbag2 import Writer as Writer2
from rosbags.typesys import Stores, get_typestore
from rosbags.typesys.store import Typestore

ROS1, ROS2 = get_typestore(Stores.ROS1_NOETIC), get_typestore(Stores.ROS2_JAZZY)
GRID = "nav_msgs/msg/OccupancyGrid"
Messages = Sequence[tuple[str, int, Any]]
"""Topic, time and message."""


def grid_message(
    cells: NDArray[np.int8],
    *,
    store: Typestore = ROS2,
    resolution_m: float = 0.05,
    at_m: tuple[float, float] = (-1.5, 2.25),
    turn: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 1.0),
) -> Any:
    """A message with cells (h, w), row 0 = top; the turn is a quaternion x, y, z, w."""
    make = store.types
    stamp = make["builtin_interfaces/msg/Time"](sec=1, nanosec=2)
    sequence = {"seq": 7} if store is ROS1 else {}
    pose = make["geometry_msgs/msg/Pose"](
        position=make["geometry_msgs/msg/Point"](x=at_m[0], y=at_m[1], z=0.0),
        orientation=make["geometry_msgs/msg/Quaternion"](**dict(zip("xyzw", turn, strict=True))),
    )
    height, width = cells.shape
    info = make["nav_msgs/msg/MapMetaData"](
        map_load_time=stamp, resolution=resolution_m, width=width, height=height, origin=pose
    )
    header = make["std_msgs/msg/Header"](**sequence, stamp=stamp, frame_id="map")
    return make[GRID](header=header, info=info, data=np.ascontiguousarray(cells[::-1]).reshape(-1))


def turned(yaw_rad: float) -> tuple[float, float, float, float]:
    return 0.0, 0.0, math.sin(yaw_rad / 2), math.cos(yaw_rad / 2)


def text_message(text: str, *, store: Typestore = ROS2) -> Any:
    return store.types["std_msgs/msg/String"](data=text)


def packed(message: Any) -> bytes:
    return bytes(ROS2.serialize_cdr(message, message.__msgtype__))


def ros2_bag(
    folder: Path, messages: Messages, plugin: StoragePlugin, mode: CompressionMode = CompressionMode.NONE
) -> Path:
    """A folder as ROS 2 records it."""
    writer = Writer2(folder, version=9, storage_plugin=plugin)
    if mode is not CompressionMode.NONE:
        writer.set_compression(mode, CompressionFormat.ZSTD)
    with writer:
        topics: dict[str, Any] = {}
        for topic, time_ns, message in messages:
            name = message.__msgtype__
            topics[topic] = topics.get(topic) or writer.add_connection(topic, name, typestore=ROS2)
            writer.write(topics[topic], time_ns, packed(message))
    return folder


def file_of(folder: Path) -> Path:
    """The one file with messages in a bag's folder."""
    (found,) = (path for path in folder.iterdir() if path.name != "metadata.yaml")
    return found


def ros1_bag(path: Path, messages: Messages, compression: Writer1.CompressionFormat | None = None) -> Path:
    writer = Writer1(path)
    if compression is not None:
        writer.set_compression(compression)
    with writer:
        topics: dict[str, Any] = {}
        for topic, time_ns, message in messages:
            name = message.__msgtype__
            topics[topic] = topics.get(topic) or writer.add_connection(topic, name, typestore=ROS1)
            writer.write(topics[topic], time_ns, ROS1.serialize_ros1(message, name))
    return path


def bare_mcap(
    path: Path, messages: Messages, *, encoding: str = "ros2msg", definition: bytes = b"", **how: Any
) -> Path:
    """An MCAP file as tools other than rosbags may write it."""
    with path.open("wb") as stream:
        writer = McapWriter(stream, **how)
        writer.start(profile="ros2")
        topics: dict[str, int] = {}
        for topic, time_ns, message in messages:
            if topic not in topics:
                schema = writer.register_schema(message.__msgtype__, encoding, definition)
                topics[topic] = writer.register_channel(topic, "cdr", schema)
            writer.add_message(topics[topic], time_ns, packed(message), time_ns)
        writer.finish()  # type: ignore[no-untyped-call]
    return path
