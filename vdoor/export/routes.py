"""Routes through free space, from every door to the middles of its two rooms."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
import scipy
from numpy.typing import NDArray

from vdoor.errors import VdoorError
from vdoor.export.geometry import Point, line_m
from vdoor.export.path_simplification import cost, straightened
from vdoor.navigate.roadmap_doors import apart
from vdoor.raster.components import contacts
from vdoor.topology import Door, Room, TopologicalMap

Cell = tuple[int, int]
Floats = NDArray[np.float64]

CLEAR_M = 0.35
"""Distance to walls beyond which a route costs its length: a robot of this width has half its width to spare."""
STEEP = 3
"""Nearer to a wall a metre costs (CLEAR_M / distance) ** STEEP: 8 at half of CLEAR_M, where that robot just fits."""


@dataclass(frozen=True)
class Side:
    """The route from a door to the middle of one of its rooms, within that room."""

    room: int
    cell: Cell
    """Row, col of the room's cell at the door's middle."""
    points_m: tuple[Point, ...]
    """Start, bends and the room's middle; straight between them."""

    @property
    def cost_m(self) -> float:
        """Length of the route."""
        return math.fsum(math.dist(*ends) for ends in pairwise(self.points_m))


@dataclass(frozen=True)
class Doorway:
    """A door, the point nearest to its middle where its rooms touch, and the routes from there on both sides."""

    door: Door
    middle_m: Point
    """On the border between two free cells, one of each room."""
    sides: tuple[Side, Side]


def doorways(topology: TopologicalMap, *, before_m: float = 0.0) -> list[Doorway]:
    """Every door with its routes, in the order of the doors.

    A route is the cheapest path over cells of its room, straight or diagonal, where metres near walls cost more (see
    `CLEAR_M`), simplified to a few straight segments. It never leaves its room, so it is valid whichever other doors
    are open, and never passes between two cells that touch only at a corner.

    It begins in the door's middle, or up to `before_m` straight in front of it, if the room is that deep.

    Raises `VdoorError` for a door whose rooms do not touch, and for a room in several pieces.
    """
    doors, rooms = topology.doors, {room.id: room for room in topology.rooms}
    places = _crossings(topology, doors)
    boxes = scipy.ndimage.find_objects(topology.labels)
    doors_of: dict[int, list[int]] = defaultdict(list)
    for row, door in enumerate(doors):
        for number in door.rooms:
            doors_of[number].append(row)
    sides: dict[tuple[int, int], Side] = {}
    for number, rows in doors_of.items():
        ways = _Ways(topology, rooms[number], boxes[number - 1])
        sides |= {(row, number): ways.side(places[row], _across(topology, doors[row]), before_m) for row in rows}
    return [
        Doorway(door, _points_m(topology, place[None])[0], (sides[row, door.rooms[0]], sides[row, door.rooms[1]]))
        for row, (door, place) in enumerate(zip(doors, places, strict=True))
    ]


def _crossings(topology: TopologicalMap, doors: Sequence[Door]) -> Floats:
    """Row, col (doors, 2) of the border of two touching cells, one of each room, nearest to each door's middle."""
    place, pair = contacts(topology.labels)
    found = np.empty((len(doors), 2))
    for row, door in enumerate(doors):
        own = place[(pair == sorted(door.rooms)).all(axis=1)]
        if not len(own):
            raise VdoorError(apart(door))
        middle = topology.frame.cell_from_world(np.array([door.start_m, door.end_m])).mean(axis=0)
        found[row] = own[np.argmin(((own - middle) ** 2).sum(axis=1))]
    return found


def _across(topology: TopologicalMap, door: Door) -> Floats:
    """Unit vector (2,) as row, col, perpendicular to the door, in either direction."""
    (row, col), (end_row, end_col) = topology.frame.cell_from_world(np.array(line_m(topology, door)))
    return np.array([col - end_col, end_row - row]) / math.hypot(end_row - row, end_col - col)


def _points_m(topology: TopologicalMap, row_col: Floats) -> tuple[Point, ...]:
    return tuple((x_m, y_m) for x_m, y_m in topology.frame.world_from_cell(row_col).tolist())


class _Ways:
    """Cheapest paths within one room from all of its cells to its middle; rows and columns are relative to a crop."""

    def __init__(self, topology: TopologicalMap, room: Room, box: tuple[slice, ...]) -> None:
        self._room, self._topology = room.id, topology
        self._weight, self._corner = weights(topology, room.id, box)
        own = np.isfinite(self._weight)
        self._place = np.argwhere(own)
        self._number = np.full(own.shape, -1, np.int32)
        self._number[own] = np.arange(len(self._place))
        middle = topology.frame.cell_from_world(np.array([room.centre_m]))[0] - self._corner
        steps = links(self._number, self._weight)
        self._spent, self._next = scipy.sparse.csgraph.dijkstra(
            steps, directed=False, indices=self._number[_cell(middle)], return_predecessors=True
        )

    def side(self, crossing: Floats, across: Floats, before_m: float) -> Side:
        """The route from a crossing (2,), as row, col of the map, or from up to `before_m` in front of it."""
        door = crossing - self._corner
        cell = next(end for end in (np.floor(door), np.ceil(door)) if np.isfinite(self._weight[_cell(end)]))
        start = self._place_before(door, 2 * (cell - door), across, before_m)
        path, spent = self._path(start, cell if start is door else np.rint(start))
        bends = straightened(path, spent, self._weight) + self._corner
        return Side(self._room, _cell(cell + self._corner), _points_m(self._topology, bends))

    def _place_before(self, door: Floats, inward: Floats, across: Floats, before_m: float) -> Floats:
        """The farthest point (2,) within the room straight in front of a door, up to `before_m`; or the door."""
        if not before_m:
            return door
        across = across if across @ inward > 0 else -across
        if across @ inward < 0.5:  # noqa: PLR2004  # the rooms' contact is more than 60 degrees off the door's line
            across = inward
        place = door + inward / 2
        for step in np.arange(0.5, before_m / self._topology.frame.resolution_m + 1e-9):
            if not np.isfinite(cost(door, door + step * across, self._weight)):
                break
            place = door + step * across
        return place

    def _path(self, start: Floats, cell: Floats) -> tuple[Floats, Floats]:
        """Path from a point (2,) in a cell to the middle: points (k, 2), one per cell, and cumulative cost (k,)."""
        numbers = [int(self._number[_cell(cell)])]
        if not np.isfinite(self._spent[numbers[0]]):
            raise VdoorError(f"room {self._room}: wanted one connected part, found several")
        while (after := int(self._next[numbers[-1]])) >= 0:
            numbers.append(after)
        spent = self._spent[numbers[0]] - self._spent[numbers]
        if np.array_equal(start, cell):
            return self._place[numbers].astype(np.float64), spent
        first = cost(start, cell, self._weight)
        return np.vstack([start, self._place[numbers]]), np.append(0.0, first + spent)


def weights(topology: TopologicalMap, room: int, box: tuple[slice, ...]) -> tuple[Floats, NDArray[np.intp]]:
    """Cost per metre (h, w) in the cells of a room, infinite elsewhere, for a crop of the map around a box.

    The second value is row, col (2,) of the crop's upper left cell, which may be one beyond the map's edge. Other rooms
    do not count as walls.
    """
    cell_m = topology.frame.resolution_m
    margin = math.ceil(CLEAR_M / cell_m)
    part = tuple(slice(max(side.start - margin, 0), side.stop + margin) for side in box)
    labels = np.pad(topology.labels[part], 1)
    clear_m = (scipy.ndimage.distance_transform_edt(labels > 0) - 0.5) * cell_m
    weight = np.maximum(CLEAR_M / np.maximum(clear_m, cell_m / 2), 1) ** STEEP
    return np.where(labels == room, weight, np.inf), np.array([side.start - 1 for side in part])


def links(number: NDArray[np.int32], weight: Floats) -> scipy.sparse.csr_array[Any]:
    """Costs of steps between neighbouring cells as a sparse matrix (cells, cells), each pair once.

    `number` (h, w) numbers the cells and is -1 elsewhere, `weight` (h, w) is the cost per cell length. Half of a step
    is in either cell. A diagonal step needs all four cells of its square.
    """
    own = number >= 0
    square = own[:-1, :-1] & own[1:, 1:] & own[:-1, 1:] & own[1:, :-1]
    pairs: list[tuple[Any, Any, NDArray[np.bool_], float]] = [
        (np.s_[:, :-1], np.s_[:, 1:], own[:, :-1] & own[:, 1:], 1.0),
        (np.s_[:-1], np.s_[1:], own[:-1] & own[1:], 1.0),
        (np.s_[:-1, :-1], np.s_[1:, 1:], square, math.sqrt(2)),
        (np.s_[:-1, 1:], np.s_[1:, :-1], square, math.sqrt(2)),
    ]
    one = np.concatenate([number[a][both] for a, _, both, _ in pairs])
    other = np.concatenate([number[b][both] for _, b, both, _ in pairs])
    costs = [step / 2 * (weight[a][both] + weight[b][both]) for a, b, both, step in pairs]
    count = int(number.max(initial=-1)) + 1
    return scipy.sparse.csr_array((np.concatenate(costs), (one, other)), shape=(count, count))


def _cell(place: Floats) -> Cell:
    """The cell that contains a point (2,) given as row, col."""
    row, col = np.rint(place).astype(int).tolist()
    return row, col
