"""The evidence as tables of text, which the command prints and the page has in Markdown."""

from __future__ import annotations

import re
import statistics
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from vdoor.paper.claims import Evidence, claims
from vdoor.paper.door_counts import (
    FURNISHING,
    ISLANDS_UP_TO_M,
    METHOD_TITLES,
    DoorCount,
    Share,
    TableRow,
    total,
)
from vdoor.paper.figures import SubCaseResult
from vdoor.paper.motion import Motion
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
from vdoor.paper.walkthrough import PRINTED_EDGES, PRINTED_GENERATION

NUMBER = re.compile(r"[-+]?[\d,.]+( %)?|-|")
NEAR = 0.2
"""How far a count may be off, as a share of the printed one, and still be called near."""
LONGER = (
    "Longer: length over that of the shortest path on the grid that keeps 0.17 m from all walls. `vdoor route-bench` "
    "measures the times."
)
ON_THE_PAGE_ONLY = ("errata", "unprinted")
"""Tables whose cells are sentences."""
ISLANDS = (
    f"With furniture, every method first takes out what stands free and is at most {ISLANDS_UP_TO_M:g} m long "
    "(simplify.max_island_m=1.0), which the paper does not do; where islands are kept, nothing is taken out."
)


@dataclass(frozen=True, kw_only=True)
class Table:
    """Rows of text under a head, and notes, numbered where rows refer to them."""

    title: str
    head: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    notes: tuple[str, ...] = ()
    numbered: bool = False

    def to_text(self) -> str:
        """Aligned columns under an underlined title."""
        lines = [self.head, *self.rows]
        widths = [max(len(line[column]) for line in lines) for column in range(len(self.head))]
        right = [self._is_of_numbers(column) for column in range(len(self.head))]
        shown = (
            "  ".join(
                cell.rjust(width) if to_right else cell.ljust(width)
                for cell, width, to_right in zip(line, widths, right, strict=True)
            ).rstrip()
            for line in lines
        )
        return "\n".join([self.title, "-" * len(self.title), *shown, *self._noted()])

    def to_markdown(self) -> str:
        """A table for a page, its notes below, without the title."""
        marks = ["---:" if self._is_of_numbers(column) else "---" for column in range(len(self.head))]
        lines = [self.head, tuple(marks), *self.rows]
        shown = ("| " + " | ".join(cell.replace("|", "\\|") for cell in line) + " |" for line in lines)
        between = "\n" if self.numbered else "\n\n"
        return "\n\n".join(["\n".join(shown), *([between.join(self._noted())] if self.notes else [])])

    def _noted(self) -> Iterator[str]:
        return (f"{number}. {note}" if self.numbered else note for number, note in enumerate(self.notes, 1))

    def _is_of_numbers(self, column: int) -> bool:
        return all(NUMBER.fullmatch(row[column]) for row in self.rows)


def all_tables(evidence: Evidence) -> dict[str, Table]:
    """Every table by a short name, in the paper's order."""
    empty, furnished = evidence.table_1
    return {
        "claims": claims_table(evidence),
        "figure_3": figure_3(evidence),
        "figure_4": figure_4(evidence),
        "rates": rates_table(evidence),
        "figure_5": figure_5(evidence),
        "search": search_table(evidence.search),
        "hits": hits_table(evidence.search),
        "table_1_empty": table_1(empty, furnished=False),
        "table_1_furnished": table_1(furnished, furnished=True),
        "apartments": apartments_table(evidence),
        "routes": routes_table(evidence.motion),
        "coverage": coverage_table(evidence.motion),
        "errata": errata_table(evidence),
        "unprinted": unprinted_table(evidence),
    }


def to_text(evidence: Evidence) -> str:
    """All tables but those that only the page has."""
    shown = (table.to_text() for name, table in all_tables(evidence).items() if name not in ON_THE_PAGE_ONLY)
    return "\n\n".join([*shown, "What the paper leaves open, and its slips, are on the page that --out writes."])


def claims_table(evidence: Evidence) -> Table:
    """What must hold for the paper's claims to stand, and whether it does."""
    return Table(
        title="What must hold",
        head=("claim", "wanted", "found", "holds"),
        rows=tuple(
            (claim.what, claim.wanted, claim.found, "yes" if claim.holds else "NO") for claim in claims(evidence)
        ),
        notes=(ISLANDS,),
    )


def figure_3(evidence: Evidence) -> Table:
    """What each stage finds on the tiny maps."""
    return Table(
        title="Figure 3: from the map to virtual doors",
        head=("part", "what", "removed cells", "candidates", "corners", "virtual doors", "doors in the end"),
        rows=tuple(map(_sub_case_row, evidence.figure_3)),
        notes=("Candidates and corners: concave + convex. Virtual doors: between pairs + at single corners.",),
    )


def _sub_case_row(result: SubCaseResult) -> tuple[str, ...]:
    counts = result.counts
    return (
        result.case.part,
        result.case.name,
        str(counts.unreachable_cells + counts.jut_cells + counts.notch_cells),
        f"{counts.concave_candidates} + {counts.convex_candidates}",
        f"{counts.concave_corners} + {counts.convex_corners}",
        f"{counts.pairs} + {counts.singles}",
        str(counts.final_edges),
    )


def figure_4(evidence: Evidence) -> Table:
    """The genetic operators on the printed strings."""
    return Table(
        title="Figure 4: the genetic operators",
        head=("operator", "before", "after", "seed"),
        rows=tuple(
            (name, " and ".join(operation.before), " and ".join(operation.after), str(operation.seed))
            for name, operation in zip(("crossover", "mutation"), evidence.figure_4, strict=True)
        ),
        notes=(
            "As the figure has them: dots are one bit, parent 1 all 0, parent 2 all 1. The first seed that does it.",
        ),
    )


def rates_table(evidence: Evidence) -> Table:
    """How often the operators change bits."""
    rates = evidence.rates
    return Table(
        title="Figure 4: how often bits change",
        head=("change", "printed", "measured"),
        rows=(
            ("exchanged by crossover", "0.5", f"{rates.exchanged:.3f}"),
            ("0 to 1 by mutation", "0.1", f"{rates.to_removed:.4f}"),
            ("1 to 0 by mutation", "0.01", f"{rates.to_kept:.4f}"),
        ),
        notes=(f"Each measured over {rates.bits:,} bits.",),
    )


def figure_5(evidence: Evidence) -> Table:
    """The walk-through's counts beside the printed ones."""
    lines = evidence.figure_5.lines
    notes = tuple(dict.fromkeys(line.note for line in lines if line.note))
    rows = (
        (
            line.what,
            str(line.printed),
            str(line.ours),
            met(line.printed, line.ours),
            str(notes.index(line.note) + 1) if line.note else "",
        )
        for line in lines
    )
    head = ("count", "printed", "here", "met", "why not")
    return Table(title="Figure 5: the walk-through", head=head, rows=tuple(rows), notes=notes, numbered=True)


def met(printed: int, ours: int) -> str:
    """Whether a count is the printed one: ``yes``, ``nearly`` or ``no``."""
    if printed == ours:
        return "yes"
    return "nearly" if abs(printed - ours) <= NEAR * printed else "no"


def search_table(search: SearchStudy) -> Table:
    """Section III's claims about the walk-through."""
    return Table(
        title="Section III: the search",
        head=("claim", "printed", "here"),
        rows=(*_load_rows(search), *_optimum_rows(search)),
    )


def _load_rows(search: SearchStudy) -> Iterator[tuple[str, str, str]]:
    """How many choices are evaluated, as a share of all."""
    printed = POPULATION * PRINTED_GENERATION
    share = f"1/2^{-PRINTED_LOG2_LOAD}; its numbers give {_power(printed, PRINTED_EDGES)}"
    yield "virtual doors", str(PRINTED_EDGES), str(search.edges)
    yield "choices of doors", f"{2**PRINTED_EDGES:,}", f"{search.search_space:,}"
    yield "generation of the optimum", str(PRINTED_GENERATION), str(search.best_generation)
    yield "choices evaluated until then", f"{PRINTED_GENERATION} x {POPULATION} = {printed}", f"{search.evaluations}"
    yield "as a share of all", share, _power(search.evaluations, search.edges)
    yield "chance of the optimum among as many drawn blindly", "", f"{_blind(search):.1%}"
    most = f"{GENERATIONS} x {POPULATION} = {GENERATIONS * POPULATION:,}, or {EXAMPLE}"
    share = f"{EXAMPLE} of 2^{EXAMPLE_EDGES}: {_power(EXAMPLE_STRINGS, EXAMPLE_EDGES)}"
    yield "choices evaluated in all generations", most, f"{search.all_evaluations:,}"
    yield f"as a share of the choices of {EXAMPLE_EDGES} doors", share, _power(search.all_evaluations, EXAMPLE_EDGES)


def _power(evaluations: int, edges: int) -> str:
    """A share of all choices as a power of two."""
    return f"1/2^{-log2_load(evaluations, edges):.1f}"


def _blind(search: SearchStudy) -> float:
    """Chance that at least one of as many random choices is optimal."""
    return 1 - (1 - search.optimal_choices / search.search_space) ** search.evaluations


def _optimum_rows(search: SearchStudy) -> Iterator[tuple[str, str, str]]:
    """Whether the choice found is the optimum, and how many searches find that."""
    reached, searches = search.reached_in, search.hits.of
    in_time = sum(generation <= PRINTED_GENERATION for generation in reached)
    spread = f"{reached[0]}, {statistics.median(reached):g}, {reached[-1]}" if reached else "-"
    yield "cost of the choice found", "", f"{search.courses[-1].best:.4f}"
    yield "least cost of all choices, each tried", "", f"{search.optimum:.4f}"
    yield "choices that cost so little", "", str(search.optimal_choices)
    yield f"searches that find the optimum, seeds 0 to {searches - 1}", "", f"{len(reached)} of {searches}"
    yield f"those that do by generation {PRINTED_GENERATION}", "", f"{in_time} of {searches}"
    yield "generation in which they do: first, median, last", "", spread


def hits_table(search: SearchStudy) -> Table:
    """How often the search reaches the proven optimum, by number of virtual doors."""
    return Table(
        title="Section III: searches that reach the proven optimum",
        head=("virtual doors", "maps", "searches", "share (95 %)"),
        rows=tuple(
            (f"{low} to {high}", str(graphs), f"{share.part:,} of {share.of:,}", _with_interval(share))
            for (low, high), (graphs, share) in search.groups.items()
            if share.of
        ),
        notes=(
            f"Intervals are Wilson's, of 95 %; they take searches as independent, though a map has {SEARCHES} of them.",
        ),
    )


def _with_interval(share: Share) -> str:
    low, high = share.interval
    return f"{share.value:.3f} ({low:.3f} to {high:.3f})"


def table_1(rows: Sequence[TableRow], *, furnished: bool) -> Table:
    """Table I on the three environments, empty or furnished."""
    printed, found = total(row.printed for row in rows), total(row.found for row in rows)
    lines = [(row.environment.name, row.environment.doors, row.printed, row.found) for row in rows]
    lines.append(("together", sum(row.environment.doors for row in rows), printed, found))
    return Table(
        title=f"Table I, {FURNISHING[furnished]}: matched / virtual doors = accuracy",
        head=(
            "environment", "real doors", "existing [8], printed", "proposed, printed",
            *(f"{METHOD_TITLES[name]}, here" for name in found),
        ),
        rows=tuple(
            (name, str(doors), *map(_accuracy, (*in_print.values(), *here.values())))
            for name, doors, in_print, here in lines
        ),
        notes=(ISLANDS,) if furnished else (),
    )  # fmt: skip


def _accuracy(count: DoorCount) -> str:
    return f"{count.matched}/{count.virtual} = {count.accuracy.value:.2f}"


def apartments_table(evidence: Evidence) -> Table:
    """Table I over many apartments, with intervals."""
    rows = (
        (
            FURNISHING[study.furniture],
            METHOD_TITLES[name],
            str(count.real),
            str(count.virtual),
            str(count.matched),
            _with_interval(count.accuracy),
            _with_interval(count.found),
            f"{study.without_error[name].part} of {study.without_error[name].of}",
        )
        for study in evidence.studies
        for name, count in study.doors.items()
    )
    return Table(
        title=f"Table I over {evidence.size.apartments} apartments, empty and furnished",
        head=(
            "apartments", "method", "real", "virtual", "matched", "matched / virtual (95 %)", "matched / real (95 %)",
            "without any error",
        ),
        rows=tuple(rows),
        notes=("Intervals are Wilson's, of 95 %; they take doors as independent of each other.", ISLANDS),
    )  # fmt: skip


def routes_table(motion: Sequence[Motion]) -> Table:
    """Planning over rooms and doors against planning on the whole grid."""
    return Table(
        title="Paths over rooms and doors against the whole grid",
        head=("environment", "rooms", "doors", "cells", "paths", "longer, mean", "longer, worst"),
        rows=tuple(
            (
                one.environment.name, str(one.rooms), str(one.doors), f"{one.cells:,}", str(one.paths),
                f"{one.longer_mean:.4f}", f"{one.longer_worst:.4f}",
            )
            for one in motion
        ),
        notes=(LONGER,),
    )  # fmt: skip


def coverage_table(motion: Sequence[Motion]) -> Table:
    """Covering room by room against covering all at once."""
    return Table(
        title="Room by room against the whole space",
        head=("environment", "how", "covered", "length, m", "turns, 1/m2", "changes of room"),
        rows=tuple(
            (
                one.environment.name, how, f"{sweep.covered:.4f}", f"{sweep.length_m:.1f}",
                f"{sweep.turns_per_m2:.2f}", str(sweep.room_changes),
            )
            for one in motion
            for how, sweep in (("room by room", one.by_room), ("all at once", one.at_once))
        ),
        notes=(_together(motion),),
    )  # fmt: skip


def _together(motion: Sequence[Motion]) -> str:
    ratio = sum(one.by_room.length_m for one in motion) / sum(one.at_once.length_m for one in motion)
    return (
        f"By one planner, back to the start. All three: room by room is {ratio:.3f} times as long. Rooms "
        "give order, and less to plan at a time; `vdoor cover-bench` measures the times."
    )


def errata_table(evidence: Evidence) -> Table:
    """Where the paper cannot be taken by the letter."""
    return Table(
        title="What cannot be taken by the letter",
        head=("where", "printed", "why not", "here"),
        rows=tuple((erratum.where, erratum.printed, erratum.trouble, erratum.here) for erratum in evidence.errata),
    )


def unprinted_table(evidence: Evidence) -> Table:
    """What the paper leaves open."""
    return Table(
        title="What is not printed",
        head=("what", "taken here"),
        rows=tuple((one.what, one.taken) for one in evidence.unprinted),
    )
