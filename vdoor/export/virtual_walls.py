"""Virtual walls that shut doors, as robot vacuums take them."""

from __future__ import annotations

import json
from collections.abc import Sequence

import numpy as np

from vdoor.export.geometry import Point, check_rooms, line_m, refuse_not_finite
from vdoor.topology import Door, TopologicalMap

CM_PER_M = 100


def to_virtual_walls(topology: TopologicalMap, rooms: Sequence[int] = (), *, own_origin_cm: Point | None = None) -> str:
    """Valetudo's virtual restrictions as JSON: a wall across each door, in whole centimetres, y down.

    With `rooms` only doors that lead out of them are shut, which keeps the robot in: doors between two of them stay
    open. `own_origin_cm` says where the lower left corner of the map's image lies in the robot's own frame, in place of
    what the map itself knows of it, as those made of Valetudo's do; where neither does, points count from the image's
    upper left corner. Sending the JSON to the robot (PUT to CombinedVirtualRestrictionsCapability) replaces all walls
    and zones it has.

    Raises `SettingError` for a room that is not there.
    """
    refuse_not_finite(topology)
    check_rooms(topology, rooms)
    corner_cm = (0.0, topology.frame.height * topology.frame.resolution_m * CM_PER_M)
    origin_cm = own_origin_cm or topology.own_origin_cm or corner_cm
    shut = [door for door in topology.doors if not rooms or len(set(door.rooms) & set(rooms)) == 1]
    walls = [{"points": _points(topology, door, origin_cm)} for door in shut]
    return json.dumps({"virtualWalls": walls, "restrictedZones": []}, indent=1) + "\n"


def _points(topology: TopologicalMap, door: Door, origin_cm: Point) -> dict[str, dict[str, int]]:
    frame = topology.frame
    row, col = frame.cell_from_world(np.array(line_m(topology, door))).T
    cell_cm = frame.resolution_m * CM_PER_M
    x_cm = np.rint(origin_cm[0] + (col + 0.5) * cell_cm).astype(int).tolist()
    y_cm = np.rint(origin_cm[1] - (frame.height - row - 0.5) * cell_cm).astype(int).tolist()
    return {end: {"x": x, "y": y} for end, x, y in zip(("pA", "pB"), x_cm, y_cm, strict=True)}
