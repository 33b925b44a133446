"""Reading the finished map from a recording or a result folder, without running anything again."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from vdoor.errors import RecordingError, VdoorError
from vdoor.evaluate.label_files import read_image, read_labels, read_table
from vdoor.evaluate.result_files import file_in, own_file
from vdoor.formats.source import checked_resolution_m, shown
from vdoor.frame import Frame
from vdoor.grid import FREE, OCCUPIED, UNKNOWN, Annotations, OccupancyGrid
from vdoor.kinds import kind_of
from vdoor.method.finished import Doors, Features, map_of
from vdoor.raster.runs import runs_of
from vdoor.record import TEXT
from vdoor.results.annotations import read_table as annotations_in
from vdoor.results.segments import named_by_robot
from vdoor.results.writing import GREY_FREE, GREY_OCCUPIED, NAMES, SCHEMA
from vdoor.topology import KINDS, Door, TopologicalMap

if TYPE_CHECKING:
    from vdoor.history.provenance import Provenance

Ints = NDArray[np.int32]
Feature = tuple[int, bool, tuple[float, float]]
"""A corner: its room, whether it is convex, and its position as x, y."""


@dataclass(frozen=True)
class Finished:
    """The result of a finished run."""

    topology: TopologicalMap
    provenance: Provenance | None = None
    """The provenance of the run, if requested."""
    settings: Mapping[str, Any] = field(default_factory=dict)
    """The settings of the run, as nested tables."""
    annotations: Annotations | None = None
    """What the robot's map file says besides the cells; None for other maps."""


def read_finished(path: str | Path, *, provenance: bool = False) -> Finished:
    """The result of a finished run: the last record of an .mcap, or a folder written by `vdoor run --out`.

    Raises `VdoorError` if it is missing or damaged, or if its files do not belong together.
    """
    path = Path(path)
    if path.is_file() and path.suffix != ".mcap" and (kind := kind_of(path)) != "an MCAP recording":
        advice = "`vdoor run MAP --out FOLDER` makes a folder"
        raise VdoorError(f"result: wanted a folder from `vdoor run --out` or an .mcap, found {kind}; {advice}: {path}")
    return read_result(path, provenance=provenance) if path.is_dir() else read_last(path, provenance=provenance)


def files_of(path: Path) -> list[Path]:
    """The files of a result: all that `read_finished` reads, and those that belong to them."""
    return [path / name for name in NAMES] if path.is_dir() else [path]


def read_last(path: Path, *, provenance: bool = False) -> Finished:
    """The result at the end of a recording; raises `RecordingError` if the run is not finished."""
    from vdoor.api import in_own_frame  # noqa: PLC0415  # a result folder is read without the method
    from vdoor.formats import read_annotations  # noqa: PLC0415
    from vdoor.history.provenance import Provenance  # noqa: PLC0415
    from vdoor.pipeline import RECORDS  # noqa: PLC0415
    from vdoor.recording.mcap import read_recording  # noqa: PLC0415

    topic, found = "nothing", None
    recording = read_recording(path, types=RECORDS)
    origin = Provenance.of(recording.info) if provenance else None
    for step, record in recording:
        topic = record.topic
        if isinstance(record, TopologicalMap):
            annotations = read_annotations(recording.info.source)
            placed = in_own_frame(record.written, recording.info.source)
            found = Finished(named_by_robot(placed, annotations), origin, recording.info.settings, annotations)
        elif origin:
            origin.run.write(step, record)
        if found and not origin:
            break
    if found:
        return found
    raise RecordingError(f"recording: wanted a finished run, found one that ends with {topic}: {path}")


def read_result(folder: Path, *, provenance: bool = False) -> Finished:
    """The result in a folder: rooms from rooms.png, doors and corners from map.json.

    Areas, centres and polygons are computed from the label image, as when it was written. Doors and corners are rounded
    as in a map that is read from a recording (`TopologicalMap.written`), so that both give the same exports. The edges
    of the initial map and the corners' numbers, which only a recording contains, are -1.
    """
    for name in ("map.json", "rooms.png"):
        if not (folder / name).is_file():
            raise VdoorError(f"result: wanted a folder written by `vdoor run --out`, found no {name} in it: {folder}")
    document = read_table(folder / "map.json")
    labels = read_labels(file_in(folder, "rooms.png", document)).astype(np.int32)
    with _naming(folder):
        if document["schema"] != SCHEMA:
            raise VdoorError(f"map.json: wanted schema {SCHEMA}, found {shown(document['schema'])}")
        rooms = _rooms(document["rooms"], labels)
        doors = [_door(table, rooms) for table in document["doors"]]
        if [door.id for door in doors] != list(range(1, len(doors) + 1)):
            raise VdoorError("map.json: wanted doors 1, 2, ... in order, found other ids")
        features = [feature for table in document["rooms"] for feature in _features(table)]
        names = {table["id"]: _text(table.get("name", "")) for table in document["rooms"]}
        topology = _assembled(labels, _frame(document, labels.shape), doors, features, names)
        own_file(folder, "rooms.png", document)
        table = document.get("annotations")
        annotations = annotations_in(table, (labels.shape[0], labels.shape[1])) if table else None
        origin = _provenance(folder, document, topology.frame) if provenance else None
        if annotations:
            topology = dataclasses.replace(topology, own_origin_cm=annotations.own_origin_cm)
        return Finished(named_by_robot(topology, annotations), origin, dict(document["settings"]), annotations)


def _provenance(folder: Path, document: Mapping[str, Any], frame: Frame) -> Provenance:
    """The provenance of the run: facts from map.json, and the input map; raises `VdoorError` for invalid values.

    Raises `KeyError` and similar exceptions for a document of a different structure.
    """
    from vdoor.history.provenance import Provenance, facts_of  # noqa: PLC0415  # only if requested

    files = tuple((str(file["name"]), str(file["sha256"])) for file in document["source"]["files"])
    settings: Mapping[str, Any] = dict(document["settings"])
    provenance = Provenance(facts_of(document["vdoor"], document["preset"], document["seed"]), settings, files)
    provenance.run.write(0, _grid(own_file(folder, "grid.png", document), frame))
    return provenance


def _grid(path: Path, frame: Frame) -> OccupancyGrid:
    """The input map in a result folder; raises `VdoorError` if it does not have the frame's size."""
    grey = read_image(path).greys()
    if grey.shape != (frame.height, frame.width):
        found = f"{grey.shape[1]} x {grey.shape[0]}"
        raise VdoorError(f"grid.png: wanted {frame.width} x {frame.height} cells, found {found}")
    cells = np.full(grey.shape, UNKNOWN, np.int8)
    cells[grey == GREY_FREE] = FREE
    cells[grey == GREY_OCCUPIED] = OCCUPIED
    return OccupancyGrid(cells=cells, frame=frame)


def _assembled(
    labels: Ints, frame: Frame, doors: Sequence[Door], features: Sequence[Feature], names: dict[int, str]
) -> TopologicalMap:
    rows = Doors(
        edge=np.full(len(doors), -1, np.int32),
        start_m=_points([door.start_m for door in doors]),
        end_m=_points([door.end_m for door in doors]),
        kind=np.array([KINDS.index(door.kind) for door in doors], np.uint8),
        length_m=np.array([door.length_m for door in doors], np.float64),
        width_m=np.array([door.width_m for door in doors], np.float64),
        tilt_rad=np.radians(np.array([door.tilt_deg for door in doors], np.float64)),
        room_a=np.array([door.rooms[0] for door in doors], np.int32),
        room_b=np.array([door.rooms[1] for door in doors], np.int32),
    )
    corners = Features(
        room=np.array([room for room, _, _ in features], np.int32),
        corner=np.full(len(features), -1, np.int32),
        convex=np.array([convex for _, convex, _ in features], np.bool_),
        point_m=_points([point_m for _, _, point_m in features]),
    )
    return map_of(labels, frame, rows, corners, names)


def _frame(document: dict[str, Any], shape: tuple[int, ...]) -> Frame:
    """The map's frame, with the label image's size; raises `VdoorError` if the document's size differs."""
    size, origin = document["size"], document["origin"]
    if (size["height"], size["width"]) != shape:
        found = f"{shape[1]} x {shape[0]}"
        raise VdoorError(f"rooms.png: wanted {shown(size['width'])} x {shown(size['height'])} cells, found {found}")
    place = (_number(origin[key]) for key in ("x_m", "y_m", "yaw_rad"))
    return Frame(shape[0], shape[1], checked_resolution_m(document["resolution_m"]), *place)


def _rooms(tables: list[dict[str, Any]], labels: Ints) -> set[int]:
    """The ids of the rooms; raises `VdoorError` unless they ascend and are those of the label image."""
    ids = [table["id"] for table in tables]
    found = np.unique(runs_of(labels).label).tolist()
    if not found or ids != found or any(type(room) is not int for room in ids):
        rooms = f"{len(ids)} rooms in map.json and {len(found)} in rooms.png"
        raise VdoorError(f"result: wanted the same rooms in both, sorted by id, found {rooms}")
    return set(ids)


def _door(table: dict[str, Any], rooms: set[int]) -> Door:
    """A door of the document; raises `VdoorError` unless it joins two rooms and has a valid kind."""
    one, other = table["rooms"]
    if one not in rooms or other not in rooms or not one < other:
        raise VdoorError(f"map.json: wanted two rooms for each door, the lower first, found {shown((one, other))}")
    if table["kind"] not in KINDS:
        raise VdoorError(f"map.json: wanted a door of kind {', '.join(KINDS)}, found {shown(table['kind'])}")
    return Door(
        id=table["id"],
        rooms=(one, other),
        start_m=_point(table["start_m"]),
        end_m=_point(table["end_m"]),
        length_m=_number(table["length_m"]),
        width_m=_number(table["width_m"]),
        tilt_deg=_number(table["tilt_deg"]),
        kind=table["kind"],
    )


def _features(table: dict[str, Any]) -> Iterator[Feature]:
    for corner in table["corners"]:
        yield table["id"], corner["kind"] == "convex", _point(corner["point_m"])


def _number(value: object) -> float:
    if isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value):
        return float(value)
    raise VdoorError(f"map.json: wanted a finite number, found {shown(value)}")


def _text(value: object) -> str:
    if isinstance(value, str) and TEXT.fullmatch(value):
        return value
    raise VdoorError(f"map.json: wanted a room name of one line and at most 100 characters, found {shown(value)}")


def _point(values: Sequence[object]) -> tuple[float, float]:
    x_m, y_m = values
    return _number(x_m), _number(y_m)


def _points(points_m: Sequence[tuple[float, float]]) -> NDArray[np.float64]:
    return np.array(points_m, np.float64).reshape(-1, 2)


@contextmanager
def _naming(folder: Path) -> Iterator[None]:
    """Append the folder to errors, and convert exceptions caused by an invalid document to `VdoorError`."""
    try:
        yield
    except VdoorError as error:
        raise type(error)(f"{error}: {folder}") from error
    except KeyError as error:
        raise VdoorError(f"map.json: wanted the key {error.args[0]}, found none: {folder}") from error
    except (TypeError, ValueError, OverflowError, IndexError, AttributeError) as error:
        raise VdoorError(f"map.json: wanted a file from `vdoor run --out`, found something else: {folder}") from error
