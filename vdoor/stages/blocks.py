"""Which doors have to be decided together: those on a common way around, and rivals."""

from __future__ import annotations

from collections.abc import Iterator
from typing import cast

import numpy as np
from networkx import Graph, biconnected_components
from numpy.typing import NDArray
from scipy.sparse import coo_array

from vdoor.stages.cost import MergeProblem
from vdoor.stages.pieces import components

Index = NDArray[np.intp]


def blocks(problem: MergeProblem) -> list[Index]:
    """The doors (edges,) in groups, such that what a door parts depends on the kept doors of its own group alone.

    One can walk around a door only through doors that lie on a closed way with it. In the graph of regions and doors
    these are in one biconnected component with it; doors that touch each other are one vertex of that graph.
    """
    touching = _touching(problem)
    group = components(np.concatenate([touching, problem.rivals], axis=1), problem.edges)
    # Regions count from 0 on, groups from -1 downwards.
    graph: Graph[int] = Graph()
    graph.add_edges_from(zip(problem.border_region.tolist(), (-1 - group[problem.border_edge]).tolist(), strict=True))
    together = []
    # Vertices, whatever the stubs of networkx say.
    for component in cast("Iterator[set[int]]", biconnected_components(graph)):
        groups = sorted(-1 - vertex for vertex in component if vertex < 0)
        together += [(groups[0], other) for other in groups[1:]]
    first = np.zeros(group.max(initial=-1) + 1, np.intp)
    first[group[::-1]] = np.arange(problem.edges)[::-1]
    links = first[np.array(together, np.intp).reshape(-1, 2).T]
    own = np.stack([np.arange(problem.edges), first[group]])
    block = components(np.concatenate([links, own], axis=1), problem.edges)
    return [np.flatnonzero(block == number) for number in range(block.max(initial=-1) + 1)]


def _touching(problem: MergeProblem) -> Index:
    """Pairs (2, k) of doors that cover a common node, or neighbouring ones."""
    count = np.diff(np.append(problem.cover_start, len(problem.cover_edge)))
    node = problem.regions + np.repeat(np.arange(len(count)), count)
    size = problem.edges, len(problem.cells)
    covers = coo_array((np.ones(len(node)), (problem.cover_edge, node)), shape=size).tocsr()
    links = coo_array((np.ones(len(problem.links[0])), problem.links), shape=(size[1], size[1])).tocsr()
    beside = covers @ (links + links.T)
    return np.stack((covers @ covers.T + beside @ covers.T).nonzero())
