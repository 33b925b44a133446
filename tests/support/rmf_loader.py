"""A reader of navigation graphs that takes what Open-RMF's fleet adapter takes of them, and refuses what it refuses."""

from __future__ import annotations

from typing import Any, NamedTuple

import yaml

Point = tuple[float, float]


class Graph(NamedTuple):
    """Waypoints of the one level, lanes, and the doors it knows."""

    places: list[Point]
    names: dict[str, int]
    lanes: list[tuple[int, int, str | None]]
    """From, to, and the door that has to open."""
    doors: dict[str, tuple[Point, Point]]


def load(text: str) -> Graph:
    """The graph in YAML text; ValueError where a waypoint's name is there twice or a lane ends nowhere."""
    document = yaml.safe_load(text)
    ((level, parts),) = document["levels"].items()
    names: dict[str, int] = {}
    for index, (_, _, options) in enumerate(parts["vertices"]):
        if options["name"] in names:
            raise ValueError(f"duplicated waypoint name {options['name']}")
        names[options["name"]] = index
    lanes = [(one, other, _options(options).get("door_name")) for one, other, options in parts["lanes"]]
    if any(not 0 <= end < len(parts["vertices"]) for one, other, _ in lanes for end in (one, other)):
        raise ValueError("a lane ends nowhere")
    doors = {}
    for name, door in document["doors"].items():
        if door["map"] != level:
            raise ValueError(f"door {name} is on another level")
        one, other = door["endpoints"]
        doors[name] = (_point(one), _point(other))
    return Graph([_point(vertex) for vertex in parts["vertices"]], names, lanes, doors)


def _options(options: Any) -> dict[str, str]:
    """The third part of a lane, which has to be a table, though it may be empty."""
    if not isinstance(options, dict):
        raise TypeError("a lane has no options")
    return options


def _point(values: list[float]) -> Point:
    x, y = values[:2]
    if not (isinstance(x, float) and isinstance(y, float)):
        raise TypeError("a place is no pair of numbers")
    return x, y
