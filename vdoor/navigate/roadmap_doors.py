"""Where a roadmap passes the doors."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import NDArray

from vdoor.errors import VdoorError
from vdoor.navigate.blocked import door_contacts
from vdoor.navigate.space import Space
from vdoor.topology import Door, TopologicalMap

Point = tuple[float, float]
Floats = NDArray[np.float64]

APART_M = 0.5
"""Of a door that is wider, nodes are added until no passable place of it is farther from one."""
NUDGE = 0.01
"""How far within a room its eye is, in cells."""


@dataclass(frozen=True)
class DoorPlace:
    """A place in a door: the middle of the side between two cells, one of each of its rooms."""

    door: int
    """Id of the door."""
    place: Point
    """Row, col in the map."""
    eyes: tuple[tuple[int, Point], tuple[int, Point]]
    """Each of the two rooms, and a point of its cell right beside the place."""
    passable: bool
    """Whether both cells keep the clearance."""
    main: bool
    """Whether this is the door's first place."""

    @property
    def rooms(self) -> tuple[int, int]:
        """The ids of the two rooms."""
        return self.eyes[0][0], self.eyes[1][0]

    def eye(self, room: int) -> Point:
        """The point beside the place within one of its rooms."""
        return dict(self.eyes)[room]


def door_places(topology: TopologicalMap, space: Space) -> list[DoorPlace]:
    """The places of all doors: first one for each door, in their order, then the further ones of wide doors.

    A door's place is the passable one nearest to its middle, or the one farthest from walls if none is passable. Raises
    `VdoorError` for a door whose rooms do not touch.
    """
    place, owner = door_contacts(topology)
    room = np.stack([topology.labels[tuple(end(place).astype(np.intp).T)] for end in (np.floor, np.ceil)], axis=1)
    free_cells = scipy.ndimage.distance_transform_edt(np.pad(~space.blocked, 1))[1:-1, 1:-1]
    mains, further = [], []
    for row, door in enumerate(topology.doors):
        own = np.flatnonzero(owner == row)
        if not len(own):
            raise VdoorError(apart(door))
        beside = [tuple(end(place[own]).astype(np.intp).T) for end in (np.floor, np.ceil)]
        passable = space.allowed[beside[0]] & space.allowed[beside[1]]
        middle = topology.frame.cell_from_world(np.array([door.start_m, door.end_m])).mean(axis=0)
        off = np.hypot(*(place[own] - middle).T)
        width = np.minimum(free_cells[beside[0]], free_cells[beside[1]])
        first = int(np.argmin(np.where(passable, off, np.inf)) if passable.any() else np.lexsort((off, -width))[0])
        chosen = [first, *_further(place[own], passable, first, APART_M / topology.frame.resolution_m)]
        made = [_made(door.id, place[own[at]], room[own[at]], bool(passable[at]), at == first) for at in chosen]
        mains.append(made[0])
        further += made[1:]
    return [*mains, *further]


def _further(place: Floats, passable: NDArray[np.bool_], first: int, apart: float) -> list[int]:
    """Passable places (k, 2) far from the first, each the farthest from those before."""
    far = np.where(passable, np.hypot(*(place - place[first]).T), 0.0)
    found = []
    while far.max() > apart:
        found.append(int(np.argmax(far)))
        far = np.minimum(far, np.hypot(*(place - place[found[-1]]).T))
    return found


def _made(door: int, place: Floats, rooms: NDArray[np.int32], passable: bool, main: bool) -> DoorPlace:
    low, high = np.floor(place), np.ceil(place)
    toward = (high - low) * NUDGE
    one, other = (place - toward).tolist(), (place + toward).tolist()
    row, col = place.tolist()
    first, second = rooms.tolist()
    return DoorPlace(door, (row, col), ((first, tuple(one)), (second, tuple(other))), passable, main)


def apart(door: Door) -> str:
    """What is wrong with a door whose rooms do not touch."""
    one, other = door.rooms
    return f"door {door.id}: wanted rooms {one} and {other} to touch, found a gap between them"
