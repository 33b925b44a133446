"""Doors that lie askew across an opening are set straight, and their rooms follow."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from vdoor.method.doors import measures
from vdoor.method.initial_map import InitialMap
from vdoor.raster.lines import lines_between
from vdoor.raster.morphology import labelled, with_neighbours

Ints = NDArray[np.int32]
Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]
Row = tuple[int, int, int]
"""A kept edge, and the two rooms that it joins."""

MOST_ASKEW_RAD = np.radians(30.0)
"""A door further than this from the map's walls lies across a corner on purpose, or beside slanted walls."""
MOVE_WORTH = 0.25
"""Cells by which a door must become shorter or squarer for each cell that its ends move."""
MARGIN = 3
"""Cells around the ends and their reach that must stay as they are."""
TRIED = 8
"""Number of lines that are tried for a door, best first."""


class Ends(NamedTuple):
    """The obstacle cells (2,) at which a door ends."""

    start: Ints
    end: Ints


def set_straight(
    free: Mask, initial: InitialMap, labels: Ints, rows: list[Row], *, reach_m: float, wall_rad: float
) -> tuple[InitialMap, Ints]:
    """The initial map with its kept doors set straight, and the rooms (h, w) with the cells that change sides.

    An end moves by at most `reach_m` along its wall. The door becomes squarer to the map's walls (`wall_rad`, as from
    `wall_direction_rad`) and no longer, and parts the same two rooms. `labels` are those of the working grid, 0 on kept
    doors. Doors that share cells with others, or join more than two rooms, stay.
    """
    start, end, labels = initial.start.copy(), initial.end.copy(), labels.copy()
    reach = int(reach_m / initial.frame.resolution_m + 1e-6)
    for edge, *rooms in _alone(free, initial, rows):
        low, window = _window(start[edge], end[edge], reach, free.shape)
        old = Ends(start[edge] - low, end[edge] - low)
        for new in _straighter(free[window], old, reach, wall_rad):
            if _moved(free[window], labels[window], (rooms[0], rooms[1]), old, new):
                start[edge], end[edge] = new.start + low, new.end + low
                break
    length_m, width_m, tilt_rad = measures(start, end, initial.frame.resolution_m)
    moved = dataclasses.replace(initial, start=start, end=end, length_m=length_m, width_m=width_m, tilt_rad=tilt_rad)
    return moved, labels


def askew_rad(span: Ints, wall_rad: float) -> Floats:
    """Angles (k,) between spans (k, 2), as row and col, and the nearer direction of the walls."""
    angle = np.arctan2(span[:, 0], span[:, 1]) - wall_rad
    return np.asarray(np.abs((angle + np.pi / 4) % (np.pi / 2) - np.pi / 4))


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


def _straighter(free: Mask, old: Ends, reach: int, wall_rad: float) -> Iterator[Ends]:
    """Lines that are squarer to the walls and no longer, through free cells alone, best first."""
    starts, ends = (_along_wall(free, cell, reach) for cell in old)
    start, end = starts.repeat(len(ends), axis=0), np.tile(ends, (len(starts), 1))
    askew, length = askew_rad(end - start, wall_rad), np.hypot(*(end - start).T)
    before, before_length = askew_rad((old.end - old.start)[None], wall_rad)[0], np.hypot(*(old.end - old.start))
    if before > MOST_ASKEW_RAD:
        return
    cost = length + length * np.sin(askew)
    move = np.hypot(*(start - old.start).T) + np.hypot(*(end - old.end).T)
    better = (askew < before - 1e-9) & (length <= before_length + 1e-9)
    better &= cost + MOVE_WORTH * move < before_length * (1 + np.sin(before)) - 1e-9
    rows = np.flatnonzero(better)
    rows = rows[lines_between(free, start[rows], end[rows])[0]]
    order = np.lexsort((move[rows], (cost + MOVE_WORTH * move)[rows].round(6)))
    for row in rows[order][:TRIED]:
        yield Ends(start[row], end[row])


def _along_wall(free: Mask, cell: Ints, reach: int) -> Ints:
    """The obstacle cells (k, 2) at the border of free space that are joined to `cell` within `reach`."""
    around = np.pad(free, 1)  # a door may end one cell outside the map
    row, col = np.ogrid[: around.shape[0], : around.shape[1]]
    near = (row - 1 - cell[0]) ** 2 + (col - 1 - cell[1]) ** 2 <= reach**2
    wall = labelled(~around & with_neighbours(around) & near, 2)
    own = wall[cell[0] + 1, cell[1] + 1]
    return (np.argwhere(wall == own) - 1).astype(np.int32) if own else cell[None]


def _moved(free: Mask, room: Ints, rooms: tuple[int, int], old: Ends, new: Ends) -> bool:
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
