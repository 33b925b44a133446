"""Why there is no way: what is ruled out on it, or where it is too tight, and how tight."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from vdoor.method.final_doors import to_segment_m
from vdoor.navigate.blocked import Restrictions
from vdoor.navigate.routes import Routes
from vdoor.navigate.space import Space
from vdoor.topology import TopologicalMap

Cell = tuple[int, int]
Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]
Ends = Callable[[Routes], tuple[Cell | None, Cell | None]]
"""Where the robot stands at the start and at the goal, None where it does not fit."""

CLOSED, AVOIDED, RULED_OUT, NARROW_DOOR, NARROW, APART = range(6)
KINDS = ("closed door", "avoided room", "no-go area", "narrow door", "narrow passage", "no passage")
"""What can be in the way: the last one where no free cells join the two."""
NEAR_DOOR_M = 0.5
"""A narrow place belongs to a door within this distance."""
LEAST = 1e-3
"""The radius in cells of a robot that fits wherever cells join at a side."""


@dataclass(frozen=True)
class Obstacle:
    """One thing in the way."""

    kind: int
    """An index into `KINDS`."""
    id: int
    """Of the door or the room; -1 for a no-go area or a virtual wall."""
    place_m: tuple[float, float]
    clear_m: float = np.nan
    """The clearance that is left there, nan unless the place is narrow."""


def in_the_way(
    topology: TopologicalMap, ends: Ends, walls: Mask, blocked: Mask, *, restrictions: Restrictions, radius_m: float
) -> list[Obstacle]:
    """What is in the way where a robot of a radius finds none: along the way that there would be otherwise.

    `walls` are the cells (h, w) that are not free, `blocked` also those that are ruled out.
    """
    routes = Routes(Space.of(walls, topology.frame, radius_m), topology)
    if (path := _path(routes, ends)) is not None:
        return [*_ruled_out(path, topology, walls, blocked, restrictions)]
    for mask in (blocked, walls):
        if (found := _tightest(mask, topology, ends, radius_m)) is not None:
            return found
    start, _ = ends(Routes(Space.of(walls, topology.frame, LEAST * topology.frame.resolution_m), topology))
    place = start or (0, 0)
    return [Obstacle(APART, int(topology.labels[place]), _place_m(topology, np.array([place])))]


def _path(routes: Routes, ends: Ends) -> list[Cell] | None:
    start, goal = ends(routes)
    if start is None or goal is None or routes.space.parts[start] != routes.space.parts[goal]:
        return None
    return routes.path(start, goal)


def _ruled_out(
    path: list[Cell], topology: TopologicalMap, walls: Mask, blocked: Mask, restrictions: Restrictions
) -> Iterator[Obstacle]:
    """The closed doors, avoided rooms, and ruled out areas along a path, each once."""
    cells = _cells_along(path)
    out = cells[(blocked & ~walls)[tuple(cells.T)]]
    doors = [topology.door(door) for door in restrictions.closed_doors]
    avoided = np.isin(topology.labels[tuple(out.T)], restrictions.avoided_rooms)
    for room in np.unique(topology.labels[tuple(out[avoided].T)]).tolist():
        yield Obstacle(AVOIDED, room, topology.room(room).centre_m)
    others = out[~avoided]
    place_m = topology.frame.world_from_cell(others)
    rest = np.ones(len(others), np.bool_)
    for door in doors:
        near = to_segment_m(place_m, np.array(door.start_m), np.array(door.end_m)) < NEAR_DOOR_M
        if near.any():
            middle = np.mean([door.start_m, door.end_m], axis=0)
            yield Obstacle(CLOSED, door.id, (float(middle[0]), float(middle[1])))
            rest &= ~near
    if rest.any():
        yield Obstacle(RULED_OUT, -1, _place_m(topology, others[rest][:1]))


def _tightest(mask: Mask, topology: TopologicalMap, ends: Ends, radius_m: float) -> list[Obstacle] | None:
    """The narrow places of the widest way, each with the clearance that it leaves; None if there is no way at all."""
    cell_m = topology.frame.resolution_m
    radii = _clearances(radius_m / cell_m)
    low, high, found = -1, len(radii), None
    while high - low > 1:
        middle = (low + high) // 2
        routes = Routes(Space.of(mask, topology.frame, radii[middle] * cell_m), topology)
        path = _path(routes, ends)
        low, high = (middle, high) if path is not None else (low, middle)
        found = path if path is not None else found
    if found is None:
        return None
    tighter = Space.of(mask, topology.frame, radii[high] * cell_m if high < len(radii) else radius_m)
    return [_narrow(topology, place, radii[low] * cell_m) for place in _partings(found, tighter)]


def _clearances(most: float) -> list[float]:
    """All distances below `most` that centres and corners of cells can have from squares, in cells."""
    half = np.arange(0, most + 1, 0.5)
    found = np.unique(np.round(np.hypot(half[:, None], half), 12))
    return [LEAST, *found[(found > LEAST) & (found < most)].tolist()]


def _partings(path: list[Cell], tighter: Space) -> Iterator[Floats]:
    """The middles (1, 2) of the pieces of a path between two parts of a space, and of those that end outside it."""
    cells = _cells_along(path)
    part = tighter.parts[tuple(cells.T)]
    inside = np.flatnonzero(part)
    if not len(inside):
        yield cells[len(cells) // 2][None]
        return
    if inside[0]:
        yield cells[0][None]
    for one, other in pairwise(inside.tolist()):
        if part[one] != part[other]:
            yield cells[(one + other) // 2][None]
    if inside[-1] < len(cells) - 1:
        yield cells[-1][None]


def _narrow(topology: TopologicalMap, place: Floats, clear_m: float) -> Obstacle:
    """A narrow place: a door's, if one is near, else one of the room that it is in."""
    place_m = _place_m(topology, place)
    apart_m = [
        float(to_segment_m(np.array([place_m]), np.array(door.start_m), np.array(door.end_m))[0])
        for door in topology.doors
    ]
    if apart_m and min(apart_m) <= NEAR_DOOR_M:
        return Obstacle(NARROW_DOOR, int(np.argmin(apart_m)) + 1, place_m, clear_m)
    row, col = place[0].astype(int).tolist()
    return Obstacle(NARROW, int(topology.labels[row, col]), place_m, clear_m)


def _cells_along(path: list[Cell]) -> NDArray[np.intp]:
    """The cells (k, 2) at half steps along a path."""
    pieces = [
        np.linspace(start, end, 2 * max(abs(end[0] - start[0]), abs(end[1] - start[1])) + 1)
        for start, end in pairwise(path)
    ]
    return np.asarray(np.rint(np.concatenate(pieces) if pieces else np.array(path)), np.intp)


def _place_m(topology: TopologicalMap, cell: NDArray[np.generic]) -> tuple[float, float]:
    x_m, y_m = topology.frame.world_from_cell(cell)[0].tolist()
    return x_m, y_m
