"""A reader of route graphs that refuses what Nav2's route server refuses, when it loads a file or plans with it."""

from __future__ import annotations

import json
from typing import Any, NamedTuple

UINT = 2**32


class RefusedError(ValueError):
    """Nav2 would not take the file, or would not plan with it."""


class Node(NamedTuple):
    """A node as the server keeps it."""

    place: tuple[float, float]
    frame: str
    metadata: dict[str, Any]


class Edge(NamedTuple):
    """A directed edge as the server keeps it."""

    id: int
    start: int
    end: int
    cost: float
    overridable: bool
    metadata: dict[str, Any]
    operations: list[tuple[str, str, dict[str, Any]]]
    """Type, trigger and metadata of each."""


class Graph(NamedTuple):
    """Nodes by id, and edges."""

    nodes: dict[int, Node]
    edges: list[Edge]
    ids: list[int]
    """Of all nodes and edges: the server takes a file that has one twice, but cannot tell the two apart."""


def load(text: str) -> Graph:
    """The graph in GeoJSON text."""
    try:
        features = json.loads(text, parse_constant=_no_number)["features"]
        points = [feature for feature in features if feature["geometry"]["type"] == "Point"]
        lines = [feature for feature in features if feature["geometry"]["type"] in ("LineString", "MultiLineString")]
        if not points or not lines:
            raise RefusedError("does not contain nodes or edges")
        nodes = [(_uint(point["properties"]["id"]), _node(point)) for point in points]
        edges = [_edge(line["properties"], dict(nodes)) for line in lines]
    except (KeyError, TypeError, IndexError, json.JSONDecodeError) as error:
        raise RefusedError(repr(error)) from error
    ids = [number for number, _ in nodes] + [edge.id for edge in edges]
    return Graph(dict(nodes), edges, ids)


def _node(feature: dict[str, Any]) -> Node:
    x, y = (_float(value) for value in feature["geometry"]["coordinates"][:2])
    frame = feature["properties"].get("frame", "")
    if not isinstance(frame, str):
        raise RefusedError("frame is no text")
    return Node((x, y), frame, _metadata(feature["properties"].get("metadata", {})))


def _edge(properties: dict[str, Any], nodes: dict[int, Node]) -> Edge:
    start, end = _uint(properties["startid"]), _uint(properties["endid"])
    if start not in nodes or end not in nodes:
        raise RefusedError("an end of the edge does not exist")
    cost, overridable = _float(properties.get("cost", 0.0)), properties.get("overridable", True)
    if not isinstance(overridable, bool):
        raise RefusedError("overridable is no truth value")
    if not overridable and cost <= 0:
        raise RefusedError("the edge has no valid cost")
    metadata = _metadata(properties.get("metadata", {}))
    return Edge(_uint(properties["id"]), start, end, cost, overridable, metadata, _operations(properties))


TRIGGERS = ("NODE", "ON_ENTER", "ON_EXIT")
CALLED = ("TriggerEvent",)
"""The operations of Nav2 that a graph may name: the others act by themselves, and an unknown one ends the route."""


def _operations(properties: dict[str, Any]) -> list[tuple[str, str, dict[str, Any]]]:
    """Operations with what their plugin reads; the loader takes an unknown trigger for NODE, which nobody means."""
    found = []
    for table in properties.get("operations", []):
        kind, trigger, metadata = table["type"], table["trigger"], _metadata(table.get("metadata", {}))
        if kind not in CALLED or trigger not in TRIGGERS:
            raise RefusedError(f"no operation {kind} at {trigger}")
        if not metadata.get("service_name"):
            raise RefusedError("no service to call")
        found.append((kind, trigger, metadata))
    return found


READ_AS = {
    "class": str,
    "service_name": str,
    "speed_limit": float,
    "abs_speed_limit": float,
    "penalty": float,
    "abs_time_taken": float,
}
"""What Nav2's own plugins read, and as what: a whole number is kept as an integer, and reading it as a float throws."""


def _metadata(table: dict[str, Any]) -> dict[str, Any]:
    """Tables of values, of arrays of values, and of tables; null and arrays of anything else are refused."""
    for name, value in table.items():
        if name in READ_AS and not isinstance(value, READ_AS[name]):
            raise RefusedError(f"{name} is read as {READ_AS[name].__name__}")
        if isinstance(value, dict):
            _metadata(value)
        elif not all(
            isinstance(part, (bool, int, float, str)) for part in (value if isinstance(value, list) else [value])
        ):
            raise RefusedError("metadata cannot be converted")
    return table


def _uint(value: object) -> int:
    if isinstance(value, int) and not isinstance(value, bool) and 0 <= value < UINT:
        return value
    raise RefusedError(f"{value!r} is no unsigned int")


def _float(value: object) -> float:
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        return float(value)
    raise RefusedError(f"{value!r} is no number")


def _no_number(name: str) -> float:
    raise RefusedError(f"{name} is no JSON")
