"""The report: a Markdown page for a reader who has the paper at hand, all numbers as JSON, and the folder of files."""

from __future__ import annotations

import dataclasses
import json
import math
from collections.abc import Sequence
from pathlib import Path
from string import Template
from typing import Any

from vdoor.files import make_folder
from vdoor.method.search.optimisers import ExhaustiveSearch
from vdoor.paper.claims import Evidence, Size, claims
from vdoor.paper.door_counts import (
    EXISTING,
    FIRST_SEED,
    MATCHED_WITHIN_M,
    METHOD_TITLES,
    PROPOSED,
    ApartmentStudy,
    CountByMethod,
    Share,
    TableRow,
    total,
)
from vdoor.paper.figures import SubCaseResult
from vdoor.paper.pictures import FIGURE_5, NAMES, SEARCH, TABLE_1, picture_of, pictures
from vdoor.paper.runs import Run, runs
from vdoor.paper.search import SearchStudy
from vdoor.paper.tables import NEAR, all_tables, met
from vdoor.paper.walkthrough import Progress, no_progress
from vdoor.partial import write_whole

PAGE_NAME, NUMBERS_NAME = "README.md", "numbers.json"


def files(folder: Path, *, rrd: bool) -> list[Path]:
    """All files that `write` writes."""
    recordings = [path for run in runs(seed=0) for path in run.files(folder, rrd=rrd)]
    return [*recordings, *(folder / name for name in (*NAMES, NUMBERS_NAME, PAGE_NAME))]


def write(evidence: Evidence, folder: Path, *, rrd: bool, progress: Progress = no_progress) -> None:
    """Write recordings, pictures, numbers and the page, each under its name only when whole; `VdoorError` if not."""
    make_folder(folder)
    recorded = list(runs(evidence.size.seed))
    progress(f"writing {len(recorded)} recordings")
    for run in recorded:
        run.record(folder, rrd=rrd)
    progress(f"drawing {len(NAMES)} pictures")
    for name, content in pictures(evidence):
        write_whole(folder / name, content)
    write_whole(folder / NUMBERS_NAME, f"{to_json(evidence)}\n".encode())
    write_whole(folder / PAGE_NAME, page(evidence, recorded).encode())


PAGE = Template("""\
# The paper's evidence, done again

For a reader who has "Generating Topological Map from Occupancy Grid-map using Virtual Door Detection" at hand: its
figures, its table and its claims, each done again by the preset `paper`, the method as printed. This page, its
pictures, [`numbers.json`](numbers.json) and the recordings come from one command:

```sh
$command
```

Equal seeds give equal pages. The paper's maps are not public. Apartments of its kind stand in for them, drawn at 20 cm
with their true doors (`vdoor synth`); those that carry a claim about doors by seeds that were settled before any method
ran on them.

$holds

$claims

## Figure 3: from the map to virtual doors

Each part on a tiny map of its own, in the figure's colours.

$cases

$figure_3

## Figure 4: the genetic operators

$figure_4

$rates

## Figure 5: the walk-through

The map has four rooms and three doors, which the figure ends with, and furniture. It was chosen so that its corners
come near the printed number; so it says how the numbers hang together, and nothing about how often they come out so.

![Six stages, as in the figure]($picture_5)

$figure_5

$met

## Section III: the search

All choices of doors are tried here, so the optimum is known. The load that the paper states does not follow from its
own numbers, and in which generation the optimum comes is one seed's luck: the picture on the right has many.

![Cost per generation, and the generation in which each of many searches reaches the optimum]($picture_search)

$search

The same on $graphs other initial maps: the first that have 1 to $most_doors virtual doors, of apartments with 3 to 6
rooms, every other one furnished (its islands taken out). Where there are too many doors to try all choices, no optimum
of eq. 7 is proven; preset `default` searches another cost, with a certificate.

$hits

## Table I: three environments

The paper's three homes are not public; these have as many real doors, by the first seeds that give so many. A virtual
door matches a real one when their middles are at most $matched m apart. The existing algorithm [8] could not be had
either: Voronoi doors (preset `voronoi-doors`) and eroded space (`eroded-space`) stand in for it, built after what is
known of it. Homes have furniture, so the second table is the one to compare with the printed numbers.

$table_1_empty

$table_1_furnished

![Doors that each method finds in the furnished environments, as in figure 6]($picture_1)

$together

## Table I over $apartments apartments

Three environments carry little. These are $apartments apartments of 4 to 6 rooms, by the seeds from $first_seed up,
each empty and with furniture.

$apartments_table

## Paths over rooms and doors

The introduction claims that a topological map makes planning simpler and covering room by room more efficient, and
prints no figures. These are the furnished environments of Table I at 5 cm.

$routes

## Room by room against the whole space

$coverage

## What cannot be taken by the letter

$errata

## What is not printed

`vdoor config --preset paper` prints every setting, `vdoor sweep` shows what one of them does.

$unprinted

## Recordings

Each is a whole run with all its stages. `vdoor verify` runs them again and compares; `vdoor show FILE` draws one in
the terminal, `vdoor step FILE` walks through it, `vdoor replay FILE --save out.rrd` makes a Rerun recording of it.

$recordings
""")


def page(evidence: Evidence, recorded: Sequence[Run]) -> str:
    """The whole page; equal evidence gives equal pages."""
    tables = {name: table.to_markdown() for name, table in all_tables(evidence).items()}
    return PAGE.substitute(
        {name: text for name, text in tables.items() if name != "apartments"},
        command=_command(evidence.size),
        holds=_verdict(evidence),
        cases="\n\n".join(map(_case_section, evidence.figure_3)),
        picture_5=FIGURE_5,
        picture_search=SEARCH,
        picture_1=TABLE_1,
        graphs=len(evidence.search.graphs),
        most_doors=ExhaustiveSearch().most_edges,
        matched=f"{MATCHED_WITHIN_M:g}",
        met=_counts_met(evidence),
        together=_environments_together(evidence),
        apartments=evidence.size.apartments,
        apartments_table=tables["apartments"],
        first_seed=FIRST_SEED,
        recordings="\n".join(["| recording | what |", "| --- | --- |", *map(_recording_row, recorded)]),
    )


def _command(size: Size) -> str:
    """The command that makes a page of that size."""
    default = dataclasses.asdict(Size())
    changed = [f"--{name} {value}" for name, value in dataclasses.asdict(size).items() if value != default[name]]
    return " ".join(["vdoor paper --out recordings/paper --force", *changed])


def _verdict(evidence: Evidence) -> str:
    checked = claims(evidence)
    failed = sum(not claim.holds for claim in checked)
    return f"{failed} of {len(checked)} claims do not hold:" if failed else f"All {len(checked)} claims hold:"


def _case_section(result: SubCaseResult) -> str:
    case = result.case
    return f"**{case.part}, {case.name}:** {case.claim}.\n\n![{case.name}]({picture_of(case)})"


def _counts_met(evidence: Evidence) -> str:
    """Which printed counts of figure 5 are met, which nearly, which not."""
    sentences = []
    for verdict, words in (("yes", "Met"), ("nearly", f"Nearly met, within {NEAR:.0%}"), ("no", "Not met")):
        names = [line.what for line in evidence.figure_5.lines if met(line.printed, line.ours) == verdict]
        sentences += [f"{words}: {', '.join(names)}."] if names else []
    return "\n\n".join(sentences)


def _environments_together(evidence: Evidence) -> str:
    """Table I, furnished, in a sentence."""
    _, rows = evidence.table_1
    printed, found = total(row.printed for row in rows), total(row.found for row in rows)
    here = ", ".join(f"{count.accuracy.value:.2f} for {METHOD_TITLES[name]}" for name, count in found.items())
    return (
        f"Furnished, the three together, matched / virtual is {here}; in print {printed[EXISTING].accuracy.value:.2f} "
        f"for the existing algorithm and {printed[PROPOSED].accuracy.value:.2f} for the proposed one."
    )


def _recording_row(run: Run) -> str:
    return f"| [`{run.name}.mcap`]({run.name}.mcap) | {run.what} |"


SCHEMA = 1
DIGITS = 9
"""Decimal places that are the same on every machine."""
LINE_LENGTH = 110


def numbers_of(evidence: Evidence) -> dict[str, Any]:
    """All that the tables have and what it is counted from; no times, no dates."""
    crossover, mutation = evidence.figure_4
    empty, furnished = evidence.table_1
    numbers = {
        "schema": SCHEMA,
        "size": dataclasses.asdict(evidence.size),
        "claims": [dataclasses.asdict(claim) for claim in claims(evidence)],
        "figure_3": [_sub_case(result) for result in evidence.figure_3],
        "figure_4": {
            "crossover": dataclasses.asdict(crossover),
            "mutation": dataclasses.asdict(mutation),
            "rates": dataclasses.asdict(evidence.rates),
        },
        "figure_5": dataclasses.asdict(evidence.figure_5),
        "search": _search(evidence.search),
        "table_1": {"empty": [_row(row) for row in empty], "furnished": [_row(row) for row in furnished]},
        "apartments": [_study(study) for study in evidence.studies],
        "motion": [dataclasses.asdict(one) for one in evidence.motion],
        "slips": [dataclasses.asdict(erratum) for erratum in evidence.errata],
        "unprinted": [dataclasses.asdict(one) for one in evidence.unprinted],
    }
    rounded: dict[str, Any] = _rounded(numbers)
    return rounded


def to_json(evidence: Evidence) -> str:
    """The numbers as JSON text; values that fit on a line are not broken."""
    return _json_text(numbers_of(evidence), 0)


def _sub_case(result: SubCaseResult) -> dict[str, Any]:
    return {
        "part": result.case.part,
        "name": result.case.name,
        "claim": result.case.claim,
        "map": result.case.drawing.split(),
        "simplified": result.simplified.split(),
        "counts": dataclasses.asdict(result.counts),
        "without_the_step": dataclasses.asdict(result.undone) if result.undone else None,
    }


def _search(search: SearchStudy) -> dict[str, Any]:
    groups = {
        f"{low} to {high}": {"maps": graphs, **_share(share)} for (low, high), (graphs, share) in search.groups.items()
    }
    courses = [[course.generation, course.best, course.mean, course.worst] for course in search.courses]
    return dataclasses.asdict(search) | {
        "search_space": search.search_space,
        "courses": {"columns": ["generation", "best", "mean", "worst"], "rows": courses},
        "hits": _share(search.hits),
        "groups": groups,
    }


def _row(row: TableRow) -> dict[str, Any]:
    return {
        "environment": dataclasses.asdict(row.environment),
        "printed": _counts(row.printed),
        "found": _counts(row.found),
    }


def _study(study: ApartmentStudy) -> dict[str, Any]:
    return {
        "furniture": study.furniture,
        "cell_m": study.cell_m,
        "doors": _counts(study.doors),
        "without_error": {name: _share(share) for name, share in study.without_error.items()},
        "each": {
            "columns": ["real", "virtual", "matched"],
            **{name: [list(dataclasses.astuple(counts[name])) for counts in study.each] for name in study.each[0]},
        },
    }


def _counts(counts: CountByMethod) -> dict[str, Any]:
    return {
        name: dataclasses.asdict(count) | {"accuracy": _share(count.accuracy), "found": _share(count.found)}
        for name, count in counts.items()
    }


def _share(share: Share) -> dict[str, Any]:
    return {"part": share.part, "of": share.of, "value": share.value, "interval": share.interval}


def _rounded(value: Any) -> Any:
    """The same with numbers rounded to `DIGITS`, and null for nan and infinity."""
    if isinstance(value, dict):
        return {name: _rounded(part) for name, part in value.items()}
    if isinstance(value, list | tuple):
        return [_rounded(part) for part in value]
    if isinstance(value, float):
        return round(value, DIGITS) if math.isfinite(value) else None
    return value


def _json_text(value: Any, depth: int) -> str:
    """JSON, broken into lines only where it is too long for one; `depth` is the indentation."""
    short = json.dumps(value, allow_nan=False)
    if len(short) + depth <= LINE_LENGTH or not isinstance(value, dict | list):
        return short
    pad = " " * (depth + 1)
    if isinstance(value, dict):
        lines = [f"{pad}{json.dumps(name)}: {_json_text(part, depth + 1)}" for name, part in value.items()]
        return "{\n" + ",\n".join(lines) + f"\n{' ' * depth}}}"
    lines = [pad + _json_text(part, depth + 1) for part in value]
    return "[\n" + ",\n".join(lines) + f"\n{' ' * depth}]"
