"""The final topological map: the rooms that remain when the removed edges are opened."""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import Annotated

import numpy as np
from numpy.typing import NDArray

from vdoor.config import Within
from vdoor.grid import FREE, OccupancyGrid
from vdoor.method.boundary import BoundaryPath
from vdoor.method.centred_doors import set_in_middle
from vdoor.method.final_doors import SILL, door_rows, matched_to_contacts, on_sill
from vdoor.method.finished import Features, map_of
from vdoor.method.initial_map import InitialMap
from vdoor.method.scoring.model import HOMES_FROM
from vdoor.method.search.books import CLOSED
from vdoor.method.search.generation import Generation
from vdoor.method.search.incremental import FlipState
from vdoor.method.search.order import RoomOrder
from vdoor.method.search.problem import Bits, MergeProblem
from vdoor.method.simplify import SimplifiedGrid
from vdoor.method.straight_doors import set_straight
from vdoor.method.wall_direction import wall_direction_rad
from vdoor.raster.labels import at_input, flooded, half_seen, handed_on, numbered, whole
from vdoor.raster.runs import runs_of
from vdoor.topology import TopologicalMap

Floats = NDArray[np.float64]
Ints = NDArray[np.int32]


@dataclass(frozen=True, kw_only=True)
class MergeRooms:
    """Open the removed doors and transfer the remaining rooms to the input's resolution."""

    passages: bool = True
    """Add a passage where rooms touch through an opening that is too narrow for the working resolution (paper); false:
    no robot fits through, so there is no door, and the space behind the opening is assigned to one room."""
    half_seen_m: Annotated[float, Within(0, 5)] = 0.0
    """Free cells apart from all rooms are assigned to one across unknown gaps up to this wide, as part of a room that
    was seen as single rays; 0 leaves them without (paper). Only without `passages`."""
    straight_m: Annotated[float, Within(0, 2)] = 0.0
    """Ends of doors that lie askew across an opening move along their walls by up to this, so that the doors are square
    to the walls; 0 leaves them (paper)."""
    centre_m: Annotated[float, Within(0, 5)] = 0.0
    """In homes, as told by how rough the map is, doors in passages deeper than a wall, and up to this deep, are put in
    the middle; 0 leaves them (paper)."""

    def __call__(
        self,
        grid: OccupancyGrid,
        simplified: SimplifiedGrid,
        initial: InitialMap,
        best: Generation,
        problem: MergeProblem,
        *,
        path: BoundaryPath,
    ) -> TopologicalMap:
        """Rooms and doors; kept doors that separate nothing are dropped, unless the search already removed them."""
        room_of_piece, rows = merged(problem, best.removed)
        pieces = runs_of(initial.piece)
        working = pieces.labelled(room_of_piece[pieces.label - 1]).image()
        free = simplified.cells == FREE
        if self.straight_m > 0:
            wall_rad = wall_direction_rad(path)
            initial, working = set_straight(free, initial, working, rows, reach_m=self.straight_m, wall_rad=wall_rad)
        if self.centre_m > 0 and problem.share_rough > HOMES_FROM:
            initial, working = set_in_middle(free, initial, working, rows, most_m=self.centre_m)
        labels = whole(at_input(working, simplified.factor, grid.free))
        if not self.passages:
            inner = at_input(free, simplified.factor, grid.free)
            labels = handed_on(flooded(labels, inner), grid.free)
            if self.half_seen_m > 0:
                labels = half_seen(labels, grid.free, ~grid.occupied, self.half_seen_m / grid.frame.resolution_m)
        else:
            labels = flooded(labels, grid.free)
        labels, number = numbered(labels, int(room_of_piece.max()))
        doors = door_rows(initial, rows, number)
        doors = doors._replace(kind=np.where(on_sill(doors, initial, simplified), SILL, doors.kind))
        if self.passages:
            doors = matched_to_contacts(labels, doors, simplified, grid.frame)

        room = number[room_of_piece[: len(initial.area_m2)]]
        feature = np.stack([room[initial.feature_region], initial.feature_corner], axis=1)
        feature, first = np.unique(feature[feature[:, 0] > 0], axis=0, return_index=True)
        source = np.flatnonzero(room[initial.feature_region] > 0)[first]
        place_m = initial.frame.world_from_cell(initial.feature_cell[source])
        features = Features(feature[:, 0], feature[:, 1], initial.feature_convex[source], place_m)
        return map_of(labels, grid.frame, doors, features)


def merged(problem: MergeProblem, removed: Bits) -> tuple[Ints, list[tuple[int, int, int]]]:
    """The room (pieces,) of every piece, from 1, 0 on closed doors; and rows (edge, room, room), the lower room first.

    A kept door that joins no two rooms when opened separates nothing and is dropped. Of two doors with nothing between
    them, the less likely one is dropped if doors have scores, otherwise the more tilted, then the longer one.
    """
    state = FlipState(problem, np.flatnonzero(removed).tolist())
    state.order = RoomOrder(state.books, removed)
    state.open_idle()
    # Checked again, since dropping a door may have given another one a third room to join.
    pairs = [
        (edge, one, other)
        for edge in range(problem.edges)
        if not state.removed[edge]
        for joined in state.open_if_idle(edge)
        for one, other in itertools.combinations(joined, 2)
    ]
    node = np.append(np.arange(problem.regions), problem.node_of_atom)
    changed = np.array([state.order.last.get(room, CLOSED) for room in state.room_of])
    real = np.unique(changed[: problem.regions])  # open atoms without a region are no room
    room = np.searchsorted(real, changed).astype(np.int32) + 1
    room[~np.isin(changed, real)] = 0
    rows = [(edge, int(min(room[a], room[b])), int(max(room[a], room[b]))) for edge, a, b in pairs]
    return room[node], sorted(rows)
