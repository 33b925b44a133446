"""All evidence gathered at once, and the paper's claims checked on it."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

from vdoor.engines import Over
from vdoor.paper.door_counts import (
    FURNISHING,
    PROPOSED,
    STAND_INS,
    ApartmentStudy,
    TableRow,
    study_apartments,
    table_one,
    total,
)
from vdoor.paper.errata import Erratum, Unprinted, errata, unprinted
from vdoor.paper.figures import Operation, OperatorRates, SubCaseResult, crossover, measured_rates, mutation, sub_cases
from vdoor.paper.motion import Motion, Sweep, study_motion
from vdoor.paper.search import SearchStudy, study_search
from vdoor.paper.walkthrough import Progress, WalkThrough, figure_5_run, no_progress, walk_through

LEAST_FOUND, LEAST_ACCURACY = 0.98, 0.95
LEAST_HITS = 0.9
MOST_LONGER = 1.015
"""Length of a path over rooms and doors, over that of the shortest on the grid."""


@dataclass(frozen=True, kw_only=True)
class Size:
    """How much is computed, as the command's options set it."""

    apartments: int = 200
    """Empty apartments, and as many furnished."""
    graphs: int = 60
    """Maps whose searches are compared with the proven optimum."""
    seed: int = 0
    """Of the searches; maps have seeds of their own."""


@dataclass(frozen=True, kw_only=True)
class Evidence:
    """The paper's figures, tables and claims as found here."""

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
    """Empty and furnished."""
    motion: tuple[Motion, ...]
    errata: tuple[Erratum, ...]
    unprinted: tuple[Unprinted, ...]


def gather_evidence(size: Size, progress: Progress = no_progress, over: Over = map) -> Evidence:
    """Compute everything; equal sizes give equal evidence."""
    run = figure_5_run(seed=size.seed)
    return Evidence(
        size=size,
        figure_3=sub_cases(),
        figure_4=(crossover(), mutation()),
        rates=measured_rates(),
        figure_5=walk_through(run),
        search=study_search(run, graphs=size.graphs, progress=progress, over=over),
        table_1=(table_one(furniture=False, seed=size.seed), table_one(furniture=True, seed=size.seed)),
        studies=(
            study_apartments(size.apartments, seed=size.seed, progress=progress, over=over),
            study_apartments(size.apartments, furniture=True, seed=size.seed, progress=progress, over=over),
        ),
        motion=study_motion(),
        errata=errata(run),
        unprinted=unprinted(),
    )


@dataclass(frozen=True, kw_only=True)
class Claim:
    """What must hold for one of the paper's claims to stand here, and what was found."""

    what: str
    wanted: str
    found: str
    holds: bool


def claims(evidence: Evidence) -> tuple[Claim, ...]:
    """All claims, in the paper's order."""
    return (
        *_of_walk_through(evidence),
        *_of_search(evidence.search),
        *(
            claim
            for rows, furnishing in zip(evidence.table_1, FURNISHING, strict=True)
            for claim in _of_environments(rows, furnishing)
        ),
        _of_environments_together(evidence.table_1[1]),
        *(claim for study in evidence.studies for claim in _of_apartments(study)),
        *_of_motion(evidence.motion),
    )


def _of_walk_through(evidence: Evidence) -> Iterator[Claim]:
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


def _of_search(search: SearchStudy) -> Iterator[Claim]:
    hits = search.hits
    shares = [share for _, share in search.groups.values() if share.of]
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


def _of_environments(rows: Iterable[TableRow], furnishing: str) -> Iterator[Claim]:
    for row in rows:
        ours, printed = row.found[PROPOSED], row.printed[PROPOSED]
        least = round(printed.accuracy.value, 2)
        best = max(row.found[name].accuracy.value for name in STAND_INS)
        yield Claim(
            what=f"Table I, {row.environment.name}, {furnishing}: "
            "all found, as accurate as printed, no stand-in better",
            wanted=f"{ours.real} of {ours.real}, at least {least:.2f}, stand-ins {best:.2f}",
            found=f"{ours.matched} of {ours.real}, {ours.accuracy.value:.2f}",
            holds=ours.real == ours.matched and ours.accuracy.value >= max(least, best),
        )


def _of_environments_together(rows: Iterable[TableRow]) -> Claim:
    accuracy = {name: count.accuracy.value for name, count in total(row.found for row in rows).items()}
    return Claim(
        what="Table I, furnished, the three together: more accurate than both stand-ins",
        wanted=f"above {max(accuracy[name] for name in STAND_INS):.2f}",
        found=f"{accuracy[PROPOSED]:.2f}",
        holds=all(accuracy[PROPOSED] > accuracy[name] for name in STAND_INS),
    )


def _of_apartments(study: ApartmentStudy) -> Iterator[Claim]:
    doors = study.doors
    found, accuracy = doors[PROPOSED].found.value, doors[PROPOSED].accuracy.value
    best = max(doors[name].accuracy.value for name in STAND_INS)
    where = f"{len(study.each)} {FURNISHING[study.furniture]} apartments"
    yield Claim(
        what=f"{where}: matched / real",
        wanted=f"at least {LEAST_FOUND:.2f}",
        found=f"{found:.3f}",
        holds=found >= LEAST_FOUND,
    )
    yield Claim(
        what=f"{where}: matched / virtual, against both stand-ins",
        wanted=f"at least {LEAST_ACCURACY:.2f}, {'above' if best < 1 else 'not below'} {best:.3f}",
        found=f"{accuracy:.3f}",
        holds=accuracy >= LEAST_ACCURACY and (accuracy > best or accuracy == best == 1),
    )


def _of_motion(motion: Sequence[Motion]) -> Iterator[Claim]:
    worst = max(one.longer_worst for one in motion)
    by_room, at_once = (
        sum(sweep.room_changes for sweep in sweeps) for sweeps in zip(*map(_sweeps, motion), strict=True)
    )
    yield Claim(
        what="After I: paths over rooms and doors, over the shortest on the whole grid",
        wanted=f"at most {MOST_LONGER:g}",
        found=f"{worst:.4f}",
        holds=worst <= MOST_LONGER,
    )
    yield Claim(
        what="After I: covering room by room goes from room to room less often than covering all at once",
        wanted=f"below {at_once}",
        found=f"{by_room}",
        holds=by_room < at_once,
    )


def _sweeps(motion: Motion) -> tuple[Sweep, Sweep]:
    return motion.by_room, motion.at_once
