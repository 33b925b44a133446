"""Section III: how much the search saves, and whether it finds the optimum that trying every choice proves."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import partial

import numpy as np

from vdoor.engines import Over
from vdoor.experiments.search_study import GROUPS, Graph, first_hit, hit_rates
from vdoor.method.initial_map import InitialMap
from vdoor.method.search.optimisers import ExhaustiveSearch
from vdoor.method.search.problem import MergeProblem
from vdoor.paper.door_counts import Share
from vdoor.paper.walkthrough import SAME_COST, MethodRun, Progress, first_at_best, no_progress, paper_pipeline

SEEDS = 200
"""Searches of the walk-through's map."""
SEARCHES = 50
"""Searches of each other map."""
POPULATION, GENERATIONS = 50, 50
"""As printed."""
PRINTED_LOG2_LOAD = -9
"""The paper says that the load falls to about 1/2^9."""
EXAMPLE, EXAMPLE_STRINGS, EXAMPLE_EDGES = "50 x 30", 50 * 30, 20
"""Strings evaluated in the paper's example, and its doors."""


@dataclass(frozen=True, kw_only=True)
class GenerationCosts:
    """Costs of the strings of one generation."""

    generation: int
    best: float
    mean: float
    worst: float


@dataclass(frozen=True, kw_only=True)
class SearchStudy:
    """The search of the walk-through, the same with other seeds, and searches of other maps."""

    edges: int
    courses: tuple[GenerationCosts, ...]
    """The walk-through's search, generation by generation."""
    optimum: float
    """Least cost of all choices, each of them tried."""
    optimal_choices: int
    """How many choices have it."""
    evaluations: int
    """Strings evaluated until the optimum was found, the first population included."""
    all_evaluations: int
    """In all generations."""
    reached: tuple[int | None, ...]
    """For each seed, 0 and up, the generation that reached the optimum."""
    graphs: tuple[Graph, ...]

    @property
    def search_space(self) -> int:
        """Number of choices."""
        return int(2**self.edges)

    @property
    def best_generation(self) -> int:
        """The first generation with the least cost of the whole search."""
        return self.courses[first_at_best([course.best for course in self.courses])].generation

    @property
    def proven(self) -> bool:
        """Whether no choice costs less than the one found."""
        return self.courses[-1].best <= self.optimum + SAME_COST

    @property
    def hits(self) -> Share:
        """Searches of the walk-through's map that reached the optimum."""
        return Share(part=len(self.reached_in), of=len(self.reached))

    @property
    def reached_in(self) -> list[int]:
        """The generations that reached it, sorted."""
        return sorted(generation for generation in self.reached if generation is not None)

    @property
    def groups(self) -> dict[tuple[int, int], tuple[int, Share]]:
        """By least and greatest number of virtual doors: number of maps, and searches that reached the optimum."""
        found = {}
        for low, high in GROUPS:
            group = [graph for graph in self.graphs if low <= graph.doors <= high]
            hits, searches = sum(graph.hits for graph in group), sum(graph.searches for graph in group)
            found[low, high] = (len(group), Share(part=hits, of=searches))
        return found


def study_search(
    run: MethodRun, *, graphs: int = 60, progress: Progress = no_progress, over: Over = map
) -> SearchStudy:
    """The search of a run held against the optimum, and searches of `graphs` maps with 1 to 20 virtual doors."""
    problem = MergeProblem(run.get(InitialMap), paper_pipeline().cost)
    optimum = list(ExhaustiveSearch()(problem, np.random.default_rng()))[-1].best_cost
    progress(f"searching the walk-through's map {SEEDS} times")
    reached = tuple(over(partial(first_hit, paper_pipeline(), problem, optimum), range(SEEDS)))
    progress(f"searching {graphs} maps {SEARCHES} times each")
    return SearchStudy(
        edges=problem.edges,
        courses=_courses(run),
        optimum=optimum,
        optimal_choices=_optimal_choices(problem, optimum),
        evaluations=run.counts.evaluations,
        all_evaluations=run.search[-1].evaluations,
        reached=reached,
        graphs=tuple(hit_rates(paper_pipeline(), graphs=graphs, seeds=SEARCHES, over=over)),
    )


def _courses(run: MethodRun) -> tuple[GenerationCosts, ...]:
    return tuple(
        GenerationCosts(
            generation=generation.number,
            best=generation.best_cost,
            mean=generation.mean_cost,
            worst=generation.worst_cost,
        )
        for generation in run.search
    )


def _optimal_choices(problem: MergeProblem, optimum: float) -> int:
    """How many of all choices cost as little as the optimum."""
    every = np.arange(2**problem.edges)[:, None] >> np.arange(problem.edges) & 1
    return int((problem.evaluate(every.astype(np.bool_)).cost <= optimum + SAME_COST).sum())


def log2_load(evaluations: int, edges: int) -> float:
    """Evaluations as a share of all choices, as a power of two."""
    return math.log2(evaluations) - edges
