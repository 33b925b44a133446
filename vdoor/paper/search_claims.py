"""Section III: how much the search saves and whether it finds the optimum, against trying every choice."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from vdoor.experiments.search_study import GROUPS, Graph, first_hit, hit_rates
from vdoor.method.initial_map import InitialMap
from vdoor.method.search.generation import Generation
from vdoor.method.search.optimisers import ExhaustiveSearch
from vdoor.method.search.problem import MergeProblem
from vdoor.paper.door_counts import Share
from vdoor.paper.walkthrough import MethodRun, Progress, no_progress, paper_pipeline

SAME_COST = 1e-9
SEEDS = 200
"""Searches of the walk-through's map."""
SEARCHES = 50
"""Searches of each other map."""
PRINTED_EDGES, PRINTED_GENERATION, POPULATION, GENERATIONS = 16, 9, 50, 50
PRINTED_LOG2_LOAD = -9
"""The paper says that the load falls to about 1/2^9."""
EXAMPLE, EXAMPLE_STRINGS, EXAMPLE_EDGES = "50 x 30", 50 * 30, 20
"""Strings evaluated in the paper's example, and its doors."""


@dataclass(frozen=True, kw_only=True)
class Course:
    """Costs of one generation."""

    generation: int
    best: float
    mean: float
    worst: float


@dataclass(frozen=True, kw_only=True)
class SearchClaims:
    """The search of the walk-through, the same with other seeds, and searches of other maps."""

    edges: int
    courses: tuple[Course, ...]
    optimum: float
    """Least cost of all choices, each of them tried."""
    optimal_choices: int
    """How many have it."""
    evaluations: int
    """Strings evaluated until the optimum was there, those of the first population with them."""
    all_evaluations: int
    """In all generations."""
    reached: tuple[int | None, ...]
    """For each seed, 0 and up, the generation in which the optimum was there."""
    graphs: tuple[Graph, ...]

    @property
    def search_space(self) -> int:
        """Choices there are."""
        return int(2**self.edges)

    @property
    def best_generation(self) -> int:
        """The first that had the best choice of the whole search."""
        least = self.courses[-1].best + SAME_COST
        return next(course.generation for course in self.courses if course.best <= least)

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
        """Generations of those, sorted."""
        return sorted(generation for generation in self.reached if generation is not None)

    @property
    def groups(self) -> dict[tuple[int, int], tuple[int, Share]]:
        """By number of virtual doors from and to: how many maps, and the searches that reached their optimum."""
        found = {}
        for low, high in GROUPS:
            group = [graph for graph in self.graphs if low <= graph.doors <= high]
            hits, searches = sum(graph.hits for graph in group), sum(graph.searches for graph in group)
            found[low, high] = (len(group), Share(part=hits, of=searches))
        return found


def log2_load(evaluations: int, edges: int) -> float:
    """Evaluations as a share of all choices, as a power of two."""
    return math.log2(evaluations) - edges


def search_claims(walk: MethodRun, *, graphs: int = 60, progress: Progress = no_progress) -> SearchClaims:
    """What section III claims, on the run walked through and on `graphs` maps with 1 to 20 virtual doors."""
    problem = MergeProblem(walk.get(InitialMap), paper_pipeline().cost)
    tried = list(ExhaustiveSearch()(problem, np.random.default_rng()))
    progress(f"searching the walk-through's map {SEEDS} times")
    reached = tuple(first_hit(paper_pipeline(), problem, tried[-1].best_cost, seed) for seed in range(SEEDS))
    progress(f"searching {graphs} maps {SEARCHES} times each")
    return SearchClaims(
        edges=problem.edges,
        courses=tuple(map(_course, walk.generations)),
        optimum=tried[-1].best_cost,
        optimal_choices=_optimal_choices(problem, tried[-1].best_cost),
        evaluations=walk.counts.evaluations,
        all_evaluations=walk.generations[-1].evaluations,
        reached=reached,
        graphs=tuple(hit_rates(paper_pipeline(), graphs=graphs, seeds=SEARCHES)),
    )


def _course(generation: Generation) -> Course:
    return Course(
        generation=generation.number,
        best=generation.best_cost,
        mean=generation.mean_cost,
        worst=generation.worst_cost,
    )


def _optimal_choices(problem: MergeProblem, optimum: float) -> int:
    """How many of all choices cost as little."""
    every = np.arange(2**problem.edges)[:, None] >> np.arange(problem.edges) & 1
    return int((problem.evaluate(every.astype(np.bool_)).cost <= optimum + SAME_COST).sum())
