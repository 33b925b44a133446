"""Messages for third-party viewers, written beside the records: markers, a coloured picture and log lines.

They repeat what the records contain and are never read back, so records' topics and fields are named here directly.
"""

from __future__ import annotations

import colorsys
import functools
import io
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vdoor.errors import RecordingError
from vdoor.grid import FREE_TO
from vdoor.record import Record, sizes
from vdoor.recording import ros
from vdoor.recording.rasters import occupancy_grid

MARKERS, PICTURE, LOG = "/vdoor/markers", "/vdoor/map/picture", "/rosout"
PATHS = {"route": "/vdoor/route/path", "coverage": "/vdoor/coverage/path"}
SWEPT = "/vdoor/coverage/percent_of_time"
TOPICS = (MARKERS, PICTURE, *PATHS.values(), SWEPT, LOG)
INFO = 20
CUBE_LIST, LINE_LIST, TEXT, DELETE_ALL = 6, 5, 9, 3
PICTURE_TO_PX = 4096
"""Longest side of the picture; a larger map is subsampled to every second, third, ... cell."""
GREYS = 3
"""Number of palette colours before the rooms' hues: free, unknown, occupied."""
HUES = 251

Segments = NDArray[np.float64]
"""Line segments (k, 2, 2): start and end, each x, y in metres."""


def for_viewers(
    record: Record, *, time_ns: int, cells: NDArray[np.int8] | None
) -> Iterator[tuple[str, str, memoryview]]:
    """Topic, ROS type and CDR bytes of the viewer messages for a record; `cells` is the input map."""
    yield LOG, "rcl_interfaces/msg/Log", ros.pack(_log(record, time_ns))
    if record.topic in DRAW:
        yield MARKERS, "visualization_msgs/msg/MarkerArray", ros.pack(_markers(record, time_ns))
    if record.topic == "map" and cells is not None:
        yield PICTURE, "sensor_msgs/msg/CompressedImage", ros.pack(_picture(record, time_ns, cells=cells))
    if record.topic in PATHS:
        yield PATHS[record.topic], "nav_msgs/msg/Path", ros.pack(ros.path(*_path(record), time_ns=time_ns))
    if record.topic == "coverage":
        yield SWEPT, "nav_msgs/msg/OccupancyGrid", ros.pack(_swept(record, time_ns))


def _path(record: Any) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Points and headings of a route or of a covering path."""
    return record.point_m, record.yaw_rad


def _swept(record: Any, time_ns: int) -> Any:
    """When each cell is swept, in per cent of the path's time; -1 for cells that are not."""
    swept = np.clip(record.swept, 0, len(record.at_s))  # damaged records may hold anything
    at_s = np.nan_to_num(np.clip(record.at_s, 0, None))
    percent = np.rint(100 * np.append(at_s / (at_s.max(initial=0) or 1.0), 1))
    return occupancy_grid(np.where(swept > 0, percent[swept], -1).astype(np.int8), record.frame, time_ns)


def _log(record: Record, time_ns: int) -> Any:
    texts = {"name": "vdoor", "msg": f"{type(record).__name__}: {sizes(record)}", "file": "", "function": ""}
    return ros.make("rcl_interfaces/msg/Log", stamp=ros.stamp(time_ns), level=INFO, line=0, **texts)


def _initial(record: Any) -> tuple[Segments, NDArray[np.float64], Segments]:
    """Doors, region centres and graph lines (from a door's middle to each region it borders) of the initial map."""
    world = record.frame.world_from_cell
    doors = np.stack([world(record.start), world(record.end)], axis=1)
    centres_m = world(record.centre)
    links = _links(doors, centres_m, door=record.border_edge, room=record.border_region)
    return doors, centres_m, links


def _final(record: Any) -> tuple[Segments, NDArray[np.float64], Segments]:
    """Doors, room centres and graph lines (from a door's middle to both of its rooms) of the final map."""
    doors = np.stack([record.start_m, record.end_m], axis=1)
    centres_m = record.frame.world_from_cell(record.centre)
    door, ids = np.arange(len(doors)), np.array(_room_ids(record), np.int64)
    rows = [
        np.where(np.isin(room, ids), np.searchsorted(ids, room), len(ids)) for room in (record.room_a, record.room_b)
    ]
    return doors, centres_m, np.concatenate([_links(doors, centres_m, door=door, room=row) for row in rows])


def _room_ids(record: Any) -> Sequence[int]:
    """Ids of the final map's rooms; 1, 2, ... if the labels do not have one id per row."""
    try:
        found: Sequence[int] = record.room_ids
    except RecordingError:
        return range(1, len(record.centre) + 1)
    return found


def _room_texts(record: Any) -> list[str]:
    """Labels of the rooms: names, or numbers for unnamed rooms and for regions."""
    if record.topic == "initial_map":
        return [str(region) for region in range(len(record.centre))]
    numbers = _room_ids(record)
    return [name or str(room) for room, name in zip(numbers, record.name or [""] * len(numbers), strict=True)]


DRAW = {"initial_map": _initial, "map": _final}


def _links(doors: Segments, centres_m: NDArray[np.float64], *, door: NDArray[Any], room: NDArray[Any]) -> Segments:
    """Lines from the middle of each door to a room's centre, for pairs where both exist."""
    both = (door >= 0) & (door < len(doors)) & (room >= 0) & (room < len(centres_m))
    middles_m = doors[door[both]].mean(axis=1)
    return np.stack([middles_m, centres_m[room[both]]], axis=1)


def _markers(record: Record, time_ns: int) -> Any:
    """All markers of one graph; they replace those of the previous graph."""
    doors, centres_m, links = DRAW[record.topic](record)
    size_m = record.frame.resolution_m  # type: ignore[attr-defined]  # both graphs have one
    ids = iter(range(len(centres_m) + 4))
    marker = functools.partial(_marker, time_ns=time_ns, ns=record.topic)
    labels = [
        marker(TEXT, id=next(ids), at_m=at_m, text=text, size_m=6 * size_m, rgb=(0.1, 0.1, 0.1))
        for text, at_m in zip(_room_texts(record), centres_m, strict=True)
    ]
    shapes = [
        marker(DELETE_ALL, id=next(ids)),
        marker(LINE_LIST, id=next(ids), points_m=doors.reshape(-1, 2), size_m=size_m, rgb=(0.9, 0.1, 0.1)),
        marker(LINE_LIST, id=next(ids), points_m=links.reshape(-1, 2), size_m=size_m / 2, rgb=(0.1, 0.3, 0.9)),
        marker(CUBE_LIST, id=next(ids), points_m=centres_m, size_m=3 * size_m, rgb=(0.1, 0.3, 0.9)),
    ]
    return ros.make("visualization_msgs/msg/MarkerArray", markers=shapes + labels)


def _marker(
    kind: int,
    *,
    id: int,  # noqa: A002  # the message's own name for it
    time_ns: int,
    ns: str,
    points_m: NDArray[np.float64] | None = None,
    at_m: NDArray[np.float64] | None = None,
    text: str = "",
    size_m: float = 0.0,
    rgb: tuple[float, float, float] = (0.0, 0.0, 0.0),
) -> Any:
    """Marker of one kind; fields that the kind does not use stay empty."""
    none = np.zeros(0, np.uint8)
    header = ros.header(time_ns)
    colour = dict(zip("rgb", rgb, strict=True))
    return ros.make(
        "visualization_msgs/msg/Marker",
        header=header,
        ns="" if kind == DELETE_ALL else ns,
        id=id,
        type=0 if kind == DELETE_ALL else kind,
        action=kind if kind == DELETE_ALL else 0,
        pose=ros.pose(*([] if at_m is None else at_m)),
        scale=ros.make("geometry_msgs/msg/Vector3", x=size_m, y=size_m, z=size_m),
        color=ros.make("std_msgs/msg/ColorRGBA", **colour, a=1.0),
        lifetime=ros.make("builtin_interfaces/msg/Duration", sec=0, nanosec=0),
        frame_locked=False,
        points=[] if points_m is None else [ros.point(*point) for point in points_m],
        colors=[],
        texture_resource="",
        texture=ros.make("sensor_msgs/msg/CompressedImage", header=header, format="", data=none),
        uv_coordinates=[],
        text=text,
        mesh_resource="",
        mesh_file=ros.make("visualization_msgs/msg/MeshFile", filename="", data=none),
        mesh_use_embedded_materials=False,
    )


def _picture(record: Any, time_ns: int, *, cells: NDArray[np.int8]) -> Any:
    """Rooms in colour over the input map, as a PNG with a palette."""
    from PIL import Image  # noqa: PLC0415  # only a recording needs it

    every = -(-max(record.labels.shape) // PICTURE_TO_PX) or 1
    labels = record.labels[::every, ::every]
    shown = _GREY[cells[::every, ::every].view(np.uint8)]
    if shown.shape == labels.shape:
        np.copyto(shown, (labels % HUES + GREYS).astype(np.uint8), where=labels > 0)
    image = Image.fromarray(shown)
    image.putpalette(_palette())
    png = io.BytesIO()
    image.save(png, "png", compress_level=3)
    data = np.frombuffer(png.getvalue(), np.uint8)
    return ros.make("sensor_msgs/msg/CompressedImage", header=ros.header(time_ns), format="png", data=data)


_GREY = np.array([0] * (FREE_TO + 1) + [2] * (127 - FREE_TO) + [1] * 128, np.uint8)
"""Palette index of each cell value, taken as an unsigned byte: -1 is 255."""


@functools.cache
def _palette() -> bytes:
    """Free, unknown, occupied, then one hue per room; consecutive room numbers get distant hues."""
    golden = 0.618034
    rooms = [colorsys.hsv_to_rgb(i * golden % 1, 0.55, 0.95) for i in range(HUES)]
    greys = [254] * 3 + [205] * 3 + [0] * 3
    return bytes(greys) + bytes(round(255 * c) for rgb in rooms for c in rgb)
