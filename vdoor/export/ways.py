"""Ways through free space: from every door to the middles of the rooms it joins."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage, sparse
from scipy.sparse.csgraph import dijkstra

from vdoor.errors import VdoorError
from vdoor.stages.final_doors import contacts
from vdoor.topology import Door, Room, TopologicalMap

Point = tuple[float, float]


@dataclass(frozen=True)
class Side:
    """The way from a door to the middle of one of its rooms, within that room."""

    room: int
    cost_m: float
    """From the door's middle, at least half a cell."""
    cell: tuple[int, int]
    """Row, col of the room's cell at the door's middle."""


@dataclass(frozen=True)
class Doorway:
    """A door, where its rooms touch nearest to its middle, and the way from there on both sides."""

    door: Door
    middle_m: Point
    """On the border of two free cells, one of either room."""
    sides: tuple[Side, Side]


def doorways(topology: TopologicalMap) -> list[Doorway]:
    """Every door with its ways, in the order of the doors; costs are in metres along free cells.

    A way goes from cell to cell, straight or diagonally, never between two cells that touch at a corner alone. It
    stays in its room, so that it holds whatever other doors are open.

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
        sides |= {(row, number): ways.side(places[row]) for row in rows}
    middle_m = topology.frame.world_from_cell(places).tolist()
    return [
        Doorway(door, (x_m, y_m), (sides[row, door.rooms[0]], sides[row, door.rooms[1]]))
        for row, (door, (x_m, y_m)) in enumerate(zip(doors, middle_m, strict=True))
    ]


def _crossings(topology: TopologicalMap, doors: Sequence[Door]) -> NDArray[np.float64]:
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


class _Ways:
    """Shortest ways within one room from its middle to all of its cells."""

    def __init__(self, topology: TopologicalMap, room: Room, box: tuple[slice, ...]) -> None:
        self._room, self._cell_m = room.id, topology.frame.resolution_m
        self._corner = np.array([side.start for side in box])
        own = topology.labels[box] == room.id
        self._number = np.full(own.shape, -1, np.int32)
        self._number[own] = np.arange(np.count_nonzero(own))
        centre = np.rint(topology.frame.cell_from_world(np.array([room.centre_m]))[0]).astype(int) - self._corner
        self._cells = dijkstra(links(self._number), directed=False, indices=self._number[tuple(centre)])

    def side(self, crossing: NDArray[np.float64]) -> Side:
        """The way from a crossing (2,) as row, col between a cell of this room and one of another."""
        ends = np.array([np.floor(crossing), np.ceil(crossing)]).astype(int)
        row, col = next((row, col) for row, col in ends.tolist() if self._number_at(row, col) >= 0)
        cells = float(self._cells[self._number_at(row, col)]) + 0.5
        if not np.isfinite(cells):
            raise VdoorError(f"room {self._room}: wanted one connected part, found several")
        return Side(self._room, cells * self._cell_m, (row, col))

    def _number_at(self, row: int, col: int) -> int:
        """Number of a cell of the map, -1 where it is not the room's."""
        row, col = row - int(self._corner[0]), col - int(self._corner[1])
        height, width = self._number.shape
        return int(self._number[row, col]) if 0 <= row < height and 0 <= col < width else -1


def links(number: NDArray[np.int32]) -> sparse.csr_array[Any]:
    """Steps between neighbouring cells (cells, cells) with their lengths in cells, each pair once.

    `number` (h, w) counts the cells and is -1 elsewhere. A diagonal step needs all four cells of its square.
    """
    own = number >= 0
    square = own[:-1, :-1] & own[1:, 1:] & own[:-1, 1:] & own[1:, :-1]
    pairs = [
        (number[:, :-1], number[:, 1:], own[:, :-1] & own[:, 1:], 1.0),
        (number[:-1], number[1:], own[:-1] & own[1:], 1.0),
        (number[:-1, :-1], number[1:, 1:], square, np.sqrt(2)),
        (number[:-1, 1:], number[1:, :-1], square, np.sqrt(2)),
    ]
    one = np.concatenate([a[both] for a, _, both, _ in pairs])
    other = np.concatenate([b[both] for _, b, both, _ in pairs])
    length = np.concatenate([np.full(np.count_nonzero(both), step) for _, _, both, step in pairs])
    count = int(number.max(initial=-1)) + 1
    return sparse.csr_array((length, (one, other)), shape=(count, count))
