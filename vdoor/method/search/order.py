"""The order in which rooms were last changed, if doors are removed one after the other; it numbers rooms."""

from __future__ import annotations

import itertools
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from vdoor.method.search.books import CLOSED, Books
from vdoor.method.search.flips import Change

MOST_WALKED = 1000
"""The most nodes that are looked at to find in which order the rooms beside a door are reached."""


class RoomOrder:
    """When each room was last changed: from all doors kept, the removed ones are opened in ascending order."""

    def __init__(self, books: Books, removed: NDArray[np.bool_]) -> None:
        self.books = books
        merged = Merged(books)
        for nodes in _opened_together(books, removed):
            merged.open(nodes)
        self.first = {room: merged.root(node) for node, room in enumerate(books.room_of) if room != CLOSED}
        """The node that each room was gathered from."""
        self.last = {room: merged.last[node] for room, node in self.first.items()}
        self.now = itertools.count(merged.now)

    def opened(self, change: Change) -> None:
        """Note that a door was opened: each group of rooms that it joined is one new room."""
        for stays, group in self._groups(change):
            self.first[stays] = self.first[group[0]] if group else min(change.room_of)
            self.last[stays] = next(self.now)

    def tried(self, change: Change) -> None:
        """Note that a door was opened and kept again: the rooms beside it are as before, but new."""
        for _, group in self._groups(change):
            for room in self._reached(group, change) if len(group) > 1 else group:
                self.last[room] = next(self.now)

    def _reached(self, group: list[int], change: Change) -> list[int]:
        """The rooms in the order in which they are reached from the oldest, through the nodes that the door opens."""
        room_of, neighbours = self.books.room_of, self.books.near.neighbours
        pending = [self.first[group[0]]]
        seen, reached = set(pending), group[:1]
        for node in pending:  # the list grows during the loop
            for near in neighbours[node]:
                room = room_of[near]
                if near not in seen and (room in group or near in change.room_of):
                    seen.add(near)
                    pending.append(near)
                    if room not in reached and room != CLOSED:
                        reached.append(room)
                        self.first[room] = near
            if len(reached) == len(group) or len(pending) > MOST_WALKED:
                break
        return reached + [room for room in group if room not in reached]

    def _groups(self, change: Change) -> list[tuple[int, list[int]]]:
        """The rooms that a removed door leaves, and the rooms that each is joined from; both the oldest first."""
        groups: dict[int, list[int]] = {room: [] for room, sums in change.rooms.items() if sums.nodes}
        for room in sorted(change.entry, key=self.last.__getitem__):
            groups[change.joined.get(room, room)].append(room)
        return sorted(groups.items(), key=lambda item: self.last[item[1][0]] if item[1] else np.inf)


def _opened_together(books: Books, removed: NDArray[np.bool_]) -> Iterator[list[int]]:
    """The nodes that each removed door opens, as the last one on them."""
    door, node = books.near.covers
    opening = np.full(len(books.cells), CLOSED)
    np.maximum.at(opening, node, door)
    opening[node[~removed[door]]] = CLOSED
    opened = np.flatnonzero(opening != CLOSED)
    opened = opened[np.argsort(opening[opened], kind="stable")]
    for _, together in itertools.groupby(opened.tolist(), opening.tolist().__getitem__):
        yield list(together)


class Merged:
    """Rooms that are merged as nodes open; at first each region is one."""

    def __init__(self, books: Books) -> None:
        nodes = range(len(books.cells))
        self.neighbours = books.near.neighbours
        self.is_open = [node < books.problem.regions for node in nodes]
        self.one_with, self.last = list(nodes), list(nodes)
        self.now = len(nodes)

    def root(self, node: int) -> int:
        """The node that the room of a node was gathered from."""
        one_with = self.one_with
        while one_with[node] != node:
            one_with[node] = node = one_with[one_with[node]]
        return node

    def open(self, nodes: list[int]) -> None:
        """Open nodes and merge what they join; each room that arises so is the newest."""
        for node in nodes:
            self.is_open[node], self.last[node] = True, self.now
            self.now += 1
        for node in nodes:
            for near in self.neighbours[node]:
                if self.is_open[near]:
                    self._merge(self.root(node), self.root(near))
        for root in sorted({self.root(node) for node in nodes}, key=self.last.__getitem__):
            self.last[root] = self.now
            self.now += 1

    def _merge(self, one: int, other: int) -> None:
        older, newer = (one, other) if self.last[one] <= self.last[other] else (other, one)
        self.one_with[newer] = older
