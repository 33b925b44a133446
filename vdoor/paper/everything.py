"""All of the paper's figures, tables and claims, done again at once."""

from __future__ import annotations

from dataclasses import dataclass

from vdoor.paper.door_counts import ApartmentStudy, TableRow, study_apartments, table_one
from vdoor.paper.errata import Erratum, Unprinted, errata, unprinted
from vdoor.paper.figures import Operation, OperatorRates, SubCaseResult, crossover, measured_rates, mutation, sub_cases
from vdoor.paper.search import SearchStudy, study_search
from vdoor.paper.walkthrough import Progress, WalkThrough, figure_5_run, no_progress, walk_through


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
    search: SearchStudy
    table_1: tuple[tuple[TableRow, ...], tuple[TableRow, ...]]
    """Empty and furnished."""
    studies: tuple[ApartmentStudy, ApartmentStudy]
    """Likewise."""
    errata: tuple[Erratum, ...]
    unprinted: tuple[Unprinted, ...]


def gathered(size: Size, progress: Progress = no_progress) -> Evidence:
    """Everything, in about half a minute; `progress` hears how far it is. Equal sizes give equal evidence."""
    walk = figure_5_run(seed=size.seed)
    return Evidence(
        size=size,
        figure_3=sub_cases(),
        figure_4=(crossover(), mutation()),
        rates=measured_rates(),
        figure_5=walk_through(walk),
        search=study_search(walk, graphs=size.graphs, progress=progress),
        table_1=(table_one(furniture=False, seed=size.seed), table_one(furniture=True, seed=size.seed)),
        studies=(
            study_apartments(size.apartments, seed=size.seed, progress=progress),
            study_apartments(size.apartments, furniture=True, seed=size.seed, progress=progress),
        ),
        errata=errata(walk),
        unprinted=unprinted(),
    )
