"""A choice of doors that is changed door by door, for simulated annealing and local search."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable

import numpy as np

from vdoor.method.search.books import Books, Sums
from vdoor.method.search.flips import Change, judged, make
from vdoor.method.search.generation import Generation, summary
from vdoor.method.search.order import RoomOrder
from vdoor.method.search.problem import MergeProblem


class FlipState:
    """A choice of doors with its rooms, and the best choice so far; initially all doors are kept except `removed`.

    A flip is judged before it is made, from the rooms beside its door. The sums are the same integers as in
    `MergeProblem.evaluate`, so the cost is the same to the last bit.
    """

    def __init__(self, problem: MergeProblem, removed: Iterable[int] = ()) -> None:
        self.problem = problem
        choice = np.zeros(problem.edges, np.bool_)
        choice[list(removed)] = True
        self.books = Books(problem, choice)
        self.order: RoomOrder | None = None
        """When rooms last changed, if someone wants to know."""
        self.conflicts = self.books.near.conflicts
        self.cost = self.cost_of(self.books.sums)
        self.best_cost, self.best = self.cost, list(self.removed)

    @property
    def removed(self) -> list[bool]:
        """Which doors are removed."""
        return self.books.removed

    @property
    def room_of(self) -> list[int]:
        """The room of each node, -1 where it is closed."""
        return self.books.room_of

    def try_flip(self, edge: int, allowance: float) -> bool:
        """Flip a door unless that raises the cost by more than `allowance`; returns whether it was flipped."""
        change = judged(self.books, edge)
        cost = self.cost_of(change.sums)
        if cost > self.cost + allowance:
            return False
        self._make(change)
        self._note(cost)
        return True

    def try_flips(self, edges: list[int], allowance: float = 0.0) -> bool:
        """Flip doors together unless that raises the cost by more than `allowance`; returns whether it did so."""
        for edge in edges:
            self._make(judged(self.books, edge))
        cost = self.cost_of(self.books.sums)
        if cost > self.cost + allowance:
            for edge in reversed(edges):
                self._make(judged(self.books, edge))
            return False
        self._note(cost)
        return True

    def is_vain(self, edge: int) -> bool:
        """Whether keeping a removed door cannot lower the cost, whatever it separates.

        It gains nothing itself, nor does any kept door that separates nothing yet and might with it. All else that
        keeping a door changes costs: conflicts, the area that smaller rooms lack, and pairs of rooms that become two.
        """
        books = self.books
        return (
            self.problem.cost.counts_separating and books.removed[edge] and not (books.hope[edge] or books.idle_hopes)
        )

    def open_idle(self) -> None:
        """Open the kept doors that separate nothing, the least likely first."""
        for edge in self.problem.worst_first.tolist():
            if not self.removed[edge]:
                self.open_if_idle(edge)

    def open_if_idle(self, edge: int) -> list[list[int]]:
        """The groups of rooms, each given by a node, that opening a kept door would join; opens it if there are none.

        If the cost counts separating doors, these are the rooms that the door separates for the cost.
        """
        if self.books.separated[edge]:
            beside = {self.room_of[region]: region for region in self.books.near.regions_of[edge]}
            return [sorted(beside.values())]
        change = judged(self.books, edge)
        groups: dict[int, list[int]] = {}
        for room, node in change.entry.items():
            if self.books.rooms[room].regions:  # an open atom without a region is no room
                groups.setdefault(change.joined.get(room, room), []).append(node)
        joined = [sorted(group) for group in groups.values() if len(group) > 1]
        if self.order:
            (self.order.tried if joined else self.order.opened)(change)
        if not joined:
            self._make(change)
            self._note(self.cost_of(self.books.sums))
        return joined

    def generation(self, number: int, evaluations: int, costs: list[float]) -> Generation:
        """The record of the best choice so far, with the mean and the worst of the costs since the last record."""
        best = np.array([self.best], np.bool_).reshape(1, -1)
        record = summary(number, evaluations, best, self.problem.evaluate(best))
        return dataclasses.replace(record, mean_cost=sum(costs) / len(costs), worst_cost=max(costs))

    def _make(self, change: Change) -> None:
        make(self.books, change)

    def _note(self, cost: float) -> None:
        self.cost = cost
        if cost < self.best_cost:
            self.best_cost, self.best = cost, list(self.removed)

    def cost_of(self, sums: Sums) -> float:
        """The cost of a choice with these sums."""
        return self.problem.cost.value(sums.totals(self.problem.cell_m2))
