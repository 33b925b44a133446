"""Two rooms and the doorway between them, and a search that proves its result."""

from __future__ import annotations

from maps import CELL_M

from vdoor.method.search.optimisers import ExhaustiveSearch
from vdoor.pipeline import Pipeline

TWO_ROOMS = """
    #####################
    #.........#.........#
    #.........#.........#
    #.........#.........#
    #.........#.........#
    #...................#
    #...................#
    #...................#
    #...................#
    #.........#.........#
    #.........#.........#
    #.........#.........#
    #.........#.........#
    #####################
"""
DOOR_M = (10.5 * CELL_M, 7 * CELL_M)
"""The middle of the doorway: column 10, between rows 6 and 7 of 14."""
PROVEN = Pipeline(search=ExhaustiveSearch())
