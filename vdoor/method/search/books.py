"""The rooms of one choice of doors, and which rooms each door separates: all that a flip is judged from."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from vdoor.method.search.costs import Totals
from vdoor.method.search.problem import LOG_ODDS_UNIT, TILT_UNIT_DEG2, MergeProblem

Rooms = tuple[int, ...]
"""The rooms that a door separates, ascending; none if it separates nothing."""
PAIR = 2
"""A door between more rooms than two counts as a pair of its own."""
CLOSED = -1
"""The room of nodes that are not open."""


class Room(NamedTuple):
    """Sums over the nodes of a room. Open atoms without a region are no room and do not count."""

    nodes: int = 0
    regions: int = 0
    cells: int = 0

    def plus(self, other: Room, sign: int = 1) -> Room:
        """The sums with, or for a sign of -1 without, the other's nodes."""
        return Room(
            self.nodes + sign * other.nodes, self.regions + sign * other.regions, self.cells + sign * other.cells
        )


class Sums(NamedTuple):
    """The `Totals` of one choice, in whole cells and units."""

    rooms: int
    small: int
    cells: int
    squared_cells: int
    lacking_cells: int
    doors: int
    tilt: int
    conflicts: int
    separating: int
    pairs: int
    log_odds: int

    def totals(self, cell_m2: float) -> Totals:
        """The sums in the units of the cost."""
        return Totals(
            rooms=self.rooms,
            small=self.small,
            area_m2=self.cells * cell_m2,
            area_squared_m4=self.squared_cells * cell_m2**2,
            doors=self.doors,
            tilt_squared_deg2=self.tilt * TILT_UNIT_DEG2,
            lacking_m2=self.lacking_cells * cell_m2,
            separating=self.separating,
            pairs=self.pairs,
            log_odds=self.log_odds * LOG_ODDS_UNIT,
            conflicts=self.conflicts,
        )


class Books:
    """The books of one choice of doors; rooms are numbered, in any order."""

    def __init__(self, problem: MergeProblem, removed: NDArray[np.bool_]) -> None:
        self.problem = problem
        self.near = problem.adjacency
        self.removed: list[bool] = removed.tolist()
        nodes = len(problem.cells)
        covers = self.near.covers[:, ~removed[self.near.covers[0]]]
        self.kept_doors: list[int] = np.bincount(covers[1], minlength=nodes).tolist()
        """The number of kept doors that cover each node."""
        self.cells: list[int] = problem.cells.astype(np.int64).tolist()
        self.tilt: list[int] = problem.tilt.tolist()
        self.log_odds: list[int] = problem.log_odds.tolist()
        room, is_open = (one[0] for one in problem.rooms(removed[None]))
        self.room_of: list[int] = np.where(is_open, room, CLOSED).tolist()
        self.next_room = int(room.max(initial=-1)) + 1
        self.rooms = rooms_of(problem, room, is_open)
        self.separated = separated_rooms(problem, removed, room)
        """The rooms that each kept door separates."""
        self.pairs: dict[Rooms, int] = {}
        """The number of kept doors that separate each pair of rooms, and no other."""
        self.doors_at: dict[int, set[int]] = {number: set() for number in self.rooms}
        """The kept doors that separate each room from others."""
        self.hope: list[bool] = (problem.most_gain > 0).tolist()
        """Which doors may gain anything if they separate rooms."""
        self.idle_hopes = int((~removed & (problem.most_gain > 0)).sum())
        """The number of kept doors that separate nothing but may gain."""
        for edge, rooms in enumerate(self.separated):
            if rooms:
                self.enter(edge, rooms)
        self.sums = self._sums()
        self.work = 0
        """Work done so far: nodes and doors that were looked at to judge and make flips."""

    def enter(self, edge: int, rooms: Rooms) -> None:
        """Note that a kept door separates these rooms."""
        self.idle_hopes -= self.hope[edge]
        self.separated[edge] = rooms
        for room in rooms:
            self.doors_at[room].add(edge)
        if len(rooms) == PAIR:
            self.pairs[rooms] = self.pairs.get(rooms, 0) + 1

    def strike(self, edge: int) -> None:
        """Note that a door separates nothing any more."""
        rooms = self.separated[edge]
        self.idle_hopes += self.hope[edge] and bool(rooms)
        for room in rooms:
            self.doors_at[room].discard(edge)
        if len(rooms) == PAIR:
            self.pairs[rooms] -= 1
            if not self.pairs[rooms]:
                del self.pairs[rooms]
        self.separated[edge] = ()

    def rooms_beside(self, edge: int, changed: Mapping[int, int]) -> Rooms:
        """The rooms that a door would separate if it were kept, with the changed rooms of some nodes."""
        room_of = self.room_of
        beside = {changed[one] if one in changed else room_of[one] for one in self.near.regions_of[edge]}
        return tuple(sorted(beside)) if len(beside) >= PAIR else ()

    def flooded(self, node: int) -> list[int]:
        """All nodes of the room of a node."""
        room = self.room_of[node]
        found, seen = [node], {node}
        for one in found:  # the list grows during the loop
            for near in self.near.neighbours[one]:
                if self.room_of[near] == room and near not in seen:
                    seen.add(near)
                    found.append(near)
        self.work += len(found)
        return found

    def cells_behind(self, edge: int, region: int, enough: int) -> int:
        """The number of cells that are joined to a region without the nodes of a door; beyond `enough`, fewer."""
        found, seen = [region], {region, *self.near.nodes_of[edge]}
        cells = 0
        for node in found:  # the list grows during the loop
            cells += self.cells[node]
            if cells >= enough:
                break
            fresh = [near for near in self.near.neighbours[node] if near not in seen and self.room_of[near] != CLOSED]
            seen.update(fresh)
            found += fresh
        return cells

    def of_nodes(self, nodes: Iterable[int]) -> Room:
        """The sums over some nodes."""
        count = regions = cells = 0
        for node in nodes:
            count += 1
            regions += node < self.problem.regions
            cells += self.cells[node]
        return Room(count, regions, cells)

    def _sums(self) -> Sums:
        cells = [room.cells for room in self.rooms.values() if room.regions]
        kept = [edge for edge, gone in enumerate(self.removed) if not gone]
        separating = [edge for edge in kept if self.separated[edge]]
        a, b = self.problem.conflicts.tolist()
        return Sums(
            rooms=len(cells),
            small=sum(one < self.problem.small_cells for one in cells),
            cells=sum(cells),
            squared_cells=sum(one**2 for one in cells),
            lacking_cells=sum(max(self.problem.threshold_cells - one, 0) for one in cells),
            doors=len(kept),
            tilt=sum(self.tilt[edge] for edge in kept),
            conflicts=sum(not (self.removed[one] or self.removed[other]) for one, other in zip(a, b, strict=True)),
            separating=len(separating),
            pairs=len(self.pairs) + sum(len(self.separated[edge]) > PAIR for edge in separating),
            log_odds=sum(self.log_odds[edge] for edge in separating),
        )


def rooms_of(problem: MergeProblem, room: NDArray[np.intp], is_open: NDArray[np.bool_]) -> dict[int, Room]:
    """The sums of each room that the nodes (n,) are in."""
    room = room[is_open]
    count = np.bincount(room)
    regions = np.bincount(room, weights=problem.is_region[is_open]).astype(np.int64)
    cells = np.bincount(room, weights=problem.cells[is_open]).astype(np.int64)
    number = np.flatnonzero(count)
    columns = (column[number].tolist() for column in (count, regions, cells))
    return dict(zip(number.tolist(), map(Room, *columns), strict=True))


def separated_rooms(problem: MergeProblem, removed: NDArray[np.bool_], room: NDArray[np.intp]) -> list[Rooms]:
    """The rooms that each door separates, if the cost counts that."""
    found: list[Rooms] = [()] * problem.edges
    separates, _ = (one[0] for one in problem.separating(removed[None], room[None]))
    for edge in np.flatnonzero(separates).tolist():
        beside = {int(room[region]) for region in problem.adjacency.regions_of[edge]}
        found[edge] = tuple(sorted(beside))
    return found
