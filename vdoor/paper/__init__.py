"""The paper's own evidence, done again: each function gives one figure or table as plain data."""

from vdoor.paper.apartments import Study, apartments
from vdoor.paper.doors_counted import METHODS, DoorCount
from vdoor.paper.genetic_operators import Operation, Rates, crossover, measured_rates, mutation
from vdoor.paper.sub_cases import SUB_CASES, SubCase, sub_cases
from vdoor.paper.table_one import ENVIRONMENTS, PRINTED, Environment, Row, table_one
from vdoor.paper.walk import Counts, Walk, walked
from vdoor.paper.walk_through import Line, WalkThrough, figure_walk, walk_through

__all__ = [
    "ENVIRONMENTS", "METHODS", "PRINTED", "SUB_CASES", "Counts", "DoorCount", "Environment", "Line", "Operation",
    "Rates", "Row", "Study", "SubCase", "Walk", "WalkThrough", "apartments", "crossover", "figure_walk",
    "measured_rates", "mutation", "sub_cases", "table_one", "walk_through", "walked",
]  # fmt: skip
