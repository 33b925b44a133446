"""Section III: optimisers that choose the virtual doors to remove, with one record per generation."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated

import numpy as np

from vdoor.config import Within
from vdoor.errors import SettingError
from vdoor.method.search.costs import Costs
from vdoor.method.search.generation import Generation, summary, with_best
from vdoor.method.search.incremental import FlipState
from vdoor.method.search.problem import Bits, MergeProblem


@dataclass(frozen=True, kw_only=True)
class GeneticSearch:
    """The genetic algorithm as printed: uniform crossover, asymmetric mutation, elitism."""

    population: Annotated[int, Within(2, 100_000)] = 50
    generations: Annotated[int, Within(0, 1_000_000)] = 50
    crossover: Annotated[float, Within(0, 1)] = 0.5
    """Probability that two parents exchange each bit."""
    mutate_to_removed: Annotated[float, Within(0, 1)] = 0.1
    """Probability that a 0 becomes 1."""
    mutate_to_kept: Annotated[float, Within(0, 1)] = 0.01
    """Probability that a 1 becomes 0."""
    start_removed: Annotated[float, Within(0, 1)] = 0.5
    """Probability of a 1 in the initial population (not printed)."""

    def __call__(self, problem: MergeProblem, rng: np.random.Generator) -> Iterator[Generation]:
        """The generations; 0 is the initial population. Survivors are the best of parents and offspring."""
        strings = rng.random((self.population, problem.edges)) < self.start_removed
        costs = problem.evaluate(strings)
        yield summary(0, self.population, strings, costs)
        for number in range(1, self.generations + 1):
            offspring = self.offspring(strings, rng)
            costs = Costs(*map(np.concatenate, zip(costs, problem.evaluate(offspring), strict=True)))
            strings = np.concatenate([strings, offspring])
            fittest = np.argsort(costs.cost, kind="stable")[: self.population]
            strings, costs = strings[fittest], Costs(*(term[fittest] for term in costs))
            yield summary(number, self.population * (number + 1), strings, costs)

    def offspring(self, parents: Bits, rng: np.random.Generator) -> Bits:
        """Children (p, r), as many as parents: random pairs exchange bits (Fig. 4a), then bits flip (Fig. 4b)."""
        mates = parents[rng.permutation(len(parents))]
        half = -(-len(parents) // 2)
        one, other = mates[:half], mates[-half:]
        exchanged = rng.random(one.shape) < self.crossover
        children = np.concatenate([np.where(exchanged, other, one), np.where(exchanged, one, other)])[: len(parents)]
        chance = np.where(children, self.mutate_to_kept, self.mutate_to_removed)
        return np.asarray(children ^ (rng.random(children.shape) < chance))


@dataclass(frozen=True, kw_only=True)
class ExhaustiveSearch:
    """Exhaustive search: evaluate all choices, which proves the optimum."""

    most_edges: Annotated[int, Within(0, 30)] = 20
    """Largest number of edges accepted; each further one doubles the time."""
    batch: Annotated[int, Within(1, 1_048_576)] = 4096
    """Number of choices evaluated at a time, with one record per batch."""

    def __call__(self, problem: MergeProblem, rng: np.random.Generator) -> Iterator[Generation]:
        """One generation per batch; of equally good choices the first in binary order wins. `rng` is not used."""
        del rng
        if problem.edges > self.most_edges:
            raise SettingError(
                f"search.method = exhaustive: wanted at most {self.most_edges} doors, "
                f"found {problem.edges}; use annealing or genetic"
            )
        best: Generation | None = None
        for number, begin in enumerate(range(0, 2**problem.edges, self.batch)):
            choice = np.arange(begin, min(begin + self.batch, 2**problem.edges))
            strings = (choice[:, None] >> np.arange(problem.edges) & 1).astype(np.bool_)
            batch = summary(number, begin + len(choice), strings, problem.evaluate(strings))
            if best is not None and best.best_cost <= batch.best_cost:
                batch = with_best(batch, best)
            best = batch
            yield batch


@dataclass(frozen=True, kw_only=True)
class AnnealingSearch:
    """Simulated annealing: flip one door at a time, and accept worse choices less and less often."""

    evaluations: Annotated[int, Within(1, 1_000_000_000)] = 25_000
    per_generation: Annotated[int, Within(1, 1_000_000_000)] = 500
    """Number of evaluations per record."""
    start_temperature: Annotated[float, Within(1e-09, 1_000_000_000.0)] = 1.0
    end_temperature: Annotated[float, Within(1e-09, 1_000_000_000.0)] = 0.001

    def __call__(self, problem: MergeProblem, rng: np.random.Generator) -> Iterator[Generation]:
        """The generations; the start is all doors kept, from which every flip is a local change."""
        state = FlipState(problem)
        if problem.edges == 0:
            yield state.generation(0, 1, [state.cost])
            return
        ratio = self.end_temperature / self.start_temperature
        for number, begin in enumerate(range(0, self.evaluations, self.per_generation)):
            count = min(self.per_generation, self.evaluations - begin)
            edges = rng.integers(problem.edges, size=count).tolist()
            thresholds = (-np.log(1.0 - rng.random(count))).tolist()
            seen = []
            for step, (edge, threshold) in enumerate(zip(edges, thresholds, strict=True)):
                temperature = self.start_temperature * ratio ** ((begin + step) / self.evaluations)
                state.try_flip(edge, threshold * temperature)
                seen.append(state.cost)
            yield state.generation(number, begin + count, seen)
