"""Routes: planned over rooms and doors first, then in metres within the rooms, and pulled tight.

The rooms' portals and standing places, here terminals, are the nodes of a small graph. Its distances are computed room
by room, once a map; a query costs beside that the distances from its two ends to the terminals of their rooms.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
import scipy
from numpy.typing import NDArray

from vdoor.navigate.places import Standing, standing_in
from vdoor.navigate.portals import portals_of
from vdoor.navigate.pull import pulled
from vdoor.navigate.room_graph import FAR, STRAIGHT, RoomGraph, beeline, local_way
from vdoor.navigate.room_table import Table, Tables, digest_of, table_of
from vdoor.navigate.sight import Sight
from vdoor.navigate.space import Space
from vdoor.topology import TopologicalMap

Cell = tuple[int, int]
Ints = NDArray[np.int32]
Floats = NDArray[np.float64]

NEAR_M = 15.0
"""Routes up to this length are searched anew, in all cells: there the detour to a portal counts."""
ALMOST = 1.03
"""Within a room a way at most this much longer than the straight one is looked for first, among few cells."""
MOST_NODES = 500_000
"""Cells of the rooms whose graphs are kept: 50 MB."""
MOST_DISTANCES = 20_000_000
"""Distances from terminals to cells that are kept: 80 MB."""


@dataclass(frozen=True)
class Plan:
    """A route before it is pulled tight."""

    stops: tuple[Cell, ...]
    """The start, the terminals or cells passed, and the goal."""
    lengths: tuple[int, ...]
    """The length over neighbouring cells between each two stops, in the unit of `room_graph`."""
    rooms: tuple[int, ...]
    """The room in which each two stops are joined; 0 if there are only straight or diagonal steps between them."""

    @property
    def length(self) -> int:
        """The whole length."""
        return sum(self.lengths)

    @classmethod
    def over(cls, cells: Sequence[Cell]) -> Plan:
        """The plan that passes the bends of a way over cells."""
        return cls(tuple(cells), tuple(beeline(*step) for step in pairwise(cells)), (0,) * (len(cells) - 1))


class Routes:
    """All routes of a map. Results do not depend on earlier queries, or on tables that are already there."""

    def __init__(self, space: Space, topology: TopologicalMap, *, tables: Tables | None = None) -> None:
        self.space = space
        self.topology = topology
        self.tables: Tables = {} if tables is None else tables
        """The rooms' tables; new ones are added."""
        self._boxes = scipy.ndimage.find_objects(topology.labels)
        self.standing: dict[int, Standing | None] = {
            room: standing_in(space, topology, room, self._boxes[room - 1]) for room in topology.room_ids
        }
        """Where the robot stands in each room; None for a room that it does not fit into."""
        self._keys: dict[int, bytes] = {}
        self._graphs: dict[int, RoomGraph] = {}
        self._fields: dict[tuple[int, Cell], Ints] = {}
        self._latest: tuple[tuple[int, Cell], Ints] = ((0, (0, 0)), np.zeros(0, np.int32))
        self._rows: dict[int, Floats] = {}
        self._list_terminals()

    def _list_terminals(self) -> None:
        """Number the cells of portals and of standing places, and note which rooms each belongs to."""
        rooms_of: dict[Cell, set[int]] = {}
        for portal in portals_of(self.space, self.topology):
            rooms_of.setdefault(portal.cell, set()).update(portal.rooms)
        for room, standing in self.standing.items():
            if standing is not None:
                rooms_of.setdefault(standing.cell, set()).add(room)
        self._cells = [*rooms_of]
        self._rooms_of = [sorted(rooms) for rooms in rooms_of.values()]
        self._of_room: dict[int, list[int]] = {room: [] for room in self.standing}
        for number, rooms in enumerate(self._rooms_of):
            for room in rooms:
                self._of_room[room].append(number)
        self._number = {cell: number for number, cell in enumerate(self._cells)}
        self._place = {room: self._number[standing.cell] for room, standing in self.standing.items() if standing}

    @cached_property
    def sight(self) -> Sight:
        """Straight lines in the space."""
        return Sight(self.space)

    def fill(self) -> None:
        """Compute the distances between all rooms now; otherwise they are computed when they are needed."""
        for terminal in self._place.values():
            self._row(terminal)

    def distance_m(self, one: int, other: int) -> float:
        """The length over cells between where the robot stands in two rooms; infinite if there is no way."""
        if one not in self._place or other not in self._place:
            return math.inf
        return float(self._row(self._place[one])[self._place[other]]) * self.unit_m

    @property
    def unit_m(self) -> float:
        """The unit of lengths over cells, in metres."""
        return self.space.frame.resolution_m / STRAIGHT

    def path(self, start: Cell, goal: Cell) -> list[Cell] | None:
        """The bends of a short path between two allowed cells of rooms, ends included; None if there is no way."""
        if start == goal:
            return [start]
        if self._room(start) == self._room(goal) and self.sight.clear(start, goal):
            return [start, goal]
        plan = self.plan(start, goal)
        if plan is None:
            return None
        ends = np.array(plan.stops, np.float64)
        seen = self.sight.all_clear(ends[:-1], ends[1:]).tolist()
        path = [start]
        legs = zip(pairwise(plan.stops), plan.rooms, plan.lengths, seen, strict=True)
        for (one, other), room, length, clear in legs:
            path += [other] if clear or not room else self._way(one, other, room, length)[1:]
        return pulled(path, self.sight)

    def plan(self, start: Cell, goal: Cell) -> Plan | None:
        """The rooms' terminals to pass between two allowed cells of rooms; None if there is no way.

        The shortest way through terminals, or a shorter one within the room, or, up to `NEAR_M`, the shortest of all.
        """
        same = self._room(start) == self._room(goal)
        if same and (way := local_way(self.space, start, goal, int(ALMOST * beeline(start, goal)))):
            return Plan.over(way)
        plan = self._by_doors(start, goal)
        if same:
            plan = self._inside(start, goal, plan.length if plan else np.inf) or plan
        if plan is None or plan.length == beeline(start, goal) or plan.length * self.unit_m > NEAR_M:
            return plan
        way = local_way(self.space, start, goal, plan.length)
        assert way is not None
        return Plan.over(way)

    def _way(self, start: Cell, goal: Cell, room: int, length: int) -> list[Cell]:
        """The ends and bends of the way between two stops of a plan, at least one of them a terminal, within a room."""
        if goal in self._number or start not in self._number:  # of two cells the terminal, whose field may be kept
            return self._graph(room).way(start, self._near(room, goal, length))
        return self._graph(room).way(goal, self._near(room, start, length))[::-1]

    def _near(self, room: int, cell: Cell, most: int) -> Ints:
        """The distance (n,) of each node of a room from one cell, at least of those up to a distance."""
        kept = self._fields.get((room, cell))
        return self._graph(room).distances(cell, limit=most) if kept is None else kept

    def _room(self, cell: Cell) -> int:
        return int(self.topology.labels[cell])

    def _inside(self, start: Cell, goal: Cell, most: float) -> Plan | None:
        """The way within a room, of at most that length; None if there is none."""
        graph = self._graph(self._room(start))
        distance = graph.distances(goal, limit=most)
        return Plan.over(graph.way(start, distance)) if distance[graph.number(start)] < FAR else None

    def _by_doors(self, start: Cell, goal: Cell) -> Plan | None:
        """The shortest way that passes terminals, the first of equal ones."""
        own, others = (self._of_room[self._room(cell)] for cell in (start, goal))
        if not own or not others:
            return None
        before, after = self._to_terminals(start), self._to_terminals(goal)
        row = self._from(own, before)
        last = int(np.argmin(row[others] + after))
        if not np.isfinite(row[others[last]] + after[last]):
            return None
        passed = self._passed(row, dict(zip(own, before.tolist(), strict=True)), others[last])
        stops = [start, *(self._cells[at] for at in passed), goal]
        rooms = [self._room(start), *(self._room_between(*ends) for ends in pairwise(passed)), self._room(goal)]
        lengths = [row[passed[0]], *np.diff(row[passed]), after[last]]
        moves = [at for at, length in enumerate(lengths) if length]  # an end may be a terminal itself
        return Plan(
            (start, *(stops[at + 1] for at in moves)),
            tuple(int(lengths[at]) for at in moves),
            tuple(rooms[at] for at in moves),
        )

    def _to_terminals(self, cell: Cell) -> Floats:
        """The distances (t,) from a cell to the terminals of its room."""
        room = self._room(cell)
        graph, terminals = self._graph(room), [self._cells[at] for at in self._of_room[room]]
        if all((room, terminal) in self._fields for terminal in terminals):
            node = graph.number(cell)
            found = np.array([self._fields[room, terminal][node] for terminal in terminals], np.float64)
        else:
            found = graph.distances(cell)[[graph.number(terminal) for terminal in terminals]].astype(np.float64)
        found[found == FAR] = math.inf
        return found

    def _field(self, room: int, cell: Cell) -> Ints:
        """The distance (n,) of each node of a room from one cell; those of terminals are kept while there is space."""
        if (room, cell) in self._fields:
            return self._fields[room, cell]
        if self._latest[0] != (room, cell):
            self._latest = (room, cell), self._graph(room).distances(cell)
        key, found = self._latest
        if cell in self._number and sum(map(len, self._fields.values())) + len(found) <= MOST_DISTANCES:
            self._fields[key] = found
        return found

    def _from(self, own: list[int], before: Floats) -> Floats:
        """The distances (t,) of all terminals from where the `own` ones are at some distances."""
        links, count = self._links, len(self._cells)
        reached = np.isfinite(before)
        graph = scipy.sparse.csr_array(
            (
                np.append(links.data, before[reached] + 1),  # a length of 0 would be no link
                np.append(links.indices, np.array(own)[reached]),
                np.append(links.indptr, len(links.data) + np.count_nonzero(reached)),
            ),
            shape=(count + 1, count + 1),
        )
        found: Floats = scipy.sparse.csgraph.dijkstra(graph, indices=np.array(count))[:count] - 1
        return found

    def _passed(self, row: Floats, own: dict[int, float], last: int) -> list[int]:
        """The terminals from one of `own`, at their distances, to the last one, by the distances of all in a row."""
        passed = [last]
        while own.get(passed[-1]) != row[passed[-1]]:
            passed.append(self._before(passed[-1], row))
        return passed[::-1]

    def _before(self, at: int, row: Floats) -> int:
        """The terminal from which another one is reached at its distance."""
        for room in self._rooms_of[at]:
            terminals = self._of_room[room]
            distance = self._table(room)[terminals.index(at)]
            fits = np.flatnonzero((distance > 0) & (distance < FAR) & (row[terminals] + distance == row[at]))
            if len(fits):
                return terminals[int(fits[0])]
        raise AssertionError("a terminal at a distance is reached from one nearer by")

    def _room_between(self, one: int, other: int) -> int:
        """The room through which two terminals are nearest to each other, the first of equal ones."""
        rooms = [room for room in self._rooms_of[one] if room in self._rooms_of[other]]
        return min(rooms, key=lambda room: self._apart(room, one, other))

    def _apart(self, room: int, one: int, other: int) -> int:
        terminals = self._of_room[room]
        return int(self._table(room)[terminals.index(one), terminals.index(other)])

    def _row(self, terminal: int) -> Floats:
        """The distances (t,) of all terminals from one of them, infinite where there is no way."""
        if terminal not in self._rows:
            self._rows[terminal] = scipy.sparse.csgraph.dijkstra(self._links, indices=np.array(terminal))
        return self._rows[terminal]

    @cached_property
    def _links(self) -> scipy.sparse.csr_array:
        """The distances between the terminals of each room, as a graph of all terminals."""
        links = [np.zeros((0, 3), np.int64)]
        for room, terminals in self._of_room.items():
            if terminals:
                distance, number = self._table(room), np.array(terminals)
                one, other = np.nonzero((distance < FAR) & (distance > 0))
                links.append(np.stack([number[one], number[other], distance[one, other]], axis=1))
        return _shortest(np.concatenate(links), len(self._cells))

    def _table(self, room: int) -> Table:
        if room not in self._keys:
            self._keys[room] = self._stored(room)
        return self.tables[self._keys[room]]

    def _stored(self, room: int) -> bytes:
        """The key of a room's table, which is computed if it is not there."""
        graph, cells = self._graph(room), [self._cells[at] for at in self._of_room[room]]
        key = digest_of(graph, cells)
        if key not in self.tables:
            self.tables[key] = table_of(graph, [self._field(room, cell) for cell in cells], cells)
        return key

    def _graph(self, room: int) -> RoomGraph:
        if room not in self._graphs:
            cells = [self._cells[at] for at in self._of_room[room]]
            graph = RoomGraph.of_room(self.space, self.topology.labels, room, self._boxes[room - 1], cells)
            while self._graphs and sum(kept.steps.shape[0] for kept in self._graphs.values()) > MOST_NODES:
                del self._graphs[next(iter(self._graphs))]
            self._graphs[room] = graph
        return self._graphs[room]


def _shortest(links: NDArray[np.int64], count: int) -> scipy.sparse.csr_array:
    """A graph with the shortest of the links (k, 3), each two nodes and a length, between each two of its nodes."""
    start, end, length = links[np.lexsort(links.T[::-1])].T
    first = np.append(True, (np.diff(start) != 0) | (np.diff(end) != 0))[: len(start)]
    return scipy.sparse.csr_array((length[first].astype(np.float64), (start[first], end[first])), shape=(count, count))
