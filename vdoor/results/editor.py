"""Editing a finished result: what the commands and the page to edit on both do, with the same words and files."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NamedTuple

from vdoor.editing.apply import DONE, NEEDLESS, VERDICTS, EditRooms
from vdoor.editing.edits import Edit, appended, parse, read_edits
from vdoor.editing.lookup import find_door, find_room
from vdoor.editing.places import Point, parse_place
from vdoor.errors import SettingError, VdoorError, naming
from vdoor.matching import Older
from vdoor.partial import together
from vdoor.results.reading import read_finished
from vdoor.results.writing import rewritten
from vdoor.topology import TopologicalMap

EDITS = "edits.toml"


class RefusedError(VdoorError):
    """An edit that cannot be applied to this map; `verdict` is one of `vdoor.editing.apply.VERDICTS`."""

    def __init__(self, text: str, verdict: str) -> None:
        super().__init__(text)
        self.verdict = verdict


class Change(NamedTuple):
    """What an edit does, not yet written."""

    said: str
    """What it does, in one line."""
    topology: TopologicalMap
    files: Sequence[tuple[Path, bytes]] = ()
    """The new contents of the files that change; none if the edit is not needed."""

    def write(self) -> None:
        """Write the files, all or none."""
        with together() as staged:
            for path, content in self.files:
                staged.add(path, content)


class ResultEditor:
    """A result as it is stored now, and the changes that edits would make to its files.

    Raises `VdoorError` if the result cannot be read. The edits of a recording are stored beside it; it stays as it is.
    """

    def __init__(self, result: Path, file: Path | None = None) -> None:
        self.result = result
        finished = read_finished(result)
        self.topology = finished.topology
        self._older = Older.of(self.topology, finished.settings)
        self.file = file or edits_file(result)
        """The file that stores the edits."""

    @property
    def note(self) -> str:
        """What is odd about the file of edits; empty if nothing."""
        if self.file.exists() and read_edits(self.file) != [*self._older.edits]:
            return f"the result was made with other edits than those in this file: {self.file}"
        return ""

    def rename(self, room: str, name: str) -> Change:
        """Name a room, which is given by its id, its name or a point in it, like all rooms here."""
        found, place_m = self._room(room)
        return self._change(
            Edit("name", (place_m,), name=name.strip()), lambda _: f"room {found} is now named {name.strip()}"
        )

    def split(self, start: str, end: str) -> Change:
        """Split a room along a line, which is extended to the room's walls."""
        return self._change(Edit("split", (parse_place(start), parse_place(end))), _pieces)

    def merge(self, room: str, other: str) -> Change:
        """Merge two adjacent rooms; the merged room keeps the id and name of the first."""
        (one, place_m), (two, beside_m) = self._room(room), self._room(other)
        if one == two:
            raise SettingError(f"merge: wanted two rooms, found room {one} twice: {self.result}")

        def said(done: _Done) -> str:
            return f"rooms {one} and {two} are now room {one} ({done.topology.room(one).area_m2:.2f} m2)"

        return self._change(Edit("merge", (place_m, beside_m)), said)

    def add_door(self, start: str, end: str) -> Change:
        """Add a door from jamb to jamb."""
        return self._change(Edit("add-door", (parse_place(start), parse_place(end))), _pieces)

    def remove_door(self, door: str) -> Change:
        """Remove a door, which is given by its id or a point at it; its rooms are merged."""
        with naming(self.result):
            place_m = find_door(self.topology, door).place_m

        def said(done: _Done) -> str:
            gone = ", ".join(map(str, sorted({*self.topology.room_ids} - {*done.topology.room_ids})))
            return f"door removed: room {gone} is now part of room {done.rooms[0]}"

        return self._change(Edit("remove-door", (place_m,)), said)

    def _room(self, word: str) -> tuple[int, Point]:
        """The id of a room, and the given point in it or its centre."""
        with naming(self.result):
            room, place_m = find_room(self.topology, word)
        return room.id, place_m

    def _change(self, edit: Edit, said: Callable[[_Done], str]) -> Change:
        """What an edit changes; raises `RefusedError` if it cannot be applied to this map."""
        edit = parse(str(edit))  # points to the millimetre, as in the file
        after, record = EditRooms(edits=(str(edit),), taken=self._older.taken)(self.topology)
        assert record is not None  # there is an edit
        verdict = VERDICTS[record.verdict[0]]
        if verdict not in (DONE, NEEDLESS):
            raise RefusedError(f"{edit}: {verdict}: {self.result}", verdict)
        text = said(_Done(after, record.touched_room.tolist()))
        return Change(text, after, self._files(edit, after) if verdict == DONE else ())

    def _files(self, edit: Edit, after: TopologicalMap) -> list[tuple[Path, bytes]]:
        """The new contents of the files: the edit behind those that the result was made with, and the edited map."""
        before = self._older.edits
        stored = appended(self.file, [edit] if self.file.exists() else [*before, edit])
        lines = [*map(str, before), str(edit)]
        files = rewritten(self.result, after, lines) if self.result.is_dir() else []
        return [*files, (self.file, stored)]


class _Done(NamedTuple):
    """The map after an edit, and the ids of the affected rooms; after a split, the largest piece comes first."""

    topology: TopologicalMap
    rooms: list[int]


class Action(NamedTuple):
    """Something that can be done to a result, and how many words it takes."""

    change: Callable[..., Change]
    words: int


ACTIONS = {
    "rename": Action(ResultEditor.rename, 2),
    "split": Action(ResultEditor.split, 2),
    "merge": Action(ResultEditor.merge, 2),
    "add-door": Action(ResultEditor.add_door, 2),
    "remove-door": Action(ResultEditor.remove_door, 1),
}


def edits_file(result: Path) -> Path:
    """The file that stores the edits of a result, unless another is given."""
    return result / EDITS if result.is_dir() else result.with_name(f"{result.stem}.{EDITS}")


def _pieces(done: _Done) -> str:
    """The rooms that a room was split into."""
    pieces = (done.topology.room(number) for number in done.rooms)
    rooms = " and ".join(f"{room.id} ({room.area_m2:.2f} m2)" for room in pieces)
    return f"room {done.rooms[0]} is now rooms {rooms}"
