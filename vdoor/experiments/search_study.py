"""How often the search finds the proven optimum (the claim of section III), on synthetic apartments."""

from __future__ import annotations

import dataclasses
import json
from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from itertools import islice

import numpy as np

from vdoor.engines import Over
from vdoor.method.initial_map import InitialMap
from vdoor.method.search.generation import Generation
from vdoor.method.search.optimisers import ExhaustiveSearch
from vdoor.method.search.problem import MergeProblem
from vdoor.pipeline import Pipeline
from vdoor.synth import PRESETS, Apartment, synthesize

GROUPS = ((1, 8), (9, 12), (13, 16), (17, 20))
SAME = 1e-9


@dataclass(frozen=True)
class Graph:
    """One initial map and the results of the searches on it."""

    apartment_seed: int
    furniture: bool
    doors: int
    optimum: float
    hits: int
    searches: int
    generation: float
    """Mean generation in which the optimum was first reached, over the searches that reached it; nan if none did."""


def hit_rates(pipeline: Pipeline, *, graphs: int, seeds: int, over: Over = map) -> list[Graph]:
    """Results of searching the first `graphs` initial maps with 1 to 20 virtual doors, with seeds 0 to `seeds` - 1."""
    return list(over(partial(_searched, pipeline=pipeline, seeds=seeds), islice(problems(pipeline), graphs)))


def _searched(drawn: tuple[int, bool, MergeProblem], *, pipeline: Pipeline, seeds: int) -> Graph:
    """One initial map, searched with each seed."""
    seed, furniture, problem = drawn
    optimum = last(ExhaustiveSearch()(problem, np.random.default_rng())).best_cost
    reached = [first_hit(pipeline, problem, optimum, number) for number in range(seeds)]
    hits = [generation for generation in reached if generation is not None]
    mean = float(np.mean(hits)) if hits else float("nan")
    return Graph(seed, furniture, problem.edges, optimum, len(hits), seeds, mean)


def problems(pipeline: Pipeline) -> Iterator[tuple[int, bool, MergeProblem]]:
    """Initial maps with 1 to 20 virtual doors, of apartments with seeds 0, 1, ..., every other one furnished.

    The apartments have 3 to 6 rooms. Yields the seed, whether there is furniture, and the search problem.
    """
    most = ExhaustiveSearch().most_edges
    seed = 0
    while True:
        furniture = bool(seed % 2)
        initial = initial_map(
            pipeline,
            dataclasses.replace(PRESETS["paper"], rooms=3 + seed // 2 % 4, rooms_spread=0, furniture=furniture),
            seed,
        )
        if 1 <= len(initial.door) <= most:
            yield seed, furniture, MergeProblem(initial, pipeline.cost)
        seed += 1


def initial_map(pipeline: Pipeline, apartment: Apartment, seed: int) -> InitialMap:
    """The initial topological map of a synthetic apartment."""
    grid = synthesize(apartment, np.random.default_rng(seed)).grid
    without_islands = dataclasses.replace(pipeline.simplify, max_island_m=1.0)
    return pipeline.divide(*dataclasses.replace(pipeline, simplify=without_islands).propose(grid))


def first_hit(pipeline: Pipeline, problem: MergeProblem, optimum: float, seed: int) -> int | None:
    """Number of the first generation whose best cost is the optimum; None if there is none."""
    for generation in pipeline.search(problem, np.random.default_rng(seed)):
        if generation.best_cost <= optimum + SAME:
            return generation.number
    return None


def last(generations: Iterator[Generation]) -> Generation:
    """The last generation."""
    return deque(generations, maxlen=1).pop()


def to_text(graphs: list[Graph]) -> str:
    """One line per graph, then the hit rate by number of doors."""
    lines = ["  seed furniture doors   optimum   hits  mean generation"]
    lines += [
        f"{graph.apartment_seed:6d} {'yes' if graph.furniture else 'no':>9s} {graph.doors:5d} "
        f"{graph.optimum:9.4f} {graph.hits:3d}/{graph.searches:<3d} {graph.generation:9.1f}"
        for graph in graphs
    ]
    for low, high in GROUPS:
        group = [graph for graph in graphs if low <= graph.doors <= high]
        hits, searches = sum(graph.hits for graph in group), sum(graph.searches for graph in group)
        if searches:
            lines.append(
                f"r = {low:2d} to {high:2d}: {len(group):3d} graphs, {hits}/{searches} = "
                f"{hits / searches:.4f} of searches reach the optimum"
            )
    return "\n".join(lines)


def to_json(graphs: list[Graph]) -> str:
    """The graphs as a JSON list."""
    return json.dumps([dataclasses.asdict(graph) for graph in graphs]).replace("NaN", "null")
