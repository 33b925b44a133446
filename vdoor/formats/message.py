"""A single ``nav_msgs/OccupancyGrid`` message in ROS 2's wire format (CDR): the stored part of a bag."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vdoor.errors import MapError, RecordingError
from vdoor.formats.occupancy import decided
from vdoor.formats.source import Request, agreed_resolution_m, check_size, check_values, checked_resolution_m, shown
from vdoor.grid import OccupancyGrid
from vdoor.recording import ros

SUFFIX = ".cdr"
TYPE = "nav_msgs/msg/OccupancyGrid"
LEVEL_WITHIN = 1e-3
"""Sine of the largest tilt of the map's z axis that is ignored without a note."""


def read(request: Request) -> OccupancyGrid:
    """The grid of a message, with the message's origin and resolution."""
    name = request.name
    with request.naming(name):
        request.refuse_unknown_value("a message")
        message = _message(request.data(name))
        info, pose = message.info, message.info.origin
        cells, source = decided(_cells(message, max_cells=request.max_cells), request)
        resolution_m = agreed_resolution_m(_resolution_m(info.resolution), request.resolution_m)
        x_m, y_m = pose.position.x, pose.position.y
        if not (math.isfinite(x_m) and math.isfinite(y_m)):
            raise MapError(f"origin: wanted finite coordinates, found {x_m:g}, {y_m:g}")
        yaw_rad = _yaw_rad(pose.orientation, request)
        request.note_turn(yaw_rad)
    return OccupancyGrid.from_array(cells, resolution_m, x_m=x_m, y_m=y_m, yaw_rad=yaw_rad, source=source)


def _message(data: bytes) -> Any:
    """The message in `data`; its arrays are views of `data`."""
    try:
        return ros.unpack(data, TYPE)
    except RecordingError as error:
        raise MapError(
            f"message: wanted a complete {TYPE}, found a damaged one ({shown(str(error.__cause__))})"
        ) from error


def _cells(message: Any, *, max_cells: int) -> NDArray[np.int8]:
    """The cells (h, w), row 0 = top; in the message row 0 is the bottom."""
    height, width = message.info.height, message.info.width
    check_size(height, width, max_cells=max_cells)
    if message.data.size != height * width:
        raise MapError(f"message: wanted {width} x {height} = {height * width} cells, found {message.data.size}")
    check_values("message", message.data)
    cells: NDArray[np.int8] = message.data.reshape(height, width)[::-1]
    return cells


def _resolution_m(single: float) -> float:
    """The resolution in metres per cell: the shortest decimal with the message's float32 value, such as 0.05."""
    with np.errstate(over="ignore"):
        return checked_resolution_m(float(str(np.float32(single))))


def _yaw_rad(turn: Any, request: Request) -> float:
    """The yaw of a quaternion of any length; adds a note if the quaternion is zero or the map is tilted."""
    x, y, z, w = turn.x, turn.y, turn.z, turn.w
    length = math.hypot(x, y, z, w)
    if not math.isfinite(length):
        raise MapError("origin: wanted a finite quaternion, found one that is not")
    if length == 0:
        request.note("origin: the quaternion is all zeros, using no rotation", request.name)
        return 0.0
    x, y, z, w = x / length, y / length, z / length, w / length
    if math.hypot(2 * (x * z + w * y), 2 * (y * z - w * x)) > LEVEL_WITHIN:
        request.note("origin: the map is tilted, using its yaw only", request.name)
    return math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))
