"""`vdoor export`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from vdoor.cli.options import Force


def export(
    result: Annotated[Path, typer.Argument(metavar="RESULT", help="An .mcap, or a folder of `vdoor run --out`.")],
    *,
    to: Annotated[str, typer.Option("--to", metavar="FORMAT", help="One of the formats above.")],
    out: Annotated[
        Path | None, typer.Option("--out", "-o", metavar="FILE", help="Default: text is printed, an image needs it.")
    ] = None,
    room: Annotated[
        list[int] | None,
        typer.Option("--room", metavar="ID", help="A room to stay in, for keepout and virtual-walls; repeatable."),
    ] = None,
    force: Force = False,
) -> None:
    """Give a result to other programs.

    \b
    nav2-route     route graph for Nav2's route server (GeoJSON): rooms and doors as nodes, metres along free space
    graphml        the graph alone: rooms as nodes, doors as edges
    json           the whole result as a node-link graph, with a JSON Schema
    geojson        rooms as polygons with holes, doors as lines, in metres of the map frame
    labels         room ids as PNG of 16 bits or PGM, with a map_server YAML
    keepout        Nav2 keepout mask of all but the rooms given by --room, PNG or PGM with YAML
    virtual-walls  walls across the doors (out of --room, if given) for robot vacuums: Valetudo's restrictions, in cm
    rmf            Open-RMF navigation graph with doors (YAML)
    svg            a picture of rooms and doors
    """  # noqa: D301  # \b keeps the lines of the list apart
    from vdoor.errors import VdoorError
    from vdoor.export import Export, files_of, read_finished, refuse_files, writer_named

    wanted = Export(writer_named(to), out, tuple(room or ()))
    refuse_files([wanted], force=force, read=files_of(result))
    finished = read_finished(result)
    try:
        content = wanted.content(finished)
    except VdoorError as error:
        raise type(error)(f"{error}: {result}") from error
    if out is None:
        print(content, end="")
        return
    for path in wanted.put(content):
        print(path)
