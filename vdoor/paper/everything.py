"""All of the paper's figures, tables and claims, done again at once."""

from __future__ import annotations

from dataclasses import dataclass

from vdoor.paper.apartments import Study, Told, apartments, nobody
from vdoor.paper.figures import Operation, OperatorRates, SubCaseResult, crossover, measured_rates, mutation, sub_cases
from vdoor.paper.search_claims import SearchClaims, search_claims
from vdoor.paper.slips import Slip, Unprinted, slips, unprinted
from vdoor.paper.table_one import Row, table_one
from vdoor.paper.walkthrough import WalkThrough, figure_5_run, walk_through


@dataclass(frozen=True, kw_only=True)
class Size:
    """How much is done: what the command was asked for."""

    apartments: int = 200
    """Empty ones, and as many furnished."""
    graphs: int = 60
    """Maps whose searches are compared with the proven optimum."""
    seed: int = 0
    """Of the searches; maps have seeds of their own."""


@dataclass(frozen=True, kw_only=True)
class Evidence:
    """What came out."""

    size: Size
    figure_3: tuple[SubCaseResult, ...]
    figure_4: tuple[Operation, Operation]
    """Crossover and mutation."""
    rates: OperatorRates
    figure_5: WalkThrough
    search: SearchClaims
    table_1: tuple[tuple[Row, ...], tuple[Row, ...]]
    """Empty and furnished."""
    studies: tuple[Study, Study]
    """Likewise."""
    slips: tuple[Slip, ...]
    unprinted: tuple[Unprinted, ...]


def gathered(size: Size, told: Told = nobody) -> Evidence:
    """Everything, in about half a minute; `told` hears how far it is. Equal sizes give equal evidence."""
    walk = figure_5_run(seed=size.seed)
    return Evidence(
        size=size,
        figure_3=sub_cases(),
        figure_4=(crossover(), mutation()),
        rates=measured_rates(),
        figure_5=walk_through(walk),
        search=search_claims(walk, graphs=size.graphs, told=told),
        table_1=(table_one(furniture=False, seed=size.seed), table_one(furniture=True, seed=size.seed)),
        studies=(
            apartments(size.apartments, seed=size.seed, told=told),
            apartments(size.apartments, furniture=True, seed=size.seed, told=told),
        ),
        slips=slips(walk),
        unprinted=unprinted(),
    )
