"""After the search: what people change about the rooms and doors that were found."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Annotated, ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from vdoor.config import Within
from vdoor.editing.closed_doors import Opening, openings
from vdoor.editing.draft import Draft
from vdoor.editing.edits import FORMS, MOST_ID, Edit, parse
from vdoor.editing.places import Point
from vdoor.editing.split_room import within
from vdoor.errors import SettingError
from vdoor.grid import FREE, OccupancyGrid
from vdoor.method.final_doors import to_segment_m
from vdoor.record import Record, Spec
from vdoor.topology import TopologicalMap

DONE, NEEDLESS = "done", "not needed"
VERDICTS = (DONE, NEEDLESS, "no room there", "no door there", "no wall there", "rooms do not touch", "parts nothing")
REACH_M = 0.5
"""How far a place may lie from what it means."""


class Edits(Record):
    """What came of each edit; only of runs that have edits."""

    topic: ClassVar[str] = "edits"

    kind: Annotated[NDArray[np.uint8], Spec("code", "edit", words=tuple(FORMS))]
    verdict: Annotated[NDArray[np.uint8], Spec("code", "edit", words=VERDICTS)]
    start_m: Annotated[NDArray[np.float64], Spec("column", "edit 2", unit="m")]
    end_m: Annotated[NDArray[np.float64], Spec("column", "edit 2", unit="m")]
    """The places as x, y; the second is nan for an edit of one place."""
    touched_edit: Annotated[NDArray[np.int32], Spec("column", "touch")]
    touched_room: Annotated[NDArray[np.int32], Spec("column", "touch")]
    """Which edit speaks of which rooms, by the ids that these end with."""


class Edited(NamedTuple):
    """The map after the edits, and what came of them: None where there were none."""

    topology: TopologicalMap
    edits: Edits | None


class OpenedDoors(NamedTuple):
    """The map with closed doors opened, and what was opened for each edit, None where there is no wall."""

    grid: OccupancyGrid
    openings: dict[Edit, Opening | None]


class Outcome(NamedTuple):
    """What came of one edit, and the keys of the rooms that it speaks of."""

    verdict: str
    rooms: Sequence[int] = ()


@dataclass(frozen=True, kw_only=True)
class EditRooms:
    """Name, number, merge and split rooms, add and remove doors, open doors that were shut."""

    edits: tuple[str, ...] = ()
    """Edits, one after the other, as in "name 1.2,3.4 Kitchen"; also from files by --edits and places by
    --closed-door. All of them: name, number, merge, split, add-door, remove-door, closed-door."""
    taken: Annotated[int, Within(0, MOST_ID)] = 0
    """Ids up to this one have been given to rooms before: rooms made by edits get higher ones."""

    def __post_init__(self) -> None:
        """Refuse lines that are no edits."""
        for line in self.edits:
            try:
                parse(line)
            except SettingError as error:
                raise SettingError(f"edit.edits: {str(error).removeprefix('edit: ')}") from error

    @cached_property
    def parsed(self) -> tuple[Edit, ...]:
        """The edits."""
        return tuple(parse(line) for line in self.edits)

    def open_doors(self, grid: OccupancyGrid) -> OpenedDoors:
        """The map with closed doors opened; what has none stays as it is."""
        closed = [edit for edit in self.parsed if edit.kind == "closed-door"]
        found = openings(grid.free, grid.frame, [edit.places_m[0] for edit in closed])
        through = [opening for opening in found if opening is not None]
        if through:
            cells = grid.cells.copy()
            for opening in through:
                cells[tuple(opening.cells.T)] = FREE
            grid = OccupancyGrid(cells=cells, frame=grid.frame, source=grid.source)
        return OpenedDoors(grid, dict(zip(closed, found, strict=True)))

    def __call__(self, topology: TopologicalMap, opened: OpenedDoors | None = None) -> Edited:
        """The edited map; `opened` is what `open_doors` made of the map as read.

        An edit that cannot be done changes nothing and has a verdict that says why. Doors lie where rooms touch, as
        before, and those along a cut are of the kind `added`.
        """
        if not self.edits:
            return Edited(topology, None)
        draft = Draft(topology, taken=self.taken)
        desk = Desk(draft, opened.openings if opened is not None else {})
        outcomes = [DO[edit.kind](desk, edit) for edit in self.parsed]
        return Edited(draft.finished(), self._record(outcomes, draft))

    def _record(self, outcomes: Sequence[Outcome], draft: Draft) -> Edits:
        nowhere = (np.nan, np.nan)
        ends = [(*edit.places_m, nowhere)[:2] for edit in self.parsed]
        touched = [
            (row, draft.id_of[room])
            for row, outcome in enumerate(outcomes)
            for room in outcome.rooms
            if room in draft.id_of
        ]
        edit, room = np.array(touched, np.int32).reshape(-1, 2).T
        return Edits(
            kind=np.array([list(FORMS).index(edit.kind) for edit in self.parsed], np.uint8),
            verdict=np.array([VERDICTS.index(outcome.verdict) for outcome in outcomes], np.uint8),
            start_m=np.array([start for start, _ in ends], np.float64),
            end_m=np.array([end for _, end in ends], np.float64),
            touched_edit=edit,
            touched_room=room,
        )


@dataclass(frozen=True)
class Desk:
    """Where edits are done: the draft, and the openings of closed doors."""

    draft: Draft
    openings: dict[Edit, Opening | None] = field(default_factory=dict)

    def room_at(self, place_m: Point) -> int:
        """Key of the room at a place or, within reach, nearest to it; 0 where there is none."""
        return room_near(self.draft, place_m)

    def doors_at(self, place_m: Point) -> NDArray[np.intp]:
        """Rows of the door nearest to a place, one for each pair of its rooms; none where none is in reach."""
        doors = self.draft.doors
        apart_m = [
            float(to_segment_m(np.array([place_m]), start, end)[0])
            for start, end in zip(doors.start_m, doors.end_m, strict=True)
        ]
        if not apart_m or min(apart_m) > REACH_M:
            return np.zeros(0, np.intp)
        row = int(np.argmin(apart_m))
        same = (doors.start_m == doors.start_m[row]).all(axis=1) & (doors.end_m == doors.end_m[row]).all(axis=1)
        return np.flatnonzero(same)

    def cut(self, start_m: Point, end_m: Point, *, reach_m: float, gap_m: float = 0.0) -> Outcome:
        """Split along a line."""
        start, end = self.draft.frame.cell_from_world(np.array([start_m, end_m]))
        cell_m = self.draft.frame.resolution_m
        rooms = self.draft.split(start, end, reach=reach_m / cell_m, gap=gap_m / cell_m)
        if not rooms:
            return Outcome("no room there")
        return Outcome(DONE if len(rooms) > 1 else "parts nothing", rooms)


def edited(topology: TopologicalMap, edits: Iterable[str]) -> TopologicalMap:
    """The map after edits, one after the other, as in ``name 1.2,3.4 Kitchen``; `vdoor.editing.edits` lists all forms.

    An edit that cannot be done here changes nothing. Raises `SettingError` for a line that is no edit.
    """
    after = EditRooms(edits=tuple(edits))(topology).topology
    return dataclasses.replace(after, own_origin_cm=topology.own_origin_cm)


def room_near(rooms: Draft | TopologicalMap, place_m: Point) -> int:
    """Label of the room at a place or, within reach, nearest to it; 0 where there is none."""
    labels, frame = rooms.labels, rooms.frame
    place = frame.cell_from_world(np.array([place_m]))[0]
    reach = REACH_M / frame.resolution_m
    low = np.maximum(np.floor(place - reach), 0).astype(int)
    near = labels[low[0] : max(int(place[0] + reach) + 2, 0), low[1] : max(int(place[1] + reach) + 2, 0)]
    cells = np.argwhere(near)
    apart = cells + low - place
    inside = ((apart >= -0.5) & (apart < 0.5)).all(axis=1)  # noqa: PLR2004  # half a cell
    distance = np.where(inside, -1.0, np.hypot(*apart.T))
    if not len(cells) or distance.min() > reach:
        return 0
    return int(near[tuple(cells[np.argmin(distance)])])


def _name(desk: Desk, edit: Edit) -> Outcome:
    room = desk.room_at(edit.places_m[0])
    if not room:
        return Outcome("no room there")
    same = desk.draft.name_of.get(room) == edit.name
    desk.draft.name_of[room] = edit.name
    return Outcome(NEEDLESS if same else DONE, [room])


def _number(desk: Desk, edit: Edit) -> Outcome:
    room = desk.room_at(edit.places_m[0])
    if not room:
        return Outcome("no room there")
    if desk.draft.id_of[room] == edit.id:
        return Outcome(NEEDLESS, [room])
    desk.draft.number(room, edit.id)
    return Outcome(DONE, [room])


def _merge(desk: Desk, edit: Edit) -> Outcome:
    one, other = (desk.room_at(place) for place in edit.places_m)
    if not (one and other):
        return Outcome("no room there", [room for room in (one, other) if room])
    if one == other:
        return Outcome(NEEDLESS, [one])
    if not desk.draft.touch(one, other):
        return Outcome("rooms do not touch", [one, other])
    desk.draft.merge(one, other)
    return Outcome(DONE, [one])


def _split(desk: Desk, edit: Edit) -> Outcome:
    start_m, end_m = edit.places_m
    return desk.cut(start_m, end_m, reach_m=np.inf, gap_m=REACH_M)


def _add_door(desk: Desk, edit: Edit) -> Outcome:
    start_m, end_m = edit.places_m
    return desk.cut(start_m, end_m, reach_m=REACH_M)


def _remove_door(desk: Desk, edit: Edit) -> Outcome:
    rows = desk.doors_at(edit.places_m[0])
    if not len(rows):
        return Outcome("no door there")
    rooms = np.unique([desk.draft.doors.room_a[rows], desk.draft.doors.room_b[rows]])
    cells = [np.count_nonzero(desk.draft.labels == room) for room in rooms]
    kept, *others = rooms[np.argsort(-np.array(cells), kind="stable")].tolist()
    for other in others:
        desk.draft.merge(kept, other)
    return Outcome(DONE, [kept])


def _closed_door(desk: Desk, edit: Edit) -> Outcome:
    """What was opened before the search is a door after it, unless another way around it leads to the same room.

    Where the place is in a room the door stood open when this map was made.
    """
    frame, labels = desk.draft.frame, desk.draft.labels
    opening = desk.openings.get(edit)
    if opening is None:
        cell = np.floor(frame.cell_from_world(np.array([edit.places_m[0]])) + 0.5).astype(np.int64)
        room = int(labels[tuple(cell[0])]) if within(cell, labels.shape)[0] else 0
        return Outcome(NEEDLESS, [room]) if room else Outcome("no wall there")
    sides = [int(labels[tuple(cell)]) for cell in opening.sides]
    if 0 in sides:
        return Outcome("no room there", [room for room in sides if room])
    if sides[0] != sides[1]:
        return Outcome(DONE, sides)
    start_m, end_m = frame.world_from_cell(np.array([opening.start, opening.end])).tolist()
    return desk.cut(start_m, end_m, reach_m=REACH_M)


DO: dict[str, Callable[[Desk, Edit], Outcome]] = {
    "name": _name,
    "number": _number,
    "merge": _merge,
    "split": _split,
    "add-door": _add_door,
    "remove-door": _remove_door,
    "closed-door": _closed_door,
}


def told(edits: Edits, lines: Sequence[str]) -> Iterator[tuple[str, str]]:
    """Each edit as a line, with its verdict."""
    for line, verdict in zip(lines, edits.verdict.tolist(), strict=True):
        yield line, VERDICTS[verdict]
