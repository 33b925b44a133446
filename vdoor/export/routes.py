"""Ways through free space: from every door to the middles of the rooms it joins."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage, sparse
from scipy.sparse.csgraph import dijkstra

from vdoor.errors import VdoorError
from vdoor.export.geometry import Point, line_m
from vdoor.export.path_simplification import cost, straightened
from vdoor.raster.labels import contacts
from vdoor.topology import Door, Room, TopologicalMap

Cell = tuple[int, int]
Floats = NDArray[np.float64]

CLEAR_M = 0.35
"""How far from walls a way is as good as any: a robot as wide as that passes with half its width to spare."""
STEEP = 3
"""Nearer to a wall a metre counts as (CLEAR_M / distance) ** STEEP: 8 at half of it, where that robot just fits."""


@dataclass(frozen=True)
class Side:
    """The way from a door to the middle of one of its rooms, within that room."""

    room: int
    cell: Cell
    """Row, col of the room's cell at the door's middle."""
    points_m: tuple[Point, ...]
    """Where it begins, its bends, the room's middle; straight between them."""

    @property
    def cost_m(self) -> float:
        """Its length."""
        return math.fsum(math.dist(*ends) for ends in pairwise(self.points_m))


@dataclass(frozen=True)
class Doorway:
    """A door, where its rooms touch nearest to its middle, and the way from there on both sides."""

    door: Door
    middle_m: Point
    """On the border of two free cells, one of either room."""
    sides: tuple[Side, Side]


def doorways(topology: TopologicalMap, *, before_m: float = 0.0) -> list[Doorway]:
    """Every door with its ways, in the order of the doors.

    A way is the cheapest from cell to cell of its room, straight or diagonally, where metres near walls cost more (see
    `CLEAR_M`), made of few straight pieces. It never leaves its room, so that it holds whatever other doors are open,
    and never slips between two cells that touch at a corner alone.

    It begins in the door's middle, or as far as `before_m` straight before it, where the room is that deep.

    Raises `VdoorError` for a door whose rooms do not touch, and for a room in several parts.
    """
    doors, rooms = topology.doors, {room.id: room for room in topology.rooms}
    places = _crossings(topology, doors)
    boxes = ndimage.find_objects(topology.labels)
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
    """Row, col (doors, 2) of the middle of two touching cells of each door's rooms, nearest to the door's middle."""
    place, pair = contacts(topology.labels)
    found = np.empty((len(doors), 2))
    for row, door in enumerate(doors):
        own = place[(pair == sorted(door.rooms)).all(axis=1)]
        if not len(own):
            one, other = door.rooms
            raise VdoorError(f"door {door.id}: wanted rooms {one} and {other} to touch, found a gap between them")
        middle = topology.frame.cell_from_world(np.array([door.start_m, door.end_m])).mean(axis=0)
        found[row] = own[np.argmin(((own - middle) ** 2).sum(axis=1))]
    return found


def _across(topology: TopologicalMap, door: Door) -> Floats:
    """Unit vector (2,) as row, col straight across the door, either way."""
    (row, col), (end_row, end_col) = topology.frame.cell_from_world(np.array(line_m(topology, door)))
    return np.array([col - end_col, end_row - row]) / math.hypot(end_row - row, end_col - col)


def _points_m(topology: TopologicalMap, row_col: Floats) -> tuple[Point, ...]:
    return tuple((x_m, y_m) for x_m, y_m in topology.frame.world_from_cell(row_col).tolist())


class _Ways:
    """Cheapest ways within one room from all of its cells to its middle; rows and columns are those of a part."""

    def __init__(self, topology: TopologicalMap, room: Room, box: tuple[slice, ...]) -> None:
        self._room, self._topology = room.id, topology
        self._weight, self._corner = weights(topology, room.id, box)
        own = np.isfinite(self._weight)
        self._place = np.argwhere(own)
        self._number = np.full(own.shape, -1, np.int32)
        self._number[own] = np.arange(len(self._place))
        middle = topology.frame.cell_from_world(np.array([room.centre_m]))[0] - self._corner
        steps = links(self._number, self._weight)
        self._spent, self._next = dijkstra(
            steps, directed=False, indices=self._number[_cell(middle)], return_predecessors=True
        )

    def side(self, crossing: Floats, across: Floats, before_m: float) -> Side:
        """The way from a crossing (2,) as row, col of the map between this room and another, or from before it."""
        door = crossing - self._corner
        cell = next(end for end in (np.floor(door), np.ceil(door)) if np.isfinite(self._weight[_cell(end)]))
        start = self._place_before(door, 2 * (cell - door), across, before_m)
        path, spent = self._path(start, cell if start is door else np.rint(start))
        bends = straightened(path, spent, self._weight) + self._corner
        return Side(self._room, _cell(cell + self._corner), _points_m(self._topology, bends))

    def _place_before(self, door: Floats, inward: Floats, across: Floats, before_m: float) -> Floats:
        """The last place (2,) within the room, going straight away from a door in steps of a cell; or the door."""
        if not before_m:
            return door
        across = across if across @ inward > 0 else -across
        if across @ inward < 0.5:  # noqa: PLR2004  # its rooms touch at more than 60 degrees from its line
            across = inward
        place = door + inward / 2
        for step in np.arange(0.5, before_m / self._topology.frame.resolution_m + 1e-9):
            if not np.isfinite(cost(door, door + step * across, self._weight)):
                break
            place = door + step * across
        return place

    def _path(self, start: Floats, cell: Floats) -> tuple[Floats, Floats]:
        """The way from a point (2,) in a cell to the middle: points (k, 2), cell by cell, and the cost so far (k,)."""
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
    """What a metre costs in each cell of a room, infinite elsewhere, as part (h, w) of the map around a box.

    With it row, col (2,) of the part's upper left cell, which may lie one beyond the map's edge. A door is no wall.
    """
    cell_m = topology.frame.resolution_m
    margin = math.ceil(CLEAR_M / cell_m)
    part = tuple(slice(max(side.start - margin, 0), side.stop + margin) for side in box)
    labels = np.pad(topology.labels[part], 1)
    clear_m = (ndimage.distance_transform_edt(labels > 0) - 0.5) * cell_m
    weight = np.maximum(CLEAR_M / np.maximum(clear_m, cell_m / 2), 1) ** STEEP
    return np.where(labels == room, weight, np.inf), np.array([side.start - 1 for side in part])


def links(number: NDArray[np.int32], weight: Floats) -> sparse.csr_array[Any]:
    """Steps between neighbouring cells (cells, cells) with what they cost, each pair once.

    `number` (h, w) counts the cells and is -1 elsewhere, `weight` (h, w) is what a cell's length costs in each. Half of
    a step lies in either cell. A diagonal step needs all four cells of its square.
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
    return sparse.csr_array((np.concatenate(costs), (one, other)), shape=(count, count))


def _cell(place: Floats) -> Cell:
    """The cell that a place (2,) as row, col is in."""
    row, col = np.rint(place).astype(int).tolist()
    return row, col
