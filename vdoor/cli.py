"""The command: parse, call, print. Heavy modules are imported inside the command that needs them."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from vdoor import __version__
from vdoor.errors import SettingError, VdoorError

if TYPE_CHECKING:
    from vdoor.emit import RunInfo, Stopwatch
    from vdoor.grid import OccupancyGrid
    from vdoor.pipeline import Pipeline
    from vdoor.topology import TopologicalMap

app = typer.Typer(
    help="Rooms and doors from occupancy grid maps, every stage on record.",
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
)

MapFile = Annotated[Path, typer.Argument(metavar="MAP", help="ROS map YAML, PGM, PNG, BMP, TIFF or .npy.")]
Preset = Annotated[str, typer.Option(help="paper (as printed) or default.")]
Seed = Annotated[int, typer.Option(min=0, help="Seed of everything random.")]
Config = Annotated[Path | None, typer.Option(metavar="FILE.toml", help="Settings file, see `vdoor config`.")]
Set = Annotated[list[str] | None, typer.Option("--set", metavar="STAGE.FIELD=VALUE", help="One setting; repeatable.")]
Resolution = Annotated[float | None, typer.Option(metavar="M", help="Cell size where the map does not say it.")]
Unknown = Annotated[int | None, typer.Option(metavar="GREY", help="Read cells of this grey as unknown, say 205.")]
MaxCells = Annotated[int, typer.Option(metavar="N", help="Refuse larger maps.")]
Force = Annotated[bool, typer.Option("--force", help="Overwrite existing files.")]
Json = Annotated[bool, typer.Option("--json", help="The result as JSON on stdout.")]


@app.callback()
def _vdoor(version: Annotated[bool, typer.Option("--version", help="Print the version.")] = False) -> None:
    if version:
        print(f"vdoor {__version__}")
        raise typer.Exit


@app.command(epilog="Example: vdoor run map.yaml --save out.rrd --mcap out.mcap --out result/")
def run(
    map_file: MapFile,
    *,
    save: Annotated[Path | None, typer.Option(metavar="FILE.rrd", help="Rerun recording, to look at.")] = None,
    mcap: Annotated[Path | None, typer.Option(metavar="FILE.mcap", help="MCAP recording, exact.")] = None,
    out: Annotated[Path | None, typer.Option(metavar="DIR", help="rooms.png, rooms.yaml, grid.png, map.json.")] = None,
    preset: Preset = "default",
    config: Config = None,
    set_: Set = None,
    seed: Seed = 0,
    robot: Annotated[str | None, typer.Option(metavar="X,Y", help="Where the robot is, m in the map frame.")] = None,
    cells: Annotated[bool, typer.Option("--cells", help="--robot is COL,ROW of the map instead.")] = False,
    resolution: Resolution = None,
    unknown_value: Unknown = None,
    max_cells: MaxCells = 100_000_000,
    connect: Annotated[str | None, typer.Option(metavar="URL", help="Stream to a Rerun viewer that runs.")] = None,
    serve: Annotated[bool, typer.Option("--serve", help="Stream to a web viewer on 127.0.0.1.")] = False,
    spawn: Annotated[bool, typer.Option("--spawn", help="Open a Rerun viewer and stream to it.")] = False,
    force: Force = False,
    as_json: Json = False,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="Nothing on stderr but errors.")] = False,
    verbose: Annotated[bool, typer.Option("--verbose", "-v", help="Every stage on stderr, with its time.")] = False,
) -> None:
    """Find the rooms and doors of a map."""
    from vdoor.files import refuse_existing  # noqa: PLC0415
    from vdoor.formats import result  # noqa: PLC0415
    from vdoor.outputs import Outputs  # noqa: PLC0415

    outputs = Outputs(save=save, mcap=mcap, connect=connect, serve=serve, spawn=spawn)
    folder_files = [out / name for name in result.NAMES] if out else []
    refuse_existing([*outputs.files, *folder_files], force=force)
    grid = _read(map_file, resolution, unknown_value, max_cells, quiet=quiet)
    pipeline = _pipeline(preset, config, set_, robot=_robot(grid, robot, cells=cells))
    info = _info(grid, preset, pipeline, seed)
    topology, watch = _recorded(grid, pipeline, info, outputs, quiet=quiet, verbose=verbose)
    document = result.document_of(topology, info, watch.cpu_s)
    if out:
        result.write_result(out, grid, topology, document)
    _print_result(topology, document, as_json=as_json)
    if verbose:
        for stage, seconds in watch.cpu_s.items():
            print(f"vdoor: {seconds:8.3f} s CPU  {stage}", file=sys.stderr)


@app.command(epilog="Example: vdoor config --preset paper > my.toml; vdoor run map.pgm --config my.toml")
def config(*, preset: Preset = "default", file: Config = None, set_: Set = None) -> None:
    """Print all settings as TOML."""
    from vdoor.config import to_toml  # noqa: PLC0415
    from vdoor.pipeline import SEARCHES  # noqa: PLC0415

    print(to_toml(_pipeline(preset, file, set_), {"search": SEARCHES}), end="")


@app.command(epilog="Example: vdoor synth maps/flat --kind paper --seed 3 --set furniture=true")
def synth(
    stem: Annotated[
        Path | None, typer.Argument(metavar="STEM", help="Writes STEM.pgm, STEM.yaml and the truth beside.")
    ] = None,
    *,
    kind: Annotated[str, typer.Option(help="Settings to start from: paper or paper-5cm.")] = "paper",
    set_: Annotated[list[str] | None, typer.Option("--set", metavar="FIELD=VALUE", help="One setting.")] = None,
    seed: Seed = 0,
    show: Annotated[bool, typer.Option("--show", help="Print the settings instead.")] = False,
    force: Force = False,
) -> None:
    """Draw an apartment with its true rooms and doors."""
    import numpy as np  # noqa: PLC0415

    from vdoor.config import commented, parse_assignments, replaced  # noqa: PLC0415
    from vdoor.files import refuse_existing  # noqa: PLC0415
    from vdoor.synth import PRESETS, synthesize, write_synthetic  # noqa: PLC0415

    if kind not in PRESETS:
        raise SettingError(f"--kind: wanted one of {', '.join(PRESETS)}, found {kind!r}")
    values = parse_assignments(f"apartment.{text}" for text in set_ or ()).get("apartment", {})
    settings = replaced(PRESETS[kind], values, "--set")
    if show:
        print("\n".join(commented(settings)))
        return
    if stem is None:
        raise SettingError("synth: wanted STEM, the name of the files without their endings")
    refuse_existing([stem.with_name(f"{stem.name}.pgm"), stem.with_name(f"{stem.name}.yaml")], force=force)
    for path in write_synthetic(synthesize(settings, np.random.default_rng(seed)), stem, seed=seed):
        print(path)


@app.command(epilog="Example: vdoor bench --tile 4")
def bench(
    maps: Annotated[list[Path] | None, typer.Argument(metavar="[MAP]...", help="Default: a synthetic one.")] = None,
    *,
    tile: Annotated[int, typer.Option(min=1, metavar="N", help="Repeat each map N x N times, joined.")] = 1,
    record: Annotated[bool, typer.Option("--record", help="Also with both recordings, to a scratch folder.")] = False,
    preset: Preset = "paper",
    set_: Set = None,
    resolution: Resolution = None,
    as_json: Json = False,
) -> None:
    """Measure CPU seconds of the method, stage by stage."""
    from vdoor import benchmark  # noqa: PLC0415

    pipeline = _pipeline(preset, None, set_)
    grids = {path.name: _read(path, resolution, None, 100_000_000, quiet=True) for path in maps or ()}
    for report in benchmark.measured(grids or benchmark.own_maps(), pipeline, tile=tile, record=record):
        print(report.to_json() if as_json else report.to_text())


@app.command("search-study", epilog="Example: vdoor search-study --graphs 60 --seeds 50")
def search_study(
    *,
    graphs: Annotated[int, typer.Option(min=1, help="Initial maps, from synthetic apartments.")] = 60,
    seeds: Annotated[int, typer.Option(min=1, help="Searches a graph.")] = 50,
    set_: Set = None,
    as_json: Json = False,
) -> None:
    """Compare the search with the proven optimum, by number of virtual doors."""
    from vdoor import study  # noqa: PLC0415

    found = study.hit_rates(_pipeline("paper", None, set_), graphs=graphs, seeds=seeds)
    print(study.to_json(found) if as_json else study.to_text(found))


def _read(path: Path, resolution_m: float | None, unknown: int | None, cells: int, *, quiet: bool) -> OccupancyGrid:
    """Read a map, with the reader's warnings on stderr."""
    import warnings  # noqa: PLC0415

    from vdoor.formats import read_map  # noqa: PLC0415

    with warnings.catch_warnings(record=True) as notes:
        warnings.simplefilter("always")
        grid = read_map(path, resolution_m=resolution_m, unknown_value=unknown, max_cells=cells)
    for note in () if quiet else notes:
        print(f"vdoor: note: {note.message}", file=sys.stderr)
    return grid


def _pipeline(preset: str, file: Path | None, assignments: list[str] | None, *,
              robot: tuple[float, float] | None = None) -> Pipeline:
    """The preset with the settings file, then --set, then --robot laid over it."""
    from vdoor.config import parse_assignments, read_toml, with_settings  # noqa: PLC0415
    from vdoor.pipeline import SEARCHES, preset_named  # noqa: PLC0415

    layers: list[tuple[str, dict[str, Any]]] = []
    if file is not None:
        layers.append((str(file), read_toml(file)))
    layers.append(("--set", parse_assignments(assignments or ())))
    if robot is not None:
        layers.append(("--robot", {"simplify": {"robot_m": list(robot)}}))
    pipeline = preset_named(preset)
    for place, tables in layers:
        pipeline = with_settings(pipeline, tables, {"search": SEARCHES}, place=place)
    return pipeline


def _robot(grid: OccupancyGrid, text: str | None, *, cells: bool) -> tuple[float, float] | None:
    """X,Y in the map frame from the command line."""
    if text is None:
        return None
    try:
        x, y = (float(part) for part in text.split(","))
    except ValueError:
        raise SettingError(f"--robot: wanted {'COL,ROW' if cells else 'X,Y'}, found {text!r}") from None
    if not cells:
        return x, y
    import numpy as np  # noqa: PLC0415

    x_m, y_m = grid.frame.world_from_cell(np.array([[y, x]]))[0].tolist()
    return x_m, y_m


def _info(grid: OccupancyGrid, preset: str, pipeline: Pipeline, seed: int) -> RunInfo:
    from vdoor.config import settings_of  # noqa: PLC0415
    from vdoor.emit import RunInfo  # noqa: PLC0415
    from vdoor.pipeline import SEARCHES  # noqa: PLC0415

    settings = settings_of(pipeline, {"search": SEARCHES})
    return RunInfo(version=__version__, preset=preset, seed=seed, settings=settings, source=grid.source)


def _recorded(grid: OccupancyGrid, pipeline: Pipeline, info: RunInfo, outputs: Any, *, quiet: bool,
              verbose: bool) -> tuple[TopologicalMap, Stopwatch]:
    """Run with all sinks open."""
    from vdoor.emit import Recorder, Stopwatch  # noqa: PLC0415
    from vdoor.outputs import Progress, opened  # noqa: PLC0415
    from vdoor.pipeline import run as run_pipeline  # noqa: PLC0415

    with opened(outputs, info) as sinks:
        watch = Stopwatch(Recorder([*sinks, *([] if quiet else [Progress(verbose=verbose)])]))
        return run_pipeline(grid, pipeline, seed=info.seed, emit=watch), watch


def _print_result(topology: TopologicalMap, document: dict[str, Any], *, as_json: bool) -> None:
    if as_json:
        import json  # noqa: PLC0415

        print(json.dumps(document))
        return
    rooms, doors = topology.rooms, topology.doors
    print(f"{len(rooms)} room{'s' * (len(rooms) != 1)}, {len(doors)} door{'s' * (len(doors) != 1)}, "
          f"{sum(room.area_m2 for room in rooms):.1f} m2")
    for room in rooms:
        to = ", ".join(map(str, room.neighbours)) or "none"
        print(f"room {room.id:3d}  {room.area_m2:7.2f} m2  centre {room.centre_m[0]:.2f},{room.centre_m[1]:.2f}  "
              f"neighbours {to}")
    for door in doors:
        print(f"door {door.id:3d}  {door.width_m:7.2f} m   rooms {door.rooms[0]} and {door.rooms[1]}  {door.kind}")


def main() -> None:
    """Run the command; errors are one line on stderr and exit code 2."""
    try:
        app()
    except VdoorError as error:
        print(f"vdoor: {error}", file=sys.stderr)
        sys.exit(2)
    except KeyboardInterrupt as error:
        sys.exit(getattr(error, "exit_code", 130))
