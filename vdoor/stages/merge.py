"""The final topological map: the rooms that remain when the removed doors are opened."""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from vdoor.grid import OccupancyGrid
from vdoor.record import Frame
from vdoor.stages.cost import Bits, MergeProblem
from vdoor.stages.doors import KINDS
from vdoor.stages.flips import FlipState
from vdoor.stages.rooms import InitialMap, centres, components, polygons
from vdoor.stages.runs import runs_of
from vdoor.stages.search import Generation
from vdoor.stages.simplify import SimplifiedGrid
from vdoor.topology import TopologicalMap

Floats = NDArray[np.float64]
Ints = NDArray[np.int32]


@dataclass(frozen=True, kw_only=True)
class MergeRooms:
    """Open the removed doors and carry the rooms that remain to the input's resolution."""

    def __call__(self, grid: OccupancyGrid, simplified: SimplifiedGrid, initial: InitialMap, best: Generation,
                 problem: MergeProblem) -> TopologicalMap:
        """Rooms and doors; kept doors that separate nothing are dropped."""
        room_of_piece, rows = merged(initial, problem, best.removed)
        working = np.append(0, room_of_piece)[initial.piece]
        labels = flooded(at_input(working, simplified.factor, grid.free), grid.free)
        labels, number = numbered(labels, int(room_of_piece.max()))
        doors = door_rows(initial, rows, number)
        passages = narrow_passages(labels, doors, simplified, grid.frame)
        doors = Doors(*(np.concatenate(parts) for parts in zip(doors, passages, strict=True)))

        room = number[room_of_piece[: len(initial.area_m2)]]
        feature = np.stack([room[initial.feature_region], initial.feature_corner], axis=1)
        feature, first = np.unique(feature[feature[:, 0] > 0], axis=0, return_index=True)
        source = np.flatnonzero(room[initial.feature_region] > 0)[first]
        rooms = int(labels.max(initial=0))
        vertex, vertex_room, vertex_ring = polygons(labels)
        cells = runs_of(labels).cells(rooms)
        return TopologicalMap(
            labels=labels, centre=centres(labels, rooms), area_m2=cells.astype(np.float64) * grid.frame.resolution_m**2,
            **doors._asdict(), feature_room=feature[:, 0], feature_corner=feature[:, 1], feature_convex=initial.feature_convex[source],
            feature_m=initial.frame.world_from_cell(initial.feature_cell[source]),
            vertex_m=grid.frame.world_from_cell(vertex - 0.5), vertex_room=vertex_room, vertex_ring=vertex_ring,
            frame=grid.frame,
        )


class Doors(NamedTuple):
    """The door columns of the map."""

    edge: Ints
    start_m: Floats
    end_m: Floats
    kind: NDArray[np.uint8]
    length_m: Floats
    width_m: Floats
    tilt_rad: Floats
    room_a: Ints
    room_b: Ints


def merged(initial: InitialMap, problem: MergeProblem, removed: Bits) -> tuple[Ints, list[tuple[int, int, int]]]:
    """Room (pieces,) of every piece, 1 and up, 0 on closed doors; and rows of edge and two rooms, the lower first.

    A kept door that joins no two rooms when it is opened separates nothing and is dropped: of two doors with nothing
    between them the more tilted goes, then the longer one.
    """
    state = FlipState(problem, np.flatnonzero(removed).tolist())
    worst_first = np.lexsort((np.arange(problem.edges), initial.length_m, initial.tilt_rad))[::-1]
    pairs = [
        (edge, *pair)
        for edge in worst_first.tolist() if not state.removed[edge]
        for joined in state.open_if_idle(edge)
        for pair in itertools.combinations(joined, 2)
    ]
    node = np.append(np.arange(problem.regions), problem.node_of_atom)
    room = np.array(state.room_of)
    _, number = np.unique(room[: problem.regions], return_inverse=True)
    of_room = np.zeros(room.max() + 1, np.int32)
    of_room[room[: problem.regions]] = number + 1
    room = np.where(room >= 0, of_room[room], 0).astype(np.int32)
    return room[node], sorted((edge, *sorted((int(room[a]), int(room[b])))) for edge, a, b in pairs)


def at_input(working: Ints, factor: int, free: Bits) -> Ints:
    """Labels of the working grid at the input's resolution, on its free cells."""
    fine = working.repeat(factor, axis=0).repeat(factor, axis=1) if factor > 1 else working
    return np.where(free, fine[: free.shape[0], : free.shape[1]], 0).astype(np.int32)


def flooded(labels: Ints, free: Bits) -> Ints:
    """Every free cell that a label reaches through free cells takes the nearest one by walking, the lower at a tie."""
    width = labels.shape[1] + 2
    flat = np.pad(labels, 1).reshape(-1)
    todo = np.pad(free, 1).reshape(-1) & (flat == 0)
    steps = np.array([-width, -1, 1, width])
    pending = np.flatnonzero(todo)
    edge = (pending[:, None] + steps).ravel()
    front = np.unique(edge[flat[edge] > 0])
    while len(front):
        target = (front[:, None] + steps).ravel()
        label = np.repeat(flat[front], len(steps))
        fresh = todo[target]
        target, label = target[fresh], label[fresh]
        order = np.lexsort((label, target))
        target, label = target[order], label[order]
        first = np.append(True, target[1:] != target[:-1])[: len(target)]
        front = target[first]
        flat[front] = label[first]
        todo[front] = False
    return flat.reshape(labels.shape[0] + 2, width)[1:-1, 1:-1].copy()


def numbered(labels: Ints, rooms: int) -> tuple[Ints, Ints]:
    """Labels renumbered 1, 2, ... in reading order of their first cells; and the new number (rooms + 1,) of each old.

    Rooms without a free cell of the input (they lay on removed islands) get 0.
    """
    present = runs_of(labels).label
    order = present[np.sort(np.unique(present, return_index=True)[1])]
    number = np.zeros(rooms + 1, np.int32)
    number[order] = np.arange(1, len(order) + 1)
    return number[labels], number


def door_rows(initial: InitialMap, rows: list[tuple[int, int, int]], number: Ints) -> Doors:
    """The doors of rows of edge and two rooms; `number` says what each room is called."""
    edge, a, b = np.array(rows, np.int32).reshape(-1, 3).T
    room_a, room_b = np.sort([number[a], number[b]], axis=0)
    real = room_a > 0
    edge = edge[real]
    return Doors(
        edge, initial.frame.world_from_cell(initial.start[edge]), initial.frame.world_from_cell(initial.end[edge]),
        initial.kind[edge], initial.length_m[edge], initial.width_m[edge], initial.tilt_rad[edge],
        room_a[real], room_b[real],
    )


def contacts(labels: Ints) -> tuple[Floats, Ints]:
    """Where cells of two rooms touch: middles (k, 2) as row, col, and the two rooms (k, 2), the lower first."""
    places, pairs = [], []
    for step in ((0, 1), (1, 0)):
        one = labels[: labels.shape[0] - step[0], : labels.shape[1] - step[1]]
        other = labels[step[0] :, step[1] :]
        row, col = np.nonzero((one != other) & (one > 0) & (other > 0))
        places.append(np.stack([row, col], axis=1) + np.array(step) / 2)
        pairs.append(np.sort(np.stack([one[row, col], other[row, col]], axis=1), axis=1))
    return np.concatenate(places), np.concatenate(pairs)


def narrow_passages(labels: Ints, doors: Doors, simplified: SimplifiedGrid, frame: Frame) -> Doors:
    """Doors for contacts that no door explains: openings of the input too narrow for the working resolution."""
    place, pair = contacts(labels)
    cell_m = simplified.frame.resolution_m
    place_m = frame.world_from_cell(place)
    explained = np.zeros(len(place), np.bool_)
    tree = cKDTree(place_m)
    for row in range(len(doors.edge)):
        middle_m = (doors.start_m[row] + doors.end_m[row]) / 2
        near = np.array(tree.query_ball_point(middle_m, doors.length_m[row] / 2 + 2 * cell_m), np.intp)
        near = near[(pair[near] == [doors.room_a[row], doors.room_b[row]]).all(axis=1)]
        explained[near[_to_segment_m(place_m[near], doors.start_m[row], doors.end_m[row]) <= cell_m]] = True
    start, end, rooms = [], [], []
    for contact in _pieces(place, pair):
        if not explained[contact].any():
            apart = np.hypot(*(place[contact][:, None] - place[contact][None, :]).T)
            a, b = np.unravel_index(np.argmax(apart), apart.shape)
            start.append(place[contact[a]])
            end.append(place[contact[b]])
            rooms.append(pair[contact[0]])
    count = len(rooms)
    start_cell, end_cell = np.array(start).reshape(-1, 2), np.array(end).reshape(-1, 2)
    span = np.abs(end_cell - start_cell)
    gap_m = (np.hypot(*span.T) + 1) * frame.resolution_m
    joined = np.array(rooms, np.int32).reshape(-1, 2)
    return Doors(
        np.full(count, -1, np.int32), frame.world_from_cell(start_cell), frame.world_from_cell(end_cell),
        np.full(count, KINDS.index("passage"), np.uint8), gap_m, gap_m, np.arctan2(span.min(axis=1), span.max(axis=1)), joined[:, 0], joined[:, 1],
    )


def _to_segment_m(point_m: Floats, start_m: Floats, end_m: Floats) -> Floats:
    """Distance (k,) of points (k, 2) to a segment."""
    along = end_m - start_m
    share = np.clip((point_m - start_m) @ along / max(float(along @ along), 1e-12), 0, 1)
    return np.asarray(np.hypot(*(point_m - start_m - share[:, None] * along).T))


def _pieces(place: Floats, pair: Ints) -> list[NDArray[np.intp]]:
    """Indices of contacts between the same two rooms that hang together, piece by piece."""
    if not len(place):
        return []
    links = cKDTree(place).query_pairs(1.0, output_type="ndarray")
    links = links[(pair[links[:, 0]] == pair[links[:, 1]]).all(axis=1)]
    piece = components(links.T, len(place))
    return np.split(np.argsort(piece, kind="stable"), np.cumsum(np.bincount(piece))[:-1])
