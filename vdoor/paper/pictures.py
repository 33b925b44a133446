"""The pictures of the page, by the names of their files."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator

import numpy as np

from vdoor.paper import pictures_ as draw
from vdoor.paper.claims import Evidence
from vdoor.paper.door_counts import ENVIRONMENTS, METHOD_TITLES, Environment, detect_doors, methods_for, real_doors_m
from vdoor.paper.figures import SUB_CASES, SubCase
from vdoor.paper.walkthrough import figure_5_run, run_method

FIGURE_5, SEARCH, TABLE_1 = "figure_5.png", "search.png", "table_1.png"


def picture_of(case: SubCase) -> str:
    """The name of a sub-case's picture."""
    return f"{case.file_stem}.png"


NAMES = (*map(picture_of, SUB_CASES), FIGURE_5, SEARCH, TABLE_1)
"""All of them."""


def pictures(evidence: Evidence) -> Iterator[tuple[str, bytes]]:
    """Name and PNG of each, in the order of `NAMES`; `VdoorError` where matplotlib is missing."""
    for case in SUB_CASES:
        yield picture_of(case), _sub_case(case)
    seed = evidence.size.seed
    yield FIGURE_5, draw.walk_through(figure_5_run(seed=seed).records)
    yield SEARCH, _search(evidence)
    yield TABLE_1, draw.comparison([_compared(environment, seed) for environment in ENVIRONMENTS])


def _sub_case(case: SubCase) -> bytes:
    after = run_method(case.grid)
    before = run_method(case.grid, case.pipeline_undone) if case.pipeline_undone else after
    return draw.sub_case(case.part, before.records, after.records)


def _search(evidence: Evidence) -> bytes:
    search = evidence.search
    courses = [draw.Course(**dataclasses.asdict(course)) for course in search.courses]
    return draw.search_picture(courses, optimum=search.optimum, reached=search.reached_in, searches=len(search.reached))


def _compared(environment: Environment, seed: int) -> draw.Compared:
    """An environment with furniture, and what each method finds there."""
    made = dataclasses.replace(environment, furniture=True).made
    found = {}
    for name, method in methods_for(made).items():
        detection = detect_doors(made, method, seed=seed)
        real = np.zeros(len(detection.virtual_m), np.bool_)
        real[[virtual for _, virtual in detection.pairs]] = True
        found[METHOD_TITLES[name]] = (detection.virtual_m, real)
    return draw.Compared(environment.name, made.grid, real_doors_m(made), found)
