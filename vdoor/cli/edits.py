"""`vdoor rename`, `vdoor split`, `vdoor merge` and `vdoor door`."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, NamedTuple

import typer

from vdoor.cli.rooms import Result
from vdoor.cli.run_edits import EDITS
from vdoor.errors import SettingError, VdoorError, say

if TYPE_CHECKING:
    from vdoor.editing.edits import Edit
    from vdoor.editing.places import Point
    from vdoor.export import Finished
    from vdoor.topology import TopologicalMap

RoomWord = Annotated[str, typer.Argument(metavar="ROOM", help="A room's id or name, or a place in it as X,Y.")]
PlaceWord = Annotated[str, typer.Argument(metavar="X,Y", help="An end of the line, m in the map frame.")]
EditsFile = Annotated[
    Path | None,
    typer.Option("--edits", metavar="FILE.toml", help="Where edits are kept. Default: edits.toml in the folder."),
]

ID = re.compile("[0-9]{1,9}")
"""More digits are the id of nothing."""


def rename(
    result: Result,
    room: RoomWord,
    name: Annotated[str, typer.Argument(metavar="NAME", help="What it is called from now on.")],
    *,
    edits: EditsFile = None,
) -> None:
    """Give a room a name: in the result folder, and in its edits for the next run."""
    from vdoor.editing.edits import Edit

    desk = _Desk(result, edits)
    _, place = desk.room(room)
    after, (found, *_) = desk.do(Edit("name", (place,), name=name.strip()))
    print(f"room {found} is called {after.room(found).name}")


def split(result: Result, start: PlaceWord, end: PlaceWord, *, edits: EditsFile = None) -> None:
    """Cut a room in two along a line, which goes on to the room's walls."""
    from vdoor.editing.edits import Edit

    desk = _Desk(result, edits)
    _say_parts(desk.do(Edit("split", (desk.place(start), desk.place(end)))))


def merge(result: Result, room: RoomWord, other: RoomWord, *, edits: EditsFile = None) -> None:
    """Make two rooms that touch one, which keeps the id and name of the first."""
    from vdoor.editing.edits import Edit

    desk = _Desk(result, edits)
    (one, place), (two, beside) = desk.room(room), desk.room(other)
    if one == two:
        raise SettingError(f"merge: wanted two rooms, found room {one} twice: {result}")
    after, _ = desk.do(Edit("merge", (place, beside)))
    print(f"rooms {one} and {two} are room {one} now, {after.room(one).area_m2:.2f} m2")


def door(
    action: Annotated[str, typer.Argument(metavar="add|remove", help="What to do.")],
    result: Result,
    places: Annotated[list[str], typer.Argument(metavar="PLACES", help="add: X,Y X,Y; remove: DOOR or X,Y.")],
    *,
    edits: EditsFile = None,
) -> None:
    """Add a door from one place to another, jamb to jamb, or remove one: the rooms it joins become one."""
    from vdoor.editing.edits import Edit

    wanted = {"add": 2, "remove": 1}
    if action not in wanted:
        raise SettingError(f"door: wanted add or remove, found {action!r}")
    if len(places) != wanted[action]:
        raise SettingError(f"door {action}: wanted {['DOOR or X,Y', 'X,Y X,Y'][wanted[action] - 1]}, found {places}")
    desk = _Desk(result, edits)
    if action == "add":
        start, end = (desk.place(text) for text in places)
        _say_parts(desk.do(Edit("add-door", (start, end))))
        return
    place = desk.door(places[0])
    before = {room.id for room in desk.topology.rooms}
    after, (kept, *_) = desk.do(Edit("remove-door", (place,)))
    gone = ", ".join(map(str, sorted(before - set(after.room_ids))))
    print(f"the door is open: room {kept} takes in room {gone}")


class Done(NamedTuple):
    """The map after an edit, and the ids of the rooms that it speaks of: largest part of a cut first."""

    topology: TopologicalMap
    rooms: list[int]


class _Desk:
    """A result that is edited, and the file that its edits are kept in."""

    def __init__(self, result: Path, file: Path | None) -> None:
        from vdoor.export import read_finished
        from vdoor.matching import Older

        self.result = result
        self.finished: Finished = read_finished(result)
        self.topology = self.finished.topology
        self._older = Older.of(self.topology, self.finished.settings)
        beside = result / EDITS if result.is_dir() else result.with_name(f"{result.stem}.{EDITS}")
        self.file = file or beside

    def place(self, text: str, *, what: str = "place", wanted: str = "X,Y") -> Point:
        """Where X,Y is."""
        from vdoor.editing.places import parse_place

        return parse_place(text, what=what, wanted=wanted)

    def room(self, word: str) -> tuple[int, Point]:
        """A room by its id, its name or a place in it: its id and that place, or its middle."""
        topology = self.topology
        if ID.fullmatch(word):
            room = topology.room(int(word))
        elif word in topology.name and word:
            room = topology.room_named(word)
        else:
            place = self.place(word, what="room", wanted="a room's id, its name or X,Y")
            at = topology.room_at(place)
            if at is None:
                raise SettingError(f"room: wanted a place in a room, found none at {word}: {self.result}")
            return at.id, place
        return room.id, room.centre_m

    def door(self, word: str) -> Point:
        """Where a door is, by its id or a place."""
        if not ID.fullmatch(word):
            return self.place(word, what="door", wanted="a door's id or X,Y")
        door = self.topology.door(int(word))
        return (door.start_m[0] + door.end_m[0]) / 2, (door.start_m[1] + door.end_m[1]) / 2

    def do(self, edit: Edit) -> Done:
        """The map after an edit, which is kept; `VdoorError` where it cannot be done on this map."""
        from vdoor.editing.apply import DONE, NEEDLESS, VERDICTS, EditRooms
        from vdoor.editing.edits import parse

        edit = parse(str(edit))  # places to the millimetre, as the file has them
        after, told = EditRooms(edits=(str(edit),), taken=self._older.taken)(self.topology)
        assert told is not None  # there is an edit to tell of
        verdict, rooms = VERDICTS[told.verdict[0]], told.touched_room.tolist()
        if verdict == NEEDLESS:
            say(f"note: that is so already: {self.result}")
        elif verdict != DONE:
            raise VdoorError(f"{edit}: {verdict}: {self.result}")
        else:
            self._keep(edit, after)
        return Done(after, rooms)

    def _keep(self, edit: Edit, after: TopologicalMap) -> None:
        """Write the edit behind those that the result was made with, and the map after it into the folder."""
        from vdoor.editing.edits import append_edits, read_edits
        from vdoor.files import write_whole
        from vdoor.results.writing import rewritten

        before = list(self._older.edits)
        lines = [*map(str, before), str(edit)]
        files = rewritten(self.result, after, lines) if self.result.is_dir() else []
        there = read_edits(self.file) if self.file.exists() else before
        if there != before:
            say(f"note: the result was made with other edits than this file holds: {self.file}")
        append_edits(self.file, [edit] if self.file.exists() else [*before, edit])
        for path, content in files:
            write_whole(path, content)
        say(f"edits are in {self.file}; `vdoor run MAP --edits {self.file}` does them again")


def _say_parts(done: Done) -> None:
    """Which rooms there are now where one was cut."""
    parts = (done.topology.room(number) for number in done.rooms)
    rooms = " and ".join(f"{room.id} ({room.area_m2:.2f} m2)" for room in parts)
    print(f"room {done.rooms[0]} is now rooms {rooms}")
