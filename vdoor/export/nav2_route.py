"""Nav2's route graph: nodes in rooms and doors, and straight edges through free space, in both directions."""

from __future__ import annotations

import itertools
import math
from collections.abc import Container, Mapping
from typing import Any

import numpy as np

from vdoor.errors import VdoorError
from vdoor.export.geojson import collection_text, feature
from vdoor.export.geometry import Point, refuse_not_finite, to_mm
from vdoor.grid import Annotations
from vdoor.navigate import NAV2_RADIUS_M
from vdoor.navigate.roadmap import Edge, Node, Roadmap, roadmap_of
from vdoor.topology import TopologicalMap

FRAME = "map"
FULL_SPEED = 100.0


def to_nav2_route(
    topology: TopologicalMap,
    annotations: Annotations | None = None,
    *,
    radius_m: float = NAV2_RADIUS_M,
    speed_percent: Mapping[int, float] | None = None,
    door_service: str = "",
    open_rooms: Container[int] = (),
) -> str:
    """GeoJSON for the route server; virtual walls and no-go areas of the map's file are kept clear of.

    A room's node has the room's id. Nodes of doors and all others follow, then edges, so that ids are unique. The
    metadata of a node says its `class`, and its `room` or `door`; that of an edge says its room, its clearance, and its
    class, for the server's SemanticScorer: `room`, `door` or, where a robot of that radius does not fit, `narrow`.
    `speed_percent` limits the speed in some rooms, for AdjustSpeedLimit. At each door TriggerEvent calls the service
    `door_service`, in which `{door}` stands for the door's id; no service is called if it is empty. Only `open_rooms`
    have edges, if some are named.

    Raises `VdoorError` for a door whose rooms do not touch, and if there is no edge, since the server refuses that.
    """
    refuse_not_finite(topology)
    graph = roadmap_of(topology, annotations, clearance_m=radius_m)
    if open_rooms:
        graph.edges = [edge for edge in graph.edges if edge.room in open_rooms]
    if not graph.edges:
        raise VdoorError(f"route graph: wanted two places for a robot of radius {radius_m:g} m, found one")
    ids = _ids(topology, graph)
    places = [to_mm(place) for place in topology.frame.world_from_cell(np.array([node.place for node in graph.nodes]))]
    points = [
        feature("Point", place, {"id": number, "frame": FRAME, "metadata": _about_node(topology, node)})
        for number, place, node in zip(ids, places, graph.nodes, strict=True)
    ]
    number = itertools.count(max(ids) + 1)
    lines = []
    for edge in graph.edges:
        about = _about_edge(graph, edge, radius_m)
        if speed_percent:  # everywhere: the DistanceScorer divides by it, and takes 1 where there is none
            about["speed_limit"] = float(speed_percent.get(edge.room, FULL_SPEED))
        for one, other in (edge.ends, edge.ends[::-1]):
            opened = _opened(graph.nodes[other], door_service)
            ends = {"id": next(number), "startid": ids[one], "endid": ids[other]}
            lines.append(_line(places[one], places[other], {**ends, "metadata": about} | opened))
    return collection_text("vdoor_route", [*points, *lines])


def _ids(topology: TopologicalMap, graph: Roadmap) -> list[int]:
    """The id of each node: a room's own, and for all others the numbers after the largest of these."""
    rooms = topology.room_ids
    return [*rooms, *itertools.islice(itertools.count(rooms[-1] + 1), len(graph.nodes) - len(rooms))]


def _about_node(topology: TopologicalMap, node: Node) -> dict[str, Any]:
    if node.door:
        door = topology.door(node.door)
        about = {"rooms": door.rooms, "width_m": door.width_m, "kind": door.kind, "main": node.main}
        return {"class": "door", "door": door.id} | about
    if not node.main:
        return {"class": "place", "room": node.room}
    room = topology.room(node.room)
    return {"class": "room", "room": room.id, "name": room.name, "area_m2": room.area_m2}


def _about_edge(graph: Roadmap, edge: Edge, radius_m: float) -> dict[str, Any]:
    at_door = any(graph.nodes[end].door for end in edge.ends)
    kind = "narrow" if edge.clearance_m < radius_m else "door" if at_door else "room"
    return {"class": kind, "room": edge.room, "clearance_m": round(edge.clearance_m, 3)}


def _opened(end: Node, service: str) -> dict[str, Any]:
    """The operation that asks for a door to be opened as the robot sets out for it."""
    if not (service and end.door):
        return {}
    metadata = {"service_name": service.replace("{door}", str(end.door)), "door": end.door}
    return {"operations": [{"type": "TriggerEvent", "trigger": "ON_ENTER", "metadata": metadata}]}


def _line(start: Point, end: Point, properties: dict[str, Any]) -> dict[str, Any]:
    return feature("LineString", (start, end), {**properties, "cost": round(math.dist(start, end), 3)})
