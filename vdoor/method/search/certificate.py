"""How good the choice of doors can be at best: a bound on the energy, and how far the search is from it."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Annotated, ClassVar, cast

import numpy as np
from networkx import Graph, biconnected_components
from numpy.typing import NDArray
from scipy.optimize import Bounds, LinearConstraint, milp
from scipy.sparse import coo_array

from vdoor.config import Within
from vdoor.method.arrangement import components
from vdoor.method.search.generation import Generation
from vdoor.method.search.problem import MergeProblem
from vdoor.record import Record, Spec

Index = NDArray[np.intp]

EPSILON = 1e-6
MOST_NODES = 1_000_000
"""All choices of a block are tried up to so many nodes of the map in all of them."""


class Certificate(Record):
    """What can be proven about the best choice."""

    topic: ClassVar[str] = "certificate"

    cost: Annotated[float, Spec("number", tolerance=1e-6)]
    lower_bound: Annotated[float, Spec("number", tolerance=1e-6)]
    """No choice costs less."""
    gap: Annotated[float, Spec("number", tolerance=1e-6)]
    """Log-odds between the two, 0 where the choice is optimal; where many doors depend on each other, the bound counts
    those around which one can walk, and leaves out what their rooms lack."""
    optimal: Annotated[int, Spec("count")]
    """1 where that is proven."""


@dataclass(frozen=True, kw_only=True)
class NoProof:
    """Nothing is proven (paper)."""

    def __call__(self, problem: MergeProblem, best: Generation) -> None:
        """Nothing."""


@dataclass(frozen=True, kw_only=True)
class BoundEnergy:
    """Bound the energy from below, block by block of doors that depend on each other.

    Of a few doors all choices are tried. Of many, the best without conflicts is found as an integer programme (a
    maximum-weight independent set), as if each of them parted rooms, were a further one between them, and made none
    that lacks area. So where the choice found reaches the bound it is optimal.
    """

    most_nodes: Annotated[int, Within(0, 10_000_000)] = 1000
    """The solver visits at most so many nodes, whatever time that takes; if it does not finish, the bound of the linear
    relaxation is recorded."""

    def __call__(self, problem: MergeProblem, best: Generation) -> Certificate | None:
        """The certificate of the choice; none where it was not the energy that was searched."""
        if not problem.cost.counts_separating:
            return None
        nothing = float(problem.evaluate(np.ones((1, problem.edges), np.bool_)).cost[0])
        few: list[Index] = []
        many: list[Index] = [np.zeros(0, np.intp)]
        for block in blocks(problem):
            (few if 2 ** len(block) * len(problem.cells) <= MOST_NODES else many).append(block)
        bound = nothing - gain_of_few(problem, few) - gain_of_many(problem, np.concatenate(many), self.most_nodes)
        gap = max(best.best_cost - bound, 0.0)
        return Certificate(
            cost=best.best_cost, lower_bound=bound, gap=gap, optimal=int(abs(best.best_cost - bound) <= EPSILON)
        )


def gain_of_few(problem: MergeProblem, blocks: Iterable[Index]) -> float:
    """Greatest sum of what doors save, over all choices from each of these blocks.

    What their rooms lack counts: where other blocks' doors are kept as well the rooms are smaller, and lack more.
    """
    total = 0.0
    for block in blocks:
        removed = np.ones((2 ** len(block), problem.edges), np.bool_)
        removed[:, block] = np.arange(len(removed))[::-1, None] >> np.arange(len(block)) & 1
        cost = problem.evaluate(removed).cost
        total += float(cost[0] - cost.min())  # the first choice is of no door
    return total


def gain_of_many(problem: MergeProblem, doors: Index, most_nodes: int) -> float:
    """Greatest sum of what these doors gain over all sets without conflicts, or a bound above it.

    Where the solver does not finish, its bound depends on the order in which it branched, and so on last bits; the
    optimum of the relaxation, in which doors may be kept in part, does not.
    """
    gain = np.zeros(problem.edges)
    gain[doors] = problem.most_gain[doors]
    wanted = gain > 0
    pairs = problem.conflicts[:, wanted[problem.conflicts].all(axis=0)]
    # Only where a clash costs more than the lesser of both doors gains, no best choice keeps both.
    pairs = pairs[:, gain[pairs].min(axis=0) <= problem.cost.conflict_weight]
    if not pairs.shape[1]:
        return float(gain.sum())
    row = np.tile(np.arange(pairs.shape[1]), 2)
    matrix = coo_array((np.ones(len(row)), (row, pairs.ravel())), shape=(pairs.shape[1], problem.edges))
    for whole in (1, 0):
        solved = milp(
            -gain,
            constraints=LinearConstraint(matrix.tocsr(), ub=1.0),
            integrality=np.full(problem.edges, whole),
            bounds=Bounds(0.0, 1.0),
            options={"node_limit": most_nodes, "mip_rel_gap": 0.0},
        )
        if solved.success:
            return min(float(gain.sum()), -float(solved.mip_dual_bound if whole else solved.fun))
    return float(gain.sum())


def blocks(problem: MergeProblem) -> list[Index]:
    """The doors (edges,) in groups, such that what a door parts depends on the kept doors of its own group alone.

    One can walk around a door only through doors that lie on a closed way with it. In the graph of regions and doors
    these are in one biconnected component with it; doors that touch each other are one vertex of that graph.
    """
    touching = _touching(problem)
    group = components(np.concatenate([touching, problem.conflicts], axis=1), problem.edges)
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
