"""Figure 3: each step from the map to virtual doors on a tiny map of its own."""

from __future__ import annotations

import dataclasses
import textwrap
from dataclasses import dataclass

import numpy as np

from vdoor.grid import FREE, OCCUPIED, UNKNOWN, OccupancyGrid
from vdoor.method.simplify import SimplifiedGrid, SimplifyGrid
from vdoor.paper.walkthrough import StageCounts, paper_pipeline, run_method

CELL_M = 0.2
SIGNS = {".": FREE, "#": OCCUPIED, "?": UNKNOWN}


@dataclass(frozen=True, kw_only=True)
class SubCase:
    """One part of the figure."""

    name: str
    part: str
    """As the paper has it, say ``3a``."""
    claim: str
    """What the paper says happens."""
    drawing: str
    """The map, a line a row of 20 cm cells: ``.`` free, ``#`` occupied, ``?`` unknown."""
    undone: SimplifyGrid | None = None
    """A first stage without the step in question."""

    @property
    def grid(self) -> OccupancyGrid:
        """The map."""
        rows = [[SIGNS[sign] for sign in line] for line in self.drawing.split()]
        return OccupancyGrid.from_array(np.array(rows, np.int8), CELL_M)


@dataclass(frozen=True, kw_only=True)
class Shown:
    """What the method does on one of them."""

    case: SubCase
    simplified: str
    """The simplified map, drawn as the map is."""
    counts: StageCounts
    undone: StageCounts | None
    """Without the step in question, where it can be left out."""


def sub_cases() -> tuple[Shown, ...]:
    """All parts of the figure, in its order."""
    return tuple(shown(case) for case in SUB_CASES)


def shown(case: SubCase) -> Shown:
    """The paper's preset on one of them."""
    walk = run_method(case.grid)
    signs = {value: sign for sign, value in SIGNS.items()}
    rows = ("".join(signs[value] for value in row) for row in walk.get(SimplifiedGrid).cells.tolist())
    undone = (
        run_method(case.grid, dataclasses.replace(paper_pipeline(), simplify=case.undone)).counts
        if case.undone
        else None
    )
    return Shown(case=case, simplified="\n".join(rows), counts=walk.counts, undone=undone)


def _case(part: str, name: str, claim: str, drawing: str, *, undone: SimplifyGrid | None = None) -> SubCase:
    return SubCase(name=name, part=part, claim=claim, drawing=textwrap.dedent(drawing).strip(), undone=undone)


SUB_CASES = (
    _case(
        "3a",
        "inaccessible cells",
        "cells that the robot cannot get to are removed",
        """
        ############??????
        #..........#??..??
        #..........#?...??
        #..........#??..??
        #...####...#??????
        #...#..#...#??.???
        #...####...#??..??
        #..........#??????
        #..........#??????
        ############??????
        """,
    ),
    _case(
        "3b",
        "a jut",
        "an obstacle cell that juts into the free space is flattened, or it would be a corner",
        """
        ###############
        #.............#
        #.............#
        #.............#
        #.............#
        #.............#
        #.............#
        #.............#
        #.............#
        #......#......#
        ###############
        """,
        undone=SimplifyGrid(passes=0),
    ),
    _case(
        "3c, 3d",
        "corner extraction",
        "cells of high curvature are candidates, of these the local maxima are corners",
        """
        ####################
        #..................#
        #..................#
        #..................#
        #..................#
        #..................#
        #..................#
        #..................#
        #..................#
        #........###########
        #........#??????????
        #........#??????????
        #........#??????????
        #........#??????????
        #........#??????????
        #........#??????????
        #........#??????????
        #........#??????????
        ##########??????????
        """,
    ),
    _case(
        "3e",
        "a pair of convex corners",
        "two convex corners at most 1.2 m apart make a virtual door",
        """
        ####################
        #........#.........#
        #........#.........#
        #........#.........#
        #..................#
        #..................#
        #..................#
        #..................#
        #........#.........#
        #........#.........#
        #........#.........#
        ####################
        """,
    ),
    _case(
        "3f",
        "a single corner",
        "a convex corner and the closest boundary at most 1.2 m apart make a virtual door",
        """
        ####################
        #........#.........#
        #........#.........#
        #........#.........#
        #........#.........#
        #........#.........#
        #........#.........#
        #..................#
        #..................#
        #..................#
        ####################
        """,
    ),
    _case(
        "3g",
        "many virtual doors around one passage",
        "every convex corner makes virtual doors of its own, so that they crowd",
        """
        ######################
        #........###.........#
        #........###.........#
        #........###.........#
        #....................#
        #....................#
        #....................#
        #........###.........#
        #........###.........#
        #........###.........#
        ######################
        """,
    ),
)
"""The parts, in the figure's order."""
