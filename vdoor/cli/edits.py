"""`vdoor rename`, `vdoor split`, `vdoor merge` and `vdoor door`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from vdoor.cli.rooms import Result
from vdoor.errors import SettingError, say

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
    _do(result, edits, "rename", room, name)


def split(result: Result, start: PlaceWord, end: PlaceWord, *, edits: EditsFile = None) -> None:
    """Split a room in two along a line, which is extended to the room's walls."""
    _do(result, edits, "split", start, end)


def merge(result: Result, room: RoomWord, other: RoomWord, *, edits: EditsFile = None) -> None:
    """Merge two adjacent rooms; the merged room keeps the id and name of the first."""
    _do(result, edits, "merge", room, other)


def door(
    action: Annotated[str, typer.Argument(metavar="add|remove", help="Action.")],
    result: Result,
    places: Annotated[list[str], typer.Argument(metavar="PLACES", help="add: X,Y X,Y; remove: DOOR or X,Y.")],
    *,
    edits: EditsFile = None,
) -> None:
    """Add a door from jamb to jamb, or remove a door, which merges its rooms."""
    wanted = {"add": 2, "remove": 1}
    if action not in wanted:
        raise SettingError(f"door: wanted add or remove, found {action!r}")
    if len(places) != wanted[action]:
        raise SettingError(f"door {action}: wanted {['DOOR or X,Y', 'X,Y X,Y'][wanted[action] - 1]}, found {places}")
    _do(result, edits, f"{action}-door", *places)


def _do(result: Path, file: Path | None, action: str, *words: str) -> None:
    """Change the result, store the edit, and print what was done."""
    from vdoor.results.editor import ACTIONS, ResultEditor

    editor = ResultEditor(result, file)
    change = ACTIONS[action].change(editor, *words)
    if change.files and editor.note:
        say(f"note: {editor.note}")
    change.write()
    if change.files:
        say(f"edits are stored in {editor.file}; `vdoor run MAP --edits {editor.file}` applies them again")
    else:
        say(f"note: nothing to change: {result}")
    print(change.said)
