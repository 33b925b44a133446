"""What is true: rooms as label image or drawn as blobs, doors marked as segments, or both."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vdoor.errors import MapError, VdoorError
from vdoor.evaluate.division import Division, MapChoice, check_size, is_result
from vdoor.evaluate.door_places import Doors, contact_doors, marked_doors
from vdoor.evaluate.label_files import Labels, read_table, read_true_rooms, rooms_of
from vdoor.formats.source import shown
from vdoor.formats.valetudo import segment_labels
from vdoor.formats.valetudo_json import is_valetudo

ENDINGS = ("_truth", "_reference", "_gt_segmentation")
"""What references are called beside the name of their map."""
SEGMENT = ("x1", "y1", "x2", "y2")


@dataclass(frozen=True, kw_only=True, eq=False)
class Reference:
    """The truth about one map."""

    path: Path
    rooms: Labels | None
    """Rooms 1, 2, ... (h, w); None where only doors are known."""
    doors: Doors
    unsure: Doors | None = None
    """Places where a door is neither right nor wrong."""


def read_reference(path: Path, key: str | None, division: Division, bare: MapChoice | None = None) -> Reference:
    """The truth in a file, about a map of the division's size.

    `key` names the map in a JSON that holds several. `bare` says which map the rooms of a label image were drawn on,
    if not the division's own: doors are looked for on its free cells, which furniture may cover in the division's.
    Raises `VdoorError` where the file cannot be read or is about another map.
    """
    if path.suffix.lower() != ".json":
        rooms = _rooms(path / "rooms.png" if is_result(path) else path, division)
        return Reference(path=path, rooms=rooms, doors=_contacts(rooms, path, division, bare))
    table = read_table(path)
    if "schema" in table:
        return _synthetic(table, path, division)
    if is_valetudo(table):
        rooms = _segments_of_maker(table, path, division)
        return Reference(path=path, rooms=rooms, doors=_contacts(rooms, path, division, bare))
    table = table if key is None else table[key]
    resolution_m = division.frame.resolution_m
    doors, unsure = (
        marked_doors(_segments(table, part, path), resolution_m) if part in table else None
        for part in ("doors", "ignore")
    )
    if doors is None:
        raise VdoorError(f"reference: wanted the key doors, found none: {path}")
    return Reference(path=path, rooms=None, doors=doors, unsure=unsure)


def bare_name(path: Path) -> str:
    """What a reference is about, by its name: without _truth, _reference or _gt_segmentation."""
    name = path.name if path.is_dir() else path.stem
    for ending in ENDINGS:
        name = name.removesuffix(ending)
    return name


def _rooms(path: Path, division: Division) -> Labels:
    """True rooms as the file has them."""
    labels = read_true_rooms(path)
    check_size("reference", labels, division.free, path)
    return rooms_of(labels, division.frame.resolution_m)


def _segments_of_maker(table: Mapping[str, Any], path: Path, division: Division) -> Labels:
    """Rooms as the robot's own software has them: something to compare with, not truth."""
    try:
        labels = segment_labels(table, max_cells=division.free.size)
    except MapError as error:
        raise VdoorError(f"reference: {error}: {path}") from error
    check_size("reference", labels, division.free, path)
    if not labels.any():
        raise VdoorError(f"reference: wanted segments, found none: {path}")
    return rooms_of(labels, division.frame.resolution_m)


def _contacts(rooms: Labels, path: Path, division: Division, bare: MapChoice | None) -> Doors:
    """Doors where true rooms touch: lines drawn between them are free there."""
    free = division.free
    if bare is not None:
        free = bare.read(bare_name(path))[1]
        check_size("reference", rooms, free, path)
    return contact_doors(rooms, free | (rooms > 0), division.frame.resolution_m)


def _synthetic(table: Mapping[str, Any], path: Path, division: Division) -> Reference:
    """The truth about a synthetic map: doors from jamb to jamb, and the rooms of the image beside it."""
    frame = division.frame
    size, resolution_m = table.get("size"), table.get("resolution_m")
    if size != {"height": frame.height, "width": frame.width}:
        raise VdoorError(
            f"reference: wanted {frame.width} x {frame.height} cells as the map, found {shown(size)}: {path}"
        )
    if not isinstance(resolution_m, float) or not math.isclose(resolution_m, frame.resolution_m, rel_tol=1e-9):
        wanted = f"{frame.resolution_m:g} m a cell as the map"
        raise VdoorError(f"reference: wanted {wanted}, found {shown(resolution_m)}: {path}")
    try:
        ends = [[door["start_cell"], door["end_cell"]] for door in table["doors"]]
        widths_m = np.array([door["width_m"] for door in table["doors"]], np.float64)
        doors = marked_doors(np.array(ends, np.float64).reshape(-1, 2, 2), frame.resolution_m, widths_m)
    except (KeyError, TypeError, ValueError) as error:
        raise VdoorError(
            f"reference: wanted doors with start_cell, end_cell and width_m, found none: {path}"
        ) from error
    image = path.with_suffix(".png")
    return Reference(path=path, rooms=_rooms(image, division) if image.exists() else None, doors=doors)


def _segments(table: Mapping[str, Any], part: str, path: Path) -> NDArray[np.float64]:
    """Segments (k, 2, 2) as row, col from a list of tables with x1, y1, x2, y2 in cells."""
    entries = table[part]
    if not isinstance(entries, Sequence) or isinstance(entries, str):
        raise VdoorError(f"reference: wanted a list of {part}, found a {type(entries).__name__}: {path}")
    ends = []
    for number, entry in enumerate(entries):
        values = [entry.get(name) for name in SEGMENT] if isinstance(entry, dict) else []
        if not values or not all(map(_is_number, values)):
            raise VdoorError(f"reference: {part}[{number}]: wanted numbers {', '.join(SEGMENT)}, found others: {path}")
        x1, y1, x2, y2 = values
        ends.append([[y1, x1], [y2, x2]])
    return np.array(ends, np.float64).reshape(-1, 2, 2)


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)
