"""Routes in words."""

from __future__ import annotations

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
