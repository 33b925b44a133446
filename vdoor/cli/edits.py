"""`vdoor rename`, `vdoor split`, `vdoor merge` and `vdoor door`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, NamedTuple

import typer

from vdoor.cli.options import naming
from vdoor.cli.rooms import Result
from vdoor.cli.run_edits import EDITS
from vdoor.errors import SettingError, VdoorError, say

if TYPE_CHECKING:
    from vdoor.editing.edits import Edit
    from vdoor.editing.places import Point
    from vdoor.export import Finished
    from vdoor.topology import TopologicalMap

RoomWord = Annotated[str, typer.Argument(metavar="ROOM", help="Id or name of a room, or a point in it as X,Y.")]
PlaceWord = Annotated[str, typer.Argument(metavar="X,Y", help="End of the line, metres in the map frame.")]
EditsFile = Annotated[
    Path | None,
    typer.Option("--edits", metavar="FILE.toml", help="File that stores the edits. Default: edits.toml in the folder."),
]


def rename(
    result: Result,
    room: RoomWord,
    name: Annotated[str, typer.Argument(metavar="NAME", help="New name.")],
    *,
    edits: EditsFile = None,
) -> None:
    """Name a room, in the result folder and in its edits for the next run."""
    from vdoor.editing.edits import Edit

    editor = _Editor(result, edits)
    _, place = editor.room(room)
    after, (found, *_) = editor.do(Edit("name", (place,), name=name.strip()))
    print(f"room {found} is now named {after.room(found).name}")


def split(result: Result, start: PlaceWord, end: PlaceWord, *, edits: EditsFile = None) -> None:
    """Split a room in two along a line, which is extended to the room's walls."""
    from vdoor.editing.edits import Edit

    editor = _Editor(result, edits)
    _print_split(editor.do(Edit("split", (editor.place(start), editor.place(end)))))


def merge(result: Result, room: RoomWord, other: RoomWord, *, edits: EditsFile = None) -> None:
    """Merge two adjacent rooms; the merged room keeps the id and name of the first."""
    from vdoor.editing.edits import Edit

    editor = _Editor(result, edits)
    (one, place), (two, beside) = editor.room(room), editor.room(other)
    if one == two:
        raise SettingError(f"merge: wanted two rooms, found room {one} twice: {result}")
    after, _ = editor.do(Edit("merge", (place, beside)))
    print(f"rooms {one} and {two} are now room {one} ({after.room(one).area_m2:.2f} m2)")


def door(
    action: Annotated[str, typer.Argument(metavar="add|remove", help="Action.")],
    result: Result,
    places: Annotated[list[str], typer.Argument(metavar="PLACES", help="add: X,Y X,Y; remove: DOOR or X,Y.")],
    *,
    edits: EditsFile = None,
) -> None:
    """Add a door from jamb to jamb, or remove a door, which merges its rooms."""
    from vdoor.editing.edits import Edit

    wanted = {"add": 2, "remove": 1}
    if action not in wanted:
        raise SettingError(f"door: wanted add or remove, found {action!r}")
    if len(places) != wanted[action]:
        raise SettingError(f"door {action}: wanted {['DOOR or X,Y', 'X,Y X,Y'][wanted[action] - 1]}, found {places}")
    editor = _Editor(result, edits)
    if action == "add":
        start, end = (editor.place(text) for text in places)
        _print_split(editor.do(Edit("add-door", (start, end))))
        return
    place = editor.door(places[0])
    before = {room.id for room in editor.topology.rooms}
    after, (kept, *_) = editor.do(Edit("remove-door", (place,)))
    gone = ", ".join(map(str, sorted(before - set(after.room_ids))))
    print(f"door removed: room {gone} is now part of room {kept}")


class Done(NamedTuple):
    """The map after an edit, and the ids of the affected rooms; after a split, the largest piece comes first."""

    topology: TopologicalMap
    rooms: list[int]


class _Editor:
    """A result to edit, and the file that stores its edits."""

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
        """Point from X,Y."""
        from vdoor.editing.places import parse_place

        return parse_place(text)

    def room(self, word: str) -> tuple[int, Point]:
        """Id of a room given by id, name or a point in it, and that point or the room's centre."""
        from vdoor.editing.lookup import find_room

        with naming(self.result):
            room, place_m = find_room(self.topology, word)
        return room.id, place_m

    def door(self, word: str) -> Point:
        """Middle of a door given by its id, or the given point."""
        from vdoor.editing.lookup import find_door

        with naming(self.result):
            return find_door(self.topology, word).place_m

    def do(self, edit: Edit) -> Done:
        """The map after an edit, which is stored; `VdoorError` if it cannot be applied to this map."""
        from vdoor.editing.apply import DONE, NEEDLESS, VERDICTS, EditRooms
        from vdoor.editing.edits import parse

        edit = parse(str(edit))  # points to the millimetre, as in the file
        after, record = EditRooms(edits=(str(edit),), taken=self._older.taken)(self.topology)
        assert record is not None  # there is an edit
        verdict, rooms = VERDICTS[record.verdict[0]], record.touched_room.tolist()
        if verdict == NEEDLESS:
            say(f"note: nothing to change: {self.result}")
        elif verdict != DONE:
            raise VdoorError(f"{edit}: {verdict}: {self.result}")
        else:
            self._keep(edit, after)
        return Done(after, rooms)

    def _keep(self, edit: Edit, after: TopologicalMap) -> None:
        """Append the edit to those that the result was made with, and write the edited map into the folder."""
        from vdoor.editing.edits import appended, read_edits
        from vdoor.partial import together
        from vdoor.results.writing import rewritten

        before = list(self._older.edits)
        lines = [*map(str, before), str(edit)]
        files = rewritten(self.result, after, lines) if self.result.is_dir() else []
        stored = read_edits(self.file) if self.file.exists() else before
        if stored != before:
            say(f"note: the result was made with other edits than those in this file: {self.file}")
        text = appended(self.file, [edit] if self.file.exists() else [*before, edit])
        with together() as staged:
            for path, content in [*files, (self.file, text)]:
                staged.add(path, content)
        say(f"edits are stored in {self.file}; `vdoor run MAP --edits {self.file}` applies them again")


def _print_split(done: Done) -> None:
    """Print the rooms that a room was split into."""
    pieces = (done.topology.room(number) for number in done.rooms)
    rooms = " and ".join(f"{room.id} ({room.area_m2:.2f} m2)" for room in pieces)
    print(f"room {done.rooms[0]} is now rooms {rooms}")
