"""`vdoor route` and `vdoor order`."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from vdoor.cli.options import (
    Force,
    Json,
    MaxCells,
    Preset,
    Resolution,
    Seed,
    Set,
    Unknown,
    chosen_pipeline,
    prepared_pipeline,
    print_json,
    read_grid,
)
from vdoor.config import DEFAULT_PRESET
from vdoor.errors import SettingError, naming, say
from vdoor.navigate import ROBOT_RADIUS_M

if TYPE_CHECKING:
    from vdoor.emit import Sink
    from vdoor.export.paths import PathExport
    from vdoor.grid import OccupancyGrid
    from vdoor.navigate.find_route import FindRoute, Route
    from vdoor.navigate.tasks import Task
    from vdoor.navigate.visits import Visits
    from vdoor.outputs import Outputs
    from vdoor.pipeline import AnyPipeline
    from vdoor.record import Record
    from vdoor.topology import TopologicalMap

Source = Annotated[
    Path,
    typer.Argument(metavar="RESULT|MAP", help="Folder from `vdoor run --out`, .mcap, or a map, which is run."),
]
PLACE = "a room's id, its name or X,Y in metres"
Radius = Annotated[
    float, typer.Option("--robot-radius", min=0.001, max=10, metavar="M", help="Clearance that is kept everywhere.")
]
Avoid = Annotated[list[str] | None, typer.Option("--avoid", metavar="ROOM", help="Room not to enter; repeatable.")]
Closed = Annotated[
    list[str] | None, typer.Option("--closed", metavar="DOOR", help="Door that is closed, by id or X,Y; repeatable.")
]

Exports = Annotated[
    list[str] | None,
    typer.Option("--export", metavar="FORMAT=FILE", help="The path as csv, geojson or waypoints; repeatable."),
]
Save = Annotated[Path | None, typer.Option(metavar="FILE.rrd", help="Rerun recording, for viewing.")]


@dataclasses.dataclass(frozen=True, kw_only=True)
class Running:
    """How a map is run whose rooms are not known."""

    preset: str
    assignments: list[str] | None
    seed: int
    resolution_m: float | None
    unknown: str | None
    max_cells: int

    def grid(self, path: Path) -> OccupancyGrid:
        """The map in a file."""
        return read_grid(
            path,
            quiet=False,
            resolution_m=self.resolution_m,
            unknown_value=self.unknown,
            max_cells=self.max_cells,
        )

    def pipeline(self, grid: OccupancyGrid) -> AnyPipeline:
        """The prepared pipeline for a map."""
        return prepared_pipeline(chosen_pipeline(self.preset, None, self.assignments), grid, quiet=False)


def route(
    source: Source,
    start: Annotated[str, typer.Argument(metavar="FROM", help=f"Start: {PLACE}.")],
    goal: Annotated[str, typer.Argument(metavar="TO", help=f"Goal: {PLACE}.")],
    *,
    via: Annotated[list[str] | None, typer.Option(metavar="ROOM", help="Go there on the way; repeatable.")] = None,
    avoid: Avoid = None,
    closed: Closed = None,
    robot_radius: Radius = ROBOT_RADIUS_M,
    export: Exports = None,
    save: Save = None,
    mcap: Annotated[Path | None, typer.Option(metavar="FILE.mcap", help="Recording of the run with the route.")] = None,
    preset: Preset = DEFAULT_PRESET,
    set_: Set = None,
    seed: Seed = 0,
    resolution: Resolution = None,
    unknown_value: Unknown = None,
    max_cells: MaxCells = 100_000_000,
    force: Force = False,
    as_json: Json = False,
) -> None:
    """Find a path between rooms or places: 0 if there is one, or 1 and what is in the way."""
    from vdoor.export.paths import PATH_WRITERS
    from vdoor.navigate.find_route import FindRoute, Route
    from vdoor.outputs import Outputs

    outputs = Outputs(save=save, mcap=mcap, force=force)
    exports = path_exports(export or (), list(PATH_WRITERS), outputs, source, force=force)
    find = FindRoute(
        start=start,
        goal=goal,
        via=tuple(via or ()),
        avoid=tuple(avoid or ()),
        closed=tuple(closed or ()),
        radius_m=robot_radius,
    )
    running = Running(
        preset=preset, assignments=set_, seed=seed, resolution_m=resolution, unknown=unknown_value, max_cells=max_cells
    )
    found, topology = done_on(source, "route", find, running, outputs)
    assert isinstance(found, Route)
    _tell(found, find, topology, as_json=as_json)
    if not found.found:
        raise typer.Exit(1)
    for item in exports:
        item.write(PATH_WRITERS[item.name](_driven(found)))


def path_exports(
    texts: Sequence[str], names: Sequence[str], outputs: Outputs, source: Path, *, force: bool
) -> list[PathExport]:
    """The files of a path that are asked for, in the formats `names`; `VdoorError` if one cannot be written."""
    from vdoor.export.paths import PathExport
    from vdoor.files import refuse_existing

    exports = [PathExport.parse(text, names) for text in texts]
    refuse_existing([*outputs.files, *(item.path for item in exports)], force=force, reads=[source])
    outputs.refuse_suffixes()
    return exports


def done_on(source: Path, name: str, task: Task, running: Running, outputs: Outputs) -> tuple[Record, TopologicalMap]:
    """The record of a task on a finished map or on a map that is run first, written to the outputs; and the map.

    `name` is the pipeline's field for the task.
    """
    from vdoor.results.known_map import is_result

    with naming(source, SettingError):
        if is_result(source):
            return _on_result(source, name, task, outputs)
        return _on_map(source, name, task, running, outputs)


def _on_result(path: Path, name: str, task: Task, outputs: Outputs) -> tuple[Record, TopologicalMap]:
    """On a finished map; recordings get the run's records again, with the task's behind them."""
    from vdoor.results.known_map import KnownMap

    if outputs.files and path.is_dir():
        raise SettingError(f"--save, --mcap: wanted a recording or a map, found a result folder: {path}")
    known = KnownMap.read(path)
    with known.tables() as tables:
        found = task.found(known.grid, known.topology, known.annotations, tables)
    if outputs.files:
        _record_again(path, {name: task}, found, outputs)
    return found, known.topology


def _record_again(path: Path, asked: dict[str, object], record: Record, outputs: Outputs) -> None:
    """Write the records of a recorded run again, with one more task, its settings and its record."""
    from vdoor.config import settings_of
    from vdoor.outputs import opened
    from vdoor.pipeline import METHODS, RECORDS, recorded
    from vdoor.recording.mcap import read_recording

    recording = read_recording(path, types=RECORDS)
    pipeline = dataclasses.replace(recorded(recording.info), **asked)  # type: ignore[arg-type]  # tasks by name
    settings = {**recording.info.settings, **{name: settings_of(pipeline, METHODS)[name] for name in asked}}
    with opened(outputs, dataclasses.replace(recording.info, settings=settings)) as files:
        step = -1
        for step, old in recording:  # the last step is used behind the loop
            if type(old) is not type(record):
                _write(files.sinks, step, old)
        _write(files.sinks, step + 1, record)


def _write(sinks: Sequence[Sink], step: int, record: Record) -> None:
    for sink in sinks:
        sink.write(step, record)


def _on_map(path: Path, name: str, task: Task, running: Running, outputs: Outputs) -> tuple[Record, TopologicalMap]:
    """On a map that is run first."""
    from vdoor.api import run_info, run_prepared
    from vdoor.emit import Recorder
    from vdoor.history import RunRecords
    from vdoor.outputs import opened

    grid = running.grid(path)
    pipeline = dataclasses.replace(running.pipeline(grid), **{name: task})  # type: ignore[arg-type]  # a task by name
    seen = RunRecords()
    info = run_info(grid, running.preset, pipeline, running.seed)
    with opened(outputs, info) as files:
        topology = run_prepared(grid, pipeline, seed=running.seed, emit=Recorder([*files.sinks, seen]))
    return seen.get(task.record), topology


def _tell(found: Route, find: FindRoute, topology: TopologicalMap, *, as_json: bool) -> None:
    """Print a route, and on stderr which stops were moved."""
    from vdoor.explain.routes import described, document_of

    names = ["FROM", *["--via"] * len(find.via), "TO"]
    for name, moved_m, place in zip(names, found.stop_moved_m.tolist(), found.stop_m.tolist(), strict=True):
        if moved_m:
            say(f"note: {name}: moved by {moved_m:.2f} m to {place[0]:.2f},{place[1]:.2f}, where the robot fits")
    if as_json:
        print_json(document_of(found))
    elif not found.found:
        print(described(found))
    else:
        rooms = [topology.room(room).title for room in found.stop_room.tolist()]
        print(f"{' to '.join(rooms)}: {described(found)}")
        for x_m, y_m in found.point_m.tolist():
            print(f"{x_m:.3f},{y_m:.3f}")


def _driven(found: Route) -> Any:
    from vdoor.export.paths import DrivenPath

    properties = {"length_m": found.length_m, "radius_m": found.radius_m, "doors": found.door.tolist()}
    return DrivenPath(found.point_m, found.yaw_rad, properties)


def order(
    result: Annotated[Path, typer.Argument(metavar="RESULT", help="An .mcap, or a folder from `vdoor run --out`.")],
    *,
    room: Annotated[
        list[str] | None, typer.Option("--room", metavar="ROOM", help="Room to visit; repeatable; default: all rooms.")
    ] = None,
    start: Annotated[str | None, typer.Option(metavar="PLACE", help=f"Where to begin: {PLACE}.")] = None,
    end: Annotated[str | None, typer.Option(metavar="PLACE", help=f"Where to end: {PLACE}.")] = None,
    back: Annotated[bool, typer.Option("--return", help="End at the start.")] = False,
    avoid: Avoid = None,
    closed: Closed = None,
    robot_radius: Radius = ROBOT_RADIUS_M,
    as_json: Json = False,
) -> None:
    """Find the order of rooms with the shortest way: exact for up to 12 rooms, with a lower bound beyond."""
    from vdoor.editing.lookup import find_room
    from vdoor.navigate.blocked import blocked_cells
    from vdoor.navigate.find_route import FindRoute
    from vdoor.navigate.routes import Routes
    from vdoor.navigate.space import Space
    from vdoor.navigate.targets import Target
    from vdoor.navigate.visits import visits
    from vdoor.results.known_map import KnownMap

    if back and (start is None or end is not None):
        raise SettingError("--return: wanted a --start to return to and no --end, found others")
    known = KnownMap.read(result)
    topology = known.topology
    with naming(result, SettingError), known.tables() as tables:
        asked = FindRoute(avoid=tuple(avoid or ()), closed=tuple(closed or ()))
        blocked = blocked_cells(known.grid, topology, asked.restrictions(topology, known.annotations))
        routes = Routes(Space.of(blocked, known.grid.frame, robot_radius), topology, tables=tables)
        rooms = [find_room(topology, text, what="--room").room.id for text in room or map(str, topology.room_ids)]
        first = Target.of(topology, start, what="--start") if start is not None else None
        last = first if back else Target.of(topology, end, what="--end") if end is not None else None
        found = visits(routes, rooms, first, last)
    _tell_order(found, topology, as_json=as_json)


def _tell_order(found: Visits, topology: TopologicalMap, *, as_json: bool) -> None:
    if as_json:
        stops = [{"room": stop.room or None, "place_m": stop.place_m} for stop in found.stops]
        document = {"stops": stops, "length_m": found.order.length, "lower_bound_m": found.order.lower_bound}
        print_json(document | {"exact": found.order.exact, "out_of_reach": found.out_of_reach})
        return
    bound = "the shortest" if found.order.exact else f"no order is shorter than {found.order.lower_bound:.2f} m"
    print(f"{found.order.length:.2f} m, {bound}")
    for stop in found.stops:
        print(stop.told(topology))
    for room in found.out_of_reach:
        print(f"out of reach: {topology.room(room).title}")
