"""The order in which rooms were last changed, if doors are removed one after the other; it numbers rooms."""

from __future__ import annotations

import itertools

import numpy as np
from numpy.typing import NDArray

from vdoor.method.search.books import CLOSED, Books
from vdoor.method.search.flips import Change


class RoomOrder:
    """When each room was last changed: from all doors kept, the removed ones are opened in ascending order."""

    def __init__(self, books: Books, removed: NDArray[np.bool_]) -> None:
        last = _last_changes(books, removed)
        self.last = {room: last[node] for node, room in enumerate(books.room_of) if room != CLOSED}
        self.now = itertools.count(max(last, default=0) + 1)

    def opened(self, change: Change) -> None:
        """Note that a door was opened: each group of rooms that it joined is one new room."""
        for stays, _ in self._groups(change):
            self.last[stays] = next(self.now)

    def tried(self, change: Change) -> None:
        """Note that a door was opened and kept again: the rooms beside it are as before, but new."""
        for _, group in self._groups(change):
            for room in group:
                self.last[room] = next(self.now)

    def _groups(self, change: Change) -> list[tuple[int, list[int]]]:
        """The rooms that a removed door leaves, and the rooms that each is joined from; both the oldest first."""
        groups: dict[int, list[int]] = {room: [] for room, sums in change.rooms.items() if sums.nodes}
        for room in sorted(change.entry, key=self.last.__getitem__):
            groups[change.joined.get(room, room)].append(room)
        return sorted(groups.items(), key=lambda item: self.last[item[1][0]] if item[1] else np.inf)


def _last_changes(books: Books, removed: NDArray[np.bool_]) -> list[int]:
    """For each node (n,) the flip that its room was last changed by, in an order of all flips and their rooms."""
    cover, node = books.near.covers
    nodes = len(books.cells)
    opening = np.full(nodes, CLOSED)
    np.maximum.at(opening, node, cover)
    opening[node[~removed[cover]]] = CLOSED  # covered by a kept door
    opened = np.flatnonzero(opening != CLOSED)
    opened = opened[np.argsort(opening[opened], kind="stable")]
    one_with, last, is_open = (
        list(range(nodes)),
        list(range(nodes)),
        [one < books.problem.regions for one in range(nodes)],
    )

    def found(one: int) -> int:
        while one_with[one] != one:
            one_with[one] = one = one_with[one_with[one]]
        return one

    now = nodes
    for _, together in itertools.groupby(opened.tolist(), opening.tolist().__getitem__):
        group = list(together)
        for one in group:
            is_open[one], last[one] = True, now
            now += 1
        for one, near in ((one, near) for one in group for near in books.near.neighbours[one] if is_open[near]):
            a, b = found(one), found(near)
            last[a] = min(last[a], last[b])
            one_with[b] = a
        for root in sorted({found(one) for one in group}, key=last.__getitem__):
            last[root] = now
            now += 1
    return [last[found(one)] for one in range(nodes)]
