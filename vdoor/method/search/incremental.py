"""A choice of doors that is changed door by door, for simulated annealing and local search."""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from vdoor.method.search.costs import Totals
from vdoor.method.search.generation import Generation, summary
from vdoor.method.search.problem import LOG_ODDS_UNIT, TILT_UNIT_DEG2, MergeProblem


@dataclass(slots=True)
class RunningTotals:
    """The `Totals` of one choice in whole cells and units, updated with each flip."""

    rooms: int = 0
    small: int = 0
    cells: float = 0.0
    squared_cells: float = 0.0
    lacking_cells: float = 0.0
    doors: int = 0
    tilt: int = 0
    conflicts: int = 0
    separating: int = 0
    log_odds: int = 0


class FlipState:
    """A choice of doors with its rooms, and the best choice so far; initially all doors are kept except `removed`.

    A flip only changes the rooms around that door, so only these are found again. The sums are the same integers as in
    `MergeProblem.evaluate`, so the cost is the same to the last bit.
    """

    def __init__(self, problem: MergeProblem, removed: Iterable[int] = ()) -> None:
        self.problem = problem
        self.removed = [False] * problem.edges
        self.neighbours = _neighbours(problem)
        self.nodes_of_edge, self.kept_doors = _covers(problem)
        self.cells = problem.cells.tolist()
        self.tilt = problem.tilt.tolist()
        self.room_of = [-1] * len(self.cells)
        self.members: dict[int, list[int]] = {}
        self.log_odds = problem.log_odds.tolist()
        self.conflicts: list[list[int]] = [[] for _ in range(problem.edges)]
        for a, b in problem.conflicts.T.tolist():
            self.conflicts[a].append(b)
            self.conflicts[b].append(a)
        self.totals = RunningTotals(doors=problem.edges, tilt=sum(self.tilt), conflicts=problem.conflicts.shape[1])
        self.regions_of, self.edges_of = _borders(problem)
        self.separated: list[frozenset[int] | int | None] = [None] * problem.edges
        """The two rooms that each kept door separates, its number if there are more, None if none."""
        self.pairs: dict[frozenset[int] | int, int] = {}
        """The number of kept doors that separate each pair of rooms."""
        self._next_room = 0
        self._add_rooms([node for node in range(len(self.cells)) if not self.kept_doors[node]])
        for edge in range(problem.edges):
            self._update_separated(edge)
        for edge in removed:
            self._flip(edge)
        self.cost = self._cost()
        self.best_cost, self.best = self.cost, list(self.removed)

    def try_flip(self, edge: int, allowance: float) -> bool:
        """Flip a door unless that raises the cost by more than `allowance`; returns whether it was flipped."""
        return self.try_flips([edge], allowance)

    def try_flips(self, edges: list[int], allowance: float = 0.0) -> bool:
        """Flip doors together unless that raises the cost by more than `allowance`; returns whether it did so."""
        before = self.cost
        for edge in edges:
            self._flip(edge)
        self.cost = self._cost()
        if self.cost > before + allowance:
            for edge in edges:
                self._flip(edge)
            self.cost = before
            return False
        if self.cost < self.best_cost:
            self.best_cost, self.best = self.cost, list(self.removed)
        return True

    def open_idle(self) -> None:
        """Open the kept doors that separate nothing, the least likely first."""
        for edge in self.problem.worst_first.tolist():
            if not self.removed[edge]:
                self.open_if_idle(edge)

    def open_if_idle(self, edge: int) -> list[list[int]]:
        """The groups of rooms, each given by its lowest node, that opening a kept door would join; opens it if none.

        If the cost counts separating doors, these are the rooms that the door separates for the cost.
        """
        if self.separated[edge] is not None:
            beside = {self.room_of[region] for region in self.regions_of[edge]}
            return [sorted(min(self.members[room]) for room in beside)]
        nodes = [node for node in self.nodes_of_edge[edge] if self.kept_doors[node] == 1]
        around = {self.room_of[near] for node in nodes for near in self.neighbours[node]} - {-1}
        lowest = [min(self.members[room]) for room in sorted(around)]
        lowest = [node for node in lowest if node < self.problem.regions]  # an open atom without a region is no room
        self._flip(edge)
        groups: dict[int, list[int]] = {}
        for node in lowest:
            groups.setdefault(self.room_of[node], []).append(node)
        joined = [group for group in groups.values() if len(group) > 1]
        if joined:
            self._flip(edge)
        return joined

    def generation(self, number: int, evaluations: int, costs: list[float]) -> Generation:
        """The record of the best choice so far, with the mean and the worst of the costs since the last record."""
        best = np.array([self.best], np.bool_).reshape(1, -1)
        record = summary(number, evaluations, best, self.problem.evaluate(best))
        return dataclasses.replace(record, mean_cost=sum(costs) / len(costs), worst_cost=max(costs))

    def _flip(self, edge: int) -> None:
        keeps = self.removed[edge]
        self.removed[edge] = not keeps
        change = 1 if keeps else -1
        self.totals.doors += change
        self.totals.tilt += change * self.tilt[edge]
        self.totals.conflicts += change * sum(not self.removed[other] for other in self.conflicts[edge])
        switched = []
        for node in self.nodes_of_edge[edge]:
            self.kept_doors[node] += change
            if self.kept_doors[node] == (1 if keeps else 0):
                switched.append(node)
        if not switched:
            self._update_separated(edge)
            return
        touched = switched if keeps else [near for node in switched for near in self.neighbours[node]]
        nodes = self._take_rooms({self.room_of[node] for node in touched} - {-1})
        self._add_rooms([node for node in nodes if not self.kept_doors[node]] + ([] if keeps else switched))
        for near in {edge, *(one for node in nodes for one in self.edges_of[node])}:
            self._update_separated(near)

    def _update_separated(self, edge: int) -> None:
        """Update which rooms a door separates, and the sums over separating doors."""
        rooms = frozenset(self.room_of[region] for region in self.regions_of[edge])
        now = None if len(rooms) < 2 or self.removed[edge] else rooms if len(rooms) == 2 else edge  # noqa: PLR2004
        before = self.separated[edge]
        if now == before:
            return
        self.separated[edge] = now
        for pair, change in ((before, -1), (now, 1)):
            if pair is not None:
                self.totals.separating += change
                self.totals.log_odds += change * self.log_odds[edge]
                self.pairs[pair] = self.pairs.get(pair, 0) + change
                if not self.pairs[pair]:
                    del self.pairs[pair]

    def _take_rooms(self, rooms: Iterable[int]) -> list[int]:
        """Remove rooms, also from the sums; returns their nodes."""
        nodes: list[int] = []
        for room in sorted(rooms):
            members = self.members.pop(room)
            self._count(members, -1)
            nodes += members
            for node in members:
                self.room_of[node] = -1
        return nodes

    def _add_rooms(self, nodes: list[int]) -> None:
        """Group open nodes without a room into rooms, and add these to the sums."""
        pending = set(nodes)
        for seed in nodes:
            if seed not in pending:
                continue
            pending.discard(seed)
            members = [seed]
            for node in members:  # the list grows during the loop
                for near in self.neighbours[node]:
                    if near in pending:
                        pending.discard(near)
                        members.append(near)
            for node in members:
                self.room_of[node] = self._next_room
            self.members[self._next_room] = members
            self._next_room += 1
            self._count(members, 1)

    def _count(self, members: list[int], sign: int) -> None:
        if min(members) >= self.problem.regions:
            return  # an open atom without a region is no room
        cells = sum(self.cells[node] for node in members)
        self.totals.rooms += sign
        self.totals.small += sign * (cells < self.problem.small_cells)
        self.totals.cells += sign * cells
        self.totals.squared_cells += sign * cells**2
        self.totals.lacking_cells += sign * max(self.problem.threshold_cells - cells, 0)

    def _cost(self) -> float:
        cell_m2, running = self.problem.cell_m2, self.totals
        totals = Totals(
            rooms=running.rooms,
            small=running.small,
            area_m2=running.cells * cell_m2,
            area_squared_m4=running.squared_cells * cell_m2**2,
            doors=running.doors,
            tilt_squared_deg2=running.tilt * TILT_UNIT_DEG2,
            lacking_m2=running.lacking_cells * cell_m2,
            separating=running.separating,
            pairs=len(self.pairs),
            log_odds=running.log_odds * LOG_ODDS_UNIT,
            conflicts=running.conflicts,
        )
        return float(self.problem.cost(totals, sqrt=math.sqrt).cost)


def _neighbours(problem: MergeProblem) -> list[list[int]]:
    near: list[list[int]] = [[] for _ in problem.cells]
    for a, b in zip(*(ends.tolist() for ends in problem.links), strict=True):
        near[a].append(b)
        near[b].append(a)
    return near


def _borders(problem: MergeProblem) -> tuple[list[list[int]], list[list[int]]]:
    """The regions that each edge borders, and the edges that border each node; empty if the cost does not use them."""
    regions: list[list[int]] = [[] for _ in range(problem.edges)]
    edges: list[list[int]] = [[] for _ in problem.cells]
    if problem.cost.counts_separating:
        ends = [*problem.border_start.tolist(), len(problem.border_region)]
        for edge, (begin, end) in enumerate(itertools.pairwise(ends)):
            regions[edge] = problem.border_region[begin:end].tolist()
            for region in regions[edge]:
                edges[region].append(edge)
    return regions, edges


def _covers(problem: MergeProblem) -> tuple[list[list[int]], list[int]]:
    """The nodes that each edge covers, and the number of edges that cover each node."""
    ends = np.append(problem.cover_start, len(problem.cover_edge))
    nodes: list[list[int]] = [[] for _ in range(problem.edges)]
    for index, edge in enumerate(problem.cover_edge.tolist()):
        nodes[edge].append(problem.regions + int(np.searchsorted(ends, index, "right")) - 1)
    return nodes, [0] * problem.regions + np.diff(ends).tolist()
