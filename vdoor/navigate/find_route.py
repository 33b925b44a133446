"""The stage that finds a route on the finished map, and its record."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from itertools import pairwise
from typing import Annotated, ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from vdoor.config import Within
from vdoor.editing.lookup import find_door, find_room
from vdoor.formats import read_annotations
from vdoor.frame import Frame
from vdoor.grid import Annotations, OccupancyGrid
from vdoor.method.final_doors import to_segment_m
from vdoor.navigate import ROBOT_RADIUS_M
from vdoor.navigate.blocked import Restrictions, blocked_cells
from vdoor.navigate.obstacles import KINDS, Obstacle, in_the_way
from vdoor.navigate.places import Standing
from vdoor.navigate.room_table import Tables
from vdoor.navigate.routes import Cell, Routes
from vdoor.navigate.sight import least_clearance
from vdoor.navigate.space import Space
from vdoor.navigate.targets import Target
from vdoor.record import Record, Spec
from vdoor.topology import TopologicalMap

Floats = NDArray[np.float64]
Ints = NDArray[np.int32]

BACK_AND_FORTH_M = 0.3
"""A path along the jagged line between two rooms passes it again within this distance."""


class Route(Record):
    """A way through stops on the finished map, or what is in the way; only in runs that are asked for one."""

    topic: ClassVar[str] = "route"

    point_m: Annotated[Floats, Spec("column", "point 2", unit="m", tolerance=1e-9)]
    """The bends of the path with its ends, x, y in the map frame; none if there is no way."""
    yaw_rad: Annotated[Floats, Spec("column", "point", unit="rad", tolerance=1e-9)]
    """The direction in which the robot leaves each point; at the last one, that in which it arrives."""
    along_m: Annotated[Floats, Spec("column", "point", unit="m", tolerance=1e-9)]
    """How far each point is along the path."""
    leg: Annotated[Ints, Spec("column", "point")]
    """The stop that the robot goes to from each point; at the last one, the last stop."""
    stop_m: Annotated[Floats, Spec("column", "stop 2", unit="m", tolerance=1e-9)]
    """Where the robot stands at the start, the rooms or places to pass, and the goal; nan where it does not fit."""
    stop_room: Annotated[Ints, Spec("column", "stop")]
    stop_moved_m: Annotated[Floats, Spec("column", "stop", unit="m", tolerance=1e-9)]
    """How far a stop lies from the place that was asked for, since that was too near to a wall."""
    door: Annotated[Ints, Spec("column", "crossing")]
    """The ids of the doors that are passed, in order."""
    obstacle: Annotated[NDArray[np.uint8], Spec("code", "obstacle", words=KINDS)]
    """What is in the way, if there is no way."""
    obstacle_id: Annotated[Ints, Spec("column", "obstacle")]
    """The id of the door or room, -1 for an area."""
    obstacle_m: Annotated[Floats, Spec("column", "obstacle 2", unit="m", tolerance=1e-9)]
    obstacle_clear_m: Annotated[Floats, Spec("column", "obstacle", unit="m", tolerance=1e-9)]
    """The clearance that is left at a narrow place; nan for others."""
    radius_m: Annotated[float, Spec("number", unit="m")]
    """The robot's radius: the clearance that is kept."""
    length_m: Annotated[float, Spec("number", unit="m", tolerance=1e-9)]
    clear_m: Annotated[float, Spec("number", unit="m", tolerance=1e-9)]
    """The least distance from the path to anything that the robot must not touch, 2 m at most; nan without a path."""
    frame: Frame

    @property
    def found(self) -> bool:
        """Whether there is a way."""
        return len(self.point_m) > 0


class Stops(NamedTuple):
    """The start, the rooms or places to pass, and the goal, and where the robot stands there."""

    targets: list[Target]
    standing: list[Standing | None]


@dataclass(frozen=True, kw_only=True)
class FindRoute:
    """Find a route on the finished map, if a start is set."""

    start: str = ""
    """Where the route begins: a room's id, its name or X,Y in metres; empty for no route."""
    goal: str = ""
    """Where it ends."""
    via: tuple[str, ...] = ()
    """Rooms or places to go to on the way, in order."""
    avoid: tuple[str, ...] = ()
    """Rooms not to enter, by id, name or place."""
    closed: tuple[str, ...] = ()
    """Doors that are closed, by id or place."""
    radius_m: Annotated[float, Within(0.001, 10)] = ROBOT_RADIUS_M
    """Clearance that is kept everywhere: the robot's radius."""

    record: ClassVar[type[Record]] = Route

    @property
    def asked(self) -> bool:
        """Whether a route is to be found."""
        return bool(self.start)

    def __call__(self, grid: OccupancyGrid, topology: TopologicalMap) -> Route:
        """The route, or what is in the way, as `found` with the restrictions in the map's file."""
        return self.found(grid, topology, read_annotations(grid.source))

    def found(
        self,
        grid: OccupancyGrid,
        topology: TopologicalMap,
        annotations: Annotations | None = None,
        tables: Tables | None = None,
    ) -> Route:
        """The route on a map with restrictions; `tables` holds distances of earlier queries and takes new ones.

        Raises `SettingError` for a room or door that the map does not have, and for a place too near to a wall.
        """
        restrictions = self.restrictions(topology, annotations)
        blocked = blocked_cells(grid, topology, restrictions)
        routes = Routes(Space.of(blocked, grid.frame, self.radius_m), topology, tables=tables)
        stops = self._stops(routes)
        legs: list[list[Cell]] = []
        for number, (one, other) in enumerate(pairwise(stops.standing)):
            leg = _path(routes, one, other)
            if leg is None:
                walls = blocked_cells(grid, topology)
                obstacles = in_the_way(
                    topology,
                    partial(_ends, stops, number),
                    walls,
                    blocked,
                    restrictions=restrictions,
                    radius_m=self.radius_m,
                )
                return _record(routes, stops, [], obstacles)
            legs.append(leg)
        return _record(routes, stops, legs, [])

    def restrictions(self, topology: TopologicalMap, annotations: Annotations | None) -> Restrictions:
        """What is ruled out on a map, by its file and by these settings."""
        return Restrictions(
            annotations=annotations,
            closed_doors=[find_door(topology, text, what="closed").door.id for text in self.closed],
            avoided_rooms=[find_room(topology, text, what="avoid").room.id for text in self.avoid],
        )

    def _stops(self, routes: Routes) -> Stops:
        given = [("start", self.start), *(("via", text) for text in self.via), ("goal", self.goal)]
        targets = [Target.of(routes.topology, text, what=what) for what, text in given]
        standing = [target.standing(routes, what=what) for target, (what, _) in zip(targets, given, strict=True)]
        return Stops(targets, standing)


def _path(routes: Routes, one: Standing | None, other: Standing | None) -> list[Cell] | None:
    if one is None or other is None or routes.space.parts[one.cell] != routes.space.parts[other.cell]:
        return None
    return routes.path(one.cell, other.cell)


def _ends(stops: Stops, leg: int, routes: Routes) -> tuple[Cell | None, Cell | None]:
    one, other = (stops.targets[at].cell(routes, stops.standing[at]) for at in (leg, leg + 1))
    return one, other


def _record(routes: Routes, stops: Stops, legs: Sequence[list[Cell]], obstacles: Sequence[Obstacle]) -> Route:
    cells = np.array([cell for leg in legs for cell in leg[:-1]] + [leg[-1] for leg in legs[-1:]]).reshape(-1, 2)
    frame = routes.space.frame
    point_m = frame.world_from_cell(cells)
    step_m = np.diff(point_m, axis=0)
    along_m = np.concatenate([[0.0], np.cumsum(np.hypot(*step_m.T))])[: len(cells)]
    place_m = [standing.place_m if standing else (math.nan, math.nan) for standing in stops.standing]
    number = [at + 1 for at, leg in enumerate(legs) for _ in leg[:-1]] + [len(legs)] * bool(legs)
    return Route(
        point_m=point_m,
        yaw_rad=headings(step_m)[: len(cells)],
        along_m=along_m,
        leg=np.array(number, np.int32),
        stop_m=np.array(place_m, np.float64),
        stop_room=np.array([_room(routes.topology, *stop) for stop in zip(*stops, strict=True)], np.int32),
        stop_moved_m=np.array([standing.moved_m if standing else 0.0 for standing in stops.standing], np.float64),
        door=np.array(crossed(routes.topology, cells), np.int32),
        obstacle=np.array([found.kind for found in obstacles], np.uint8),
        obstacle_id=np.array([found.id for found in obstacles], np.int32),
        obstacle_m=np.array([found.place_m for found in obstacles], np.float64).reshape(-1, 2),
        obstacle_clear_m=np.array([found.clear_m for found in obstacles], np.float64),
        radius_m=routes.space.radius_m,
        length_m=float(along_m[-1]) if len(cells) else math.nan,
        clear_m=least_clearance(routes.space, cells.astype(np.float64)) if len(cells) else math.nan,
        frame=frame,
    )


def _room(topology: TopologicalMap, target: Target, standing: Standing | None) -> int:
    return target.room if standing is None else int(topology.labels[standing.cell])


def headings(step_m: Floats) -> Floats:
    """The direction (k + 1,) of each of the steps (k, 2), and once more of the last one; 0 for a path of one point."""
    yaw_rad = np.arctan2(step_m[:, 1], step_m[:, 0])
    return np.append(yaw_rad, yaw_rad[-1:] if len(yaw_rad) else 0.0)


def crossed(topology: TopologicalMap, cells: Floats) -> list[int]:
    """The ids of the doors that a path through points (k, 2) passes, in order: the nearest between two rooms."""
    if not len(cells):
        return []
    rooms, places, along_m = _rooms_along(topology, cells)
    found: list[tuple[int, float]] = []
    for ends, place, at_m in zip(pairwise(rooms.tolist()), places, along_m.tolist(), strict=True):
        door = _door_between(topology, ends, place)
        if found and found[-1][0] == door and at_m - found[-1][1] < BACK_AND_FORTH_M:
            found.pop()
        elif door:
            found.append((door, at_m))
    return [door for door, _ in found]


def _door_between(topology: TopologicalMap, rooms: tuple[int, int], place_m: Floats) -> int:
    """The id of the door between two rooms that is nearest to a place (2,); 0 if there is none."""
    pair = np.stack([topology.room_a, topology.room_b], axis=1)
    rows = np.flatnonzero((pair == sorted(rooms)).all(axis=1)).tolist()
    apart = [to_segment_m(place_m[None], topology.start_m[row], topology.end_m[row])[0] for row in rows]
    return rows[int(np.argmin(apart))] + 1 if rows else 0


def _rooms_along(topology: TopologicalMap, cells: Floats) -> tuple[Ints, Floats, Floats]:
    """The rooms (k,) that a path goes through; where (k - 1, 2), and after how many metres, it passes to the next."""
    pieces = [np.linspace(start, end, int(4 * np.abs(end - start).max()) + 2) for start, end in pairwise(cells)]
    place = np.concatenate(pieces) if pieces else cells.astype(np.float64)
    along_m = np.append(0.0, np.cumsum(np.hypot(*np.diff(place, axis=0).T))) * topology.frame.resolution_m
    room = topology.labels[tuple(np.floor(place + 0.5).astype(np.intp).T)]
    place, along_m, room = place[room > 0], along_m[room > 0], room[room > 0]
    change = np.flatnonzero(np.diff(room))
    return room[np.append(change, len(room) - 1)], topology.frame.world_from_cell(place[change]), along_m[change]
