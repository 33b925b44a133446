"""Doors that were closed when the map was made: finding the passage to open through the wall."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import NDArray

from vdoor.editing.places import Point
from vdoor.editing.split_room import within
from vdoor.frame import Frame

Floats = NDArray[np.float64]
Ints = NDArray[np.int32]
Mask = NDArray[np.bool_]

DOOR_M = 0.8
"""Width of the opening, or less if the wall is shorter."""
THICKEST_M = 1.0
"""Largest thickness of the wall."""
REACH_M = 0.3
"""Largest distance between the position in an edit and the wall."""
UNEVEN_M = 0.2
"""How much thicker the wall may be at the sides of the door than in its middle."""
LEAST_M2 = 0.25
"""Smallest area of free space that a door can lead to."""
WAYS = 24
"""Number of directions tried through the wall, including the grid's axes."""


@dataclass(frozen=True, eq=False)
class Opening:
    """A passage through a wall."""

    cells: Ints
    """The cells (k, 2) to become free."""
    start: Floats
    end: Floats
    """Ends of the door's line, in the middle of the wall, as row, col (2,)."""
    sides: Ints
    """A free cell on each side (2, 2)."""


def openings(free: Mask, frame: Frame, places_m: Iterable[Point]) -> list[Opening | None]:
    """For each position, the shortest straight passage through cells that are not free; None if there is none.

    A passage has free space on both sides, and the wall is at most `THICKEST_M` thick.
    """
    sides = _with_room(free, LEAST_M2 / frame.resolution_m**2) if (places_m := list(places_m)) else free
    return [_opening(sides, frame.cell_from_world(np.array([place]))[0], 1 / frame.resolution_m) for place in places_m]


def _with_room(free: Mask, least: float) -> Mask:
    """The free cells in 4-connected parts of at least `least` cells."""
    label, _ = scipy.ndimage.label(free)
    cells = np.bincount(label.ravel())
    cells[0] = 0
    return np.asarray(cells[label] >= least)


def _opening(free: Mask, place: Floats, cells_m: float) -> Opening | None:
    middle = _nearest_wall(free, place, REACH_M * cells_m)
    if middle is None:
        return None
    angle = np.arange(WAYS) * np.pi / WAYS
    ways = np.stack([np.sin(angle), np.cos(angle)], axis=1)
    through = [(_run(free, middle, way, THICKEST_M * cells_m), index) for index, way in enumerate(ways)]
    walls = [(after - before, index, before, after) for (before, after), index in through if after - before < np.inf]
    walls = [wall for wall in walls if wall[0] <= THICKEST_M * cells_m + 1]
    if not walls:
        return None
    thick, index, before, after = min(walls, key=lambda wall: (round(wall[0], 6), wall[1]))
    way = ways[index]
    sides = np.floor(middle + np.array([[before], [after]]) * way + 0.5).astype(np.int32)
    middle = middle + way * (before + after) / 2
    along = np.array([-way[1], way[0]])
    most = max(2 * thick, thick + UNEVEN_M * cells_m)
    first, last, cells = _widened(free, middle, way, most=most, half=DOOR_M * cells_m / 2)
    return Opening(cells, middle + along * first, middle + along * last, sides)


def _nearest_wall(free: Mask, place: Floats, reach: float) -> Floats | None:
    """The cell (2,), not free, nearest to a position; None if none is within reach or the position is off the map."""
    if not within(place[None], (*free.shape,))[0]:
        return None
    span = np.arange(-int(reach) - 1, int(reach) + 2)
    around = np.stack(np.meshgrid(span, span, indexing="ij"), axis=-1).reshape(-1, 2)
    cells = (np.rint(place) + around).astype(np.int32)
    cells = cells[within(cells, free.shape)]
    apart = np.hypot(*(cells - place).T)
    good = ~free[tuple(cells.T)] & (apart <= max(reach, 1.0))
    return cells[good][np.argmin(apart[good])].astype(np.float64) if good.any() else None


def _run(free: Mask, middle: Floats, way: Floats, most: float) -> tuple[float, float]:
    """Where the wall begins and ends along a direction, in cells from `middle`; infinite if beyond `most`."""
    step = np.arange(0, most + 1.5, 0.5)
    found = []
    for sign in (-1, 1):
        cells = np.floor(middle + sign * step[:, None] * way + 0.5).astype(np.int32)
        inside = within(cells, free.shape)
        inside[inside] = free[tuple(cells[inside].T)]
        found.append(sign * (step[np.argmax(inside)] if inside.any() else np.inf))
    return float(found[0]), float(found[1])


def _widened(free: Mask, middle: Floats, way: Floats, *, most: float, half: float) -> tuple[float, float, Ints]:
    """How far the passage extends to both sides along the wall, and its cells.

    It ends after `half` cells, or where the wall is thicker than `most`.
    """
    along = np.array([-way[1], way[0]])
    cells, ends = [], []
    for sign in (-1, 1):
        reached = 0.0
        for aside in np.arange(0, max(half - 0.5, 0.0) + 0.25, 0.5):
            at = middle + sign * aside * along
            before, after = _run(free, at, way, most)
            if after - before > most:
                break
            step = np.arange(before, after + 0.25, 0.5)
            cells.append(np.floor(at + step[:, None] * way + 0.5).astype(np.int32))
            reached = sign * aside
        ends.append(reached)
    found = np.unique(np.concatenate(cells), axis=0)
    found = found[within(found, free.shape)]
    return ends[0], ends[1], found[~free[tuple(found.T)]]
