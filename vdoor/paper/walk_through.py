"""Figure 5: a map of the paper's kind walked through, with the printed counts beside ours."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np

from vdoor.grid import OccupancyGrid
from vdoor.paper.walk import Counts, Walk, walked
from vdoor.synth import PRESETS, Apartment, synthesize

SEED = 0
"""Of the map; its settings were chosen so that the corners come near the printed ones."""
AREA_M2, FREE_PIECES_PER_M2 = 90.0, 0.02


@dataclass(frozen=True, kw_only=True)
class Line:
    """One printed number, ours beside it, and why the two differ."""

    what: str
    printed: int
    ours: int
    note: str = ""


@dataclass(frozen=True, kw_only=True)
class WalkThrough:
    """The figure's numbers."""

    counts: Counts
    lines: tuple[Line, ...]


SAMPLING = (
    "Cannot be met with the corners: at a convex corner only its own cell bends, at a concave one up to four do "
    "(Fig. 3c). That makes {convex_each:.1f} and {concave_each:.1f} a corner here, against 2.3 and 3.5 in print; how "
    "the boundary is sampled, from which it follows, is not printed."
)
CORNERS = (
    "Cannot both be all corners: on a connected right-angled map concave less convex is 4 - 4 x islands, at most 4. 43 "
    "less 35 says that convex ones were missed or concave ones found twice. Here the boundary turns {concave_turns} "
    "times concave and {convex_turns} times convex, around {islands} islands."
)
REGIONS = (
    "Cannot be met by doors with two sides each: nodes are 1 + doors + crossings - islands tied in, at most 17 of 16 "
    "doors that do not cross. It takes doors that cross, or a map in two parts."
)
SEEDED = "By chance: another seed gives another generation (section III below)."
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


def walk_through(walk: Walk) -> WalkThrough:
    """A run on the figure's stand-in, in numbers."""
    counts = walk.counts
    ours = dataclasses.asdict(counts)
    each = {
        "convex_each": counts.convex_candidates / counts.convex_corners,
        "concave_each": counts.concave_candidates / counts.concave_corners,
    }
    lines = (
        Line(what=what, printed=printed, ours=ours[name], note=note.format(**each, **ours))
        for what, name, printed, note in PRINTED
    )
    return WalkThrough(counts=counts, lines=tuple(lines))


def figure_walk(*, seed: int = 0) -> Walk:
    """The paper's preset on the figure's stand-in, the search seeded with `seed`."""
    return walked(figure_map(), seed=seed)


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
