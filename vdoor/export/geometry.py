"""Doors as lines and rooms as rings for other programs, and checks before they are written."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from vdoor.errors import SettingError, VdoorError
from vdoor.frame import LEAST_DECIMALS
from vdoor.topology import Door, Polygon, TopologicalMap, signed_area_m2

Point = tuple[float, float]
Line = tuple[Point, Point]


def rounded_m(place_m: Sequence[float] | NDArray[np.float64], decimals: int = LEAST_DECIMALS) -> Point:
    """A point x, y rounded to what it is worth: maps are not more exact, and people read the numbers."""
    x_m, y_m = place_m
    return round(float(x_m), decimals) + 0.0, round(float(y_m), decimals) + 0.0  # no -0.0


def line_m(topology: TopologicalMap, door: Door) -> Line:
    """Line along a door, as long as the door.

    The ends of a passage are the middles of its outermost contacts, which may coincide; its line is extended by half a
    cell at both ends, to the walls.
    """
    start, end = topology.frame.cell_from_world(np.array([door.start_m, door.end_m]))
    span, length = end - start, door.length_m / topology.frame.resolution_m
    short = length - math.hypot(*span)
    if short < 1e-6:  # noqa: PLR2004  # a rounding error, in cells
        return door.start_m, door.end_m
    if not span.any():
        # A contact is between two rows or between two columns; the line runs along the border between them.
        between_rows = abs(start[0] - round(start[0])) > 0.25  # noqa: PLR2004  # the difference is 0.5 or 0
        span = np.array([0.0, 1.0]) if between_rows else np.array([1.0, 0.0])
    more = span / math.hypot(*span) * short / 2
    one, other = topology.frame.world_from_cell(np.stack([start - more, end + more]))
    return rounded_m(one, topology.frame.decimals), rounded_m(other, topology.frame.decimals)


def right_handed(polygon_m: Polygon) -> Polygon:
    """The same rings, the outer one counter-clockwise and holes clockwise, as RFC 7946 requires."""
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
    """Raise `VdoorError` for the first field of a map with a number that is not finite, as in damaged recordings."""
    columns = {field.name: getattr(topology, field.name) for field in dataclasses.fields(topology)}
    pose = {f"frame.{name}": np.array(value, np.float64) for name, value in vars(topology.frame).items()}
    for name, values in (columns | pose).items():
        if isinstance(values, np.ndarray) and values.dtype == np.float64 and not np.isfinite(values).all():
            raise VdoorError(f"map: wanted finite numbers, found {values[~np.isfinite(values)].item(0)} in {name}")
