"""Where a robot can stand that is asked to be at a place, or in a room."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from vdoor.errors import SettingError
from vdoor.navigate.space import EPSILON, Space
from vdoor.topology import TopologicalMap

Point = tuple[float, float]
Cell = tuple[int, int]
Box = tuple[slice, ...]


@dataclass(frozen=True)
class Standing:
    """The allowed cell for a place."""

    cell: Cell
    """Row, col."""
    place_m: Point
    """The centre of the cell, x, y."""
    moved_m: float = 0.0
    """How far that is from the place, 0 if the place is in the cell."""

    def note(self, what: str) -> str:
        """One line on the move; empty if there was none."""
        if not self.moved_m:
            return ""
        x_m, y_m = self.place_m
        return f"{what}: moved by {self.moved_m:.2f} m to {x_m:.2f},{y_m:.2f}, where the robot fits"


def standing_on(space: Space, row: int, col: int) -> Standing:
    """Where the robot stands on a cell, which must be allowed."""
    x_m, y_m = space.frame.world_from_cell(np.array([(row, col)]))[0].tolist()
    return Standing((row, col), (x_m, y_m))


def standing_at(space: Space, place_m: Point, *, what: str) -> Standing:
    """The cell of a place, or the nearest allowed cell within the robot's radius, the first in reading order at a tie.

    Raises `SettingError`, which begins with `what`, if there is none.
    """
    place = space.frame.cell_from_world(np.array([place_m]))[0]
    row, col = np.floor(place + 0.5).astype(int).tolist()
    if _inside(space, row, col) and space.allowed[row, col]:
        return standing_on(space, row, col)
    reach = space.radius_m / space.frame.resolution_m
    low = np.maximum(np.ceil(place - reach).astype(int), 0)
    high = np.maximum(np.floor(place + reach).astype(int) + 1, 0)
    cells = np.argwhere(space.allowed[low[0] : high[0], low[1] : high[1]]) + low
    apart = np.hypot(*(cells - place).T)
    if not len(cells) or apart.min() > reach + EPSILON:
        at = f"{place_m[0]:g},{place_m[1]:g}"
        within = f"a place within {space.radius_m:g} m of where the robot fits"
        raise SettingError(f"{what}: wanted {within}, found none near {at}")
    nearest = int(np.argmin(apart))
    moved_m = float(apart[nearest]) * space.frame.resolution_m
    return replace(standing_on(space, *cells[nearest].tolist()), moved_m=moved_m)


def standing_in(space: Space, topology: TopologicalMap, room: int, box: Box | None = None) -> Standing | None:
    """The allowed cell of a room that is nearest to its centre, in the largest part of its allowed cells.

    The room lies in the box, if one is given. None if the robot fits nowhere in the room. Raises `SettingError` if
    there is no such room.
    """
    centre = topology.centre[topology.room_row(room)]
    rows, cols = box or (slice(0, None), slice(0, None))
    cells = np.argwhere((topology.labels[rows, cols] == room) & space.allowed[rows, cols])
    if not len(cells):
        return None
    cells += (rows.start, cols.start)
    part = space.parts[tuple(cells.T)]
    cells = cells[part == np.argmax(np.bincount(part))]
    row, col = cells[np.argmin(((cells - centre) ** 2).sum(axis=1))].tolist()
    return standing_on(space, row, col)


def _inside(space: Space, row: int, col: int) -> bool:
    return 0 <= row < space.frame.height and 0 <= col < space.frame.width
