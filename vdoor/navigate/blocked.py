"""What the robot must not touch: walls, and what people and the map's file rule out."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import skimage
from numpy.typing import NDArray

from vdoor.frame import Frame
from vdoor.grid import Annotations, Line, OccupancyGrid
from vdoor.method.final_doors import to_segment_m
from vdoor.raster.components import contacts
from vdoor.raster.strips import near_segments
from vdoor.topology import TopologicalMap

Mask = NDArray[np.bool_]
Ints = NDArray[np.int32]
Floats = NDArray[np.float64]

TOUCH = 1e-6
"""A line touches the cells nearer than this, in cells."""


@dataclass(frozen=True, kw_only=True)
class Restrictions:
    """What is ruled out besides walls."""

    annotations: Annotations | None = None
    """Virtual walls and no-go areas of the map's file."""
    closed_doors: Sequence[int] = ()
    """Ids of doors that are shut: the cells on both sides of where their rooms touch."""
    avoided_rooms: Sequence[int] = ()
    """Ids of rooms not to enter: all of their cells."""
    mops: bool = False
    """Whether the robot mops, so that no-mop areas are ruled out too."""


def blocked_cells(grid: OccupancyGrid, topology: TopologicalMap, restrictions: Restrictions | None = None) -> Mask:
    """The cells (h, w) that the robot must not touch: all that are not free, unknown ones too, and what is ruled out.

    A wall that an edit opened as a closed door is free. Raises `SettingError` for a door that the map does not have.
    """
    wanted = restrictions or Restrictions()
    blocked = ~(grid.free | (topology.labels > 0))
    if wanted.annotations is not None:
        blocked |= ruled_out(grid.frame, wanted.annotations, mops=wanted.mops)
    if wanted.avoided_rooms:
        blocked |= np.isin(topology.labels, [topology.room(room).id for room in wanted.avoided_rooms])
    if wanted.closed_doors:
        rows = [topology.door(door).id - 1 for door in wanted.closed_doors]
        place, owner = door_contacts(topology)
        beside = place[np.isin(owner, rows)]
        for cell in (np.floor(beside), np.ceil(beside)):
            blocked[tuple(cell.astype(np.intp).T)] = True
    return blocked


def ruled_out(frame: Frame, annotations: Annotations, *, mops: bool) -> Mask:
    """The cells (h, w) touched by virtual walls and no-go areas, and by no-mop areas if the robot mops."""
    areas = (*annotations.no_go_areas_m, *(annotations.no_mop_areas_m if mops else ()))
    out = np.zeros((frame.height, frame.width), np.bool_)
    for area in areas:
        row, col = frame.cell_from_world(np.array(area)).T
        out[skimage.draw.polygon(row, col, out.shape)] = True
    for start, end in _sides(frame, annotations.virtual_walls_m, areas):
        for row, columns in _touched(start, end, out.shape):
            out[row, columns] = True
    return out


def _sides(frame: Frame, walls: Iterable[Line], areas: Iterable[Line]) -> Iterator[tuple[Floats, Floats]]:
    """The sides of walls and areas, their ends as row, col."""
    for line in (*walls, *((*area, area[0]) for area in areas)):
        yield from pairwise(frame.cell_from_world(np.array(line)))


def _touched(start: Floats, end: Floats, shape: tuple[int, int]) -> Iterator[tuple[int, slice]]:
    """The row and the columns of the cells of a raster that a segment touches."""
    first, begin, stop = near_segments(start[None], end[None], TOUCH)
    for row, (left, right) in enumerate(zip(begin[0].tolist(), stop[0].tolist(), strict=True), start=int(first[0, 0])):
        if 0 <= row < shape[0]:
            yield row, slice(max(left, 0), max(right, 0))


def door_contacts(topology: TopologicalMap) -> tuple[Floats, Ints]:
    """Where rooms touch: the midpoints (k, 2), as row, col, of cell sides, and the row of the door (k,) of each.

    The door is the nearest one between the same two rooms; -1 if there is none.
    """
    place, pair = contacts(topology.labels)
    owner = np.full(len(place), -1, np.int32)
    nearest = np.full(len(place), np.inf)
    start, end = (topology.frame.cell_from_world(points_m) for points_m in (topology.start_m, topology.end_m))
    key = pair[:, 0].astype(np.int64) << 32 | pair[:, 1]
    order = np.argsort(key, kind="stable")
    wanted = topology.room_a.astype(np.int64) << 32 | topology.room_b
    first, last = (np.searchsorted(key[order], wanted, side) for side in ("left", "right"))
    for row in range(len(wanted)):
        own = order[first[row] : last[row]]
        apart = to_segment_m(place[own], start[row], end[row])
        nearer = own[apart < nearest[own]]
        nearest[nearer] = apart[apart < nearest[own]]
        owner[nearer] = row
    return place, owner
