"""GeoJSON for map programs: rooms as polygons with holes, doors as lines."""

from __future__ import annotations

from vdoor.export import feature_collection
from vdoor.export.feature_collection import feature
from vdoor.export.finite import refuse_not_finite
from vdoor.export.geometry import line_m, right_handed
from vdoor.topology import Door, Room, TopologicalMap


def to_geojson(topology: TopologicalMap) -> str:
    """Rooms, then doors, each with its own fields as properties; x, y in metres of the map frame.

    Features are called `room-1`, `door-1`, and so on. Outer rings run counter-clockwise, holes clockwise. A door's
    line is as long as the door, so that of a passage goes half a cell further than `start_m` and `end_m`.
    """
    refuse_not_finite(topology)
    rooms = [
        feature("Polygon", right_handed(room.polygon_m), _room(room), id=f"room-{room.id}") for room in topology.rooms
    ]
    doors = [
        feature("LineString", line_m(topology, door), _door(door), id=f"door-{door.id}") for door in topology.doors
    ]
    return feature_collection.to_text("vdoor", [*rooms, *doors])


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
