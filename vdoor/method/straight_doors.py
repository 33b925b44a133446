"""Doors that lie askew across an opening are set straight."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import numpy as np
from numpy.typing import NDArray

from vdoor.method.initial_map import InitialMap
from vdoor.method.moved_doors import Ends, Row, move_doors
from vdoor.raster.lines import lines_between
from vdoor.raster.morphology import labelled, with_neighbours

Ints = NDArray[np.int32]
Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]

MOST_ASKEW_RAD = np.radians(30.0)
"""A door further than this from the map's walls lies across a corner on purpose, or beside slanted walls."""
MOVE_WORTH = 0.25
"""Cells by which a door must become shorter or squarer for each cell that its ends move."""
TRIED = 8
"""Number of lines that are tried for a door, best first."""


def set_straight(
    free: Mask, initial: InitialMap, labels: Ints, rows: list[Row], *, reach_m: float, wall_rad: float
) -> tuple[InitialMap, Ints]:
    """The initial map with its kept doors set straight, and the rooms (h, w), as `move_doors`.

    An end moves by at most `reach_m` along its wall. The door becomes squarer to the map's walls (`wall_rad`, as from
    `wall_direction_rad`) and no longer.
    """
    reach = int(reach_m / initial.frame.resolution_m + 1e-6)
    lines = partial(straighter, reach=reach, wall_rad=wall_rad)
    return move_doors(free, initial, labels, rows, reach=reach, lines=lines)


def askew_rad(span: Ints, wall_rad: float) -> Floats:
    """Angles (k,) between spans (k, 2), as row and col, and the nearer direction of the walls."""
    angle = np.arctan2(span[:, 0], span[:, 1]) - wall_rad
    return np.asarray(np.abs((angle + np.pi / 4) % (np.pi / 2) - np.pi / 4))


def straighter(free: Mask, old: Ends, *, reach: int, wall_rad: float) -> Iterator[Ends]:
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
