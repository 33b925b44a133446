"""Where routes pass a door: at the ends and in the middle of the cells that keep the clearance, and between."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vdoor.navigate.blocked import door_contacts
from vdoor.navigate.space import Space
from vdoor.topology import TopologicalMap

APART_M = 1.0
"""Portals of a wide door are at most so far apart."""
Cell = tuple[int, int]
Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Portal:
    """One place to pass a door: a cell of one of its rooms, beside a cell of the other."""

    door: int
    """Id of the door."""
    rooms: tuple[int, int]
    cell: Cell


def portals_of(space: Space, topology: TopologicalMap) -> list[Portal]:
    """The portals of all doors, in their order: three for each run of passable contacts, more where it is wide.

    A door that is too narrow for the robot has none.
    """
    place, owner = door_contacts(topology)
    lower, upper = np.floor(place).astype(np.intp), np.ceil(place).astype(np.intp)
    passable = space.allowed[tuple(lower.T)] & space.allowed[tuple(upper.T)] & (owner >= 0)
    place, owner, lower = place[passable], owner[passable], lower[passable]
    start, end = (topology.frame.cell_from_world(points_m) for points_m in (topology.start_m, topology.end_m))
    order = np.argsort(owner, kind="stable")
    found = []
    for own in np.split(order, np.flatnonzero(np.diff(owner[order])) + 1) if len(order) else ():
        door = topology.door(int(owner[own[0]]) + 1)
        along, apart = end[door.id - 1] - start[door.id - 1], APART_M / topology.frame.resolution_m
        for row, col in _chosen(place[own], lower[own], along, apart):
            found.append(Portal(door.id, door.rooms, (row, col)))
    return found


def _chosen(place: Floats, cell: NDArray[np.intp], along: Floats, apart: float) -> list[Cell]:
    """The cells at both ends, in the middle, and at most `apart` cells on, of each run of contacts (k, 2)."""
    order = np.lexsort((place[:, 1], place[:, 0], np.round(place @ along, 6)))
    gaps = np.hypot(*np.diff(place[order], axis=0).T) > 1.5  # noqa: PLR2004  # more than a diagonal step
    cells: list[Cell] = []
    for run in np.split(order, np.flatnonzero(gaps) + 1):
        count = 2 * math.ceil(max(len(run) / (2 * apart), 1)) + 1
        for at in np.unique(np.linspace(0, len(run) - 1, count).round().astype(int)).tolist():
            row, col = cell[run[at]].tolist()
            cells.append((row, col))
    return list(dict.fromkeys(cells))
