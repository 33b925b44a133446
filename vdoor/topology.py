"""The result: rooms as nodes, doors as edges, and the room of every free cell."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import TYPE_CHECKING, Annotated, ClassVar

import numpy as np
from numpy.typing import NDArray

from vdoor.errors import RecordingError, SettingError
from vdoor.frame import Frame
from vdoor.raster.runs import runs_of
from vdoor.record import Record, Spec

if TYPE_CHECKING:
    import networkx as nx

KINDS = ("pair", "single", "passage", "extension", "added", "sill")
"""Kinds of doors, explained at `Door.kind`."""
TILT_DECIMALS = 2
POINTS_AND_LENGTHS = ("start_m", "end_m", "length_m", "width_m", "feature_m", "vertex_m")
"""The columns in metres."""
Ring = tuple[tuple[float, float], ...]
Polygon = tuple[Ring, ...]


@dataclass(frozen=True)
class Corner:
    """A corner of a room's boundary, in the map frame."""

    point_m: tuple[float, float]
    convex: bool


@dataclass(frozen=True)
class Room:
    """One room, in the map frame."""

    id: int
    area_m2: float
    centre_m: tuple[float, float]
    """The centre of a free cell of the room, the one nearest to the room's mean."""
    polygon_m: Polygon
    """Rings of x, y, the outer one first, then the holes; each ends with its first vertex. In a room of several parts
    the rings of its largest part, then those of the others: see `parts_m`."""
    neighbours: tuple[int, ...]
    corners: tuple[Corner, ...]
    """The corners on the room's boundary."""
    name: str = ""
    """The name given to the room by an edit; empty if none."""

    @property
    def title(self) -> str:
        """The room's name or, without one, `room` and its id."""
        return self.name or f"room {self.id}"

    @property
    def parts_m(self) -> tuple[Polygon, ...]:
        """A polygon for each part of the room that unknown or occupied cells separate, the largest first.

        Most rooms have one. A room has more where a robot saw it only in part, or where its floor is interrupted by a
        sill.
        """
        outer = [(signed_area_m2(ring) < 0) == (signed_area_m2(self.polygon_m[0]) < 0) for ring in self.polygon_m]
        begins = [*np.flatnonzero(outer).tolist(), len(outer)]
        return tuple(self.polygon_m[begin:end] for begin, end in pairwise(begins))


@dataclass(frozen=True)
class Door:
    """One door, in the map frame."""

    id: int
    rooms: tuple[int, int]
    start_m: tuple[float, float]
    end_m: tuple[float, float]
    length_m: float
    """Distance between the centres of the end cells."""
    width_m: float
    """Width of the free gap."""
    tilt_deg: float
    """Angle to the nearer axis of the grid."""
    kind: str
    """pair, single, extension, passage (too narrow for the working resolution), added (by an edit), or sill (the floor
    of the doorway is unknown)."""


class TopologicalMap(Record):
    """Rooms as nodes, doors as edges, at the input's resolution.

    Room ids are the values of `labels`: 1, 2, ... in reading order, unless edits change them. The rooms' columns are
    sorted by id, see `room_ids`.
    """

    topic: ClassVar[str] = "map"

    labels: Annotated[NDArray[np.int32], Spec("labels", "height width")]
    """Room id of every free cell that can be reached from a room; 0 elsewhere."""
    centre: Annotated[NDArray[np.int32], Spec("cell", "room 2")]
    """The cell of the room nearest to the mean of its cells."""
    area_m2: Annotated[NDArray[np.float64], Spec("column", "room", unit="m2", tolerance=1e-9)]
    name: Annotated[tuple[str, ...], Spec("text", "room")] = ()
    """The names of the rooms, empty for a room without one; an empty tuple if no room has a name."""
    edge: Annotated[NDArray[np.int32], Spec("column", "door", of="initial_map.door", or_none=True)]
    """Edge of the initial map, -1 for a passage too narrow for the working resolution."""
    start_m: Annotated[NDArray[np.float64], Spec("column", "door 2", unit="m", tolerance=1e-9)]
    end_m: Annotated[NDArray[np.float64], Spec("column", "door 2", unit="m", tolerance=1e-9)]
    """End points as x, y in the map frame."""
    kind: Annotated[NDArray[np.uint8], Spec("code", "door", words=KINDS)]
    length_m: Annotated[NDArray[np.float64], Spec("column", "door", unit="m", tolerance=1e-9)]
    width_m: Annotated[NDArray[np.float64], Spec("column", "door", unit="m", tolerance=1e-9)]
    tilt_rad: Annotated[NDArray[np.float64], Spec("column", "door", unit="rad", tolerance=1e-9)]
    room_a: Annotated[NDArray[np.int32], Spec("column", "door")]
    room_b: Annotated[NDArray[np.int32], Spec("column", "door")]
    """The two rooms that the door joins, a < b; a door that borders more rooms has one row per pair."""
    feature_room: Annotated[NDArray[np.int32], Spec("column", "feature")]
    feature_corner: Annotated[NDArray[np.int32], Spec("column", "feature")]
    feature_convex: Annotated[NDArray[np.bool_], Spec("column", "feature")]
    feature_m: Annotated[NDArray[np.float64], Spec("column", "feature 2", unit="m", tolerance=1e-9)]
    """Centre of the corner's obstacle cell as x, y."""
    vertex_m: Annotated[NDArray[np.float64], Spec("column", "vertex 2", unit="m", tolerance=1e-9)]
    """Polygons with holes as x, y in the map frame; each ring ends with its first vertex."""
    vertex_room: Annotated[NDArray[np.int32], Spec("column", "vertex")]
    vertex_ring: Annotated[NDArray[np.int32], Spec("column", "vertex")]
    """Ring number within the room: 0 for the outer one, then the holes; then the same for the room's smaller parts."""
    frame: Frame
    own_origin_cm: tuple[float, float] | None = None
    """The map frame's origin in the robot's own frame, whose y axis points down, in centimetres; None if unknown. Not
    recorded: it comes from the map file."""

    def __repr__(self) -> str:
        """One line: how many rooms and doors, and how large."""
        rooms, doors, frame = len(self.area_m2), len(self.kind), self.frame
        size = f"{frame.width} x {frame.height} cells of {frame.resolution_m:g} m"
        return f"TopologicalMap({rooms} rooms, {doors} doors, {self.total_m2:.1f} m2, {size})"

    @cached_property
    def written(self) -> TopologicalMap:
        """The map with its numbers rounded as files and `rooms` and `doors` have them: see `Frame.decimals`.

        Areas have a decimal more. What is read from a file is the same again.
        """
        decimals, tilt_deg = self.frame.decimals, np.degrees(self.tilt_rad).round(TILT_DECIMALS)
        points = {name: getattr(self, name).round(decimals) + 0.0 for name in POINTS_AND_LENGTHS}  # no -0.0
        area_m2 = self.area_m2.round(decimals + 1)
        return dataclasses.replace(self, **points, area_m2=area_m2, tilt_rad=np.radians(tilt_deg))

    @property
    def total_m2(self) -> float:
        """The area of all rooms, rounded like theirs."""
        return round(float(self.area_m2.sum()), self.frame.decimals + 1)

    @property
    def doors(self) -> list[Door]:
        """All doors, with ids 1, 2, ... in order."""
        return [self._door(row) for row in range(len(self.kind))]

    @property
    def rooms(self) -> list[Room]:
        """All rooms, sorted by id."""
        return [self._room(row) for row in range(len(self.room_ids))]

    @cached_property
    def room_ids(self) -> tuple[int, ...]:
        """The ids of the rooms, ascending: the values of `labels`, one for each row of the rooms' columns.

        Raises `RecordingError` if a recording has a different number of rows.
        """
        ids = np.unique(runs_of(self.labels).label).tolist()
        if len(ids) != len(self.area_m2):
            raise RecordingError(f"map: wanted a row for each of {len(ids)} rooms, found {len(self.area_m2)}")
        return tuple(ids)

    def room(self, number: int) -> Room:
        """The room with that id; raises `SettingError` if there is none."""
        return self._room(self.room_row(number))

    def room_row(self, number: int) -> int:
        """The row of a room in `centre`, `area_m2` and `name`, by its id; raises `SettingError` if there is none."""
        if number not in self.room_ids:
            raise SettingError(f"room: wanted one of {', '.join(map(str, self.room_ids)) or 'none'}, found {number}")
        return self.room_ids.index(number)

    def room_named(self, name: str) -> Room:
        """The room with that name; raises `SettingError` if there is none, or more than one."""
        rows = [row for row, own in enumerate(self.name) if own == name]
        if len(rows) != 1:
            known = ", ".join(repr(own) for own in self.name if own) or "none"
            raise SettingError(f"room: wanted the name of one room, found {name!r}; names are {known}")
        return self._room(rows[0])

    def room_at(self, place_m: tuple[float, float]) -> Room | None:
        """The room at x, y in the map frame; None if there is none."""
        cell = self.cell_at(place_m)
        label = int(self.labels[cell]) if cell else 0
        return self.room(label) if label else None

    def cell_at(self, place_m: tuple[float, float]) -> tuple[int, int] | None:
        """Row, col of the cell at x, y in the map frame; None outside the map."""
        row, col = np.floor(self.frame.cell_from_world(np.array([place_m]))[0] + 0.5).tolist()
        inside = 0 <= row < self.frame.height and 0 <= col < self.frame.width
        return (int(row), int(col)) if inside else None

    def door(self, number: int) -> Door:
        """The door with that id; raises `SettingError` if there is none."""
        if not 1 <= number <= len(self.kind):
            raise SettingError(f"door: wanted one of the map's {len(self.kind)} doors, found {number}")
        return self._door(number - 1)

    def doors_of(self, room: int) -> list[Door]:
        """The doors of a room, by its id; raises `SettingError` if there is no such room."""
        self.room_row(room)
        return [self._door(row) for row in np.flatnonzero((self.room_a == room) | (self.room_b == room)).tolist()]

    def _door(self, row: int) -> Door:
        return Door(
            id=row + 1,
            rooms=(int(self.room_a[row]), int(self.room_b[row])),
            start_m=_point(self.written.start_m[row]),
            end_m=_point(self.written.end_m[row]),
            length_m=float(self.written.length_m[row]),
            width_m=float(self.written.width_m[row]),
            tilt_deg=round(float(np.degrees(self.tilt_rad[row])), TILT_DECIMALS),
            kind=KINDS[self.kind[row]],
        )

    def _room(self, row: int) -> Room:
        room = self.room_ids[row]
        return Room(
            id=room,
            area_m2=float(self.written.area_m2[row]),
            centre_m=_point(self.frame.world_from_cell(self.centre[row])[0].round(self.frame.decimals) + 0.0),
            polygon_m=self.polygon_m(room),
            neighbours=self.neighbours(room),
            corners=self.corners(room),
            name=self.name[row] if self.name else "",
        )

    def polygon_m(self, room: int) -> Polygon:
        """The rings of one room as x, y, the outer one first."""
        own = self.vertex_room == room
        ring, vertex_m = self.vertex_ring[own], self.written.vertex_m[own]
        rings = np.split(vertex_m, np.flatnonzero(np.diff(ring)) + 1) if len(ring) else []
        return tuple(tuple((x_m, y_m) for x_m, y_m in points.tolist()) for points in rings)

    def corners(self, room: int) -> tuple[Corner, ...]:
        """The corners on one room's boundary, in the order of the boundary path."""
        own = np.flatnonzero(self.feature_room == room)
        return tuple(Corner(_point(self.written.feature_m[row]), bool(self.feature_convex[row])) for row in own)

    def neighbours(self, room: int) -> tuple[int, ...]:
        """The ids of the rooms that share a door with this one, sorted."""
        near = np.concatenate([self.room_b[self.room_a == room], self.room_a[self.room_b == room]])
        return tuple(np.unique(near).tolist())

    def to_networkx(self) -> nx.MultiGraph[int]:
        """The graph: rooms as nodes with name, area_m2 and centre_m; doors as edges with their fields, keyed by id."""
        import networkx as nx  # noqa: PLC0415  # a seventh of a second, only for this graph

        graph: nx.MultiGraph[int] = nx.MultiGraph()
        for room in self.rooms:
            graph.add_node(room.id, name=room.name, area_m2=room.area_m2, centre_m=room.centre_m)
        for door in self.doors:
            graph.add_edge(
                *door.rooms,
                key=door.id,
                kind=door.kind,
                width_m=door.width_m,
                length_m=door.length_m,
                tilt_deg=door.tilt_deg,
                start_m=door.start_m,
                end_m=door.end_m,
            )
        return graph


def _point(row: NDArray[np.float64]) -> tuple[float, float]:
    return float(row[0]), float(row[1])


def signed_area_m2(ring: Ring) -> float:
    """Signed area of a closed ring: positive if it runs counter-clockwise (y up)."""
    x_m, y_m = ring[0]  # relative to the first vertex: far from the origin the products would lose precision
    doubled_m2 = sum(
        (ax_m - x_m) * (by_m - y_m) - (bx_m - x_m) * (ay_m - y_m) for (ax_m, ay_m), (bx_m, by_m) in pairwise(ring)
    )
    return doubled_m2 / 2
