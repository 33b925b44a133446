"""A lower bound on the energy of any choice of doors, and the search result's gap to it."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Annotated, ClassVar, cast

import numpy as np
import scipy
from numpy.typing import NDArray

from vdoor.config import Within
from vdoor.method.search.generation import Generation
from vdoor.method.search.incremental import FlipState
from vdoor.method.search.problem import MergeProblem
from vdoor.raster.components import components
from vdoor.record import Record, Spec

Index = NDArray[np.intp]

EPSILON = 1e-6
MOST_NODES = 1_000_000
"""Limit for enumerating all choices of a block: the number of choices times the number of nodes."""

FEW_NODES = 256
"""In problems of so many nodes, evaluating choices as arrays is faster than going from one to the next."""


class Certificate(Record):
    """What is proven about the best choice."""

    topic: ClassVar[str] = "certificate"

    cost: Annotated[float, Spec("number", tolerance=1e-6)]
    lower_bound: Annotated[float, Spec("number", tolerance=1e-6)]
    """No choice costs less than this."""
    gap: Annotated[float, Spec("number", tolerance=1e-6)]
    """Cost minus bound, in log-odds; 0 if the choice is optimal. For large blocks of interdependent doors the bound
    also counts doors that separate nothing, and ignores the area that rooms lack."""
    optimal: Annotated[int, Spec("count")]
    """1 if the choice is proven optimal, else 0."""


@dataclass(frozen=True, kw_only=True)
class NoProof:
    """Prove nothing (paper)."""

    def __call__(self, problem: MergeProblem, best: Generation) -> None:
        """No certificate."""


@dataclass(frozen=True, kw_only=True)
class BoundEnergy:
    """Bound the energy from below, for each block of interdependent doors.

    For a small block, all choices are evaluated. For a large one, an integer programme finds the best choice without
    conflicts (a maximum-weight independent set), assuming that every door separates rooms, gets the bias of a further
    door, and creates no room that lacks area. A choice that reaches the bound is therefore optimal.
    """

    most_nodes: Annotated[int, Within(0, 10_000_000)] = 1000
    """Limit of branch-and-bound nodes for the integer programme, instead of a time limit, so that runs are
    reproducible; if it is reached, the bound of the linear relaxation is recorded."""

    def __call__(self, problem: MergeProblem, best: Generation) -> Certificate | None:
        """The certificate of the choice; None if the search did not minimise the energy."""
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
    """The largest total saving, over all choices of doors in each of these blocks.

    The area that rooms lack counts: with doors of other blocks kept as well, rooms are only smaller and lack more.
    """
    total, state = 0.0, None
    for block in blocks:
        if not (problem.most_gain[block] > 0).any():
            continue
        if len(problem.cells) <= FEW_NODES:
            removed = np.ones((2 ** len(block), problem.edges), np.bool_)
            removed[:, block] = np.arange(len(removed))[::-1, None] >> np.arange(len(block)) & 1
            cost = problem.evaluate(removed).cost
            total += float(cost[0] - cost.min())  # the first choice keeps no door
        else:
            state = state or FlipState(problem, range(problem.edges))
            total += gain_by_flips(state, block.tolist())
    return total


def gain_by_flips(state: FlipState, block: list[int]) -> float:
    """The largest saving over all choices of a block's doors, with all doors removed before and after.

    Choices follow each other in the order of a Gray code, one flip from the last, which looks at the rooms around.
    """
    if len(block) == 1:
        return gain_of_bridge(state, block[0])
    nothing = lowest = state.cost
    for number in range(1, 2 ** len(block)):
        state.try_flip(block[(number & -number).bit_length() - 1], np.inf)
        lowest = min(lowest, state.cost)
    state.try_flip(block[-1], np.inf)  # the only one that is kept at the end
    return nothing - lowest


def gain_of_bridge(state: FlipState, edge: int) -> float:
    """The saving from keeping the only door of a block, if all doors are removed.

    No way leads around it, so that each region beside it is in a part of its own. How large these parts are only
    matters below the room threshold.
    """
    books, threshold = state.books, state.problem.threshold_cells
    parts = [books.cells_behind(edge, region, threshold) for region in books.near.regions_of[edge]]
    whole = books.rooms[books.room_of[books.near.regions_of[edge][0]]].cells
    sums = books.sums
    kept = sums._replace(
        lacking_cells=sums.lacking_cells
        + sum(max(threshold - cells, 0) for cells in parts)
        - max(threshold - whole, 0),
        separating=sums.separating + 1,
        pairs=sums.pairs + 1,
        log_odds=sums.log_odds + books.log_odds[edge],
    )
    return state.cost - min(state.cost, state.cost_of(kept))


def gain_of_many(problem: MergeProblem, doors: Index, most_nodes: int) -> float:
    """The largest total gain over all sets of these doors without conflicts, or an upper bound of it.

    If the solver does not finish, its bound would depend on the order of branching, and so on the last bits of the
    input. The optimum of the linear relaxation, in which doors may be kept fractionally, does not.
    """
    gain = np.zeros(problem.edges)
    gain[doors] = problem.most_gain[doors]
    wanted = gain > 0
    pairs = problem.conflicts[:, wanted[problem.conflicts].all(axis=0)]
    # A best choice keeps at most one of two doors only if their conflict costs more than the lesser of them gains.
    pairs = pairs[:, gain[pairs].min(axis=0) <= problem.cost.conflict_weight]
    if not pairs.shape[1]:
        return float(gain.sum())
    from scipy.optimize import Bounds, LinearConstraint, milp  # noqa: PLC0415  # slow to load, and often not needed

    row = np.tile(np.arange(pairs.shape[1]), 2)
    matrix = scipy.sparse.coo_array((np.ones(len(row)), (row, pairs.ravel())), shape=(pairs.shape[1], problem.edges))
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
    """The doors in blocks (arrays of edges), such that what a door separates depends only on kept doors of its block.

    The way around a door leads only through doors that are on a cycle with it. In the graph of regions and doors these
    are in the same biconnected component. Doors that touch or conflict are one vertex of that graph.
    """
    import networkx as nx  # noqa: PLC0415  # a seventh of a second, which reading a result does not need

    touching = _touching(problem)
    group = components(np.concatenate([touching, problem.conflicts], axis=1), problem.edges)
    # Regions are numbered from 0 upwards, groups of doors from -1 downwards.
    graph: nx.Graph[int] = nx.Graph()
    graph.add_edges_from(zip(problem.border_region.tolist(), (-1 - group[problem.border_edge]).tolist(), strict=True))
    together = []
    # The components are sets of vertices; networkx's stubs are wrong.
    for component in cast("Iterator[set[int]]", nx.biconnected_components(graph)):
        groups = sorted(-1 - vertex for vertex in component if vertex < 0)
        together += [(groups[0], other) for other in groups[1:]]
    first = np.zeros(group.max(initial=-1) + 1, np.intp)
    first[group[::-1]] = np.arange(problem.edges)[::-1]
    links = first[np.array(together, np.intp).reshape(-1, 2).T]
    own = np.stack([np.arange(problem.edges), first[group]])
    block = components(np.concatenate([links, own], axis=1), problem.edges)
    return [np.flatnonzero(block == number) for number in range(block.max(initial=-1) + 1)]


def _touching(problem: MergeProblem) -> Index:
    """Pairs (2, k) of doors that cover the same node or neighbouring nodes."""
    edge, node = problem.adjacency.covers
    size = problem.edges, len(problem.cells)
    covers = scipy.sparse.coo_array((np.ones(len(node)), (edge, node)), shape=size).tocsr()
    links = scipy.sparse.coo_array((np.ones(len(problem.links[0])), problem.links), shape=(size[1], size[1])).tocsr()
    beside = covers @ (links + links.T)
    return np.stack((covers @ covers.T + beside @ covers.T).nonzero())
