"""The order in which to visit rooms, by the distances between where the robot stands in them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vdoor.errors import SettingError
from vdoor.navigate.order import Order, best_order
from vdoor.navigate.places import Standing
from vdoor.navigate.routes import Routes
from vdoor.navigate.targets import Target

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Visits:
    """An order of rooms, and the rooms that are left out since the robot cannot get there."""

    stops: tuple[Target, ...]
    """The start if one is given, the rooms, and the end if one is given."""
    order: Order
    """Its places are the rows of the distances, not rooms."""
    out_of_reach: tuple[int, ...]


def visits(routes: Routes, rooms: Sequence[int], start: Target | None = None, end: Target | None = None) -> Visits:
    """The shortest order found of some rooms, from a start to an end; a start that is also the end is returned to.

    Rooms that cannot be reached from the start, or without one from the room with most others in reach, are left out.
    Raises `SettingError` for a start or end where the robot does not fit, or between which there is no way.
    """
    ends = [target for target in dict.fromkeys((start, end)) if target is not None]
    wanted = [room for room in dict.fromkeys(rooms) if not any(target.room == room for target in ends)]
    stops = [*ends, *(Target(str(room), room=room) for room in wanted if routes.standing[room] is not None)]
    distance = distances_m(routes, stops)
    kept = _in_reach(distance, fixed=len(ends))
    stops = [stops[row] for row in kept]
    found = best_order(
        distance[np.ix_(kept, kept)],
        start=None if start is None else stops.index(start),
        end=None if end is None else stops.index(end),
    )
    reached = {stop.room for stop in stops}
    return Visits(
        tuple(stops[place] for place in found.places), found, tuple(room for room in wanted if room not in reached)
    )


def _standing(routes: Routes, target: Target) -> Standing:
    found = target.standing(routes, what="order")
    if found is None:
        raise SettingError(f"order: wanted a start and end where the robot fits, found {target.told(routes.topology)}")
    return found


def distances_m(routes: Routes, stops: Sequence[Target]) -> Floats:
    """The lengths over cells (k, k) between rooms or places, infinite where there is no way.

    Raises `SettingError` for a place or room where the robot does not fit.
    """
    cells = [_standing(routes, stop).cell for stop in stops]
    found = np.zeros((len(stops), len(stops)))
    for row, one in enumerate(stops):
        for col, other in enumerate(stops[:row]):
            if one.room and other.room:
                length_m = routes.distance_m(one.room, other.room)
            else:
                plan = routes.plan(cells[row], cells[col])
                length_m = math.inf if plan is None else plan.length * routes.unit_m
            found[row, col] = found[col, row] = length_m
    return found


def _in_reach(distance: Floats, *, fixed: int) -> list[int]:
    """The rows that the fixed first ones reach, or without these the row that reaches most."""
    reached = np.isfinite(distance)
    if not fixed:
        fixed_row = int(np.argmax(reached.sum(axis=1))) if len(distance) else 0
        return np.flatnonzero(reached[fixed_row]).tolist() if len(distance) else []
    if not reached[:fixed, :fixed].all():
        raise SettingError("order: wanted a way from the start to the end, found none")
    return np.flatnonzero(reached[0]).tolist()
