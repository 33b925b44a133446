"""Rasters as messages: occupancy as an OccupancyGrid, codes and labels as an Image."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from vdoor.errors import RecordingError
from vdoor.frame import Frame
from vdoor.record import Record
from vdoor.recording import ros

Encodings = dict[str, tuple[str, int, int]]
"""By the ROS name of a pixel type: its numpy name and the smallest and largest value stored in it."""
LABELS: Encodings = {"16UC1": ("<u2", 0, 2**16 - 1), "32SC1": ("<i4", -(2**31), 2**31 - 1)}


def codes(words: tuple[str, ...]) -> Encodings:
    """Encoding of codes that are indices into `words`."""
    return {"8UC1": ("u1", 0, len(words) - 1)}


def occupancy_grid(cells: NDArray[np.int8], frame: Frame, time_ns: int) -> Any:
    """An occupancy raster (h, w) as a nav_msgs/OccupancyGrid."""
    return ros.make(
        Grid.message,
        header=ros.header(time_ns),
        info=_info(frame, cells.shape, time_ns),
        data=np.ascontiguousarray(cells[::-1]).reshape(-1),
    )


@dataclass(frozen=True)
class Grid:
    """An occupancy raster as an OccupancyGrid, where row 0 is at the bottom."""

    place: str
    field: str

    message: ClassVar[str] = "nav_msgs/msg/OccupancyGrid"

    def encode(self, record: Record, time_ns: int) -> Any:
        """Message with the pose of the record's frame."""
        return occupancy_grid(getattr(record, self.field), frame_of(record), time_ns)

    def decode(self, message: Any) -> dict[str, NDArray[np.int8]]:
        """Raster by its field's name; `RecordingError` if the message does not contain a valid one."""
        cells = _shaped(self.place, message.data, message.info.height, message.info.width)
        check_range(self.place, cells, -1, 100)
        return {self.field: np.ascontiguousarray(cells[::-1])}


@dataclass(frozen=True)
class Picture:
    """A raster of codes or labels as an Image, in the first encoding that holds all of its values."""

    place: str
    field: str
    dtype: np.dtype[Any]
    encodings: Encodings

    message: ClassVar[str] = "sensor_msgs/msg/Image"

    def encode(self, record: Record, time_ns: int) -> Any:
        """Message with row 0 at the top, as in the record."""
        raster = getattr(record, self.field)
        least, greatest = raster.min(initial=0), raster.max(initial=0)
        name = next(name for name, (_, low, high) in self.encodings.items() if low <= least and greatest <= high)
        pixels = np.ascontiguousarray(raster, dtype=self.encodings[name][0])
        return ros.make(
            self.message,
            header=ros.header(time_ns),
            height=pixels.shape[0],
            width=pixels.shape[1],
            encoding=name,
            is_bigendian=0,
            step=pixels.shape[1] * pixels.itemsize,
            data=pixels.reshape(-1).view(np.uint8),
        )

    def decode(self, message: Any) -> dict[str, NDArray[Any]]:
        """Raster by its field's name; `RecordingError` if the message does not contain a valid one."""
        if message.encoding not in self.encodings or message.is_bigendian:
            end = "big" if message.is_bigendian else "little"
            raise RecordingError(
                f"{self.place}: wanted {' or '.join(self.encodings)} little endian, found {message.encoding!r} {end}"
            )
        name, low, high = self.encodings[message.encoding]
        step = message.width * np.dtype(name).itemsize
        if message.step != step:
            raise RecordingError(f"{self.place}: wanted {step} bytes a row, found {message.step}")
        data = _shaped(self.place, message.data, message.height, step)
        pixels = data.reshape(-1).view(name).reshape(message.height, message.width)
        check_range(self.place, pixels, low, high)
        return {self.field: pixels.astype(self.dtype)}


def frame_of(record: Record) -> Frame:
    """Frame of a record; all records with rasters or cells have one."""
    frame = getattr(record, "frame", None)
    assert isinstance(frame, Frame), f"{type(record).__name__} has no frame"
    return frame


def check_range(place: str, values: NDArray[Any], low: int, high: int) -> None:
    """Raise `RecordingError` if a value is outside `low` to `high`, both included."""
    if values.size == 0:
        return
    info = np.iinfo(values.dtype)
    if low > info.min and values.min() < low:
        raise RecordingError(f"{place}: wanted values from {low}, found {values.min()}")
    if high < info.max and values.max() > high:
        raise RecordingError(f"{place}: wanted values to {high}, found {values.max()}")


def _shaped(place: str, data: NDArray[Any], height: int, width: int) -> NDArray[Any]:
    """View of `data` as (height, width); `RecordingError` if its size does not match."""
    if height * width != data.size:
        raise RecordingError(f"{place}: wanted {height} x {width} = {height * width} elements, found {data.size}")
    return data.reshape(height, width)


def _info(frame: Frame, shape: tuple[int, int], time_ns: int) -> Any:
    """Size and pose of a grid; `resolution` is a float32, so the exact value is stored with the record's numbers."""
    half_rad = frame.yaw_rad / 2
    return ros.make(
        "nav_msgs/msg/MapMetaData",
        map_load_time=ros.stamp(time_ns),
        resolution=frame.resolution_m,
        width=shape[1],
        height=shape[0],
        origin=ros.pose(frame.x_m, frame.y_m, z=math.sin(half_rad), w=math.cos(half_rad)),
    )
