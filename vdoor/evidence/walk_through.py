"""Figure 5: a map of the paper's kind walked through, with the printed counts beside ours."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np

from vdoor.evidence.walk import Counts, Walk, paper, walked
from vdoor.grid import OccupancyGrid
from vdoor.stages.cost import MergeProblem
from vdoor.stages.rooms import InitialMap
from vdoor.stages.search import ExhaustiveSearch
from vdoor.synth import PRESETS, Apartment, synthesize

SEED = 0
"""Of the map; its settings were chosen so that the corners come near the printed ones."""
AREA_M2, FREE_PIECES_PER_M2 = 90.0, 0.02
SAME_COST = 1e-9


@dataclass(frozen=True, kw_only=True)
class Line:
    """One printed number, ours beside it, and why the two differ."""

    what: str
    printed: int
    ours: int
    note: str = ""


@dataclass(frozen=True, kw_only=True)
class WalkThrough:
    """The figure's numbers, and section III's about the search."""

    counts: Counts
    lines: tuple[Line, ...]
    optimum_proven: bool
    """No choice of doors is better than the one found, by trying all."""
    search_space: int
    """Choices there are, 2 to the number of edges."""

    @property
    def share_evaluated(self) -> float:
        """Choices evaluated up to the best one, the first population with them, as a share of all."""
        return self.counts.evaluations / self.search_space


CORNERS = (
    "of all corners of a connected right-angled map, concave minus convex is 4 - 4 x islands, at most 4; more says "
    "that convex ones were missed or concave ones found twice"
)
REGIONS = (
    "regions are 1 + doors + crossings - islands tied in: 18 of 16 doors needs doors that cross, or a map in two parts"
)
SAMPLING = "how many cells around a corner bend enough follows from how the boundary is sampled, which is not printed"
SEEDED = "by chance: another seed gives another generation"
PRINTED_SHARE, SHARE_OF_PRINTED = 2.0**-9, 9 * 50 / 2**16
"""What the paper says of the load, and what its own numbers give: 450 of 65,536 evaluations, or 1 / 2^7.2."""
PRINTED = (
    ("concave candidates", "concave_candidates", 150, SAMPLING),
    ("convex candidates", "convex_candidates", 82, SAMPLING),
    ("concave corners", "concave_corners", 43, CORNERS),
    ("convex corners", "convex_corners", 35, CORNERS),
    ("virtual doors", "virtual_doors", 16, ""),
    ("nodes of the initial map", "nodes", 18, REGIONS),
    ("edges of the initial map", "edges", 16, ""),
    ("generation of the optimum", "best_generation", 9, SEEDED),
    ("nodes of the final map", "final_nodes", 4, ""),
    ("edges of the final map", "final_edges", 3, ""),
)
"""What the paper prints, our count of the same name, and what is to be said of it."""


def walk_through(*, seed: int = 0) -> WalkThrough:
    """The paper's preset on the figure's stand-in, the search seeded with `seed`."""
    walk = walked(figure_map(), seed=seed)
    counts = walk.counts
    ours = dataclasses.asdict(counts)
    return WalkThrough(
        counts=counts,
        lines=tuple(
            Line(what=what, printed=printed, ours=ours[name], note=note) for what, name, printed, note in PRINTED
        ),
        optimum_proven=is_optimum(walk),
        search_space=2**counts.edges,
    )


def figure_map() -> OccupancyGrid:
    """The stand-in: four rooms and three doors, furnished, at 20 cm."""
    settings: Apartment = dataclasses.replace(
        PRESETS["paper"],
        rooms=4,
        rooms_spread=0,
        furniture=True,
        area_m2=AREA_M2,
        free_pieces_per_m2=FREE_PIECES_PER_M2,
    )
    return synthesize(settings, np.random.default_rng(SEED)).grid


def is_optimum(walk: Walk) -> bool:
    """Whether trying all choices finds none that is cheaper than the search's last."""
    problem = MergeProblem(walk.get(InitialMap), paper().cost)
    every = list(ExhaustiveSearch()(problem, np.random.default_rng()))
    return bool(walk.generations[-1].best_cost <= every[-1].best_cost + SAME_COST)
