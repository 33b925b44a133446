"""What a map's file says beside its cells, taken into a run: where the robot is, and where its own frame lies."""

from __future__ import annotations

import dataclasses
from typing import NamedTuple

from vdoor.errors import MapError
from vdoor.formats import read_annotations
from vdoor.grid import OccupancyGrid, Source
from vdoor.stages.simplify import SimplifyGrid
from vdoor.topology import TopologicalMap


class Placed(NamedTuple):
    """The first stage for one map, and what its user should know of it."""

    simplify: SimplifyGrid
    note: str = ""
    """Empty where nothing had to be assumed."""


def placed(simplify: SimplifyGrid, grid: OccupancyGrid) -> Placed:
    """The stage with the robot, or else its charger, where the map's file says, unless its place is set already.

    A place without a free cell near it is passed over, as the stage would refuse it.
    """
    said = None if simplify.robot_m else read_annotations(grid.source)
    places_m = said.places_m if said else ()
    for place_m in places_m:
        there = dataclasses.replace(simplify, robot_m=place_m)
        try:
            there(grid)
        except MapError:
            continue
        return Placed(there)
    note = "the robot's place in the map's file is not free; the largest free space is taken"
    return Placed(simplify, note if places_m else "")


def in_own_frame(topology: TopologicalMap, source: Source) -> TopologicalMap:
    """The map that knows where it lies in the frame of the robot whose file it was made of, if that says so."""
    said = read_annotations(source)
    return dataclasses.replace(topology, own_origin_cm=said.own_origin_cm) if said else topology
