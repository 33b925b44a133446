"""The final topological map: the rooms that remain when the removed doors are opened."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vdoor.grid import FREE, OccupancyGrid
from vdoor.stages.cost import Bits, MergeProblem
from vdoor.stages.final_doors import door_rows, matched_to_contacts
from vdoor.stages.final_map import Features, map_of
from vdoor.stages.flips import FlipState
from vdoor.stages.labels import at_input, flooded, handed_on, numbered, whole
from vdoor.stages.rooms import InitialMap
from vdoor.stages.search import Generation
from vdoor.stages.simplify import SimplifiedGrid
from vdoor.topology import TopologicalMap

Ints = NDArray[np.int32]


@dataclass(frozen=True, kw_only=True)
class MergeRooms:
    """Open the removed doors and carry the rooms that remain to the input's resolution."""

    passages: bool = True
    """Rooms that touch where the simplified grid has no opening have a passage there, too narrow for the working
    resolution (paper); false: no robot fits through, so it is no door, and what lies behind it belongs to one room."""

    def __call__(
        self,
        grid: OccupancyGrid,
        simplified: SimplifiedGrid,
        initial: InitialMap,
        best: Generation,
        problem: MergeProblem,
    ) -> TopologicalMap:
        """Rooms and doors; kept doors that separate nothing are dropped, where the search did not do that itself."""
        room_of_piece, rows = merged(problem, best.removed)
        working = np.append(0, room_of_piece)[initial.piece]
        labels = whole(at_input(working, simplified.factor, grid.free))
        if not self.passages:
            inner = at_input((simplified.cells == FREE).astype(np.int32), simplified.factor, grid.free) > 0
            labels = handed_on(flooded(labels, inner), grid.free)
        else:
            labels = flooded(labels, grid.free)
        labels, number = numbered(labels, int(room_of_piece.max()))
        doors = door_rows(initial, rows, number)
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
    """Room (pieces,) of every piece, 1 and up, 0 on closed doors; and rows of edge and two rooms, the lower first.

    A kept door that joins no two rooms when it is opened separates nothing and is dropped: of two doors with nothing
    between them the less likely goes where doors have scores, else the more tilted, then the longer one.
    """
    state = FlipState(problem, np.flatnonzero(removed).tolist())
    state.open_idle()
    # Asked again, since a dropped door may have been all that kept another from joining a third room.
    pairs = [
        (edge, one, other)
        for edge in range(problem.edges)
        if not state.removed[edge]
        for joined in state.open_if_idle(edge)
        for one, other in itertools.combinations(joined, 2)
    ]
    node = np.append(np.arange(problem.regions), problem.node_of_atom)
    room = np.array(state.room_of)
    _, number = np.unique(room[: problem.regions], return_inverse=True)
    of_room = np.zeros(room.max() + 1, np.int32)
    of_room[room[: problem.regions]] = number + 1
    room = np.where(room >= 0, of_room[room], 0).astype(np.int32)
    rows = [(edge, int(min(room[a], room[b])), int(max(room[a], room[b]))) for edge, a, b in pairs]
    return room[node], sorted(rows)
