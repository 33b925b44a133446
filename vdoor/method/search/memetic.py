"""A memetic search: genetic as in section III, but with a greedy start and local search on the best child."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Annotated

import numpy as np
from numpy.typing import NDArray

from vdoor.config import Within
from vdoor.method.search.costs import Costs
from vdoor.method.search.generation import Generation, summary
from vdoor.method.search.incremental import FlipState
from vdoor.method.search.problem import Bits, MergeProblem

SURELY = 1e-9
"""Smallest decrease of the cost that counts as an improvement, and not as rounding."""
MOST_WORK = 2_000_000
"""Limit for the nodes and doors that local search looks at, in all generations together."""


@dataclass(frozen=True, kw_only=True)
class MemeticSearch:
    """Genetic search: uniform crossover, one mutation per string, and local search on the best child."""

    population: Annotated[int, Within(2, 100_000)] = 16
    """Number of strings that survive a generation."""
    generations: Annotated[int, Within(0, 1_000_000)] = 50
    """Maximum number of generations."""
    patience: Annotated[int, Within(1, 1_000_000)] = 5
    """Number of generations without improvement after which the search ends."""

    def __call__(self, problem: MergeProblem, rng: np.random.Generator) -> Iterator[Generation]:
        """The generations; 0 is the greedy choice and strings near it. Survivors are the best distinct strings."""
        first = greedy(problem)
        near = rng.random((self.population - 1, problem.edges)) < 2 / max(problem.edges, 2)
        strings = np.concatenate([first[None], first ^ near])
        strings, costs = ordered(problem, strings, problem.evaluate(strings))
        evaluations = len(strings) + 1
        yield summary(0, evaluations, strings, costs)
        best, since, work_left = float(costs.cost.min()), 0, MOST_WORK
        for number in range(1, self.generations + 1):
            children = self._children(strings, rng)
            of_children = problem.evaluate(children)
            improved, work = climbed(problem, children[np.argmin(of_children.cost)], work_left)
            strings = np.concatenate([strings, children, improved[None]])
            costs = joined(costs, of_children, problem.evaluate(improved[None]))
            strings, first_of = np.unique(strings, axis=0, return_index=True)
            evaluations += len(children) + len(strings) + 1  # as if all were evaluated, which some were before
            strings, costs = ordered(problem, strings, rows(costs, first_of))
            strings, costs = strings[: self.population], rows(costs, slice(self.population))
            yield summary(number, evaluations, strings, costs)
            since = 0 if costs.cost[0] < best else since + 1
            best, work_left = float(costs.cost[0]), work_left - work
            if since == self.patience or problem.edges == 0 or work_left <= 0:
                return

    def cut_short(self, best_costs: Sequence[float]) -> bool:
        """Whether a search with these best costs, one per generation, ended because its work was limited."""
        lately = best_costs[-self.patience - 1 :]
        patient = len(lately) > self.patience and lately[0] == lately[-1]
        return not patient and len(best_costs) <= self.generations

    def _children(self, parents: Bits, rng: np.random.Generator) -> Bits:
        """Children (p, r), as many as the population: bits of two random parents, one flipped on average."""
        one, other = parents[rng.integers(len(parents), size=(2, self.population))]
        child = np.where(rng.random(one.shape) < 0.5, one, other)  # noqa: PLR2004  # uniform crossover
        return np.asarray(child ^ (rng.random(child.shape) < 1 / max(child.shape[1], 1)))


def ordered(problem: MergeProblem, strings: Bits, costs: Costs) -> tuple[Bits, Costs]:
    """The strings (p, r) with their costs, the best first; in the best one, doors that separate nothing are removed.

    This is done if the cost counts separating doors only: such doors gain nothing, and the final map would drop them.
    So the final map has exactly the doors that the best string keeps.
    """
    fittest = np.argsort(costs.cost, kind="stable")
    strings, costs = strings[fittest], rows(costs, fittest)
    best = strings[:1]
    separating, _ = problem.separating(best, problem.rooms(best)[0])
    if not problem.cost.counts_separating or (best ^ separating).all():
        return strings, costs
    state = FlipState(problem, np.flatnonzero(strings[0]).tolist())
    state.open_idle()
    strings[0] = state.removed
    return strings, joined(problem.evaluate(strings[:1]), rows(costs, slice(1, None)))


def rows(costs: Costs, chosen: NDArray[np.intp] | slice) -> Costs:
    """The costs of some of the strings."""
    return Costs(*(term[chosen] for term in costs))


def joined(*parts: Costs) -> Costs:
    """The costs of several groups of strings in one."""
    return Costs(*map(np.concatenate, zip(*parts, strict=True)))


def greedy(problem: MergeProblem) -> Bits:
    """The greedy choice (r,): keeps doors that gain, the likeliest first, without conflicts; bit 1 = removed."""
    removed = [True] * problem.edges
    conflicts = problem.adjacency.conflicts
    order = np.argsort(-problem.log_odds, kind="stable")
    for edge in order[problem.gain[order] > 0].tolist():
        removed[edge] = not all(removed[other] for other in conflicts[edge])
    return np.array(removed, np.bool_)


def climbed(problem: MergeProblem, removed: Bits, most_work: int) -> tuple[Bits, int]:
    """The string (r,) after local search, and the work it took.

    Doors are flipped, or swapped with those in conflict, until none helps or the work is more than `most_work`.
    """
    state = FlipState(problem, np.flatnonzero(removed).tolist())
    in_vain = 0
    for edge in itertools.cycle(range(problem.edges)):
        in_vain = 0 if _improved(state, edge) else in_vain + 1
        if in_vain == problem.edges or state.books.work > most_work:
            break
    return np.array(state.removed, np.bool_), state.books.work


def _improved(state: FlipState, edge: int) -> bool:
    """Whether the cost fell by flipping a door, or by keeping it instead of those in conflict with it."""
    kept = [other for other in state.conflicts[edge] if not state.removed[other]] if state.removed[edge] else []
    if kept:
        return state.try_flips([*kept, edge], -SURELY)
    return not state.is_vain(edge) and state.try_flip(edge, -SURELY)
