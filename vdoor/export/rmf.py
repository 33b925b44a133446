"""Open-RMF's navigation graph, with doors."""

from __future__ import annotations

from typing import Any

import numpy as np
import yaml

from vdoor.export.geometry import Point, line_m
from vdoor.export.ways import Doorway, doorways
from vdoor.topology import TopologicalMap

LEVEL = "L1"
APPROACH_M = 0.5
"""How far before a door a robot waits for it to open, where the room is that deep."""


def to_rmf(topology: TopologicalMap) -> str:
    """YAML for RMF's fleet adapters: vertices, lanes both ways, and doors with their end points, in metres.

    A robot must not stand in a doorway while it opens, so each door has a vertex on either side, straight before it.
    The lanes between these two carry `door_name`, and RMF then asks the door of that name to open: drop the name
    where a passage has no door leaf.

    Raises `VdoorError` for a door whose rooms do not touch, and for a room in several parts.
    """
    index = {room.id: number for number, room in enumerate(topology.rooms)}
    vertices = [_vertex(room.centre_m, f"room_{room.id}") for room in topology.rooms]
    lanes: list[list[Any]] = []
    ways = doorways(topology)
    for way in ways:
        for side, place_m in zip(way.sides, _approaches_m(topology, way), strict=True):
            lanes += _both_ways(index[side.room], len(vertices))
            vertices.append(_vertex(place_m, f"{_name(way)}_room_{side.room}"))
        lanes += _both_ways(len(vertices) - 2, len(vertices) - 1, door_name=_name(way))
    doors = {_name(way): {"endpoints": _points(topology, way), "map": LEVEL} for way in ways}
    document = {
        "building_name": "vdoor",
        "doors": doors,
        "levels": {LEVEL: {"lanes": lanes, "vertices": vertices}},
        "lifts": {},
    }
    return yaml.safe_dump(document, sort_keys=False, default_flow_style=None)


def _approaches_m(topology: TopologicalMap, way: Doorway) -> list[Point]:
    """On either side the last place within the room, going up to `APPROACH_M` straight away from the door."""
    frame = topology.frame
    (row, col), (end_row, end_col) = frame.cell_from_world(np.array(line_m(topology, way.door)))
    normal = np.array([col - end_col, end_row - row]) / np.hypot(end_row - row, end_col - col)
    steps = np.arange(0, APPROACH_M / frame.resolution_m, 0.5)[:, None]
    one, other = (np.array(side.cell) for side in way.sides)
    places = []
    for side, cell, outward in zip(way.sides, (one, other), (one - other, other - one), strict=True):
        path = cell + steps * (normal if normal @ outward > 0 else -normal)
        at = np.rint(path).astype(int)
        inside = ((at >= 0) & (at < topology.labels.shape)).all(axis=1)
        inside[inside] = topology.labels[tuple(at[inside].T)] == side.room
        places.append(path[np.flatnonzero(np.logical_and.accumulate(inside))[-1]])
    (x_m, y_m), (to_x_m, to_y_m) = frame.world_from_cell(np.array(places)).tolist()
    return [(x_m, y_m), (to_x_m, to_y_m)]


def _name(way: Doorway) -> str:
    return f"door_{way.door.id}"


def _vertex(place_m: Point, name: str) -> list[Any]:
    return [*place_m, {"name": name}]


def _both_ways(one: int, other: int, **options: str) -> list[list[Any]]:
    return [[one, other, dict(options)], [other, one, dict(options)]]


def _points(topology: TopologicalMap, way: Doorway) -> list[list[float]]:
    return [list(point) for point in line_m(topology, way.door)]
