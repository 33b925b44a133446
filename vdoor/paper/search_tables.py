"""Section III's claims as tables."""

from __future__ import annotations

import statistics
from collections.abc import Iterator

from vdoor.paper.search import (
    EXAMPLE,
    EXAMPLE_EDGES,
    EXAMPLE_STRINGS,
    GENERATIONS,
    POPULATION,
    PRINTED_LOG2_LOAD,
    SEARCHES,
    SearchStudy,
    log2_load,
)
from vdoor.paper.table import Table, with_interval
from vdoor.paper.walkthrough import PRINTED_EDGES, PRINTED_GENERATION


def search_table(search: SearchStudy) -> Table:
    """Section III's claims about the walk-through."""
    return Table(
        title="Section III: the search",
        head=("claim", "printed", "here"),
        rows=(*_load_rows(search), *_optimum_rows(search)),
    )


def _load_rows(search: SearchStudy) -> Iterator[tuple[str, str, str]]:
    """How much is evaluated of how much."""
    printed = POPULATION * PRINTED_GENERATION
    meant = f"1/2^{-log2_load(printed, PRINTED_EDGES):.1f}"
    here = f"1/2^{-log2_load(search.evaluations, search.edges):.1f}"
    yield "virtual doors", str(PRINTED_EDGES), str(search.edges)
    yield "choices of doors", f"{2**PRINTED_EDGES:,}", f"{search.search_space:,}"
    yield "generation of the optimum", str(PRINTED_GENERATION), str(search.best_generation)
    yield "choices evaluated until then", f"{PRINTED_GENERATION} x {POPULATION} = {printed}", f"{search.evaluations}"
    yield "as a share of all", f"1/2^{-PRINTED_LOG2_LOAD}; its numbers give {meant}", here
    yield "chance of the optimum among as many drawn blindly", "", f"{_blind(search):.1%}"
    most = f"{GENERATIONS} x {POPULATION} = {GENERATIONS * POPULATION:,}, or {EXAMPLE}"
    strings = EXAMPLE_STRINGS, search.all_evaluations
    meant, now = (f"1/2^{-log2_load(count, EXAMPLE_EDGES):.1f}" for count in strings)
    yield "choices evaluated in all generations", most, f"{search.all_evaluations:,}"
    yield f"as a share of the choices of {EXAMPLE_EDGES} doors", f"{EXAMPLE} of 2^{EXAMPLE_EDGES}: {meant}", now


def _optimum_rows(search: SearchStudy) -> Iterator[tuple[str, str, str]]:
    """Whether it is the optimum, and whether it is always found."""
    reached = search.reached_in
    in_time = sum(generation <= PRINTED_GENERATION for generation in reached)
    spread = f"{reached[0]}, {statistics.median(reached):g}, {reached[-1]}" if reached else "-"
    yield "cost of the choice found", "", f"{search.courses[-1].best:.4f}"
    yield "least cost of all choices, each tried", "", f"{search.optimum:.4f}"
    yield "choices that cost so little", "", str(search.optimal_choices)
    yield (
        f"searches that find the optimum, seeds 0 to {search.hits.of - 1}",
        "",
        f"{search.hits.part} of {search.hits.of}",
    )
    yield f"those that do by generation {PRINTED_GENERATION}", "", f"{in_time} of {search.hits.of}"
    yield "generation in which they do: first, median, last", "", spread


def _blind(search: SearchStudy) -> float:
    """Chance that at least one of as many random choices is optimal."""
    return 1 - (1 - search.optimal_choices / search.search_space) ** search.evaluations


def hits_table(search: SearchStudy) -> Table:
    """How often the search reaches the proven optimum, by the number of virtual doors."""
    rows = [
        (f"{low} to {high}", str(graphs), f"{share.part:,} of {share.of:,}", with_interval(share))
        for (low, high), (graphs, share) in search.groups.items()
        if share.of
    ]
    return Table(
        title="Section III: searches that reach the proven optimum",
        head=("virtual doors", "maps", "searches", "share (95 %)"),
        rows=tuple(rows),
        notes=(
            f"Intervals are Wilson's, of 95 %; they take searches as independent, though a map has {SEARCHES} of them.",
        ),
    )
