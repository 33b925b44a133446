"""The paper's own evidence, done again: each function gives one figure or table as plain data."""

from vdoor.paper.apartments import Study, apartments
from vdoor.paper.doors_counted import METHODS, DoorCount
from vdoor.paper.figures import (
    SUB_CASES,
    Operation,
    OperatorRates,
    SubCase,
    crossover,
    measured_rates,
    mutation,
    sub_cases,
)
from vdoor.paper.table_one import ENVIRONMENTS, PRINTED, Environment, Row, table_one
from vdoor.paper.walkthrough import (
    ComparedCount,
    MethodRun,
    StageCounts,
    WalkThrough,
    figure_5_run,
    run_method,
    walk_through,
)

__all__ = [
    "ENVIRONMENTS",
    "METHODS",
    "PRINTED",
    "SUB_CASES",
    "ComparedCount",
    "DoorCount",
    "Environment",
    "MethodRun",
    "Operation",
    "OperatorRates",
    "Row",
    "StageCounts",
    "Study",
    "SubCase",
    "WalkThrough",
    "apartments",
    "crossover",
    "figure_5_run",
    "measured_rates",
    "mutation",
    "run_method",
    "sub_cases",
    "table_one",
    "walk_through",
]  # fmt: skip
