"""Maps of ROS map_server and Nav2: a YAML file and the image it refers to.

The semantics are those of Nav2's main branch (see `occupancy`). Scalars are loaded as text and parsed here, because
PyYAML (YAML 1.1) and yaml-cpp, which Nav2 uses, read numbers differently: for PyYAML 5e-2 is text and 010 is eight.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, TypeVar, cast

import yaml

from vdoor.errors import MapError
from vdoor.formats import images
from vdoor.formats.occupancy import Mode, Rule, cells_from_image
from vdoor.formats.source import (
    Request,
    agreed_resolution_m,
    base_name,
    checked_resolution_m,
    finite,
    number,
    shown,
)
from vdoor.grid import OccupancyGrid

T = TypeVar("T")
MAX_BYTES = 65_536
MODES: tuple[Mode, ...] = ("trinary", "scale", "raw")
TRUE, FALSE = ("y", "yes", "true", "on"), ("n", "no", "false", "off")


@dataclass(frozen=True, kw_only=True)
class Header:
    """The values in the YAML file."""

    image: str
    resolution_m: float
    origin: tuple[float, float, float]
    """x and y in metres, and yaw in radians, which may be nan."""
    rule: Rule


def read(request: Request) -> OccupancyGrid:
    """The grid of a YAML file and its image, which is found among the request's files by base name."""
    name = request.name
    with request.naming(name):
        header = parse(request.data(name))
        resolution_m = agreed_resolution_m(header.resolution_m, request.resolution_m)
    image_name = base_name(header.image)
    with request.naming(image_name):
        image = images.decode(request.data(image_name), max_cells=request.max_cells)
        cells = cells_from_image(image, header.rule, request=request, name=name)
    _note_oddities(header, request)
    x_m, y_m, yaw_rad = header.origin
    return OccupancyGrid.from_array(
        cells,
        resolution_m,
        x_m=x_m,
        y_m=y_m,
        yaw_rad=0.0 if math.isnan(yaw_rad) else yaw_rad,
        source=request.source,
    )


def image_paths(data: bytes) -> tuple[str, ...]:
    """The path of the image as written in the YAML file: relative to that file, or absolute."""
    return (parse(data).image,)


@functools.lru_cache(maxsize=1)  # asked for once to find the image, and once to read it
def parse(data: bytes) -> Header:
    """The header in a YAML file; raises MapError if it is not a map_server file, or a value is invalid."""
    table = _table(data)
    return Header(
        image=_value(table, "image", _file),
        resolution_m=_value(table, "resolution", lambda text: checked_resolution_m(number(text))),
        origin=_value(table, "origin", _origin),
        rule=Rule(
            mode=_value(table, "mode", _mode) if "mode" in table else "trinary",
            negate=_value(table, "negate", _flag),
            free_thresh=_value(table, "free_thresh", _threshold),
            occupied_thresh=_value(table, "occupied_thresh", _threshold),
        ),
    )


def _table(data: bytes) -> Mapping[str, Any]:
    """The YAML file as a table of strings, lists and tables."""
    if len(data) > MAX_BYTES:
        raise MapError(f"YAML: wanted at most {MAX_BYTES} bytes, found {len(data)}")
    try:
        # Safe: this loader creates only strings, lists and tables, and resolves no tags or merge keys.
        table = yaml.load(data, Loader=yaml.BaseLoader)  # noqa: S506
    except (yaml.YAMLError, ValueError, OverflowError, RecursionError) as error:
        problem = getattr(error, "problem", None) or type(error).__name__
        mark = getattr(error, "problem_mark", None)
        raise MapError(
            f"YAML{f', line {mark.line + 1}' if mark else ''}: wanted a map_server file, found {shown(problem)}"
        ) from None
    if not isinstance(table, dict):
        raise MapError(f"YAML: wanted a table of keys, found {shown(table)}")
    return cast("Mapping[str, Any]", table)


def _value(table: Mapping[str, Any], key: str, convert: Callable[[Any], T]) -> T:
    """The converted value of a required key; raises MapError naming the key."""
    if key not in table:
        raise MapError(f"YAML: wanted the key {key}, found none")
    try:
        return convert(table[key])
    except MapError as error:
        text = str(error)
        raise MapError(text if text.startswith(key) else f"{key}: {text}") from None


def _file(text: Any) -> str:
    if isinstance(text, str) and base_name(text):
        return text
    raise MapError(f"wanted the path of an image, found {shown(text)}")


def _origin(values: Any) -> tuple[float, float, float]:
    wanted = 3
    if not isinstance(values, list) or len(values) != wanted:
        raise MapError(f"wanted [x, y, yaw], found {shown(values)}")
    x_m, y_m, yaw = values
    yaw_rad = number(yaw)
    return finite(x_m), finite(y_m), yaw_rad if math.isnan(yaw_rad) else finite(yaw)


def _threshold(text: Any) -> float:
    value = finite(text)
    if 0 <= value <= 1:
        return value
    raise MapError(f"wanted 0 to 1, found {shown(text)}")


def _flag(text: Any) -> bool:
    """The value of a flag as Nav2 reads it: an integer (true unless 0), or one of YAML's words for true and false."""
    word = text.lower() if isinstance(text, str) else ""
    if word in TRUE + FALSE:
        return word in TRUE
    try:
        return int(word) != 0
    except ValueError:
        raise MapError(f"wanted 0, 1, true or false, found {shown(text)}") from None


def _mode(text: Any) -> Mode:
    word = text.lower() if isinstance(text, str) else ""
    for mode in MODES:
        if word == mode:
            return mode
    raise MapError(f"wanted {', '.join(MODES[:-1])} or {MODES[-1]}, found {shown(text)}")


def _note_oddities(header: Header, request: Request) -> None:
    """Add notes on values that are valid but often a mistake."""
    yaw_rad, rule = header.origin[2], header.rule
    if math.isnan(yaw_rad):
        request.note("origin: yaw is nan, using 0", request.name)
    else:
        request.note_turn(yaw_rad)
    if rule.mode != "raw" and rule.free_thresh >= rule.occupied_thresh:
        request.note(
            f"free_thresh {rule.free_thresh:g} is not below occupied_thresh {rule.occupied_thresh:g}; "
            "a cell that meets both is free, as in Nav2",
            request.name,
        )
