"""All numbers as JSON."""

from __future__ import annotations

import dataclasses
import json
import math
from typing import Any

from vdoor.paper.claims import Evidence, claims
from vdoor.paper.door_counts import ApartmentStudy, DoorCount, Share, TableRow
from vdoor.paper.figures import SubCaseResult
from vdoor.paper.search import SearchStudy
from vdoor.paper.tables import COVERAGE

SCHEMA = 1
DIGITS = 9
"""Behind the point: what is further behind may differ between machines."""
LINE = 110


def document(evidence: Evidence) -> dict[str, Any]:
    """Everything that the tables say, and what they are counted from; no times, no dates."""
    crossover, mutation = evidence.figure_4
    empty, furnished = evidence.table_1
    found = {
        "schema": SCHEMA,
        "size": dataclasses.asdict(evidence.size),
        "claims": [dataclasses.asdict(claim) for claim in claims(evidence)],
        "figure_3": [_case(shown) for shown in evidence.figure_3],
        "figure_4": {
            "crossover": dataclasses.asdict(crossover),
            "mutation": dataclasses.asdict(mutation),
            "rates": dataclasses.asdict(evidence.rates),
        },
        "figure_5": dataclasses.asdict(evidence.figure_5),
        "search": _search(evidence.search),
        "table_1": {"empty": [_row(row) for row in empty], "furnished": [_row(row) for row in furnished]},
        "apartments": [_study(study) for study in evidence.studies],
        "coverage": COVERAGE,
        "slips": [dataclasses.asdict(erratum) for erratum in evidence.errata],
        "unprinted": [dataclasses.asdict(one) for one in evidence.unprinted],
    }
    rounded: dict[str, Any] = _rounded(found)
    return rounded


def to_json(evidence: Evidence) -> str:
    """The document, what is short on a line of its own."""
    return _text(document(evidence), 0)


def _case(shown: SubCaseResult) -> dict[str, Any]:
    undone = dataclasses.asdict(shown.undone) if shown.undone else None
    return {
        "part": shown.case.part,
        "name": shown.case.name,
        "claim": shown.case.claim,
        "map": shown.case.drawing.split(),
        "simplified": shown.simplified.split(),
        "counts": dataclasses.asdict(shown.counts),
        "without_the_step": undone,
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
        "printed": {name: _count(count) for name, count in row.printed.items()},
        "found": {name: _count(count) for name, count in row.found.items()},
    }


def _study(study: ApartmentStudy) -> dict[str, Any]:
    return {
        "furniture": study.furniture,
        "cell_m": study.cell_m,
        "doors": {name: _count(count) for name, count in study.doors.items()},
        "without_error": {name: _share(share) for name, share in study.without_error.items()},
        "each": {
            "columns": ["real", "virtual", "matched"],
            **{name: [list(dataclasses.astuple(found[name])) for found in study.each] for name in study.each[0]},
        },
    }


def _count(count: DoorCount) -> dict[str, Any]:
    return dataclasses.asdict(count) | {"accuracy": _share(count.accuracy), "found": _share(count.found)}


def _share(share: Share) -> dict[str, Any]:
    return {"part": share.part, "of": share.of, "value": share.value, "interval": share.interval}


def _rounded(value: Any) -> Any:
    """The same with shorter numbers, and null for what is no number."""
    if isinstance(value, dict):
        return {name: _rounded(part) for name, part in value.items()}
    if isinstance(value, list | tuple):
        return [_rounded(part) for part in value]
    if isinstance(value, float):
        return round(value, DIGITS) if math.isfinite(value) else None
    return value


def _text(value: Any, depth: int) -> str:
    """JSON, broken into lines only where it is too long for one."""
    short = json.dumps(value, allow_nan=False)
    if len(short) + depth <= LINE or not isinstance(value, dict | list):
        return short
    pad = " " * (depth + 1)
    if isinstance(value, dict):
        lines = [f"{pad}{json.dumps(name)}: {_text(part, depth + 1)}" for name, part in value.items()]
        return "{\n" + ",\n".join(lines) + f"\n{' ' * depth}}}"
    lines = [pad + _text(part, depth + 1) for part in value]
    return "[\n" + ",\n".join(lines) + f"\n{' ' * depth}]"
