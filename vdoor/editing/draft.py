"""A finished map being edited: rooms under fixed keys, with their ids and names, and the doors between them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import scipy
from numpy.typing import NDArray

from vdoor.editing.split_room import borders, clipped, parts, prolonged, room_of_line
from vdoor.frame import Frame
from vdoor.method.final_doors import doors_along, to_segment_m
from vdoor.method.finished import Doors, Features, map_of
from vdoor.raster.components import contacts
from vdoor.topology import TopologicalMap

Floats = NDArray[np.float64]
Ints = NDArray[np.int32]
Box = tuple[slice, slice]

HALF = 0.5
LEAST_M2 = 0.25
"""Smallest area of a room created by a cut."""


class Draft:
    """Rooms and doors being edited; the ends of lines are row, col (2,)."""

    def __init__(self, topology: TopologicalMap, *, taken: int) -> None:
        self.labels = topology.labels
        """Room keys (h, w), initially the ids."""
        self.id_of = {room: room for room in topology.room_ids}
        """Room key -> id."""
        self.name_of = {room: name for room, name in zip(self.id_of, topology.name, strict=False) if name}
        self.doors = Doors(*(getattr(topology, column) for column in Doors._fields))
        self.frame: Frame = topology.frame
        self._features = Features(
            topology.feature_room, topology.feature_corner, topology.feature_convex, topology.feature_m
        )
        self._taken = taken
        self._last_key = max(self.id_of, default=0)

    def number(self, room: int, number: int) -> None:
        """Give a room an id; a room that already has it gets this room's id instead."""
        other = next((key for key, own in self.id_of.items() if own == number), None)
        if other is not None:
            self.id_of[other] = self.id_of[room]
        self.id_of[room] = number

    def touch(self, one: int, other: int) -> bool:
        """Whether two rooms touch, that is, have a door between them."""
        a, b = self.doors.room_a, self.doors.room_b
        return bool((((a == one) & (b == other)) | ((a == other) & (b == one))).any())

    def merge(self, one: int, other: int) -> None:
        """Merge the second of two touching rooms into the first; doors between them are removed."""
        box = _box(self.labels == other)
        self._write(box, np.where(self.labels[box] == other, one, self.labels[box]))
        columns = {name: np.where(getattr(self.doors, name) == other, one, getattr(self.doors, name)) for name in ROOMS}
        a, b = np.sort([columns["room_a"], columns["room_b"]], axis=0)
        self.doors = _without_doubles(self.doors._replace(room_a=a, room_b=b), keep=a != b)
        self._features = _joined(self._features, one, other)
        del self.id_of[other]
        self.name_of.pop(other, None)

    def split(self, start: Floats, end: Floats, *, reach: float, gap: float) -> list[int]:
        """Cut the room that contains most of a line; returns the resulting rooms, the largest first.

        These are the room alone if the line does not separate it, and none if the line is in no room. The line is
        extended by at most `reach` cells. If that does not separate the room, it is also extended across obstacles up
        to `gap` cells wide, unless it runs along another room, as at an earlier cut.
        """
        start, end = clipped(start, end, self.labels.shape)
        room = room_of_line(self.labels, start, end)
        if not room:
            return []
        box = _box(self.labels == room)
        corner = np.array([side.start for side in box])
        before = self.labels[box].copy()
        own = before == room
        least = LEAST_M2 / self.frame.resolution_m**2
        cells = prolonged(own, start - corner, end - corner, reach=reach)
        part, count = parts(own, cells, least)
        if count == 1 and gap and borders(before, cells).mean() < HALF:
            part, count = parts(own, prolonged(own, start - corner, end - corner, reach=reach, gap=gap), least)
        if count < 2:  # noqa: PLR2004  # the room stays whole
            return [room]
        keys = [room, *(self._new() for _ in range(count - 1))]
        after = np.where(own, np.array([0, *keys], np.int32)[part], before)
        self._write(box, after)
        self._split_doors(room, before, box, (start, end))
        self._split_features(room, own, after, corner)
        return keys

    def _new(self) -> int:
        """The key of a new room, whose id is above all others."""
        self._last_key += 1  # never a removed room's key, which earlier edits may refer to
        self.id_of[self._last_key] = max(self._taken, *self.id_of.values()) + 1
        return self._last_key

    def _write(self, box: Box, labels: Ints) -> None:
        self.labels = self.labels.copy() if not self.labels.flags.writeable else self.labels
        self.labels[box] = labels

    def _split_doors(self, room: int, before: Ints, box: Box, line: tuple[Floats, Floats]) -> None:
        """Assign the doors of a room that was cut to its parts, and add doors along the cut."""
        outer: Any = tuple(slice(max(side.start - 1, 0), side.stop + 1) for side in box)
        low = np.array([side.start for side in outer])
        after = self.labels[outer]
        old = after.copy()
        top, left = (np.array([side.start for side in box]) - low).tolist()
        old[top : top + before.shape[0], left : left + before.shape[1]] = before
        place, was = contacts(old)
        own = (was == room).any(axis=1)
        now = np.sort(_sides(after, place[own]), axis=0).T
        rows = self._rows_beside(room, self.frame.world_from_cell(place[own] + low), was[own], now)
        place, pair = contacts(after)
        inner = (_sides(old, place) == room).all(axis=0)
        self.doors = rows.followed_by(doors_along(*line, place[inner] + low, pair[inner], self.frame))

    def _rows_beside(self, room: int, at_m: Floats, was: Ints, now: Ints) -> Doors:
        """All doors; those of `room` get one row for each pair of rooms that now touch at the door."""
        found: list[tuple[int, int, int]] = []
        beside: dict[int, NDArray[np.bool_]] = {}
        nearest, distance_m = np.full(len(at_m), -1), np.full(len(at_m), np.inf)
        for row, (a, b) in enumerate(zip(self.doors.room_a.tolist(), self.doors.room_b.tolist(), strict=True)):
            if room not in (a, b):
                found.append((row, a, b))
                continue
            apart_m = to_segment_m(at_m, self.doors.start_m[row], self.doors.end_m[row])
            apart_m[(was != [a, b]).any(axis=1)] = np.inf
            closer = apart_m < distance_m
            nearest[closer], distance_m[closer] = row, apart_m[closer]
            beside[row] = np.isfinite(apart_m) & (apart_m == apart_m.min(initial=np.inf))
        for row, closest in beside.items():  # two doors at the same position are both kept
            own = (nearest == row) | closest
            found += [(row, a, b) for a, b in np.unique(now[own], axis=0).tolist()]
        rows, room_a, room_b = np.array(sorted(found), np.int32).reshape(-1, 3).T
        columns: list[Any] = [column[rows] for column in self.doors]
        return Doors(*columns)._replace(room_a=room_a, room_b=room_b)

    def _split_features(self, room: int, own: NDArray[np.bool_], after: Ints, corner: NDArray[np.intp]) -> None:
        """Assign the corners of a room that was cut to the nearest of its parts."""
        rows = np.flatnonzero(self._features.room == room)
        if not len(rows):
            return
        cells = np.argwhere(own)
        place = self.frame.cell_from_world(self._features.point_m[rows]) - corner
        _, nearest = scipy.spatial.cKDTree(cells).query(place)
        numbers = self._features.room.copy()
        numbers[rows] = after[tuple(cells[nearest].T)]
        self._features = self._features._replace(room=numbers)

    def finished(self) -> TopologicalMap:
        """The topological map of the draft's current state."""
        keys = np.array([0, *sorted(self.id_of)], np.int32)
        ids = np.array([0, *(self.id_of[key] for key in keys[1:].tolist())], np.int32)

        def numbered(values: Ints) -> Ints:
            return values if (keys == ids).all() else ids[np.searchsorted(keys, values)]

        room_a, room_b = np.sort([numbered(self.doors.room_a), numbered(self.doors.room_b)], axis=0)
        names = {self.id_of[key]: name for key, name in self.name_of.items()}
        features = _by_room(self._features._replace(room=numbered(self._features.room)))
        doors = self.doors._replace(room_a=room_a, room_b=room_b)
        return map_of(numbered(self.labels), self.frame, doors, features, names)


ROOMS = ("room_a", "room_b")


def _sides(labels: Ints, place: Floats) -> Ints:
    """The labels (2, k) of the two cells that touch at contacts (k, 2)."""
    return np.stack([labels[tuple(cell.astype(np.intp).T)] for cell in (np.floor(place), np.ceil(place))])


def _box(mask: NDArray[np.bool_]) -> Box:
    """The bounding box of a mask."""
    rows, cols = (np.flatnonzero(mask.any(axis=axis)) for axis in (1, 0))
    return slice(int(rows[0]), int(rows[-1]) + 1), slice(int(cols[0]), int(cols[-1]) + 1)


def _without_doubles(doors: Doors, *, keep: NDArray[np.bool_]) -> Doors:
    """The doors to keep, each once: two rows of a door that bordered three rooms may have become equal."""
    keys: Sequence[Any] = [*doors.start_m.T, *doors.end_m.T, doors.room_a, doors.room_b]
    _, first = np.unique(np.stack(keys, axis=1), axis=0, return_index=True)
    rows = np.intersect1d(np.flatnonzero(keep), first)
    columns: list[Any] = [column[rows] for column in doors]
    return Doors(*columns)


def _joined(features: Features, one: int, other: int) -> Features:
    """The corners after merging room `other` into `one`; a corner that both rooms have is kept once."""
    keys = np.stack([*features.point_m.T, features.convex], axis=1)
    own = set(map(tuple, keys[features.room == one].tolist()))
    taken = np.flatnonzero(features.room == other)
    double = [row for row, key in zip(taken.tolist(), map(tuple, keys[taken].tolist()), strict=True) if key in own]
    room = np.where(features.room == other, one, features.room)
    columns: list[Any] = [np.delete(column, double, axis=0) for column in features._replace(room=room)]
    return Features(*columns)


def _by_room(features: Features) -> Features:
    """The corners sorted by room, then by corner."""
    order = np.lexsort((features.corner, features.room))
    columns: list[Any] = [column[order] for column in features]
    return Features(*columns)
