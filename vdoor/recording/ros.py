"""ROS 2 messages, written and read as CDR bytes; the only module here that imports rosbags."""

from __future__ import annotations

import functools
import struct
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from vdoor.errors import RecordingError

if TYPE_CHECKING:
    from rosbags.typesys.store import Typestore

FRAME_ID = "map"
NS_PER_S = 1_000_000_000


@functools.cache
def store() -> Typestore:
    """Message types of one ROS 2 release; those used here are the same in all recent releases."""
    from rosbags.typesys import Stores, get_typestore  # noqa: PLC0415  # only recordings need it

    return get_typestore(Stores.ROS2_JAZZY)


def make(name: str, /, **fields: Any) -> Any:
    """Message of type `name` (``nav_msgs/msg/OccupancyGrid``); all of its fields must be given."""
    return store().types[name](**fields)


def pack(message: Any) -> memoryview:
    """Bytes of a message as little-endian CDR."""
    return store().serialize_cdr(message, message.__msgtype__, little_endian=True)


def unpack(data: bytes | memoryview, name: str) -> Any:
    """Message of type `name` in `data`; its arrays are views of `data`, so false sizes cost no memory.

    Raises `RecordingError` if the bytes are not such a message.
    """
    from rosbags.serde import SerdeError  # noqa: PLC0415  # only recordings need it

    try:
        return store().deserialize_cdr(data, name)
    except (SerdeError, struct.error, ValueError, IndexError, OverflowError) as error:
        raise RecordingError(f"wanted a {name} message, found other bytes ({error})") from error


def definition(name: str) -> bytes:
    """Definition of message type `name` and of all types in it, in the format of ``ros2msg`` schemas."""
    text, _ = store().generate_msgdef(name, ros_version=2)
    return text.encode()


def stamp(time_ns: int) -> Any:
    """ROS time of `time_ns` since 1970."""
    return make("builtin_interfaces/msg/Time", sec=time_ns // NS_PER_S, nanosec=time_ns % NS_PER_S)


def header(time_ns: int) -> Any:
    """Header in the map frame."""
    return make("std_msgs/msg/Header", stamp=stamp(time_ns), frame_id=FRAME_ID)


def point(x_m: float, y_m: float) -> Any:
    """Point at height 0."""
    return make("geometry_msgs/msg/Point", x=float(x_m), y=float(y_m), z=0.0)


def pose(x_m: float = 0.0, y_m: float = 0.0, *, z: float = 0.0, w: float = 1.0) -> Any:
    """Pose at height 0, rotated about the vertical by the quaternion (0, 0, z, w)."""
    turn = make("geometry_msgs/msg/Quaternion", x=0.0, y=0.0, z=float(z), w=float(w))
    return make("geometry_msgs/msg/Pose", position=point(x_m, y_m), orientation=turn)


def path(point_m: NDArray[np.float64], yaw_rad: NDArray[np.float64], *, time_ns: int) -> Any:
    """nav_msgs/Path through points (k, 2), x, y in metres, with the heading (k,) at each."""
    with np.errstate(invalid="ignore"):  # a damaged recording can hold any number
        turns = np.stack([np.sin(yaw_rad / 2), np.cos(yaw_rad / 2)], axis=1)
    poses = [
        make("geometry_msgs/msg/PoseStamped", header=header(time_ns), pose=pose(*at, z=z, w=w))
        for at, (z, w) in zip(point_m.tolist(), turns.tolist(), strict=True)
    ]
    return make("nav_msgs/msg/Path", header=header(time_ns), poses=poses)
