"""Options that several commands share, and functions that evaluate them."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from vdoor.errors import SettingError, say

if TYPE_CHECKING:
    from vdoor.editing.places import Point
    from vdoor.formats.source import UnknownValue
    from vdoor.frame import Frame
    from vdoor.grid import OccupancyGrid
    from vdoor.pipeline import AnyPipeline

PIPE = "-"
MapFile = Annotated[
    Path, typer.Argument(metavar="MAP", help="ROS map YAML, image, .npy, Valetudo JSON or - (stdin), bag, recording.")
]
PRESET_HELP = "paper (as printed), default, voronoi-doors or eroded-space."
Preset = Annotated[str, typer.Option(help=PRESET_HELP)]
Seed = Annotated[int, typer.Option(min=0, help="Random seed.")]
Config = Annotated[Path | None, typer.Option(metavar="FILE.toml", help="Settings file, see `vdoor config`.")]
Set = Annotated[list[str] | None, typer.Option("--set", metavar="STAGE.FIELD=VALUE", help="One setting; repeatable.")]
Resolution = Annotated[float | None, typer.Option(metavar="M", help="Cell size in metres, if the map has none.")]
Unknown = Annotated[
    str | None,
    typer.Option(metavar="GREY", help="Read cells of this grey as unknown, such as 205; none: only as the YAML says."),
]
Topic = Annotated[str | None, typer.Option(metavar="NAME", help="Topic of the nav_msgs/OccupancyGrid in a bag.")]
MaxCells = Annotated[int, typer.Option(metavar="N", help="Refuse maps with more cells.")]
Force = Annotated[bool, typer.Option("--force", help="Overwrite existing files.")]
Json = Annotated[bool, typer.Option("--json", help="Print the result as JSON.")]


def read_grid(
    path: Path, resolution_m: float | None, unknown: str | None, cells: int, *, topic: str | None = None, quiet: bool
) -> OccupancyGrid:
    """Map from a file or from stdin; the reader's warnings go to stderr."""
    import sys
    import warnings

    from vdoor.formats import read_map, read_piped

    grey = grey_or_none(unknown)
    with warnings.catch_warnings(record=True) as notes:
        warnings.simplefilter("always")
        if str(path) != PIPE:
            grid = read_map(path, resolution_m=resolution_m, unknown_value=grey, topic=topic, max_cells=cells)
        elif topic is not None:
            raise SettingError("--topic: wanted a bag, found a pipe")
        else:
            grid = read_piped(sys.stdin.buffer, resolution_m=resolution_m, unknown_value=grey, max_cells=cells)
    for note in () if quiet else notes:
        say(f"note: {note.message}")
    return grid


def grey_or_none(text: str | None) -> UnknownValue:
    """The value of --unknown-value; raises SettingError if it is neither a whole number nor the word none."""
    if text is None:
        return None
    if text == "none":
        return "none"
    try:
        return int(text)
    except ValueError:
        raise SettingError(f"--unknown-value: wanted a grey from 0 to 255, or none, found {text!r}") from None


def chosen_pipeline(
    preset: str, file: Path | None, assignments: list[str] | None, *, robot: tuple[float, float] | None = None
) -> AnyPipeline:
    """The preset, overridden by the settings file, then by --set, then by --robot."""
    from vdoor.config import parse_assignments, read_toml, with_settings
    from vdoor.pipeline import METHODS, preset_named

    layers: list[tuple[str, dict[str, Any]]] = []
    if file is not None:
        layers.append((str(file), read_toml(file)))
    layers.append(("--set", parse_assignments(assignments or ())))
    if robot is not None:
        layers.append(("--robot", {"simplify": {"robot_m": list(robot)}}))
    pipeline = preset_named(preset)
    for place, tables in layers:
        pipeline = with_settings(pipeline, tables, METHODS, place=place)
    return pipeline


def robot_place(grid: OccupancyGrid, text: str | None, *, cells: bool) -> tuple[float, float] | None:
    """Point in the map frame from --robot; None if it was not given."""
    return None if text is None else place_in(grid.frame, text, what="--robot", cells=cells)


def place_in(frame: Frame, text: str, *, what: str, cells: bool) -> Point:
    """Point from the command line, X,Y in the map frame or COL,ROW of its cells; errors begin with `what`."""
    from vdoor.editing.places import parse_place

    x, y = parse_place(text, what=what, wanted="COL,ROW" if cells else "X,Y")
    if not cells:
        return x, y
    import numpy as np

    x_m, y_m = frame.world_from_cell(np.array([[y, x]]))[0].tolist()
    return x_m, y_m


def prepared_pipeline(pipeline: AnyPipeline, grid: OccupancyGrid, *, quiet: bool) -> AnyPipeline:
    """The pipeline that `vdoor.run` uses for this map; a robot position from the map's file is noted on stderr."""
    from vdoor.api import prepared

    ready, note = prepared(pipeline, grid)
    if ready != pipeline:
        x_m, y_m = ready.simplify.robot_m
        note = f"robot at {x_m:g},{y_m:g}, from the map's file (--robot overrides it)"
    if note and not quiet:
        say(f"note: {note}")
    return ready
