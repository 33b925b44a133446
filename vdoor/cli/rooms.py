"""`vdoor rooms` and `vdoor room-at`: asking a finished map."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

import typer

from vdoor.cli.options import Json
from vdoor.errors import SettingError
from vdoor.say import say

if TYPE_CHECKING:
    from vdoor.topology import Door, Room, TopologicalMap

Result = Annotated[Path, typer.Argument(metavar="RESULT", help="An .mcap, or a folder of `vdoor run --out`.")]


FARTHEST = 1e9


class Line(NamedTuple):
    """One room with the doors that lead out of it."""

    room: Room
    doors: list[Door]


COLUMNS: tuple[tuple[str, Callable[[Line], str]], ...] = (
    ("room", lambda line: str(line.room.id)),
    ("area m2", lambda line: f"{line.room.area_m2:.2f}"),
    ("centre x,y m", lambda line: "{:.2f},{:.2f}".format(*line.room.centre_m)),
    ("doors", lambda line: " ".join(str(door.id) for door in line.doors) or "none"),
    ("neighbours", lambda line: " ".join(map(str, line.room.neighbours)) or "none"),
)
"""Head of each column of the table, and what it says of a room."""


def rooms(result: Result, *, as_json: Json = False) -> None:
    """List the rooms of a result with their areas, doors and neighbours."""
    import json

    from vdoor.export import read_finished

    lines = list(_lines(read_finished(result).topology))
    if as_json:
        print(json.dumps({"rooms": [_table(line) for line in lines]}))
        return
    cells = [[head for head, _ in COLUMNS], *([tell(line) for _, tell in COLUMNS] for line in lines)]
    widths = [max(map(len, column)) for column in zip(*cells, strict=True)]
    for row in cells:
        print("  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip())


def room_at(
    place: Annotated[str, typer.Argument(metavar="X,Y", help="Where, m in the map frame.")],
    result: Result,
    *,
    cells: Annotated[bool, typer.Option("--cells", help="The place is COL,ROW of the map instead.")] = False,
    as_json: Json = False,
) -> None:
    """Tell which room a place is in: 0 and the room's number, or 1 where there is no room."""
    import json

    import numpy as np

    from vdoor.export import read_finished

    x, y = _pair(place, "COL,ROW" if cells else "X,Y")
    topology = read_finished(result).topology
    cell = np.array([[y, x]]) if cells else topology.frame.cell_from_world(np.array([[x, y]]))
    row, col = np.floor(cell[0] + 0.5).tolist()
    inside = 0 <= row < topology.frame.height and 0 <= col < topology.frame.width
    room = int(topology.labels[int(row), int(col)]) if inside else 0
    if as_json:
        line = _table(next(line for line in _lines(topology) if line.room.id == room)) if room else None
        print(json.dumps({"cell": [int(col), int(row)] if inside else None, "room": line}))
    elif room:
        print(f"room {room}")
    if not room:
        say(f"room-at: no room at {place}, {'a cell that is in none' if inside else 'outside the map'}: {result}")
        raise typer.Exit(1)


def _lines(topology: TopologicalMap) -> list[Line]:
    """All rooms in order."""
    doors = topology.doors
    return [Line(room, [door for door in doors if room.id in door.rooms]) for room in topology.rooms]


def _table(line: Line) -> dict[str, Any]:
    """One room as plain values."""
    room = line.room
    return {
        "id": room.id,
        "area_m2": room.area_m2,
        "centre_m": room.centre_m,
        "doors": [
            {"id": door.id, "to": sum(door.rooms) - room.id, "width_m": door.width_m, "kind": door.kind}
            for door in line.doors
        ],
        "neighbours": room.neighbours,
    }


def _pair(text: str, wanted: str) -> tuple[float, float]:
    """Two numbers from the command line, of a size that a map can have."""
    try:
        x, y = (float(part) for part in text.split(","))
    except ValueError:
        raise SettingError(f"place: wanted {wanted}, found {text!r}") from None
    if not math.hypot(x, y) < FARTHEST:
        raise SettingError(f"place: wanted numbers below {FARTHEST:g}, found {text!r}")
    return x, y
