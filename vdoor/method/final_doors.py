"""The doors of the final map: kept edges, and passages too narrow for the working resolution."""

from __future__ import annotations

from typing import Any

import numpy as np
import scipy
from numpy.typing import NDArray

from vdoor.frame import Frame
from vdoor.grid import FREE
from vdoor.method.finished import Doors
from vdoor.method.initial_map import InitialMap
from vdoor.method.simplify import REASONS, SimplifiedGrid
from vdoor.raster.components import contact_pieces, contacts
from vdoor.raster.lines import lines_between
from vdoor.raster.morphology import with_neighbours
from vdoor.topology import KINDS

Floats = NDArray[np.float64]
Ints = NDArray[np.int32]
Mask = NDArray[np.bool_]

SILL = np.uint8(KINDS.index("sill"))


def door_rows(initial: InitialMap, rows: list[tuple[int, int, int]], number: Ints) -> Doors:
    """The doors of rows (edge, room, room); `number` maps these rooms to the final ids, 0 for rooms that are gone."""
    edge, a, b = np.array(rows, np.int32).reshape(-1, 3).T
    room_a, room_b = np.sort([number[a], number[b]], axis=0)
    real = room_a > 0
    edge = edge[real]
    return Doors(
        edge,
        initial.frame.world_from_cell(initial.start[edge]),
        initial.frame.world_from_cell(initial.end[edge]),
        initial.kind[edge],
        initial.length_m[edge],
        initial.width_m[edge],
        initial.tilt_rad[edge],
        room_a[real],
        room_b[real],
    )


def on_sill(doors: Doors, initial: InitialMap, simplified: SimplifiedGrid) -> Mask:
    """Which doors (k,) have most of their cells on or beside sills that the input does not show."""
    sill = with_neighbours(simplified.reason == REASONS.index("sill"))
    start, end = initial.start[doors.edge], initial.end[doors.edge]
    _, cell, owner = lines_between(simplified.cells == FREE, start, end)
    on = np.bincount(owner, weights=sill[cell[:, 0], cell[:, 1]], minlength=len(doors.edge))
    return np.asarray(2 * on > np.bincount(owner, minlength=len(doors.edge)))


def matched_to_contacts(labels: Ints, doors: Doors, simplified: SimplifiedGrid, frame: Frame) -> Doors:
    """The doors at which their rooms touch, and a passage for each piece of contact without a door.

    A passage is an opening of the input that is too narrow for the working resolution. A door is dropped if its rooms
    do not touch within a working cell of it: it is on cells that only flattening made free. Contacts nearby become
    passages.
    """
    place, pair = contacts(labels)
    cell_m = simplified.frame.resolution_m
    place_m = frame.world_from_cell(place)
    explained = np.zeros(len(place), np.bool_)
    touched = np.zeros(len(doors.edge), np.bool_)
    tree = scipy.spatial.cKDTree(place_m)
    for row in range(len(doors.edge)):
        middle_m = (doors.start_m[row] + doors.end_m[row]) / 2
        near = np.array(tree.query_ball_point(middle_m, doors.length_m[row] / 2 + 2 * cell_m), np.intp)
        near = near[(pair[near] == [doors.room_a[row], doors.room_b[row]]).all(axis=1)]
        near = near[to_segment_m(place_m[near], doors.start_m[row], doors.end_m[row]) <= cell_m]
        explained[near] = True
        touched[row] = len(near) > 0
    passages = passages_at(place[~explained], pair[~explained], frame)
    columns: list[Any] = [column[touched] for column in doors]
    return Doors(*columns).followed_by(passages)


def passages_at(place: Floats, pair: Ints, frame: Frame) -> Doors:
    """A passage for each connected piece of contacts (k, 2), as row, col, between the same two rooms."""
    start, end, rooms = [], [], []
    for contact in _pieces(place, pair):
        one = _farthest(place[contact], place[contact[0]])
        start.append(one)
        end.append(_farthest(place[contact], one))
        rooms.append(pair[contact[0]])
    count = len(rooms)
    start_cell, end_cell = np.array(start).reshape(-1, 2), np.array(end).reshape(-1, 2)
    span = np.abs(end_cell - start_cell)
    gap_m = (np.hypot(*span.T) + 1) * frame.resolution_m
    joined = np.array(rooms, np.int32).reshape(-1, 2)
    return Doors(
        np.full(count, -1, np.int32),
        frame.world_from_cell(start_cell),
        frame.world_from_cell(end_cell),
        np.full(count, KINDS.index("passage"), np.uint8),
        gap_m,
        gap_m,
        np.arctan2(span.min(axis=1), span.max(axis=1)),
        joined[:, 0],
        joined[:, 1],
    )


def doors_along(start: Floats, end: Floats, place: Floats, pair: Ints, frame: Frame) -> Doors:
    """A door along a line for each connected piece of contacts (k, 2) beside it; the line and contacts as row, col.

    The doors have the line's direction and are in the middle of their contacts. Contacts more than a cell away from
    that, as in a nook cut off by the line, get doors of their own.
    """
    doors = passages_at(place, pair, frame)
    way = (end - start) / max(float(np.hypot(*(end - start))), 1e-9)
    aside = np.array([-way[1], way[0]])
    spans, astray = [], np.zeros(len(place), np.bool_)
    for contact in _pieces(place, pair):
        along, apart = (place[contact] - start) @ way, (place[contact] - start) @ aside
        spans.append([along.min(), along.max(), (apart.min() + apart.max()) / 2])
        astray[contact] = np.abs(apart - spans[-1][-1]) > 1
    first, last, off = np.array(spans).reshape(-1, 3).T[:, :, None]
    gap_m = (last - first + 1).ravel() * frame.resolution_m
    tilt_rad = np.full(len(gap_m), np.arctan2(*np.sort(np.abs(way))))
    doors = doors._replace(
        start_m=frame.world_from_cell(start + first * way + off * aside),
        end_m=frame.world_from_cell(start + last * way + off * aside),
        length_m=gap_m,
        width_m=gap_m,
        tilt_rad=tilt_rad,
    )
    doors = doors.followed_by(passages_at(place[astray], pair[astray], frame))
    return doors._replace(kind=np.full_like(doors.kind, KINDS.index("added")))


def _farthest(place: Floats, point: Floats) -> Floats:
    """The one (2,) of the points (k, 2) that is farthest from `point`."""
    return np.asarray(place[np.argmax(np.hypot(*(place - point).T))])


def to_segment_m(point_m: Floats, start_m: Floats, end_m: Floats) -> Floats:
    """Distances (k,) in metres of points (k, 2) to a segment."""
    along = end_m - start_m
    share = np.clip((point_m - start_m) @ along / max(float(along @ along), 1e-12), 0, 1)
    return np.asarray(np.hypot(*(point_m - start_m - share[:, None] * along).T))


def _pieces(place: Floats, pair: Ints) -> list[NDArray[np.intp]]:
    """The indices of contacts, for each connected piece between the same two rooms."""
    if not len(place):
        return []
    piece = contact_pieces(place, pair, 1.0)
    return np.split(np.argsort(piece, kind="stable"), np.cumsum(np.bincount(piece))[:-1])
