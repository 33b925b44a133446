"""`vdoor run` and `vdoor config`."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from vdoor.cli.export import RunExports
from vdoor.cli.options import (
    PIPE,
    Config,
    Force,
    FreeBelow,
    Json,
    MapFile,
    MaxCells,
    OccupiedFrom,
    Preset,
    Resolution,
    Seed,
    Set,
    Topic,
    Unknown,
    chosen_pipeline,
    naming_path,
    prepared_pipeline,
    read_grid,
    robot_place,
)
from vdoor.cli.run_edits import EditNotes, edit_files, matched, with_edits
from vdoor.cli.run_search import SearchNotes
from vdoor.config import DEFAULT_PRESET
from vdoor.errors import SettingError, say

if TYPE_CHECKING:
    from vdoor.grid import OccupancyGrid
    from vdoor.topology import TopologicalMap

MOST_LEFT_OUT = 0.02
"""Largest share of the free space without a room that is not worth a note."""


def run(
    map_file: MapFile,
    more: Annotated[list[Path] | None, typer.Argument(hidden=True)] = None,
    *,
    save: Annotated[Path | None, typer.Option(metavar="FILE.rrd", help="Rerun recording, for viewing.")] = None,
    mcap: Annotated[Path | None, typer.Option(metavar="FILE.mcap", help="MCAP recording, with exact values.")] = None,
    out: Annotated[Path | None, typer.Option(metavar="DIR", help="rooms.png, rooms.yaml, grid.png, map.json.")] = None,
    export: Annotated[
        list[str] | None,
        typer.Option("--export", metavar="FORMAT=FILE", help="Also export the map, see `vdoor export`; repeatable."),
    ] = None,
    preset: Preset = DEFAULT_PRESET,
    config: Config = None,
    set_: Set = None,
    seed: Seed = 0,
    robot: Annotated[str | None, typer.Option(metavar="X,Y", help="Robot position, metres in the map frame.")] = None,
    cells: Annotated[bool, typer.Option("--cells", help="--robot is COL,ROW of the map instead.")] = False,
    edits: Annotated[
        Path | None, typer.Option("--edits", metavar="FILE.toml", help="Edits of rooms and doors, see `vdoor rename`.")
    ] = None,
    closed_door: Annotated[
        list[str] | None,
        typer.Option("--closed-door", metavar="X,Y", help="Wall that is a closed door, to be opened; repeatable."),
    ] = None,
    match: Annotated[
        Path | None,
        typer.Option("--match", metavar="OLD", help="Older result or .mcap whose room ids, names and edits are kept."),
    ] = None,
    resolution: Resolution = None,
    unknown_value: Unknown = None,
    free_below: FreeBelow = None,
    occupied_from: OccupiedFrom = None,
    topic: Topic = None,
    max_cells: MaxCells = 100_000_000,
    connect: Annotated[str | None, typer.Option(metavar="URL", help="Stream to a running Rerun viewer.")] = None,
    serve: Annotated[bool, typer.Option("--serve", help="Stream to a web viewer on 127.0.0.1.")] = False,
    spawn: Annotated[bool, typer.Option("--spawn", help="Open a Rerun viewer and stream to it.")] = False,
    force: Force = False,
    as_json: Json = False,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="Only errors on stderr.")] = False,
    verbose: Annotated[bool, typer.Option("--verbose", "-v", help="Print each stage and its time on stderr.")] = False,
) -> None:
    """Find the rooms and doors of a map."""
    from vdoor.api import run_info, run_prepared
    from vdoor.emit import Recorder, Stopwatch
    from vdoor.formats import read_annotations
    from vdoor.outputs import Outputs, Progress, opened
    from vdoor.results import writing
    from vdoor.results.segments import named_by_robot

    if more:
        raise SettingError(f"run: wanted one map, found {len(more) + 1}; `vdoor batch` runs many: {more[0]}")
    outputs = Outputs(save=save, mcap=mcap, connect=connect, serve=serve, spawn=spawn, force=force)
    exports = RunExports(export or ())
    written = [*outputs.files, *([out / name for name in writing.NAMES] if out else []), *exports.files]
    _refuse_outputs(written, out, [map_file, *([edits] if edits else [])], force=force)
    outputs.refuse_suffixes()
    grid = read_grid(
        map_file,
        quiet=quiet,
        resolution_m=resolution,
        unknown_value=unknown_value,
        free_below=free_below,
        occupied_from=occupied_from,
        topic=topic,
        max_cells=max_cells,
    )
    _refuse_sources(written, map_file, grid)
    pipeline = chosen_pipeline(preset, config, set_, robot=robot_place(grid, robot, cells=cells))
    pipeline = prepared_pipeline(pipeline, grid, quiet=quiet)
    pipeline = with_edits(pipeline, edits, closed_door or (), grid)
    found = None
    if match is not None:
        pipeline, found = matched(match, grid, pipeline, seed=seed, edits_too=edits is None, quiet=quiet)
    info = run_info(grid, preset, pipeline, seed)
    with opened(outputs, info) as recording:
        notes = [
            *([] if quiet else [Progress(verbose=verbose)]),
            *EditNotes.sinks(pipeline, quiet=quiet),
            *SearchNotes.sinks(pipeline, quiet=quiet),
        ]
        watch = Stopwatch(Recorder([*recording.sinks, *exports.sinks(info), *notes]))
        with naming_path(map_file, grid):
            topology = run_prepared(grid, pipeline, seed=seed, emit=watch)
        annotations = read_annotations(grid.source)
        topology = named_by_robot(topology, annotations)
        document = writing.document_of(topology, info, watch.cpu_s) | ({"match": found.document()} if found else {})
        if out:
            recording.staged.make_folder(out)
            for name, content in writing.contents_of(out, grid, topology, document):
                recording.staged.add(out / name, content, force=force)
            for path, content in edit_files(out, pipeline.edit.edits, quiet=quiet):
                recording.staged.add(path, content)
        refused = exports.stage(recording.staged, topology, map_file, annotations, force=force)
        recording.finish_files()
        if not quiet:
            _note_left_out(grid, topology)
        _print_result(topology, document, as_json=as_json)
        if refused:
            raise refused
    if verbose:
        for stage, seconds in watch.cpu_s.items():
            say(f"{seconds:8.3f} s CPU  {stage}")


def config(*, preset: Preset = DEFAULT_PRESET, config: Config = None, set_: Set = None) -> None:
    """Print all settings as TOML."""
    from vdoor.config import to_toml
    from vdoor.pipeline import METHODS

    print(to_toml(chosen_pipeline(preset, config, set_), METHODS), end="")


def _refuse_outputs(written: Sequence[Path], folder: Path | None, reads: Sequence[Path], *, force: bool) -> None:
    """Raise `VdoorError` if an output cannot be written or must not be overwritten."""
    from vdoor.files import refuse_existing, refuse_folder

    refuse_existing(written, force=force, reads=reads)
    if folder:
        refuse_folder(folder)
    for path in written:
        if not path.parent.is_dir() and path.parent != folder:
            raise SettingError(f"output: wanted an existing folder for it, found none: {path}")


def _refuse_sources(written: Sequence[Path], map_file: Path, grid: OccupancyGrid) -> None:
    """Raise `VdoorError` if an output would overwrite a file that belongs to the map, such as its image."""
    from vdoor.files import refuse_input

    names = [name for name, _ in grid.source.files]
    if str(map_file) != PIPE and names[:1] == [map_file.name]:
        for name in names:
            refuse_input(map_file.parent / name, written)


def _note_left_out(grid: OccupancyGrid, topology: TopologicalMap) -> None:
    """Say how much of the free space indoors has no room, if it is more than `MOST_LEFT_OUT`."""
    from vdoor.method.parts import walled
    from vdoor.raster.morphology import counted

    free = grid.free
    labels, count = counted(free & (topology.labels == 0))
    left_out = walled(labels, count, grid.occupied)[labels]
    share = left_out.sum() / max(int(free.sum()), 1)
    if share > MOST_LEFT_OUT:
        area_m2 = left_out.sum() * grid.frame.resolution_m**2
        say(f"note: {area_m2:.1f} m2 of free space ({share:.0%}) have no room: not connected to one, and no room alone")


def _print_result(topology: TopologicalMap, document: dict[str, Any], *, as_json: bool) -> None:
    if as_json:
        import json

        print(json.dumps(document))
        return
    rooms, doors = topology.rooms, topology.doors
    print(
        f"{len(rooms)} room{'s' * (len(rooms) != 1)}, {len(doors)} door{'s' * (len(doors) != 1)}, "
        f"{topology.total_m2:.1f} m2"
    )
    for room in rooms:
        to = ", ".join(map(str, room.neighbours)) or "none"
        print(
            f"room {room.id:3d}  {room.area_m2:7.2f} m2  centre {room.centre_m[0]:.2f},{room.centre_m[1]:.2f}  "
            f"neighbours {to}{f'  {room.name}' * bool(room.name)}"
        )
    for door in doors:
        print(f"door {door.id:3d}  {door.width_m:7.2f} m   rooms {door.rooms[0]} and {door.rooms[1]}  {door.kind}")
