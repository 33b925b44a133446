"""Routes in words."""

from __future__ import annotations

import math
from typing import Any

from vdoor.navigate.find_route import Route
from vdoor.navigate.obstacles import APART, AVOIDED, CLOSED, KINDS, NARROW, NARROW_DOOR


def described(route: Route) -> str:
    """A route in one line: its length, doors and least clearance, or what is in the way."""
    if not route.found:
        reasons = "; ".join(obstacle_text(route, row) for row in range(len(route.obstacle)))
        return f"no way with a clearance of {route.radius_m:g} m: {reasons}"
    doors = ", ".join(map(str, route.door.tolist())) or "none"
    return f"{route.length_m:.2f} m, doors {doors}, least clearance {route.clear_m:.3f} m"


def obstacle_text(route: Route, row: int) -> str:
    """One thing in the way, in words."""
    kind, number = int(route.obstacle[row]), int(route.obstacle_id[row])
    x_m, y_m = route.obstacle_m[row].tolist()
    if kind == CLOSED:
        return f"door {number} is closed"
    if kind == AVOIDED:
        return f"room {number} is to be avoided"
    if kind == APART:
        return f"no free cells lead out of room {number}"
    if kind in {NARROW, NARROW_DOOR}:
        what = f"door {number}" if kind == NARROW_DOOR else f"a passage in room {number}"
        return f"{what} at {x_m:.2f},{y_m:.2f} leaves {route.obstacle_clear_m[row]:.3f} m"
    return f"a {KINDS[kind]} or virtual wall at {x_m:.2f},{y_m:.2f}"


def document_of(route: Route) -> dict[str, Any]:
    """A route as plain values; what is not known is None."""
    bends = zip(route.point_m.tolist(), route.yaw_rad.tolist(), route.along_m.tolist(), strict=True)
    stops = zip(route.stop_m.tolist(), route.stop_room.tolist(), route.stop_moved_m.tolist(), strict=True)
    return {
        "found": route.found,
        "radius_m": route.radius_m,
        "length_m": _known(route.length_m),
        "clear_m": _known(route.clear_m),
        "doors": route.door.tolist(),
        "stops": [
            {"room": room, "place_m": [*map(_known, place_m)], "moved_m": moved_m} for place_m, room, moved_m in stops
        ],
        "path": [{"x_m": x_m, "y_m": y_m, "yaw_rad": yaw, "along_m": along_m} for (x_m, y_m), yaw, along_m in bends],
        "in_the_way": [
            {
                "kind": KINDS[route.obstacle[row]],
                "id": int(route.obstacle_id[row]),
                "place_m": route.obstacle_m[row].tolist(),
                "clear_m": _known(float(route.obstacle_clear_m[row])),
                "text": obstacle_text(route, row),
            }
            for row in range(len(route.obstacle))
        ],
    }


def _known(value: float) -> float | None:
    return None if math.isnan(value) else value
