"""What must hold for the paper's claims to stand here, each with what was found."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from vdoor.paper.door_counts import METHODS, PROPOSED, ApartmentStudy, DoorCount, TableRow
from vdoor.paper.everything import Evidence

LEAST_FOUND, LEAST_ACCURACY = 0.98, 0.95
LEAST_HITS = 0.9
STAND_INS = tuple(name for name in METHODS if name != PROPOSED)
KINDS = ("empty", "furnished")
"""Of maps: without furniture and with it."""


@dataclass(frozen=True, kw_only=True)
class Claim:
    """One of them."""

    what: str
    wanted: str
    found: str
    holds: bool


def claims(evidence: Evidence) -> tuple[Claim, ...]:
    """All of them, in the paper's order."""
    return (
        *_of_walk(evidence),
        *_of_searches(evidence),
        *(claim for rows, kind in zip(evidence.table_1, KINDS, strict=True) for claim in _of_cases(rows, kind)),
        _together(evidence.table_1[1]),
        *(claim for study in evidence.studies for claim in _of_study(study)),
    )


def _of_walk(evidence: Evidence) -> Iterator[Claim]:
    counts, search = evidence.figure_5.counts, evidence.search
    yield Claim(
        what="Fig. 5f: rooms and doors of the final map",
        wanted="4 nodes, 3 edges",
        found=f"{counts.final_nodes} nodes, {counts.final_edges} edges",
        holds=(counts.final_nodes, counts.final_edges) == (4, 3),
    )
    yield Claim(
        what="Fig. 5f: no other choice of doors costs less",
        wanted="proven by trying all",
        found=f"of {search.search_space:,}, {'none' if search.proven else 'some'}",
        holds=search.proven,
    )


def _of_searches(evidence: Evidence) -> Iterator[Claim]:
    hits = evidence.search.hits
    shares = [share for _, share in evidence.search.groups.values() if share.of]
    yield Claim(
        what="III: searches of the walk-through that reach the proven optimum",
        wanted=f"at least {LEAST_HITS:.2f}",
        found=f"{hits.value:.3f}",
        holds=hits.value >= LEAST_HITS,
    )
    yield Claim(
        what="III: the same on other maps, by number of virtual doors up to 20",
        wanted=f"at least {LEAST_HITS:.2f}",
        found=", ".join(f"{share.value:.3f}" for share in shares),
        holds=all(share.value >= LEAST_HITS for share in shares),
    )


def _of_cases(rows: Iterable[TableRow], kind: str) -> Iterator[Claim]:
    for row in rows:
        ours, printed = row.found[PROPOSED], row.printed[PROPOSED]
        least = round(printed.accuracy.value, 2)
        best = max(row.found[name].accuracy.value for name in STAND_INS)
        yield Claim(
            what=f"Table I, {row.environment.name}, {kind}: all found, as accurate as printed, no stand-in better",
            wanted=f"{ours.real} of {ours.real}, at least {least:.2f}, stand-ins {best:.2f}",
            found=f"{ours.matched} of {ours.real}, {ours.accuracy.value:.2f}",
            holds=ours.real == ours.matched and ours.accuracy.value >= max(least, best),
        )


def _together(rows: Iterable[TableRow]) -> Claim:
    total = {name: sum((row.found[name] for row in rows), DoorCount()).accuracy.value for name in METHODS}
    return Claim(
        what="Table I, furnished, the three together: more accurate than both stand-ins",
        wanted=f"above {max(total[name] for name in STAND_INS):.2f}",
        found=f"{total[PROPOSED]:.2f}",
        holds=all(total[PROPOSED] > total[name] for name in STAND_INS),
    )


def _of_study(study: ApartmentStudy) -> Iterator[Claim]:
    ours = study.doors[PROPOSED]
    accuracy = ours.accuracy.value
    best = max(study.doors[name].accuracy.value for name in STAND_INS)
    where = f"{len(study.each)} {KINDS[study.furniture]} apartments"
    yield Claim(
        what=f"{where}: matched / real",
        wanted=f"at least {LEAST_FOUND:.2f}",
        found=f"{ours.found.value:.3f}",
        holds=ours.found.value >= LEAST_FOUND,
    )
    yield Claim(
        what=f"{where}: matched / virtual, against both stand-ins",
        wanted=f"at least {LEAST_ACCURACY:.2f}, {'above' if best < 1 else 'not below'} {best:.3f}",
        found=f"{accuracy:.3f}",
        holds=accuracy >= LEAST_ACCURACY and (accuracy > best or accuracy == best == 1),
    )
