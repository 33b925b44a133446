"""`vdoor rooms` and `vdoor room-at`: queries on a finished map."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

import typer

from vdoor.cli.options import Json, place_in, print_json
from vdoor.errors import say

if TYPE_CHECKING:
    from vdoor.topology import Door, Room, TopologicalMap

Result = Annotated[Path, typer.Argument(metavar="RESULT", help="An .mcap, or a folder from `vdoor run --out`.")]


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
"""Heading of each column of the table, and its text for a room."""
NAMES: tuple[tuple[str, Callable[[Line], str]], ...] = (("name", lambda line: line.room.name),)
"""Additional column if any room has a name."""


def rooms(result: Result, *, as_json: Json = False) -> None:
    """List the rooms of a result with their areas, doors and neighbours."""
    from vdoor.results.reading import read_finished
    from vdoor.results.segments import segments_of

    finished = read_finished(result)
    lines, segments = list(_lines(finished.topology)), segments_of(finished.topology, finished.annotations)
    if as_json:
        own = [{"segment": segments[line.room.id].id} if line.room.id in segments else {} for line in lines]
        print_json({"rooms": [_table(line) | segment for line, segment in zip(lines, own, strict=True)]})
        return
    columns = [COLUMNS[0], *(NAMES if any(line.room.name for line in lines) else ()), *COLUMNS[1:]]
    cells = [[head for head, _ in columns], *([text(line) for _, text in columns] for line in lines)]
    widths = [max(map(len, column)) for column in zip(*cells, strict=True)]
    for row in cells:
        print("  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip())


def room_at(
    result: Result,
    place: Annotated[str, typer.Argument(metavar="X,Y", help="Point, metres in the map frame.")],
    *,
    cells: Annotated[bool, typer.Option("--cells", help="The point is COL,ROW of the map instead.")] = False,
    as_json: Json = False,
) -> None:
    """Print the room at a point: 0 and the room's number, or 1 if there is no room."""
    from vdoor.editing.places import parse_place
    from vdoor.results.reading import read_finished

    parse_place(place, wanted="COL,ROW" if cells else "X,Y")  # checked before the result is read
    topology = read_finished(result).topology
    place_m = place_in(topology.frame, place, what="place", cells=cells)
    cell, room = topology.cell_at(place_m), topology.room_at(place_m)
    if as_json:
        line = _table(Line(room, topology.doors_of(room.id))) if room else None
        print_json({"cell": [cell[1], cell[0]] if cell else None, "room": line})
    elif room:
        print(f"room {room.id}{f'  {room.name}' * bool(room.name)}")
    if not room:
        say(f"room-at: no room at {place}, {'a cell outside all rooms' if cell else 'outside the map'}: {result}")
        raise typer.Exit(1)


def _lines(topology: TopologicalMap) -> list[Line]:
    """All rooms in order."""
    return [Line(room, topology.doors_of(room.id)) for room in topology.rooms]


def _table(line: Line) -> dict[str, Any]:
    """One room as plain values."""
    room = line.room
    return {
        "id": room.id,
        "name": room.name,
        "area_m2": room.area_m2,
        "centre_m": room.centre_m,
        "doors": [
            {"id": door.id, "to": sum(door.rooms) - room.id, "width_m": door.width_m, "kind": door.kind}
            for door in line.doors
        ],
        "neighbours": room.neighbours,
    }
