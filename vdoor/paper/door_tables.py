"""Table I, on three environments and on many apartments."""

from __future__ import annotations

from collections.abc import Iterable

from vdoor.paper.claims import Evidence
from vdoor.paper.door_counts import FURNISHING, ISLANDS_UP_TO_M, METHOD_TITLES, PROPOSED, DoorCount, TableRow
from vdoor.paper.table import Table, with_interval

ISLANDS = (
    f"With furniture, every method first takes out what stands free and is at most {ISLANDS_UP_TO_M:g} m long "
    "(simplify.max_island_m=1.0), which the paper does not do; where islands are kept, nothing is taken out."
)


def table_1(rows: Iterable[TableRow], kind: str) -> Table:
    """Table I on the three environments, empty or furnished."""
    rows = tuple(rows)
    cells = [
        (row.environment.name, str(row.environment.doors), *map(_doors, (*row.printed.values(), *row.found.values())))
        for row in rows
    ]
    printed = [_doors(_total(row.printed[name] for row in rows)) for name in ("existing", PROPOSED)]
    found = [_doors(_total(row.found[name] for row in rows)) for name in rows[0].found]
    total = ("together", str(sum(row.environment.doors for row in rows)), *printed, *found)
    return Table(
        title=f"Table I, {kind}: matched / virtual doors = accuracy",
        head=(
            "environment", "real doors", "existing [8], printed", "proposed, printed",
            *(f"{METHOD_TITLES[name]}, here" for name in rows[0].found),
        ),
        rows=(*cells, total),
        notes=(ISLANDS,) if kind == FURNISHING[1] else (),
    )  # fmt: skip


def _total(counts: Iterable[DoorCount]) -> DoorCount:
    return sum(counts, DoorCount())


def _doors(count: DoorCount) -> str:
    return f"{count.matched}/{count.virtual} = {count.accuracy.value:.2f}"


def apartments_table(evidence: Evidence) -> Table:
    """Table I over many apartments, with intervals."""
    rows = []
    for study in evidence.studies:
        for name, count in study.doors.items():
            complete = study.without_error[name]
            rows.append(
                (
                    FURNISHING[study.furniture],
                    METHOD_TITLES[name],
                    str(count.real),
                    str(count.virtual),
                    str(count.matched),
                    with_interval(count.accuracy),
                    with_interval(count.found),
                    f"{complete.part} of {complete.of}",
                )
            )
    return Table(
        title=f"Table I over {evidence.size.apartments} apartments, empty and furnished",
        head=(
            "apartments", "method", "real", "virtual", "matched", "matched / virtual (95 %)", "matched / real (95 %)",
            "without any error",
        ),
        rows=tuple(rows),
        notes=(
            "Intervals are Wilson's, of 95 %; they take doors as independent of each other.",
            ISLANDS,
        ),
    )  # fmt: skip
