"""Doors of the final map are moved along their walls, and their rooms follow."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from vdoor.method.doors import measures
from vdoor.method.initial_map import InitialMap
from vdoor.raster.lines import lines_between
from vdoor.raster.morphology import labelled, with_neighbours

Ints = NDArray[np.int32]
Mask = NDArray[np.bool_]
Row = tuple[int, int, int]
"""A kept edge, and the two rooms that it joins."""

MARGIN = 3
"""Cells around the ends and their reach that must stay as they are."""


class Ends(NamedTuple):
    """The obstacle cells (2,) at which a door ends."""

    start: Ints
    end: Ints


Lines = Callable[[Mask, Ends], Iterable[Ends]]
"""The lines to which a door may move, best first: in a part of the map, by where the door lies in it."""


def move_doors(
    free: Mask, initial: InitialMap, labels: Ints, rows: list[Row], *, reach: int, lines: Lines
) -> tuple[InitialMap, Ints]:
    """The initial map with its kept doors moved, and the rooms (h, w) with the cells that change sides.

    Each goes to the first of `lines`, at most `reach` cells away, that parts the same two rooms. `labels` are those of
    the working grid, 0 on kept doors. Doors that share cells with others, or join more than two rooms, stay.
    """
    start, end, labels = initial.start.copy(), initial.end.copy(), labels.copy()
    for edge, *rooms in _alone(free, initial, rows):
        low, window = _window(start[edge], end[edge], reach, free.shape)
        old = Ends(start[edge] - low, end[edge] - low)
        for new in lines(free[window], old):
            if moved(free[window], labels[window], (rooms[0], rooms[1]), old, new):
                start[edge], end[edge] = new.start + low, new.end + low
                break
    length_m, width_m, tilt_rad = measures(start, end, initial.frame.resolution_m)
    changed = dataclasses.replace(initial, start=start, end=end, length_m=length_m, width_m=width_m, tilt_rad=tilt_rad)
    return changed, labels


def _alone(free: Mask, initial: InitialMap, rows: list[Row]) -> list[Row]:
    """The rows of doors that join one pair of rooms and share no cell with another kept door."""
    edges, pairs = np.unique([edge for edge, _, _ in rows], return_counts=True)
    edges = edges.astype(np.intp)
    _, cell, owner = lines_between(free, initial.start[edges], initial.end[edges])
    _, place, lines = np.unique(cell, axis=0, return_inverse=True, return_counts=True)
    shared = np.bincount(owner, weights=lines[place.ravel()] > 1, minlength=len(edges)) > 0
    single = set(edges[(pairs == 1) & ~shared].tolist())
    return [row for row in rows if row[0] in single]


def _window(start: Ints, end: Ints, reach: int, shape: tuple[int, ...]) -> tuple[Ints, tuple[slice, slice]]:
    """The first cell (2,) of the part of the map that matters to a door, and that part."""
    low = np.maximum(np.minimum(start, end) - reach - MARGIN, 0)
    high = np.minimum(np.maximum(start, end) + reach + MARGIN + 1, shape)
    return low, (slice(low[0], high[0]), slice(low[1], high[1]))


def moved(free: Mask, room: Ints, rooms: tuple[int, int], old: Ends, new: Ends) -> bool:
    """Move the border of two rooms in `room` (h, w) to the new line if that parts them as the old one did, and say so.

    Both rooms, cut along the new line, fall into pieces, each of which goes to the room that has most of it. Nothing
    may change but between the two lines: no cell at another room or door, and none at the edge of the window.
    """
    was, now = _on_line(free, old), _on_line(free, new)
    own = free & ((room == rooms[0]) | (room == rooms[1]) | was)
    if (now & ~own).any():
        return False
    piece = labelled(own & ~now)
    cells = [np.bincount(piece[room == number], minlength=int(piece.max()) + 1) for number in rooms]
    after = np.where(cells[0] >= cells[1], *rooms)[piece].astype(np.int32)
    changed = (piece > 0) & (after != room) & ~was
    inner = np.zeros_like(changed)
    inner[1:-1, 1:-1] = True
    beside = with_neighbours(changed) & free & ~own
    both = all(((piece > 0) & (after == number)).any() for number in rooms)
    if not both or beside.any() or (changed & ~inner).any() or changed.sum() > _most_changed(old, new):
        return False
    room[piece > 0] = after[piece > 0]
    room[now] = 0
    return True


def _on_line(free: Mask, ends: Ends) -> Mask:
    """The cells (h, w) of a line."""
    _, cell, _ = lines_between(free, ends.start[None], ends.end[None])
    on = np.zeros(free.shape, np.bool_)
    on[cell[:, 0], cell[:, 1]] = True
    return on


def _most_changed(old: Ends, new: Ends) -> float:
    """Twice the cells between two lines: more means that a room would leak into the other."""
    length = np.hypot(*(old.end - old.start))
    move = max(np.hypot(*(new.start - old.start)), np.hypot(*(new.end - old.end)))
    return float(2 * (length * (move + 1)) + 4)
