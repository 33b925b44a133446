"""`vdoor nav2`."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from vdoor.cli.navigate import Radius, Running, Source
from vdoor.cli.options import Force, MaxCells, Preset, Resolution, Seed, Set, Unknown
from vdoor.config import DEFAULT_PRESET
from vdoor.errors import SettingError, naming, say
from vdoor.navigate import NAV2_RADIUS_M

if TYPE_CHECKING:
    from vdoor.export import Finished
    from vdoor.topology import TopologicalMap


def nav2(
    source: Source,
    *,
    out: Annotated[Path, typer.Option("--out", "-o", metavar="DIR", help="Folder for the files.")],
    robot_radius: Radius = NAV2_RADIUS_M,
    room: Annotated[
        list[str] | None,
        typer.Option("--room", metavar="ROOM", help="Room that stays open; repeatable; default: all rooms."),
    ] = None,
    slow: Annotated[
        list[str] | None,
        typer.Option("--slow", metavar="ROOM=PERCENT", help="Limit the speed in a room; repeatable."),
    ] = None,
    door_service: Annotated[
        str, typer.Option(metavar="NAME", help="Service that opens a door, std_srvs/Trigger; {door} is the door's id.")
    ] = "",
    preset: Preset = DEFAULT_PRESET,
    set_: Set = None,
    seed: Seed = 0,
    resolution: Resolution = None,
    unknown_value: Unknown = None,
    max_cells: MaxCells = 100_000_000,
    force: Force = False,
) -> None:
    """Write all that Nav2 needs: route graph, keepout and speed mask, parameters, launch file, and what to do.

    Virtual walls and no-go areas of the map's file are in the graph and the mask. Nav2 itself is not started.
    """
    from vdoor.editing.lookup import find_room
    from vdoor.export import files_of
    from vdoor.export.nav2_folder import Nav2Options, nav2_files
    from vdoor.files import refuse_existing, refuse_folder
    from vdoor.partial import together

    limits = [_limit(text) for text in slow or ()]
    names = Nav2Options(speed_percent=dict.fromkeys(range(len(limits)), 100)).names()
    refuse_folder(out)
    refuse_existing([out / name for name in names], force=force, reads=files_of(source))
    running = Running(
        preset=preset,
        assignments=set_,
        seed=seed,
        resolution_m=resolution,
        unknown=unknown_value,
        max_cells=max_cells,
    )
    finished = _finished(source, running)
    topology = finished.topology
    with naming(source):
        options = Nav2Options(
            radius_m=robot_radius,
            rooms=tuple(_ids(topology, room or ())),
            speed_percent={find_room(topology, name, what="--slow").room.id: percent for name, percent in limits},
            door_service=door_service,
        )
        files = nav2_files(topology, out.resolve(), options, finished.annotations)
    with together() as staged:
        staged.make_folder(out)
        for name, data in files.items():
            staged.add(out / name, data)
    for name in files:
        print(out / name)
    if topology.frame.yaw_rad:
        say("note: the map lies askew; costmaps of Nav2 read maps and masks as if they did not: save the map upright")


def _limit(text: str) -> tuple[str, float]:
    """Room and per cent of --slow; `SettingError` for any other text."""
    name, _, number = text.rpartition("=")
    if not name or not number.isdigit() or not 1 <= int(number) <= 100:  # noqa: PLR2004  # per cent
        raise SettingError(f"--slow: wanted ROOM=PERCENT with a whole number from 1 to 100, found {text!r}")
    return name, float(number)


def _ids(topology: TopologicalMap, rooms: Sequence[str]) -> list[int]:
    from vdoor.editing.lookup import find_room

    return [find_room(topology, name, what="--room").room.id for name in rooms]


def _finished(source: Path, running: Running) -> Finished:
    """The result at a path, or of the map there, which is run."""
    from vdoor.api import run_prepared
    from vdoor.cli.options import naming_path
    from vdoor.export import Finished, read_finished
    from vdoor.formats import read_annotations
    from vdoor.results.known_map import is_result
    from vdoor.results.segments import named_by_robot

    if is_result(source):
        return read_finished(source)
    grid = running.grid(source)
    with naming_path(source, grid):
        topology = run_prepared(grid, running.pipeline(grid), seed=running.seed)
    annotations = read_annotations(grid.source)
    return Finished(named_by_robot(topology, annotations), annotations=annotations)
