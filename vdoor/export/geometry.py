"""Doors as lines and rooms as rings, the way other programs take them, and the checks before they are written."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence

import numpy as np

from vdoor.errors import SettingError, VdoorError
from vdoor.topology import Door, Polygon, TopologicalMap, signed_area_m2

Point = tuple[float, float]
Line = tuple[Point, Point]


def line_m(topology: TopologicalMap, door: Door) -> Line:
    """The door's ends, as far apart as it is long.

    A passage's ends are middles of its outermost contacts, which may be one and the same: its line goes half a cell
    on, to the walls.
    """
    start, end = topology.frame.cell_from_world(np.array([door.start_m, door.end_m]))
    span, length = end - start, door.length_m / topology.frame.resolution_m
    short = length - math.hypot(*span)
    if short < 1e-6:  # noqa: PLR2004  # a rounding error, in cells
        return door.start_m, door.end_m
    if not span.any():
        # A contact lies between two rows or between two columns; the border goes along it.
        between_rows = abs(start[0] - round(start[0])) > 0.25  # noqa: PLR2004  # it is a half or none
        span = np.array([0.0, 1.0]) if between_rows else np.array([1.0, 0.0])
    more = span / math.hypot(*span) * short / 2
    (x_m, y_m), (to_x_m, to_y_m) = topology.frame.world_from_cell(np.stack([start - more, end + more])).tolist()
    return (x_m, y_m), (to_x_m, to_y_m)


def right_handed(polygon_m: Polygon) -> Polygon:
    """The same rings, the outer one counter-clockwise and holes clockwise, as RFC 7946 wants them."""
    return tuple(
        ring if (signed_area_m2(ring) > 0) == (index == 0) else tuple(reversed(ring))
        for index, ring in enumerate(polygon_m)
    )


def check_rooms(topology: TopologicalMap, rooms: Sequence[int]) -> None:
    """Raise `SettingError` for the first of `rooms` that the map does not have."""
    known = {room.id for room in topology.rooms}
    for room in rooms:
        if room not in known:
            raise SettingError(f"--room: wanted one of the map's {len(known)} rooms, found {room}")


def refuse_not_finite(topology: TopologicalMap) -> None:
    """VdoorError naming the first part of a map that has a number which is not finite, as damaged recordings have."""
    columns = {field.name: getattr(topology, field.name) for field in dataclasses.fields(topology)}
    pose = {f"frame.{name}": np.array(value, np.float64) for name, value in vars(topology.frame).items()}
    for name, values in (columns | pose).items():
        if isinstance(values, np.ndarray) and values.dtype == np.float64 and not np.isfinite(values).all():
            raise VdoorError(f"map: wanted finite numbers, found {values[~np.isfinite(values)].item(0)} in {name}")
