"""The paper's figures and tables as tables of text: what the command prints and what is on the page."""

from __future__ import annotations

from vdoor.paper.claims import Evidence, claims
from vdoor.paper.door_counts import FURNISHING
from vdoor.paper.door_tables import ISLANDS, apartments_table, table_1
from vdoor.paper.figures import SubCaseResult
from vdoor.paper.search_tables import hits_table, search_table
from vdoor.paper.table import Table

NEAR = 0.2
"""How far a count may be off, as a share of the printed one, and still be called near."""
COVERAGE = "to be measured when coverage exists"
SENTENCES = ("errata", "unprinted")


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
        "table_1_empty": table_1(empty, FURNISHING[0]),
        "table_1_furnished": table_1(furnished, FURNISHING[1]),
        "apartments": apartments_table(evidence),
        "coverage": coverage_table(),
        "errata": errata_table(evidence),
        "unprinted": unprinted_table(evidence),
    }


def to_text(evidence: Evidence) -> str:
    """All tables to be printed, but for those whose cells are sentences; the page has these."""
    shown = (table.to_text() for name, table in all_tables(evidence).items() if name not in SENTENCES)
    return "\n\n".join([*shown, "What the paper leaves open, and its slips, are on the page that --out writes."])


def claims_table(evidence: Evidence) -> Table:
    """What must hold."""
    return Table(
        title="What must hold",
        head=("claim", "wanted", "found", "holds"),
        rows=tuple(
            (claim.what, claim.wanted, claim.found, "yes" if claim.holds else "NO") for claim in claims(evidence)
        ),
        notes=(ISLANDS,),
    )


def figure_3(evidence: Evidence) -> Table:
    """The sub-cases: what each stage finds on each tiny map."""
    head = ("part", "what", "removed cells", "candidates", "corners", "virtual doors", "doors in the end")
    rows = [_case(shown) for shown in evidence.figure_3]
    return Table(title="Figure 3: from the map to virtual doors", head=head, rows=tuple(rows), notes=CASE_NOTES)


CASE_NOTES = ("Candidates and corners: concave + convex. Virtual doors: between pairs + at single corners.",)


def _case(shown: SubCaseResult) -> tuple[str, ...]:
    counts = shown.counts
    return (
        shown.case.part,
        shown.case.name,
        str(counts.unreachable_cells + counts.jut_cells + counts.notch_cells),
        f"{counts.concave_candidates} + {counts.convex_candidates}",
        f"{counts.concave_corners} + {counts.convex_corners}",
        f"{counts.pairs} + {counts.singles}",
        str(counts.final_edges),
    )


def figure_4(evidence: Evidence) -> Table:
    """The genetic operators on the printed strings."""
    rows = [
        (name, " and ".join(operation.before), " and ".join(operation.after), str(operation.seed))
        for name, operation in zip(("crossover", "mutation"), evidence.figure_4, strict=True)
    ]
    return Table(
        title="Figure 4: the genetic operators",
        head=("operator", "before", "after", "seed"),
        rows=tuple(rows),
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
    notes = list(dict.fromkeys(line.note for line in lines if line.note))
    rows = [
        (
            line.what,
            str(line.printed),
            str(line.ours),
            met(line.printed, line.ours),
            str(notes.index(line.note) + 1) if line.note else "",
        )
        for line in lines
    ]
    head = ("count", "printed", "here", "met", "why not")
    return Table(title="Figure 5: the walk-through", head=head, rows=tuple(rows), notes=tuple(notes), numbered=True)


def met(printed: int, ours: int) -> str:
    """Whether a count is the printed one: ``yes``, ``nearly`` or ``no``."""
    if printed == ours:
        return "yes"
    return "nearly" if abs(printed - ours) <= NEAR * printed else "no"


def coverage_table() -> Table:
    """The paper's opening claim, which needs a planner of coverage."""
    return Table(
        title="Room by room against the whole space",
        head=("claim", "printed", "here"),
        rows=(("I: cleaning room by room is more efficient than the whole space at once", "no figure", COVERAGE),),
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
