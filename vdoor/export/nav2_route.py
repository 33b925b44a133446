"""Nav2's route graph: rooms and doors as nodes, both directions between them as edges."""

from __future__ import annotations

import itertools
from typing import Any

from vdoor.errors import VdoorError
from vdoor.export import feature_collection
from vdoor.export.feature_collection import feature
from vdoor.export.ways import Doorway, doorways
from vdoor.topology import TopologicalMap

FRAME = "map"


def to_nav2_route(topology: TopologicalMap) -> str:
    """GeoJSON for the route server: a node a room and a door, an edge from each door to its rooms and back.

    A room's node has the room's id; doors follow in their order, then edges, so that ids are unique. Costs are metres
    along free space, and marked as not overridable, or the server's default scorer would put straight distances in
    their place. Edges are drawn straight: what drives along them is for a planner to find.

    Raises `VdoorError` for a map without doors, whose graph would have no edge: the server refuses such a file.
    """
    ways = doorways(topology)
    if not ways:
        raise VdoorError("route graph: wanted at least one door, found none")
    place_m = {room.id: room.centre_m for room in topology.rooms}
    nodes = [
        _node(room.id, room.centre_m, {"kind": "room", "room": room.id, "area_m2": room.area_m2})
        for room in topology.rooms
    ]
    number = itertools.count(max(place_m) + 1)
    node_of = {way.door.id: next(number) for way in ways}
    nodes += [_node(node_of[way.door.id], way.middle_m, _about(way)) for way in ways]
    place_m |= {node_of[way.door.id]: way.middle_m for way in ways}
    edges = [
        _edge(next(number), ends, place_m, side.cost_m, {"kind": "way", "door": way.door.id, "room": side.room})
        for way in ways
        for side in way.sides
        for ends in ((node_of[way.door.id], side.room), (side.room, node_of[way.door.id]))
    ]
    return feature_collection.to_text("vdoor_route", [*nodes, *edges])


def _about(way: Doorway) -> dict[str, Any]:
    door = way.door
    return {"kind": "door", "door": door.id, "rooms": door.rooms, "width_m": door.width_m, "door_kind": door.kind}


def _node(number: int, place_m: tuple[float, float], metadata: dict[str, Any]) -> dict[str, Any]:
    return feature("Point", place_m, {"id": number, "frame": FRAME, "metadata": metadata})


def _edge(
    number: int,
    ends: tuple[int, int],
    place_m: dict[int, tuple[float, float]],
    cost_m: float,
    metadata: dict[str, Any],
) -> dict[str, Any]:
    start, end = ends
    properties = {"id": number, "startid": start, "endid": end, "cost": cost_m, "overridable": False}
    return feature("LineString", (place_m[start], place_m[end]), properties | {"metadata": metadata})
