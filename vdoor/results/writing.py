"""The result as files: rooms.png with rooms.yaml, grid.png, map.json; later commands need nothing else."""

from __future__ import annotations

import dataclasses
import hashlib
import io
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from vdoor.emit import RunInfo
from vdoor.errors import VdoorError
from vdoor.grid import OccupancyGrid, Source
from vdoor.partial import together
from vdoor.results.annotations import table_of
from vdoor.topology import Door, Room, TopologicalMap

SCHEMA = 1
"""Incremented when a key is removed or changes its meaning; added keys do not change it."""
NAMES = ("rooms.png", "rooms.yaml", "grid.png", "map.json")
MOST_ROOMS = 65_535
GREY_OCCUPIED, GREY_UNKNOWN, GREY_FREE = 0, 205, 254


def write_result(folder: Path, grid: OccupancyGrid, topology: TopologicalMap, document: dict[str, Any]) -> None:
    """Write the four files into `folder`, created if missing; they get their names together."""
    with together() as staged:
        staged.make_folder(folder)
        for name, content in contents_of(folder, grid, topology, document):
            staged.add(folder / name, content)


def contents_of(
    folder: Path, grid: OccupancyGrid, topology: TopologicalMap, document: dict[str, Any]
) -> list[tuple[str, bytes]]:
    """The four files that are to be written into `folder`, by name, map.json first.

    The document is given the checksums of the others.

    Once map.json has its name, a reader takes the others under whichever name they have, so that a result is never
    made of two, even if the process is killed while it names them.
    """
    refuse_high_ids(folder, topology)
    others = {
        "rooms.png": png(topology.labels.astype(np.uint16)),
        "rooms.yaml": map_server_yaml(grid, "rooms.png"),
        "grid.png": png(greys(grid)),
    }
    document["files"] = {name: hashlib.sha256(content).hexdigest() for name, content in others.items()}
    return [("map.json", _json(document)), *others.items()]


def refuse_high_ids(folder: Path, topology: TopologicalMap) -> None:
    """Raise VdoorError if a room id is too high for a 16-bit label image."""
    if (most := int(topology.labels.max(initial=0))) > MOST_ROOMS:
        raise VdoorError(f"rooms.png: wanted room ids up to {MOST_ROOMS}, found {most}: {folder}")


def rewritten(folder: Path, topology: TopologicalMap, edits: Sequence[str]) -> list[tuple[Path, bytes]]:
    """The new contents of a result folder's files for an edited map; `edits` are all edits that led to it.

    Raises `VdoorError` if the map cannot be stored. All contents are made before any file is written, so that an error
    leaves the folder unchanged.
    """
    refuse_high_ids(folder, topology)
    document = json.loads((folder / "map.json").read_text(encoding="utf-8"))
    labels = png(topology.labels.astype(np.uint16))
    document |= _graph(topology)
    if "files" in document:
        document["files"]["rooms.png"] = hashlib.sha256(labels).hexdigest()
    document["settings"]["edit"] = document["settings"].get("edit", {}) | {"edits": list(edits)}
    try:
        text = _json(document)
    except ValueError as error:  # such as NaN, which Python reads although it is not valid JSON
        raise VdoorError(f"map.json: wanted finite numbers, found others: {folder}") from error
    return [(folder / "map.json", text), (folder / "rooms.png", labels)]


def _json(document: Mapping[str, Any]) -> bytes:
    """The document as JSON, a line for each field, room and door.

    Raises `ValueError` for numbers that are not finite.
    """
    return "".join(
        ["{\n", ",\n".join(f" {_name(name)}{_lines(value)}" for name, value in document.items()), "\n}\n"]
    ).encode()


def _lines(value: Any) -> str:
    """A value of a document, a line for each item of a list and for each list of a table."""
    if isinstance(value, list) and value and isinstance(value[0], dict):
        return "[\n  " + ",\n  ".join(map(_dumped, value)) + "\n ]"
    if isinstance(value, dict) and any(isinstance(item, list | dict) for item in value.values()):
        return "{\n  " + ",\n  ".join(f"{_name(name)}{_dumped(item)}" for name, item in value.items()) + "\n }"
    return _dumped(value)


def _name(name: str) -> str:
    return f"{json.dumps(name)}: "


_dumped = json.JSONEncoder(allow_nan=False).encode


def document_of(topology: TopologicalMap, info: RunInfo, timings_s: Mapping[str, float]) -> dict[str, Any]:
    """The content of map.json: lengths in metres, points as [x, y] in the map frame."""
    from vdoor.formats import read_annotations  # noqa: PLC0415  # loads all readers

    frame = topology.frame
    annotations = read_annotations(info.source)
    return {
        "schema": SCHEMA,
        "vdoor": info.version,
        "resolution_m": frame.resolution_m,
        "size": {"width": frame.width, "height": frame.height},
        "origin": {"x_m": frame.x_m, "y_m": frame.y_m, "yaw_rad": frame.yaw_rad},
        "source": source_table(info.source),
        "annotations": annotations and table_of(annotations),
        "preset": info.preset,
        "settings": dict(info.settings),
        "seed": info.seed,
        **_graph(topology),
        "timings_s": {stage: round(seconds, 4) for stage, seconds in timings_s.items()},
    }


def source_table(source: Source) -> dict[str, Any]:
    """Which files a map was read from, and how."""
    files = [{"name": name, "sha256": hashlib.sha256(data).hexdigest()} for name, data in source.files]
    return {"files": files, "options": dict(source.options)}


def _graph(topology: TopologicalMap) -> dict[str, Any]:
    rooms, doors = topology.rooms, topology.doors
    return {
        "rooms": [_room(room) for room in rooms],
        "doors": [_fields(door) for door in doors],
        "graph": {
            "nodes": [room.id for room in rooms],
            "edges": [{"door": door.id, "rooms": list(door.rooms)} for door in doors],
        },
    }


def _room(room: Room) -> dict[str, Any]:
    corners = [{"point_m": corner.point_m, "kind": "convex" if corner.convex else "concave"} for corner in room.corners]
    return _fields(room) | {"corners": corners}


def _fields(record: Room | Door) -> dict[str, Any]:
    """The fields by name, as they are: `dataclasses.asdict` would copy each point of a polygon."""
    return {field.name: getattr(record, field.name) for field in dataclasses.fields(record)}


def greys(grid: OccupancyGrid) -> NDArray[np.uint8]:
    """The grid (h, w) in map_server's three grey values."""
    grey = np.full(grid.cells.shape, GREY_UNKNOWN, np.uint8)
    grey[grid.free] = GREY_FREE
    grey[grid.occupied] = GREY_OCCUPIED
    return grey


def png(image: NDArray[np.uint8] | NDArray[np.uint16]) -> bytes:
    """An 8-bit or 16-bit grey PNG."""
    buffer = io.BytesIO()
    Image.fromarray(image).save(buffer, format="png", compress_level=4)
    return buffer.getvalue()


def map_server_yaml(grid: OccupancyGrid, image: str, *, mode: str = "raw") -> bytes:
    """The YAML file that ROS map_server needs with an image of the grid's shape."""
    import yaml  # noqa: PLC0415  # reading a result needs none

    frame = grid.frame
    dumper: Any = getattr(yaml, "CSafeDumper", yaml.SafeDumper)  # the same text, ten times as fast
    text: str = yaml.dump(
        {
            "image": image,
            "mode": mode,
            "resolution": frame.resolution_m,
            "origin": [frame.x_m, frame.y_m, frame.yaw_rad],
            "negate": 0,
            "occupied_thresh": 0.65,
            "free_thresh": 0.196,
        },
        Dumper=dumper,
        sort_keys=False,
        default_flow_style=None,
    )
    return text.encode()
