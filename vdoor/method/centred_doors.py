"""Doors in a short passage are put in its middle.

A passage that is deeper than a wall, such as a doorway between cupboards or a lobby, has a face at each end, and the
door may hang in either. Its middle is the line that is nearest to both.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import numpy as np
from numpy.typing import NDArray

from vdoor.method.initial_map import InitialMap
from vdoor.method.moved_doors import Ends, Row, move_doors

Ints = NDArray[np.int32]
Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]

WALL_M = 0.5
"""Openings up to this deep go through a wall, and their doors stay."""
STRAIGHT_M = 0.11
"""A passage ends where one of its walls steps back or forth by more than this, or by a cell."""


def set_in_middle(
    free: Mask, initial: InitialMap, labels: Ints, rows: list[Row], *, most_m: float
) -> tuple[InitialMap, Ints]:
    """The initial map with its kept doors in the middle of passages up to `most_m` deep, and the rooms (h, w).

    See `move_doors`.
    """
    cell_m = initial.frame.resolution_m
    lines = partial(in_middle, wall=WALL_M / cell_m, most=most_m / cell_m, step=max(STRAIGHT_M / cell_m, 1.0))
    return move_doors(free, initial, labels, rows, reach=int(most_m / cell_m) + 1, lines=lines)


def in_middle(free: Mask, old: Ends, *, wall: float, most: float, step: float) -> Iterator[Ends]:
    """The line across the middle of the passage in which a door lies, if the passage is between `wall` and `most` deep.

    All in cells.
    """
    along = (old.end - old.start).astype(np.float64)
    length = float(np.hypot(*along))
    along /= length
    across = np.array([along[1], -along[0]])
    middle = (old.start + old.end) / 2
    shift = np.arange(-int(most) - 1, int(most) + 2)
    places = middle + shift[:, None] * across
    reach = length / 2 + step + 1
    sides = np.stack([_free_run(free, places, -along, reach), _free_run(free, places, along, reach)])
    at = len(shift) // 2
    like: Mask = np.all(np.abs(sides - sides[:, at, None]) <= step, axis=0)
    like[[0, -1]] = False
    back, on = int(np.argmin(like[at::-1])) - 1, int(np.argmin(like[at:])) - 1
    to = round((on - back) / 2)
    if not to or not wall < back + on < most:
        return
    before, after = sides[:, at + to]
    yield Ends(*(np.rint(places[at + to] + way * along).astype(np.int32) for way in (-before, after)))


def _free_run(free: Mask, places: Floats, way: Floats, reach: float) -> Floats:
    """The way (k,) in cells, in half ones, from each of some places (k, 2) to the first cell that is not free."""
    steps = np.arange(0, reach, 0.5)
    cell = np.rint(places[:, None] + steps[:, None] * way).astype(np.intp) + 1
    around = np.pad(free, 1)
    blocked = ~around[tuple(np.minimum(np.maximum(cell[..., axis], 0), around.shape[axis] - 1) for axis in (0, 1))]
    blocked[:, -1] = True
    return np.asarray(steps[np.argmax(blocked, axis=1)])
