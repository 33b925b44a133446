"""`vdoor valetudo`: requests for a robot with Valetudo, printed and not sent."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from vdoor.cli.export import note_replaced
from vdoor.cli.options import Force
from vdoor.cli.rooms import Result
from vdoor.errors import SettingError, naming, say


def valetudo(
    result: Result,
    *,
    clean: Annotated[
        list[str] | None,
        typer.Option("--clean", metavar="ROOM", help="Clean this room, by id, name or X,Y; repeatable, in this order."),
    ] = None,
    segments: Annotated[
        bool, typer.Option("--segments", help="Split and join the robot's segments so that they become ours.")
    ] = False,
    walls: Annotated[
        list[str] | None,
        typer.Option("--keep-in", metavar="ROOM", help="Walls across the doors out of this room; repeatable."),
    ] = None,
    out: Annotated[Path | None, typer.Option("--out", "-o", metavar="FILE", help="File in place of stdout.")] = None,
    force: Force = False,
) -> None:
    """Print what to send to a robot with Valetudo, one JSON body a line; nothing is sent.

    The `curl` line that would send it goes to stderr.
    """
    from vdoor.editing.lookup import find_room
    from vdoor.export import Export, files_of, read_finished, writer_named
    from vdoor.export import valetudo as requests
    from vdoor.export.virtual_walls import to_walls
    from vdoor.files import refuse_existing
    from vdoor.partial import write_whole

    if (given := sum(map(bool, (clean, segments, walls)))) != 1:
        raise SettingError(f"valetudo: wanted one of --clean, --segments, --keep-in, found {given}: {result}")
    refuse_existing([out] if out else [], force=force, reads=files_of(result))
    finished = read_finished(result)
    topology, annotations = finished.topology, finished.annotations
    with naming(result):
        chosen = [find_room(topology, word, what="room").room.id for word in (*(clean or ()), *(walls or ()))]
        if clean:
            todo = requests.clean(topology, chosen, annotations)
        elif segments:
            todo = requests.reshape(topology, annotations)
        else:
            body = to_walls(topology, chosen, annotations)
            todo = [requests.Request("CombinedVirtualRestrictionsCapability", body)]
    if walls:
        note_replaced(Export(writer_named("virtual-walls")), finished)
    if segments:
        again = "; then save the map and run again, as the robot gives new ids" * bool(todo)
        say(f"{len(todo)} change{'s' * (len(todo) != 1)} to make the robot's segments ours{again}")
    text = "".join(f"{request.text}\n" for request in todo)
    if out is None:
        print(text, end="")
    else:
        print(write_whole(out, text.encode()))
    for request in todo:
        say(request.curl)
