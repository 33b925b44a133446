"""The stage that plans a path whose tool sweeps the floor of the finished map, and its record."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, ClassVar

import numpy as np
from numpy.typing import NDArray

from vdoor.config import Within
from vdoor.editing.lookup import find_room
from vdoor.errors import SettingError
from vdoor.formats import read_annotations
from vdoor.frame import Frame
from vdoor.grid import Annotations, OccupancyGrid
from vdoor.navigate import LEAVE, ROBOT_RADIUS_M, TOOL_M, TRADE
from vdoor.navigate.blocked import Restrictions, blocked_cells
from vdoor.navigate.coverage.measures import Motion, measured
from vdoor.navigate.coverage.path import KINDS
from vdoor.navigate.find_route import FindRoute, headings
from vdoor.navigate.places import Standing, standing_at, standing_in, standing_on
from vdoor.navigate.room_table import Tables
from vdoor.navigate.space import Space
from vdoor.navigate.targets import Target
from vdoor.record import Record, Spec
from vdoor.topology import TopologicalMap

if TYPE_CHECKING:
    from vdoor.navigate.coverage.plan import Covered

Floats = NDArray[np.float64]
Ints = NDArray[np.int32]
Mask = NDArray[np.bool_]

UNITS = ("room", "map")
"""What is swept as a whole before the robot goes on: each room (the paper's way), or the map."""
WANTED, OTHER = 1, 2
"""The units of the map as a whole: what is to be swept, and what is only driven through."""
BACK = "start"
"""The end of a path that returns to where it began."""


class Coverage(Record):
    """A path whose tool sweeps rooms, and when it sweeps each cell; only in runs that are asked for one."""

    topic: ClassVar[str] = "coverage"

    swept: Annotated[Ints, Spec("labels", "height width")]
    """The row of the point that ends the segment which sweeps a cell first (h, w); 0 for a cell that is not swept."""
    point_m: Annotated[Floats, Spec("column", "point 2", unit="m", tolerance=1e-9)]
    """The bends of the path with its ends, x, y in the map frame."""
    yaw_rad: Annotated[Floats, Spec("column", "point", unit="rad", tolerance=1e-9)]
    """The direction in which the robot leaves each point; at the last one, that in which it arrives."""
    along_m: Annotated[Floats, Spec("column", "point", unit="m", tolerance=1e-9)]
    """How far each point is along the path."""
    at_s: Annotated[Floats, Spec("column", "point", unit="s", tolerance=1e-9)]
    """When the robot is there, at its speed and with a stop at each turn."""
    purpose: Annotated[NDArray[np.uint8], Spec("code", "point", words=KINDS)]
    """What the robot drives to the point for: to get there, along a wall or an island, or along a lane."""
    visit: Annotated[Ints, Spec("column", "point", of="coverage.visit_room")]
    visit_room: Annotated[Ints, Spec("column", "visit")]
    """The room that is swept; one with several parts is visited for each. 0 if the map is swept as one."""
    visit_done_s: Annotated[Floats, Spec("column", "visit", unit="s", tolerance=1e-9)]
    missed: Annotated[Ints, Spec("column", "room")]
    """The rooms that were wanted but are out of the robot's reach."""
    radius_m: Annotated[float, Spec("number", unit="m")]
    tool_m: Annotated[float, Spec("number", unit="m")]
    covered: Annotated[float, Spec("number", tolerance=1e-9)]
    """Share of the cells within the tool's reach of where the robot can be."""
    length_m: Annotated[float, Spec("number", unit="m", tolerance=1e-9)]
    excess: Annotated[float, Spec("number", tolerance=1e-9)]
    """Length over what a path without overlap would need: the swept area over the tool's width."""
    swept_twice: Annotated[float, Spec("number", tolerance=1e-9)]
    """Share of the swept cells that are swept again after the tool has been elsewhere."""
    turns: Annotated[int, Spec("count")]
    turns_per_m2: Annotated[float, Spec("number", unit="1/m2", tolerance=1e-9)]
    rotation_rad: Annotated[float, Spec("number", unit="rad", tolerance=1e-9)]
    clear_m: Annotated[float, Spec("number", unit="m", tolerance=1e-9)]
    """The least distance from the path to anything that the robot must not touch."""
    room_changes: Annotated[int, Spec("count")]
    frame: Frame

    @property
    def time_s(self) -> float:
        """When the path is done."""
        return float(self.at_s[-1])


@dataclass(frozen=True, kw_only=True)
class CoverFloor:
    """Plan a path whose tool sweeps rooms of the finished map, if a unit is set."""

    unit: str = ""
    """What is swept as a whole before the robot goes on: room or map; empty for no path."""
    rooms: tuple[str, ...] = ()
    """The rooms to sweep, by id or name; all if empty."""
    ordered: bool = False
    """Whether the rooms are swept in the order in which they are given."""
    avoid: tuple[str, ...] = ()
    """Rooms not to enter."""
    closed: tuple[str, ...] = ()
    """Ids of doors that are closed."""
    start: str = ""
    """Where the path begins: a room's id or name, or X,Y in metres; if empty, the charger, the robot's place, or a
    corner of the largest room."""
    end: str = ""
    """Where it ends: as for the start, or `start` to return; anywhere if empty."""
    mops: bool = False
    """Whether the robot mops, and so keeps out of no-mop areas."""
    radius_m: Annotated[float, Within(0.001, 10)] = ROBOT_RADIUS_M
    """Clearance that is kept everywhere: the robot's radius."""
    tool_m: Annotated[float, Within(0.01, 10)] = TOOL_M
    """Width of the tool."""
    trade: Annotated[float, Within(0, 1)] = TRADE
    """How much area may stay uncovered for a length saved, as a share of what the tool sweeps on that length: the dial
    between coverage and length."""
    leave: Annotated[float, Within(0, 1)] = LEAVE
    """Largest share of the floor that may stay uncovered for a shorter path."""
    bend_m: Annotated[float, Within(0, 10)] = 0.33
    """What a bend of the path costs, as a length."""
    speed_m_s: Annotated[float, Within(0.001, 10)] = 0.3
    turn_rad_s: Annotated[float, Within(0.001, 100)] = 1.5

    record: ClassVar[type[Record]] = Coverage

    @property
    def asked(self) -> bool:
        """Whether a path is to be planned."""
        return bool(self.unit)

    def __call__(self, grid: OccupancyGrid, topology: TopologicalMap) -> Coverage:
        """The path, with the restrictions in the map's file.

        Raises `SettingError` for a room or door that the map does not have, for a place too near to a wall, and if the
        robot fits nowhere.
        """
        return self.found(grid, topology, read_annotations(grid.source))

    def found(
        self,
        grid: OccupancyGrid,
        topology: TopologicalMap,
        annotations: Annotations | None = None,
        tables: Tables | None = None,
    ) -> Coverage:
        """The path on a map with restrictions; `tables` is not needed."""
        from vdoor.navigate.coverage.plan import Task, cover  # noqa: PLC0415  # shapely, which only this stage needs

        del tables
        if self.unit not in UNITS:
            raise SettingError(f"unit: wanted {' or '.join(UNITS)}, found {self.unit!r}")
        blocked = blocked_cells(grid, topology, self._restrictions(topology, annotations))
        space = Space.of(blocked, grid.frame, self.radius_m)
        rooms = self._rooms(topology)
        start = self._start(space, topology, annotations)
        resolution_m = grid.frame.resolution_m
        covered = cover(
            Task(
                space=space,
                labels=self._labels(topology, rooms),
                rooms=[WANTED] if self.unit == "map" else rooms,
                ordered=self.ordered,
                start=np.array(start.cell, np.float64),
                end=self._end(space, topology, start),
                reach=self.tool_m / 2 / resolution_m,
                trade=self.trade,
                bend=self.bend_m / resolution_m,
                leave=self.leave,
            )
        )
        if not covered.room:
            raise SettingError("cover: wanted a room that the robot can reach, found none")
        return self._record(covered, space, topology, rooms)

    def _restrictions(self, topology: TopologicalMap, annotations: Annotations | None) -> Restrictions:
        """What is ruled out on a map, by its file and by these settings."""
        ruled_out = FindRoute(avoid=self.avoid, closed=self.closed).restrictions(topology, annotations)
        return dataclasses.replace(ruled_out, mops=self.mops)

    def _rooms(self, topology: TopologicalMap) -> list[int]:
        """The ids of the rooms to sweep."""
        wanted = [find_room(topology, text, what="rooms").room.id for text in self.rooms] or list(topology.room_ids)
        avoided = {find_room(topology, text, what="avoid").room.id for text in self.avoid}
        return [room for room in dict.fromkeys(wanted) if room not in avoided]

    def _labels(self, topology: TopologicalMap, rooms: Sequence[int]) -> Ints:
        """The units (h, w): the rooms, or `WANTED` and `OTHER` for the map."""
        if self.unit == "room":
            return topology.labels
        wanted = np.where(np.isin(topology.labels, rooms), WANTED, OTHER)
        return np.where(topology.labels > 0, wanted, 0).astype(np.int32)

    def _start(self, space: Space, topology: TopologicalMap, annotations: Annotations | None) -> Standing:
        """Where the path begins."""
        if self.start:
            return self._standing(space, topology, self.start, what="start")
        for place_m in (annotations.charger_m, annotations.robot_m) if annotations else ():
            if place_m is not None:
                try:
                    return standing_at(space, place_m, what="start")
                except SettingError:
                    continue  # a charger stands at a wall
        for row in np.argsort(-topology.area_m2, kind="stable").tolist():
            if standing := standing_in(space, topology, topology.room_ids[row]):
                own = (space.parts == space.parts[standing.cell]) & (topology.labels == topology.room_ids[row])
                return standing_on(space, *np.argwhere(own)[0].tolist())
        raise SettingError(f"radius_m: wanted a robot that fits into a room, found a radius of {self.radius_m:g} m")

    def _end(self, space: Space, topology: TopologicalMap, start: Standing) -> Floats | None:
        """Row, col (2,) of where the path ends; None for anywhere."""
        if not self.end:
            return None
        end = start if self.end == BACK else self._standing(space, topology, self.end, what="end")
        if space.parts[end.cell] != space.parts[start.cell]:
            raise SettingError(f"end: wanted a place that can be reached from the start, found {self.end}")
        return np.array(end.cell, np.float64)

    def _standing(self, space: Space, topology: TopologicalMap, text: str, *, what: str) -> Standing:
        target = Target.of(topology, text, what=what)
        if target.place_m is not None:
            return standing_at(space, target.place_m, what=what)
        if standing := standing_in(space, topology, target.room):
            return standing
        raise SettingError(f"{what}: wanted a room that the robot fits into, found {target.told(topology)}")

    def _record(self, found: Covered, space: Space, topology: TopologicalMap, rooms: Sequence[int]) -> Coverage:
        frame, path = space.frame, found.path
        figures = measured(path, found.tool, found.wanted, topology.labels, space)
        point_m = frame.world_from_cell(path.point)
        step_m = np.diff(point_m, axis=0)
        fine = found.tool.fine
        row, col = np.nonzero(found.wanted)
        reached = np.bincount(topology.labels[row // fine, col // fine], minlength=max(rooms) + 1)
        motion = Motion(speed_m_s=self.speed_m_s, turn_rad_s=self.turn_rad_s)
        at_s = motion.times_s(path, frame.resolution_m)
        last = np.searchsorted(path.visit, np.arange(len(found.room)), "right") - 1
        return Coverage(
            swept=first_swept(found, space.blocked),
            point_m=point_m,
            yaw_rad=headings(step_m)[: len(point_m)],
            along_m=np.concatenate([[0.0], np.cumsum(np.hypot(*step_m.T))]),
            at_s=at_s,
            purpose=path.kind,
            visit=path.visit.astype(np.int32),
            visit_room=np.array(found.room if self.unit == "room" else [0] * len(found.room), np.int32),
            visit_done_s=at_s[last],
            missed=np.array([room for room in rooms if not reached[room]], np.int32),
            radius_m=self.radius_m,
            tool_m=self.tool_m,
            covered=figures.covered,
            length_m=figures.length_m,
            excess=figures.excess,
            swept_twice=figures.swept_twice,
            turns=figures.turns,
            turns_per_m2=figures.turns_per_m2,
            rotation_rad=figures.rotation_rad,
            clear_m=figures.clearance_m,
            room_changes=figures.room_changes,
            frame=frame,
        )


def first_swept(found: Covered, blocked: Mask) -> Ints:
    """The number of the segment that sweeps each cell of the map first (h, w), from 1 on; 0 for none.

    `blocked` (h, w) are the cells of the map that stop the tool.
    """
    tool = dataclasses.replace(found.tool, blocked=blocked, fine=1)
    swept = tool.swept(found.path.point[:-1], found.path.point[1:])
    first = np.zeros(blocked.size, np.int32)
    first[swept.cell[::-1]] = swept.segment[::-1] + 1  # the last assignment stays
    return first.reshape(blocked.shape)
