"""Options that several commands share, and functions that evaluate them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
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
MOST_CELLS = 1 << 40
"""More than any memory holds; a limit above it means nothing, and would overflow."""
MapFile = Annotated[
    Path, typer.Argument(metavar="MAP", help="ROS map YAML, image, .npy, Valetudo JSON, bag, recording; - for stdin.")
]
PRESET_HELP = "paper (as printed), default, voronoi-doors or eroded-space."


def complete_preset(begun: str) -> list[str]:
    """Presets that begin so."""
    from vdoor.pipeline import PRESETS

    return [name for name in PRESETS if name.startswith(begun)]


def complete_stage(begun: str) -> list[str]:
    """Stages and tabs that begin so."""
    from vdoor.explain.stage_names import tab_names
    from vdoor.history import STAGES

    return [name for name in (*STAGES, *tab_names()) if name.startswith(begun)]


def complete_format(begun: str) -> list[str]:
    """Formats of `vdoor export` that begin so."""
    from vdoor.export import WRITERS

    return [writer.name for writer in WRITERS if writer.name.startswith(begun)]


Preset = Annotated[str, typer.Option(help=PRESET_HELP, autocompletion=complete_preset)]
Seed = Annotated[int, typer.Option(min=0, help="Random seed.")]
Config = Annotated[Path | None, typer.Option(metavar="FILE.toml", help="Settings file, see `vdoor config`.")]
Set = Annotated[list[str] | None, typer.Option("--set", metavar="STAGE.FIELD=VALUE", help="One setting; repeatable.")]
Resolution = Annotated[float | None, typer.Option(metavar="M", help="Cell size in metres, if the map has none.")]
Unknown = Annotated[
    str | None,
    typer.Option(metavar="GREY", help="Read cells of this grey as unknown, such as 205; none: only as the YAML says."),
]
FreeBelow = Annotated[
    float | None, typer.Option(metavar="PERCENT", help="Read cells of less occupancy as free, in place of thresholds.")
]
OccupiedFrom = Annotated[
    float | None, typer.Option(metavar="PERCENT", help="Read cells of this occupancy or more as occupied.")
]
Topic = Annotated[str | None, typer.Option(metavar="NAME", help="Topic of the nav_msgs/OccupancyGrid in a bag.")]
MaxCells = Annotated[int, typer.Option(min=1, max=MOST_CELLS, metavar="N", help="Refuse maps with more cells.")]
Jobs = Annotated[int, typer.Option("--jobs", "-j", min=1, metavar="N", help="Maps at work at a time.")]
Force = Annotated[bool, typer.Option("--force", help="Overwrite existing files.")]
Json = Annotated[bool, typer.Option("--json", help="Print the result as JSON.")]


def print_json(document: Any, *, indent: int | None = None) -> None:
    """Print plain values as JSON, numbers as exact as they are worth."""
    import json

    from vdoor.rounding import rounded

    print(json.dumps(rounded(document), indent=indent, allow_nan=False))


def read_grid(path: Path, *, quiet: bool, **how: Any) -> OccupancyGrid:
    """Map from a file or from stdin, with the options of `read_map`; the reader's warnings go to stderr.

    The unknown value is text, as typed.
    """
    import sys
    import warnings

    from vdoor.formats import read_map, read_piped

    _refuse_folder_of_maps(path)
    if "unknown_value" in how:
        how["unknown_value"] = grey_or_none(how["unknown_value"])
    with warnings.catch_warnings(record=True) as notes:
        warnings.simplefilter("always")
        grid = read_piped(sys.stdin.buffer, **how) if str(path) == PIPE else read_map(path, **how)
    for note in () if quiet else notes:
        say(f"note: {note.message}")
    return grid


@contextmanager
def naming_path(path: Path, grid: OccupancyGrid) -> Iterator[None]:
    """End errors that end with the map's stored name with its path instead."""
    from vdoor.errors import MapError

    try:
        yield
    except MapError as error:
        name = grid.source.files[0][0] if grid.source.files else "map"
        text = str(error)
        raise MapError(f"{text.removesuffix(f': {name}')}: {path}" if text.endswith(f": {name}") else text) from error


def _refuse_folder_of_maps(path: Path) -> None:
    """Raise `SettingError` for a folder that is no bag, with what to do."""
    from vdoor.kinds import kind_of

    if not path.is_dir() or any(path.glob("*.mcap")) or any(path.glob("*.db3")) or (path / "metadata.yaml").is_file():
        return
    kind = kind_of(path)
    advice = "give the map that it was made of" if "result" in kind else "`vdoor batch` runs all maps in it"
    raise SettingError(f"map: wanted a map file or the folder of a ROS 2 bag, found {kind}; {advice}: {path}")


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
    layers.append(("--set", parse_assignments(_whole_names(preset_named(preset), assignments or ()))))
    if robot is not None:
        layers.append(("--robot", {"simplify": {"robot_m": list(robot)}}))
    pipeline = preset_named(preset)
    for place, tables in layers:
        pipeline = with_settings(pipeline, tables, METHODS, place=place)
    return pipeline


def _whole_names(pipeline: AnyPipeline, assignments: Sequence[str]) -> Sequence[str]:
    """The assignments as they are; `SettingError` for one without a stage, which names the settings it may mean."""
    from vdoor.config import full_names, settings_of
    from vdoor.pipeline import METHODS

    for text in assignments:
        word, equals, value = text.partition("=")
        if not equals or "." in word:
            continue
        meant = [f"{name}={value}" for name in full_names(settings_of(pipeline, METHODS), word)]
        if meant:
            raise SettingError(f"--set: wanted stage.field=value, found {text!r}; did you mean {' or '.join(meant)}?")
    return assignments


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
    from vdoor.formats import read_annotations

    ready, note = prepared(pipeline, grid)
    if ready != pipeline:
        x_m, y_m = ready.simplify.robot_m
        annotations = read_annotations(grid.source)
        charger = annotations is not None and (x_m, y_m) == annotations.charger_m != annotations.robot_m
        whose = "robot taken to be at its charger, at" if charger else "robot at"
        note = f"{whose} {x_m:g},{y_m:g}, from the map's file (--robot overrides it)"
    if note and not quiet:
        say(f"note: {note}")
    return ready
