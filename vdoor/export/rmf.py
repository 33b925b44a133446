"""Open-RMF's navigation graph, with doors."""

from __future__ import annotations

import re
from itertools import pairwise
from typing import Any

import yaml

from vdoor.export.geometry import Point, line_m, refuse_not_finite, to_mm
from vdoor.export.routes import Doorway, doorways
from vdoor.topology import Room, TopologicalMap

LEVEL = "L1"
OURS = re.compile("(room|door)_[0-9]")
"""Pattern of default vertex names."""
APPROACH_M = 0.5
"""Distance before a door at which a robot waits for it to open, if the room is that deep."""


def to_rmf(topology: TopologicalMap) -> str:
    """YAML for RMF's fleet adapters: vertices, lanes through free space both ways, and doors, in metres.

    A robot must not stand in a doorway while the door opens, so each door has a vertex on either side, straight in
    front of it. The lanes between these two have a `door_name`, and RMF requests that door to open: remove the name if
    a passage has no door leaf. From each of the two vertices, lanes lead to the middle of the room, with a vertex at
    each bend. Rooms are named as the user named them, others `room_` and their id.

    Raises `VdoorError` for a door whose rooms do not touch, and for a room in several pieces.
    """
    refuse_not_finite(topology)
    index = {room.id: number for number, room in enumerate(topology.rooms)}
    vertices = [_vertex(room.centre_m, _called(room, topology)) for room in topology.rooms]
    lanes: list[list[Any]] = []
    ways = doorways(topology, before_m=APPROACH_M)
    for way in ways:
        before: list[int] = []
        for side in way.sides:
            name, first = f"{_name(way)}_room_{side.room}", len(vertices)
            vertices.append(_vertex(side.points_m[0], name))
            vertices += [_vertex(bend_m, f"{name}_bend_{n}") for n, bend_m in enumerate(side.points_m[1:-1], start=1)]
            for ends in pairwise([*range(first, len(vertices)), index[side.room]]):
                lanes += _both_ways(*ends)
            before.append(first)
        lanes += _both_ways(*before, door_name=_name(way))
    doors = {_name(way): {"endpoints": _points(topology, way), "map": LEVEL} for way in ways}
    document = {
        "building_name": "vdoor",
        "doors": doors,
        "levels": {LEVEL: {"lanes": lanes, "vertices": vertices}},
        "lifts": {},
    }
    return yaml.safe_dump(document, sort_keys=False, default_flow_style=None)


def _called(room: Room, topology: TopologicalMap) -> str:
    """Name of a room if it is unique and does not look like a default name, else `room_` and the id."""
    own = topology.name.count(room.name) == 1 and not OURS.match(room.name)
    return room.name if own and room.name else f"room_{room.id}"


def _name(way: Doorway) -> str:
    return f"door_{way.door.id}"


def _vertex(place_m: Point, name: str) -> list[Any]:
    return [*to_mm(place_m), {"name": name}]


def _both_ways(one: int, other: int, **options: str) -> list[list[Any]]:
    return [[one, other, dict(options)], [other, one, dict(options)]]


def _points(topology: TopologicalMap, way: Doorway) -> list[list[float]]:
    return [[*to_mm(point)] for point in line_m(topology, way.door)]
