"""Virtual walls that close doors, in the format of robot vacuums with Valetudo."""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from vdoor.export.geometry import Point, check_rooms, line_m, refuse_not_finite
from vdoor.grid import Annotations
from vdoor.topology import Door, TopologicalMap

CM_PER_M = 100
CORNERS = ("pA", "pB", "pC", "pD")
ZONES = {"regular": "no_go_areas_m", "mop": "no_mop_areas_m"}
"""Valetudo's types of restricted zones, and the annotations that are such zones."""


def to_virtual_walls(
    topology: TopologicalMap,
    rooms: Sequence[int] = (),
    annotations: Annotations | None = None,
    *,
    own_origin_cm: Point | None = None,
) -> str:
    """Valetudo's virtual restrictions as JSON: a wall across each door, in whole centimetres, y down.

    With `rooms`, only doors that lead out of them are closed, which keeps the robot in; doors between two of them stay
    open. Sending the JSON to the robot (PUT to CombinedVirtualRestrictionsCapability) replaces all walls and zones it
    has, so those among the `annotations` of its map come first. `own_origin_cm` is the position of the lower left
    corner of the map's image in the robot's own frame. By default it is taken from the map, if it was read from a
    Valetudo map; otherwise points are relative to the image's upper left corner.

    Raises `SettingError` for an unknown room.
    """
    return json.dumps(to_walls(topology, rooms, annotations, own_origin_cm=own_origin_cm), indent=1) + "\n"


def to_walls(
    topology: TopologicalMap,
    rooms: Sequence[int] = (),
    annotations: Annotations | None = None,
    *,
    own_origin_cm: Point | None = None,
) -> dict[str, list[dict[str, Any]]]:
    """The content of `to_virtual_walls`, before it is text."""
    refuse_not_finite(topology)
    check_rooms(topology, rooms)
    origin_cm = own_origin_cm or origin_of(topology)
    closed = [door for door in topology.doors if not rooms or len(set(door.rooms) & set(rooms)) == 1]
    walls = [{"points": _points(topology, door, origin_cm)} for door in closed]
    own = restrictions_of(annotations)
    return {**own, "virtualWalls": [*own["virtualWalls"], *walls]}


def restrictions_of(annotations: Annotations | None) -> dict[str, list[dict[str, Any]]]:
    """The walls and zones that the robot has already, in Valetudo's format."""
    if annotations is None:
        return {"virtualWalls": [], "restrictedZones": []}
    corner_cm = annotations.own_origin_cm
    walls = [{"points": _corners(line, corner_cm)} for line in annotations.virtual_walls_m]
    zones = [
        {"points": _corners(area, corner_cm), "type": kind}
        for kind, name in ZONES.items()
        for area in getattr(annotations, name)
    ]
    return {"virtualWalls": walls, "restrictedZones": zones}


def origin_of(topology: TopologicalMap) -> Point:
    """The lower left corner of the map's image in the robot's own frame, else relative to the upper left one."""
    return topology.own_origin_cm or (0.0, topology.frame.height * topology.frame.resolution_m * CM_PER_M)


def _corners(points_m: Iterable[Point], origin_cm: Point) -> dict[str, dict[str, int]]:
    """Points in the frame of the map's lower left corner, whatever the map's own frame is, by name."""
    left_cm, bottom_cm = origin_cm
    return {
        name: {"x": round(left_cm + x_m * CM_PER_M), "y": round(bottom_cm - y_m * CM_PER_M)}
        for name, (x_m, y_m) in zip(CORNERS, points_m, strict=False)
    }


def _points(topology: TopologicalMap, door: Door, origin_cm: Point) -> dict[str, dict[str, int]]:
    row_col = topology.frame.cell_from_world(np.array(line_m(topology, door)))
    return dict(zip(CORNERS, own_points_cm(topology, row_col, origin_cm), strict=False))


def own_points_cm(
    topology: TopologicalMap, row_col: np.ndarray[Any, np.dtype[np.float64]], origin_cm: Point
) -> list[dict[str, int]]:
    """Points (k, 2), as row, col of the map, in the robot's own frame, in whole centimetres, y down."""
    row, col = row_col.T
    cell_cm = topology.frame.resolution_m * CM_PER_M
    x_cm = np.rint(origin_cm[0] + (col + 0.5) * cell_cm).astype(int).tolist()
    y_cm = np.rint(origin_cm[1] - (topology.frame.height - row - 0.5) * cell_cm).astype(int).tolist()
    return [{"x": x, "y": y} for x, y in zip(x_cm, y_cm, strict=True)]
