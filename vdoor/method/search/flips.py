"""What flipping one door would change, found on the smaller side only, and without making the flip."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Mapping
from typing import NamedTuple

from vdoor.method.search.books import CLOSED, PAIR, Books, Room, Rooms, Sums

NONE = Room()
SHUT = -1
WORK_OF_FLIP = 20
"""What judging any flip takes, beside looking at so many nodes or doors."""
FIRST_STEP = 8
"""The number of nodes to which each part of a room grows at first; it doubles with each turn."""


class Change(NamedTuple):
    """What changes in the books if a door is flipped."""

    edge: int
    room_of: dict[int, int]
    """The new rooms of the nodes that are opened, closed or parted."""
    joined: dict[int, int]
    """The rooms that are joined to larger ones, and those."""
    entry: dict[int, int]
    """A node of each of these rooms."""
    rooms: dict[int, Room]
    """The new sums of rooms that change or arise; those without nodes are gone."""
    separated: dict[int, Rooms]
    """The rooms that doors separate, if these change."""
    sums: Sums


def judged(books: Books, edge: int) -> Change:
    """What changes if the door is removed, or kept if it is removed."""
    change = closing(books, edge) if books.removed[edge] else opening(books, edge)
    books.work += WORK_OF_FLIP + len(change.separated)
    return change


def opening(books: Books, edge: int) -> Change:
    """What changes if a kept door is removed: rooms are joined."""
    new_room = itertools.count(books.next_room)
    room_of: dict[int, int] = {}
    joined: dict[int, int] = {}
    rooms: dict[int, Room] = {}
    entries = {}
    for nodes, entry in openings(books, [node for node in books.near.nodes_of[edge] if books.kept_doors[node] == 1]):
        # Of equally large rooms, the one with the lower number stays.
        largest = max(entry, key=lambda room: (books.rooms[room].nodes, -room), default=CLOSED)
        stays = next(new_room) if largest == CLOSED else largest
        room_of.update(dict.fromkeys(nodes, stays))
        rooms[stays] = books.of_nodes(nodes)
        for room in entry:
            rooms[stays] = rooms[stays].plus(books.rooms[room])
            if room != stays:
                joined[room], rooms[room] = stays, Room()
        entries.update(entry)
    doors = {edge}.union(*(books.doors_at[room] for room in joined))
    separated = {door: renamed(books.separated[door], joined) for door in doors}
    separated[edge] = ()
    return Change(edge, room_of, joined, entries, rooms, separated, changed_sums(books, edge, rooms, separated))


def closing(books: Books, edge: int) -> Change:
    """What changes if a removed door is kept: rooms are parted."""
    closed = [node for node in books.near.nodes_of[edge] if not books.kept_doors[node]]
    room_of = dict.fromkeys(closed, CLOSED)
    rooms: dict[int, Room] = {}
    new_room = itertools.count(books.next_room)
    doors = {edge}
    for room in {books.room_of[node]: None for node in closed}:
        inside = [node for node in closed if books.room_of[node] == room]
        rest = books.rooms[room].plus(books.of_nodes(inside), -1)
        for part in parts(books, room, inside):
            number = next(new_room)
            rooms[number] = books.of_nodes(part)
            rest = rest.plus(rooms[number], -1)
            room_of.update(dict.fromkeys(part, number))
            doors.update(door for node in part for door in books.near.edges_of[node] if not books.removed[door])
        rooms[room] = rest
    separated = {door: books.rooms_beside(door, room_of) for door in doors}
    return Change(edge, room_of, {}, {}, rooms, separated, changed_sums(books, edge, rooms, separated))


def openings(books: Books, nodes: list[int]) -> list[tuple[list[int], dict[int, int]]]:
    """The nodes in groups that will be one room with their neighbours, with a node of each room that they join."""
    found: list[tuple[list[int], dict[int, int]]] = []
    pending = set(nodes)
    for first in nodes:
        if first not in pending:
            continue
        pending.discard(first)
        group = [first]
        entry: dict[int, int] = {}
        for node in group:  # the list grows during the loop
            for near in books.near.neighbours[node]:
                if near in pending:
                    pending.discard(near)
                    group.append(near)
                elif books.room_of[near] != CLOSED:
                    entry.setdefault(books.room_of[near], near)
        for other in [other for other in found if not entry.keys().isdisjoint(other[1])]:
            found.remove(other)
            group, entry = other[0] + group, other[1] | entry
        found.append((group, entry))
    return found


def parts(books: Books, room: int, closed: Iterable[int]) -> list[list[int]]:
    """The parts (lists of nodes) that a room falls into without some nodes, but for one that is left over.

    They grow in turns until all but one are complete, which costs about what the smaller ones do.
    """
    shut = set(closed)
    inside = {near for node in closed for near in books.near.neighbours[node] if books.room_of[near] == room}
    starts = sorted(inside - shut)
    return Growth(books, room, shut, starts).complete() if len(starts) > 1 else []


class Growth:
    """Groups of nodes of a room that grow from their starts until they meet or are complete."""

    def __init__(self, books: Books, room: int, shut: set[int], starts: list[int]) -> None:
        self.books, self.room = books, room
        self.group_of = dict.fromkeys(shut, SHUT)
        self.group_of.update((start, group) for group, start in enumerate(starts))
        self.one_with = list(range(len(starts)))
        """A group that each group is one with: itself, or one that it met."""
        self.nodes = [[start] for start in starts]
        self.pending = [[start] for start in starts]
        self.growing = list(range(len(starts)))

    def complete(self) -> list[list[int]]:
        """The nodes of all complete groups when only one is left that grows."""
        found: list[list[int]] = []
        size = FIRST_STEP
        while len(self.growing) > 1:
            for group in list(self.growing):
                if self.one_with[group] != group:
                    continue
                self._grow(group, size)
                if not self.pending[group]:
                    found.append(self.nodes[group])
                    self.growing.remove(group)
                if len(self.growing) == 1:
                    break
            size *= 2
        self.books.work += len(self.group_of)
        return found

    def _grow(self, group: int, size: int) -> None:
        """Add neighbours until the group has that many nodes, or no more to be added."""
        room, room_of, neighbours, group_of = self.room, self.books.room_of, self.books.near.neighbours, self.group_of
        nodes, pending = self.nodes[group], self.pending[group]
        while pending and len(nodes) < size:
            for near in neighbours[pending.pop()]:
                other = group_of.get(near)
                if other is None:
                    if room_of[near] == room:
                        group_of[near] = group
                        nodes.append(near)
                        pending.append(near)
                elif other not in (group, SHUT):
                    self._meet(group, other)

    def _meet(self, group: int, other: int) -> None:
        """Add a group that is met, unless it was before."""
        while self.one_with[other] != other:
            other = self.one_with[other]
        if other != group:
            self.one_with[other] = group
            self.nodes[group] += self.nodes[other]
            self.pending[group] += self.pending[other]
            self.growing.remove(other)


def changed_sums(books: Books, edge: int, rooms: Mapping[int, Room], separated: Mapping[int, Rooms]) -> Sums:
    """The sums after a flip with these changes."""
    keeps = 1 if books.removed[edge] else -1
    sums, problem = books.sums, books.problem
    count = small = cells = squared = lacking = 0
    for room, changed in rooms.items():
        for one, sign in ((books.rooms.get(room, NONE), -1), (changed, 1)):
            if one.regions:
                count += sign
                small += sign * (one.cells < problem.small_cells)
                cells += sign * one.cells
                squared += sign * one.cells**2
                lacking += sign * max(problem.threshold_cells - one.cells, 0)
    separating, pairs, log_odds = changed_doors(books, separated)
    return Sums(
        sums.rooms + count,
        sums.small + small,
        sums.cells + cells,
        sums.squared_cells + squared,
        sums.lacking_cells + lacking,
        sums.doors + keeps,
        sums.tilt + keeps * books.tilt[edge],
        sums.conflicts + keeps * sum(not books.removed[other] for other in books.near.conflicts[edge]),
        sums.separating + separating,
        sums.pairs + pairs,
        sums.log_odds + log_odds,
    )


def changed_doors(books: Books, separated: Mapping[int, Rooms]) -> tuple[int, int, int]:
    """By how much the number of separating doors, that of pairs of rooms, and the sum of log-odds change."""
    separating = pairs = log_odds = 0
    of_pair: dict[Rooms, int] = {}
    for door, after in separated.items():
        before = books.separated[door]
        change = bool(after) - bool(before)
        separating += change
        log_odds += change * books.log_odds[door]
        for rooms, sign in ((before, -1), (after, 1)):
            if len(rooms) == PAIR:
                of_pair[rooms] = of_pair.get(rooms, 0) + sign
            elif rooms:
                pairs += sign
    for rooms, change in of_pair.items():
        count = books.pairs.get(rooms, 0)
        pairs += (count + change > 0) - (count > 0)
    return separating, pairs, log_odds


def renamed(rooms: Rooms, joined: Mapping[int, int]) -> Rooms:
    """The rooms after some were joined; none if they all were."""
    left = {joined.get(room, room) for room in rooms}
    return tuple(sorted(left)) if len(left) >= PAIR else ()


def make(books: Books, change: Change) -> None:
    """Flip the door."""
    keeps = books.removed[change.edge]
    books.idle_hopes += books.hope[change.edge] if keeps else -books.hope[change.edge]
    books.removed[change.edge] = not keeps
    for node in books.near.nodes_of[change.edge]:
        books.kept_doors[node] += 1 if keeps else -1
    for door in change.separated:
        books.strike(door)
    for room, stays in change.joined.items():
        for node in books.flooded(change.entry[room]):
            books.room_of[node] = stays
    for node, room in change.room_of.items():
        books.room_of[node] = room
    for room, sums in change.rooms.items():
        if sums.nodes:
            books.rooms[room] = sums
            books.doors_at.setdefault(room, set())
            books.next_room = max(books.next_room, room + 1)
        else:
            del books.rooms[room], books.doors_at[room]
    for door, rooms in change.separated.items():
        if rooms:
            books.enter(door, rooms)
    books.sums = change.sums
