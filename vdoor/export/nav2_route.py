"""Nav2's route graph: rooms, doors and the bends between them as nodes, joined in both directions by edges."""

from __future__ import annotations

import itertools
import math
from itertools import pairwise
from typing import Any, NamedTuple

from vdoor.errors import VdoorError
from vdoor.export.geojson import collection_text, feature
from vdoor.export.geometry import Point, refuse_not_finite
from vdoor.export.routes import Doorway, doorways
from vdoor.topology import TopologicalMap

FRAME = "map"


class Node(NamedTuple):
    """A place a robot goes to."""

    id: int
    place_m: Point
    about: dict[str, Any]


def to_nav2_route(topology: TopologicalMap) -> str:
    """GeoJSON for the route server: nodes for rooms, doors and bends, edges through free space in both directions.

    A room's node has the room's id; doors follow in their order, then bends, then edges, so that ids are unique. The
    server knows an edge as the straight line between its nodes, whatever lies between them in the file, so the way
    from a door to the middle of a room is a chain of edges over waypoints. An edge costs its length in metres, which
    is what the server's default scorer makes of it as well; other scorers may change it or close the edge.

    Raises `VdoorError` for a map without doors, whose graph would have no edge: the server refuses such a file.
    """
    refuse_not_finite(topology)
    ways = doorways(topology)
    if not ways:
        raise VdoorError("route graph: wanted at least one door, found none")
    rooms = {
        room.id: Node(
            room.id, room.centre_m, {"kind": "room", "room": room.id, "name": room.name, "area_m2": room.area_m2}
        )
        for room in topology.rooms
    }
    number = itertools.count(max(rooms) + 1)
    doors = {way.door.id: Node(next(number), way.middle_m, _about(way)) for way in ways}
    waypoints: list[Node] = []
    lines: list[tuple[Node, Node, dict[str, Any]]] = []
    for way in ways:
        for side in way.sides:
            about = {"door": way.door.id, "room": side.room}
            bends = [Node(next(number), place_m, {"kind": "waypoint"} | about) for place_m in side.points_m[1:-1]]
            for one, other in pairwise((doors[way.door.id], *bends, rooms[side.room])):
                lines += [(one, other, about), (other, one, about)]
            waypoints += bends
    points = [_point(node) for node in (*rooms.values(), *doors.values(), *waypoints)]
    edges = [_line(next(number), start, end, {"kind": "way"} | about) for start, end, about in lines]
    return collection_text("vdoor_route", [*points, *edges])


def _about(way: Doorway) -> dict[str, Any]:
    door = way.door
    return {"kind": "door", "door": door.id, "rooms": door.rooms, "width_m": door.width_m, "door_kind": door.kind}


def _point(node: Node) -> dict[str, Any]:
    return feature("Point", node.place_m, {"id": node.id, "frame": FRAME, "metadata": node.about})


def _line(number: int, start: Node, end: Node, about: dict[str, Any]) -> dict[str, Any]:
    cost_m = math.dist(start.place_m, end.place_m)
    ends = {"id": number, "startid": start.id, "endid": end.id}
    return feature("LineString", (start.place_m, end.place_m), {**ends, "cost": cost_m, "metadata": about})
