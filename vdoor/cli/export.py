"""`vdoor export`, and the exports of `vdoor run --export`."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from vdoor.cli.options import Force, complete_format
from vdoor.errors import VdoorError, naming, say
from vdoor.navigate import NAV2_RADIUS_M

if TYPE_CHECKING:
    from vdoor.emit import RunInfo, Sink
    from vdoor.export import Export, Finished
    from vdoor.grid import Annotations
    from vdoor.history.provenance import Provenance
    from vdoor.partial import Staged
    from vdoor.topology import TopologicalMap


def export(
    result: Annotated[Path, typer.Argument(metavar="RESULT", help="An .mcap, or a folder from `vdoor run --out`.")],
    *,
    to: Annotated[
        str, typer.Option("--to", metavar="FORMAT", help="One of the formats above.", autocompletion=complete_format)
    ],
    out: Annotated[
        Path | None,
        typer.Option("--out", "-o", metavar="FILE", help="Output file; text is printed without it."),
    ] = None,
    room: Annotated[
        list[str] | None,
        typer.Option(
            "--room",
            metavar="ROOM",
            help="Room for keepout or virtual-walls to keep the robot in, by id, name or X,Y; repeatable.",
        ),
    ] = None,
    robot_radius: Annotated[
        float | None,
        typer.Option(
            "--robot-radius",
            min=0.001,
            max=10,
            metavar="M",
            help=f"What nav2-route keeps to walls.  [default: {NAV2_RADIUS_M}]",
        ),
    ] = None,
    force: Force = False,
) -> None:
    """Export a result for other programs.

    \b
    nav2-route     route graph for Nav2's route server (GeoJSON): nodes in rooms and doors, costs in metres
    graphml        the graph only: rooms as nodes, doors as edges
    json           the whole result as a node-link graph, with a JSON Schema
    geojson        rooms as polygons with holes, doors as lines, in metres of the map frame
    labels         room ids as 16-bit PNG or PGM, with a map_server YAML
    keepout        Nav2 keepout mask of all but the rooms given by --room, PNG or PGM with YAML
    virtual-walls  walls across doors (only those out of --room, if given), as Valetudo's restrictions, in cm
    rmf            Open-RMF navigation graph with doors (YAML)
    svg            a picture of rooms and doors
    report         a self-contained web page: map, rooms, doors, settings, and from an .mcap also stages and cost curve
    """  # noqa: D301  # \b keeps the lines of the list separate
    from vdoor.export import Export, files_of, read_finished, refuse_files, writer_named

    wanted = Export(writer_named(to), out, tuple(room or ()), robot_radius)
    refuse_files([wanted], force=force, read=files_of(result))
    finished = read_finished(result, provenance=wanted.takes_provenance)
    with naming(result):
        content = wanted.content(finished)
    note_replaced(wanted, finished)
    if out is None:
        print(content, end="")
        return
    for path in wanted.put(content, force=force):
        print(path)


def note_replaced(wanted: Export, finished: Finished) -> None:
    """Say on stderr what becomes of the walls and zones that the robot has."""
    if wanted.writer.name != "virtual-walls":
        return
    from vdoor.export.virtual_walls import restrictions_of

    own = sum(map(len, restrictions_of(finished.annotations).values()))
    kept = f"{own} of its own are in it, as of this map" if finished.annotations else "its own are not known"
    say(f"note: the robot replaces all its walls and zones by this list; {kept}")


class RunExports:
    """The exports of `vdoor run`, each given as FORMAT=FILE; `SettingError` for any other text."""

    def __init__(self, texts: Sequence[str]) -> None:
        self.all: list[Export] = []
        self._provenance: Provenance | None = None
        if texts:
            from vdoor.export import Export  # takes a second

            self.all = [Export.parse(text) for text in texts]

    @property
    def files(self) -> list[Path]:
        """All files that will be written."""
        return [path for item in self.all for path in item.files]

    def sinks(self, info: RunInfo) -> list[Sink]:
        """Sinks that collect the records of the run, if an export needs them."""
        if not any(item.takes_provenance for item in self.all):
            return []
        from vdoor.history.provenance import Provenance

        self._provenance = Provenance.of(info)
        return [self._provenance.run]

    def stage(
        self,
        staged: Staged,
        topology: TopologicalMap,
        map_file: Path,
        annotations: Annotations | None,
        *,
        force: bool,
    ) -> VdoorError | None:
        """Stage all exports that this map has; the error of the first one that it has not, or None."""
        if not self.all:
            return None
        from vdoor.export import Finished

        finished = Finished(topology, self._provenance, annotations=annotations)
        refused = None
        for item in self.all:
            try:
                content = item.content(finished)
            except VdoorError as error:
                refused = refused or type(error)(f"{error}: {map_file}")
            else:
                for path, data in item.contents(content):
                    staged.add(path, data, force=force)
                note_replaced(item, finished)
        return refused
