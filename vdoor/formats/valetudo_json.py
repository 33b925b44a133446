"""The checked content of a Valetudo map: JSON in cells and centimetres from the top left.

Both versions of the format are read: version 1 stores a layer's cells as pairs, version 2 as runs.
"""

from __future__ import annotations

import json
from dataclasses import dataclass, replace
from typing import Any, TypeVar, cast

import numpy as np
from numpy.typing import NDArray

from vdoor.errors import MapError
from vdoor.formats.source import shown

T = TypeVar("T", dict[str, Any], list[Any])
VERSIONS = (1, 2)
LAYERS = ("floor", "segment", "wall")
"""Types of layers; where layers overlap, the later type in this list wins."""
FEWEST_POINTS = {"robot_position": 1, "charger_location": 1, "virtual_wall": 2, "no_go_area": 3, "no_mop_area": 3}
"""Types of entities that are read, and their minimum numbers of points; others are ignored."""
MAX_BYTES = 1 << 24
"""50 times the size of the largest map seen."""
MOST_LAYERS = 10_000
DEEPEST, MOST_KEYS = 4, 100
"""Levels of tables in which a map is looked for, and keys of each."""
LARGEST_CM = 1_000_000


@dataclass(frozen=True, kw_only=True, eq=False)
class Layer:
    """A layer: cells of one type."""

    kind: str
    runs: NDArray[np.int64]
    """Runs of cells (k, 3): x, y of the first cell, and the number of cells to the right."""
    segment_id: str = ""
    name: str = ""
    declared_cells: int | None = None
    """The number of cells according to the layer's metadata; None if not given."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Entity:
    """An entity: a marker with one or more points."""

    kind: str
    points_cm: NDArray[np.float64]
    """The points (k, 2) as x, y."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Home:
    """Everything that is read from a map."""

    cell_cm: float
    layers: list[Layer]
    """The layers, with at least one cell in total."""
    entities: list[Entity]


def is_valetudo(table: object) -> bool:
    """Whether the content of a JSON file looks like a Valetudo map."""
    return isinstance(table, dict) and "layers" in table and "pixelSize" in table


def map_within(table: object) -> object:
    """The map in a robot's whole state, where it lies under ``map`` or deeper; anything else as it is."""
    level = [table]
    for _ in range(DEEPEST):
        for one in level:
            if is_valetudo(one):
                return one
        tables = [one for one in level if isinstance(one, dict)]
        level = [inner for one in tables for inner in list(one.values())[:MOST_KEYS] if isinstance(inner, dict)]
    return table


def parse(data: bytes) -> Home:
    """The content of a map; raises MapError naming the missing or invalid key."""
    if len(data) > MAX_BYTES:
        raise MapError(f"JSON: wanted at most {MAX_BYTES} bytes, found {len(data)}")
    try:
        table = json.loads(data)
    except (ValueError, RecursionError) as error:
        raise MapError(f"JSON: wanted a complete file, found a damaged one ({shown(str(error))})") from None
    return home_of(table)


def home_of(table: object) -> Home:
    """The content of a map, or of a state with a map, already parsed as JSON; raises the same errors as `parse`."""
    table = map_within(table)
    if not isinstance(table, dict):
        raise MapError(f"JSON: wanted a Valetudo map, found {shown(table)}")
    version = _value(_value(table, "metaData", dict), "version", place="metaData.")
    if isinstance(version, bool) or version not in VERSIONS:
        raise MapError(f"metaData.version: wanted {' or '.join(map(str, VERSIONS))}, found {shown(version)}")
    if table["metaData"].get("defaultMap"):
        raise MapError("metaData.defaultMap: wanted a map that the robot made, found the placeholder of a robot "
                       "that has none (let it map the home first)")  # fmt: skip
    cell_cm = _positive(_value(table, "pixelSize"), "pixelSize")
    size = _value(table, "size", dict)
    # The size is in centimetres in all files seen; the limit is also safe if a file gives it in cells.
    sides = [_positive(_value(size, side, place="size."), f"size.{side}") / min(cell_cm, 1) for side in ("x", "y")]
    tables = _value(table, "layers", list)
    if len(tables) > MOST_LAYERS:
        raise MapError(f"layers: wanted at most {MOST_LAYERS}, found {len(tables)}")
    layers = [_layer(layer, f"layers[{at}]", sides) for at, layer in enumerate(tables)]
    if not any(len(layer.runs) for layer in layers):
        raise MapError("layers: wanted at least one cell, found none (the robot has no map yet)")
    entities = [_entity(entity, f"entities[{at}]") for at, entity in enumerate(_value(table, "entities", list))]
    return Home(cell_cm=cell_cm, layers=layers, entities=[entity for entity in entities if entity is not None])


def _layer(value: object, place: str, sides: list[float]) -> Layer:
    table = _table(value, place)
    kind = _value(table, "type", place=f"{place}.")
    if kind not in LAYERS:
        raise MapError(f"{place}.type: wanted {', '.join(LAYERS)}, found {shown(kind)}")
    runs = _runs(table, place)
    first, last = runs[:, :2], runs[:, :2] + np.stack([runs[:, 2] - 1, np.zeros_like(runs[:, 2])], axis=1)
    if len(runs) and (first.min() < 0 or (last.max(axis=0) >= sides).any()):
        found = f"x {first[:, 0].min()} to {last[:, 0].max()}, y {first[:, 1].min()} to {last[:, 1].max()}"
        raise MapError(f"{place}: wanted cells within the map's size, found {found}")
    dimensions = table.get("dimensions")
    cells = dimensions.get("pixelCount") if isinstance(dimensions, dict) else None
    layer = Layer(kind=kind, runs=runs, declared_cells=cells if isinstance(cells, int) else None)
    if kind != "segment":
        return layer
    about = _value(table, "metaData", dict, place=f"{place}.")
    number, name = _value(about, "segmentId", place=f"{place}.metaData."), about.get("name")
    if isinstance(number, bool) or not isinstance(number, str | int):
        raise MapError(f"{place}.metaData.segmentId: wanted a string or number, found {shown(number)}")
    return replace(layer, segment_id=str(number), name=name if isinstance(name, str) else "")


def _runs(layer: dict[str, Any], place: str) -> NDArray[np.int64]:
    """The runs (k, 3) of a layer, from either of its two notations."""
    key = "compressedPixels" if layer.get("compressedPixels") or "pixels" not in layer else "pixels"
    place = f"{place}.{key}"
    if key not in layer:
        raise MapError(f"{place}: wanted the layer's cells, found none")
    values, width = layer[key], 3 if key == "compressedPixels" else 2
    whole = isinstance(values, list) and set(map(type, values)) <= {int} and len(values) % width == 0
    try:
        numbers = np.array(values if whole else None, np.int64)
    except (TypeError, OverflowError):
        wanted = "runs of x, y, count" if width > 2 else "pairs of x, y"  # noqa: PLR2004  # three or two
        raise MapError(f"{place}: wanted whole numbers in {wanted}, found {shown(values)}") from None
    runs = numbers.reshape(-1, width)
    if width == 2:  # noqa: PLR2004
        runs = np.hstack([runs, np.ones((len(runs), 1), np.int64)])
    if len(runs) and (runs[:, 2].min() < 1 or np.abs(runs).max() > LARGEST_CM):
        raise MapError(f"{place}: wanted counts of at least 1 and numbers up to {LARGEST_CM}, found others")
    return runs


def _entity(entity: object, place: str) -> Entity | None:
    """An entity of a type that is read; None for other types."""
    table = _table(entity, place)
    kind = _value(table, "type", place=f"{place}.")
    if not isinstance(kind, str) or kind not in FEWEST_POINTS:
        return None
    fewest, values = FEWEST_POINTS[kind], _value(table, "points", list, place=f"{place}.")
    if len(values) % 2 or len(values) < 2 * fewest or not all(map(_is_number, values)):
        raise MapError(f"{place}.points: wanted x, y of {fewest} or more points, found {shown(values)}")
    return Entity(kind=kind, points_cm=np.array(values, np.float64).reshape(-1, 2))


def _value(table: dict[str, Any], key: str, kind: type[T] | None = None, *, place: str = "") -> Any:
    """The value of a required key; raises MapError if it is missing or has the wrong type."""
    if key not in table:
        raise MapError(f"{place}{key}: wanted the key, found none")
    value = table[key]
    if kind is not None and not isinstance(value, kind):
        raise MapError(f"{place}{key}: wanted a {'table' if kind is dict else 'list'}, found {shown(value)}")
    return value


def _table(value: object, place: str) -> dict[str, Any]:
    if not isinstance(value, dict):
        raise MapError(f"{place}: wanted a table, found {shown(value)}")
    return cast("dict[str, Any]", value)


def _positive(value: object, place: str) -> float:
    if not _is_number(value) or not 0 < cast("float", value) <= LARGEST_CM:
        raise MapError(f"{place}: wanted a number above 0 and up to {LARGEST_CM}, found {shown(value)}")
    return float(cast("float", value))


def _is_number(value: object) -> bool:
    """Whether a value is a number in the range of coordinates."""
    return isinstance(value, int | float) and not isinstance(value, bool) and abs(value) <= LARGEST_CM
