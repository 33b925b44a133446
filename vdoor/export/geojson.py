"""GeoJSON for map programs: rooms as polygons with holes, doors as lines, one feature per line of text."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from typing import Any

from vdoor.export.geometry import Point, line_m, refuse_not_finite, right_handed, to_mm
from vdoor.topology import Door, Room, TopologicalMap


def to_geojson(topology: TopologicalMap) -> str:
    """Rooms, then doors, each with its own fields as properties; x, y in metres of the map frame.

    Feature ids are `room-1`, `door-1`, and so on. Outer rings run counter-clockwise, holes clockwise. A door's line is
    as long as the door, so that of a passage extends half a cell beyond `start_m` and `end_m`.
    """
    refuse_not_finite(topology)
    rooms = [feature(*_shape(room), _room(room), id=f"room-{room.id}") for room in topology.rooms]
    doors = [
        feature("LineString", _in_mm(line_m(topology, door)), _door(door), id=f"door-{door.id}")
        for door in topology.doors
    ]
    return collection_text("vdoor", [*rooms, *doors])


def _in_mm(points_m: Iterable[Point]) -> tuple[Point, ...]:
    """Points rounded to the millimetre."""
    return tuple(map(to_mm, points_m))


def _shape(room: Room) -> tuple[str, tuple[Any, ...]]:
    """The kind of geometry and its coordinates: a polygon, or several for a room of several parts."""
    parts = tuple(tuple(_in_mm(ring) for ring in right_handed(part)) for part in room.parts_m)
    return ("Polygon", parts[0]) if len(parts) == 1 else ("MultiPolygon", parts)


def _room(room: Room) -> dict[str, object]:
    return {
        "type": "room",
        "room": room.id,
        "name": room.name,
        "area_m2": room.area_m2,
        "centre_m": room.centre_m,
        "neighbours": room.neighbours,
    }


def _door(door: Door) -> dict[str, object]:
    return {
        "type": "door",
        "door": door.id,
        "rooms": door.rooms,
        "kind": door.kind,
        "width_m": door.width_m,
        "length_m": door.length_m,
        "tilt_deg": door.tilt_deg,
        "start_m": door.start_m,
        "end_m": door.end_m,
    }


CRS = {"type": "name", "properties": {"name": "urn:ogc:def:crs:EPSG::3857"}}
"""The CRS of Nav2's own files, so that map programs read the numbers as metres and not as degrees."""


def feature(kind: str, coordinates: Any, properties: Mapping[str, Any], **more: Any) -> dict[str, Any]:
    """One feature with a geometry of the given kind."""
    geometry = {"type": kind, "coordinates": coordinates}
    return {"type": "Feature", **more, "properties": properties, "geometry": geometry}


def collection_text(name: str, features: Iterable[Mapping[str, Any]]) -> str:
    """A feature collection as JSON, one feature per line."""
    head = json.dumps({"type": "FeatureCollection", "name": name, "crs": CRS})[:-1]
    lines = ",\n".join(json.dumps(item, allow_nan=False) for item in features)
    return f'{head}, "features": [\n{lines}\n]}}\n'
