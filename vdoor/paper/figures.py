"""Figures 3 and 4: the steps from the map to virtual doors on tiny maps, and the genetic operators on bit strings."""

from __future__ import annotations

import dataclasses
import textwrap
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vdoor.grid import FREE, OCCUPIED, UNKNOWN, OccupancyGrid
from vdoor.method.search.optimisers import GeneticSearch
from vdoor.method.simplify import SimplifiedGrid, SimplifyGrid
from vdoor.paper.walkthrough import StageCounts, paper_pipeline, run_method
from vdoor.pipeline import Pipeline

Bits = NDArray[np.bool_]

CELL_M = 0.2
SIGNS = {".": FREE, "#": OCCUPIED, "?": UNKNOWN}


@dataclass(frozen=True, kw_only=True)
class SubCase:
    """One part of figure 3."""

    name: str
    part: str
    """As the paper numbers it, such as ``3a``."""
    claim: str
    """What the paper says happens."""
    drawing: str
    """The map, a line a row of 20 cm cells: ``.`` free, ``#`` occupied, ``?`` unknown."""
    undone: SimplifyGrid | None = None
    """A first stage without the step in question, where that step can be left out."""

    @property
    def grid(self) -> OccupancyGrid:
        """The map."""
        rows = [[SIGNS[sign] for sign in line] for line in self.drawing.split()]
        return OccupancyGrid.from_array(np.array(rows, np.int8), CELL_M)

    @property
    def pipeline_undone(self) -> Pipeline | None:
        """The paper's method without the step in question."""
        return dataclasses.replace(paper_pipeline(), simplify=self.undone) if self.undone else None

    @property
    def file_stem(self) -> str:
        """What its files are called: ``3c, 3d`` is ``figure_3cd``."""
        return f"figure_{self.part.replace(', 3', '')}"


@dataclass(frozen=True, kw_only=True)
class SubCaseResult:
    """What the method finds on one part."""

    case: SubCase
    simplified: str
    """The simplified map, drawn as the map is."""
    counts: StageCounts
    undone: StageCounts | None
    """Without the step in question, where it can be left out."""


def sub_cases() -> tuple[SubCaseResult, ...]:
    """The results of all parts, in the figure's order."""
    return tuple(map(run_sub_case, SUB_CASES))


def run_sub_case(case: SubCase) -> SubCaseResult:
    """The paper's method on one part."""
    run = run_method(case.grid)
    signs = {value: sign for sign, value in SIGNS.items()}
    rows = ("".join(signs[value] for value in row) for row in run.get(SimplifiedGrid).cells.tolist())
    undone = run_method(case.grid, case.pipeline_undone).counts if case.pipeline_undone else None
    return SubCaseResult(case=case, simplified="\n".join(rows), counts=run.counts, undone=undone)


def _sub_case(part: str, name: str, claim: str, drawing: str, *, undone: SimplifyGrid | None = None) -> SubCase:
    return SubCase(name=name, part=part, claim=claim, drawing=textwrap.dedent(drawing).strip(), undone=undone)


SUB_CASES = (
    _sub_case(
        "3a",
        "inaccessible cells",
        "cells that the robot cannot get to are removed",
        """
        ############??????
        #..........#??..??
        #..........#?...??
        #..........#??..??
        #...####...#??????
        #...#..#...#??.???
        #...####...#??..??
        #..........#??????
        #..........#??????
        ############??????
        """,
    ),
    _sub_case(
        "3b",
        "a jut",
        "an obstacle cell that juts into the free space is flattened, or it would be a corner",
        """
        ###############
        #.............#
        #.............#
        #.............#
        #.............#
        #.............#
        #.............#
        #.............#
        #.............#
        #......#......#
        ###############
        """,
        undone=SimplifyGrid(passes=0),
    ),
    _sub_case(
        "3c, 3d",
        "corner extraction",
        "cells of high curvature are candidates, of these the local maxima are corners",
        """
        ####################
        #..................#
        #..................#
        #..................#
        #..................#
        #..................#
        #..................#
        #..................#
        #..................#
        #........###########
        #........#??????????
        #........#??????????
        #........#??????????
        #........#??????????
        #........#??????????
        #........#??????????
        #........#??????????
        #........#??????????
        ##########??????????
        """,
    ),
    _sub_case(
        "3e",
        "a pair of convex corners",
        "two convex corners at most 1.2 m apart make a virtual door",
        """
        ####################
        #........#.........#
        #........#.........#
        #........#.........#
        #..................#
        #..................#
        #..................#
        #..................#
        #........#.........#
        #........#.........#
        #........#.........#
        ####################
        """,
    ),
    _sub_case(
        "3f",
        "a single corner",
        "a convex corner and the closest boundary at most 1.2 m apart make a virtual door",
        """
        ####################
        #........#.........#
        #........#.........#
        #........#.........#
        #........#.........#
        #........#.........#
        #........#.........#
        #..................#
        #..................#
        #..................#
        ####################
        """,
    ),
    _sub_case(
        "3g",
        "many virtual doors around one passage",
        "every convex corner makes virtual doors of its own, so that they crowd",
        """
        ######################
        #........###.........#
        #........###.........#
        #........###.........#
        #....................#
        #....................#
        #....................#
        #........###.........#
        #........###.........#
        #........###.........#
        ######################
        """,
    ),
)
"""The parts of figure 3, in its order."""

PARENT_BITS, EXCHANGED_BITS = 7, (0, 1, 6)
"""Length of figure 4's parents, their dots being one bit, and the bits that they exchange: two and the last."""
BEFORE_MUTATION, AFTER_MUTATION = "00010110000", "10010100000"
"""Figure 4's string and its result, the dots being one bit."""
MOST_SEEDS = 1_000_000


@dataclass(frozen=True, kw_only=True)
class Operation:
    """One genetic operation on given strings; 1 = edge removed."""

    before: tuple[str, ...]
    after: tuple[str, ...]
    changed: tuple[int, ...]
    """The bits that were exchanged or flipped, from 0."""
    seed: int
    """The first seed from which the search draws just that."""


@dataclass(frozen=True, kw_only=True)
class OperatorRates:
    """How often the operators change bits, over many offspring."""

    exchanged: float
    """Share of bits that crossover exchanges."""
    to_removed: float
    """Share of 0s that mutation makes 1."""
    to_kept: float
    """Share of 1s that mutation makes 0."""
    bits: int
    """How many bits each share is of."""


def crossover() -> Operation:
    """Two complementary parents exchange the bits that figure 4's parents do, without mutation."""
    search = GeneticSearch(mutate_to_removed=0.0, mutate_to_kept=0.0)
    before = _complementary_parents(PARENT_BITS)
    after = before.copy()
    after[:, list(EXCHANGED_BITS)] ^= True
    return _operation(search, before, after)


def mutation() -> Operation:
    """Figure 4's string becomes its result, at the printed rates and without crossover."""
    before, after = (np.array([[bit == "1" for bit in text]]) for text in (BEFORE_MUTATION, AFTER_MUTATION))
    return _operation(GeneticSearch(crossover=0.0), before, after)


def measured_rates(search: GeneticSearch | None = None, *, bits: int = 100_000, seed: int = 0) -> OperatorRates:
    """How often the operators of a search, by default the printed ones, change bits in strings of that length."""
    search = search or GeneticSearch()
    parents = _complementary_parents(bits)
    crossing = dataclasses.replace(search, mutate_to_removed=0.0, mutate_to_kept=0.0)
    mutating = dataclasses.replace(search, crossover=0.0)
    exchanged, _ = (_offspring(crossing, parents, seed) != parents).mean(axis=1).tolist()
    to_removed, to_kept = (_offspring(mutating, parents, seed) != parents).mean(axis=1).tolist()
    return OperatorRates(exchanged=exchanged, to_removed=to_removed, to_kept=to_kept, bits=bits)


def _operation(search: GeneticSearch, before: Bits, after: Bits) -> Operation:
    """The operation that makes strings of others, with the first seed from which the search draws it."""
    seeds = (seed for seed in range(MOST_SEEDS) if (_offspring(search, before, seed) == after).all())
    return Operation(
        before=_texts(before),
        after=_texts(after),
        changed=tuple(np.flatnonzero(before[0] ^ after[0]).tolist()),
        seed=next(seeds),
    )


def _complementary_parents(bits: int) -> Bits:
    """Two parents (2, bits) with no bit in common: all 0, all 1."""
    return np.repeat([[False], [True]], bits, axis=1)


def _offspring(search: GeneticSearch, parents: Bits, seed: int) -> Bits:
    """The children, each in the row of the parent that it has its other bits from."""
    order = np.random.default_rng(seed).permutation(len(parents))  # who mates with whom is drawn first
    return search.offspring(parents, np.random.default_rng(seed))[np.argsort(order)]


def _texts(strings: Bits) -> tuple[str, ...]:
    return tuple("".join("01"[int(bit)] for bit in string) for string in strings)
