"""`vdoor rename`, `vdoor split`, `vdoor merge` and `vdoor door`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from vdoor.cli.rooms import Result
from vdoor.cli.run_edits import EDITS
from vdoor.errors import SettingError, VdoorError
from vdoor.say import say

if TYPE_CHECKING:
    from vdoor.edits import Edit
    from vdoor.export import Finished
    from vdoor.places import Point
    from vdoor.topology import TopologicalMap

RoomWord = Annotated[str, typer.Argument(metavar="ROOM", help="A room's id or name, or a place in it as X,Y.")]
PlaceWord = Annotated[str, typer.Argument(metavar="X,Y", help="An end of the line, m in the map frame.")]
EditsFile = Annotated[
    Path | None,
    typer.Option("--edits", metavar="FILE.toml", help="Where edits are kept. Default: edits.toml in the folder."),
]


def rename(
    result: Result,
    room: RoomWord,
    name: Annotated[str, typer.Argument(metavar="NAME", help="What it is called from now on.")],
    *,
    edits: EditsFile = None,
) -> None:
    """Give a room a name: in the result folder, and in its edits for the next run."""
    from vdoor.edits import Edit

    desk = _Desk(result, edits)
    _, place = desk.room(room)
    after = desk.do(Edit("name", (place,), name=name.strip()))
    found = _there(after, place)
    print(f"room {found} is called {after.room(found).name}")


def split(result: Result, start: PlaceWord, end: PlaceWord, *, edits: EditsFile = None) -> None:
    """Cut a room in two along a line, which goes on to the room's walls."""
    from vdoor.edits import Edit

    desk = _Desk(result, edits)
    _say_parts(desk, desk.do(Edit("split", (desk.place(start), desk.place(end)))))


def merge(result: Result, room: RoomWord, other: RoomWord, *, edits: EditsFile = None) -> None:
    """Make two rooms that touch one, which keeps the id and name of the first."""
    from vdoor.edits import Edit

    desk = _Desk(result, edits)
    (one, place), (two, beside) = desk.room(room), desk.room(other)
    after = desk.do(Edit("merge", (place, beside)))
    print(f"rooms {one} and {two} are room {one} now, {after.room(one).area_m2:.2f} m2")


def door(
    action: Annotated[str, typer.Argument(metavar="add|remove", help="What to do.")],
    result: Result,
    places: Annotated[list[str], typer.Argument(metavar="PLACES", help="add: X,Y X,Y; remove: DOOR or X,Y.")],
    *,
    edits: EditsFile = None,
) -> None:
    """Add a door from one place to another, jamb to jamb, or remove one: the rooms it joins become one."""
    from vdoor.edits import Edit

    wanted = {"add": 2, "remove": 1}
    if action not in wanted:
        raise SettingError(f"door: wanted add or remove, found {action!r}")
    if len(places) != wanted[action]:
        raise SettingError(f"door {action}: wanted {['DOOR or X,Y', 'X,Y X,Y'][wanted[action] - 1]}, found {places}")
    desk = _Desk(result, edits)
    if action == "add":
        start, end = (desk.place(text) for text in places)
        _say_parts(desk, desk.do(Edit("add-door", (start, end))))
        return
    place = desk.door(places[0])
    before = {room.id for room in desk.topology.rooms}
    after = desk.do(Edit("remove-door", (place,)))
    gone = ", ".join(map(str, sorted(before - set(after.room_ids))))
    print(f"the door is open: room {_there(after, place)} takes in room {gone}")


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

    def place(self, text: str) -> Point:
        """Where X,Y is."""
        from vdoor.places import parse_place

        return parse_place(text)

    def room(self, word: str) -> tuple[int, Point]:
        """A room by its id, its name or a place in it: its id and that place, or its middle."""
        topology = self.topology
        if word.isascii() and word.isdigit():
            room = topology.room(int(word[:9]))
        elif word in topology.name and word:
            room = topology.room_named(word)
        else:
            place = self.place(word)
            at = topology.room_at(place)
            if at is None:
                raise SettingError(f"room: wanted a place in a room, found none at {word}: {self.result}")
            return at.id, place
        return room.id, room.centre_m

    def door(self, word: str) -> Point:
        """Where a door is, by its id or a place."""
        if not (word.isascii() and word.isdigit()):
            return self.place(word)
        door = self.topology.door(int(word[:9]))
        return (door.start_m[0] + door.end_m[0]) / 2, (door.start_m[1] + door.end_m[1]) / 2

    def do(self, edit: Edit) -> TopologicalMap:
        """The map after an edit, which is kept; `VdoorError` where it cannot be done on this map."""
        from vdoor.edits import append_edits, parse, read_edits
        from vdoor.formats.result import refuse_high_ids, rewrite_result
        from vdoor.stages.edit import DONE, NEEDLESS, VERDICTS, EditRooms

        edit = parse(str(edit))  # places to the millimetre, as the file has them
        after, told = EditRooms(edits=(str(edit),), taken=self._older.taken)(self.topology)
        verdict = VERDICTS[told.verdict[0]] if told is not None else NEEDLESS
        if verdict not in (DONE, NEEDLESS):
            raise VdoorError(f"{edit}: {verdict}: {self.result}")
        if verdict == NEEDLESS:
            say(f"note: that is so already: {self.result}")
            return after
        if self.result.is_dir():
            refuse_high_ids(self.result, after)
        before = list(self._older.edits)
        there = read_edits(self.file) if self.file.exists() else before
        if there != before:
            say(f"note: the result was made with other edits than this file holds: {self.file}")
        append_edits(self.file, [edit] if self.file.exists() else [*before, edit])
        if self.result.is_dir():
            rewrite_result(self.result, after, [*map(str, before), str(edit)])
        say(f"edits are in {self.file}; `vdoor run MAP --edits {self.file}` does them again")
        return after


def _there(topology: TopologicalMap, place: Point) -> int:
    """Id of the room at a place, or nearest to it."""
    from vdoor.stages.edit import room_near

    return room_near(topology, place)


def _say_parts(desk: _Desk, after: TopologicalMap) -> None:
    """What rooms there are now that were none before, and what is left of the one they were cut from."""
    before = {room.id: room.area_m2 for room in desk.topology.rooms}
    changed = [room for room in after.rooms if before.get(room.id) != room.area_m2]
    cut = [room.id for room in changed if room.id in before]
    rooms = " and ".join(f"{room.id} ({room.area_m2:.2f} m2)" for room in changed)
    print(f"room {cut[0] if cut else '?'} is now rooms {rooms}")
