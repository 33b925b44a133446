"""`vdoor sweep`."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from vdoor.cli.evaluate import BareMap, Exclude, FreeFrom, Only, Quiet, chosen, read
from vdoor.cli.options import PRESET_HELP, Force, Jobs, Json, Resolution, Seed, Set, chosen_pipeline
from vdoor.config import DEFAULT_PRESET
from vdoor.errors import SettingError, say

if TYPE_CHECKING:
    from vdoor.experiments import Choice, Point, Step, Trial

PAPER = "paper"
"""Preset to use if no setting is named."""
APARTMENTS = 20
CELL_M = 0.05
"""Cell size of an apartment's map: fine enough to sweep the working resolution."""


def sweep(
    sweeps: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="SETTING=VALUES",
            help="VALUES are FROM..TO:STEP or a list with commas; SETTING is stage.field or seed. "
            "Default: all settings that the paper gives values for.",
        ),
    ] = None,
    *,
    maps: Annotated[
        Path | None, typer.Option(metavar="MAPS", help="Map or folder of maps. Default: synthetic apartments.")
    ] = None,
    reference: Annotated[
        Path | None, typer.Option(metavar="REF", help="Truth of MAPS, see `vdoor evaluate`; or a folder.")
    ] = None,
    bare_map: BareMap = None,
    free_from: FreeFrom = None,
    resolution: Resolution = None,
    only: Only = None,
    exclude: Exclude = None,
    apartments: Annotated[
        int | None, typer.Option(min=1, metavar="N", help=f"Number of synthetic apartments.  [default: {APARTMENTS}]")
    ] = None,
    furnished: Annotated[bool, typer.Option("--furnished", help="Apartments with furniture.")] = False,
    preset: Annotated[
        str | None,
        typer.Option(help=f"{PRESET_HELP}  [default: {DEFAULT_PRESET}, or {PAPER} if no SETTING is given]"),
    ] = None,
    set_: Set = None,
    seed: Seed = 0,
    save: Annotated[Path | None, typer.Option(metavar="FILE.rrd", help="Charts as a Rerun recording.")] = None,
    png: Annotated[Path | None, typer.Option(metavar="FILE.png", help="Charts as a picture.")] = None,
    jobs: Jobs = 1,
    force: Force = False,
    as_json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Measure the effect of a setting: run the same maps at each of its values.

    The value of the preset (or --set) is always included, marked with a star. A map on which the run fails counts as
    one without any door found. Found doors are contacts between rooms, as in `vdoor evaluate`; virtual doors are those
    in the result's list, as the paper counts them; accuracy is matched / virtual.
    """
    from vdoor.config import settings_of
    from vdoor.experiments import steps, sweep_report
    from vdoor.pipeline import METHODS

    preset = preset or (DEFAULT_PRESET if sweeps else PAPER)
    pipeline = chosen_pipeline(preset, None, set_)
    todo = steps.planned(sweeps or steps.PAPER, pipeline, seed=seed)
    _refuse_pictures(save, png, force=force)
    choice = None
    if maps is None and (bare_map or resolution or free_from is not None or only or exclude):
        raise SettingError("sweep: wanted --maps with the options on reading maps, found none")
    if reference is not None:
        choice = chosen(reference, bare_map, resolution_m=resolution, free_from=free_from, only=only, exclude=exclude)
    trials = _trials(maps, choice, apartments, furnished=furnished, quiet=quiet)
    points = _swept(todo, trials, jobs, quiet=quiet)
    _draw(points, save, png)
    if as_json:
        about = {
            "preset": preset,
            "settings": settings_of(pipeline, METHODS),
            "seed": seed,
            "furnished": furnished,
            "maps": [trial.name for trial in trials],
        }
        print(json.dumps(sweep_report.document(points, about), indent=1, allow_nan=False))
    else:
        print("\n".join(sweep_report.lines(points)))


def _refuse_pictures(save: Path | None, png: Path | None, *, force: bool) -> None:
    """Raise `VdoorError`, before anything runs, if the charts could not be written."""
    from vdoor.files import refuse_existing, refuse_folder

    files = [path for path in (save, png) if path]
    refuse_existing(files, force=force)
    for path in files:
        if not path.parent.is_dir():
            raise SettingError(f"output: wanted an existing folder, found none: {path.parent}")
        refuse_folder(path.parent)


def _draw(points: list[Point], save: Path | None, png: Path | None) -> None:
    """Write the requested charts."""
    if save is not None:
        from vdoor.viz.rerun.sweep import save_sweeps

        save_sweeps(save, points)
    if png is not None:
        from vdoor.partial import write_whole
        from vdoor.viz.charts import sweep_png

        write_whole(png, sweep_png(points))


def _trials(
    maps: Path | None, choice: Choice | None, apartments: int | None, *, furnished: bool, quiet: bool
) -> list[Trial]:
    """The given maps, or synthetic apartments."""
    from vdoor.experiments import trial_of
    from vdoor.paper.door_counts import FIRST_SEED
    from vdoor.paper.door_counts import apartment_maps as drawn

    if maps is None and choice is None:
        made = drawn(apartments or APARTMENTS, furniture=furnished, cell_m=CELL_M)
        return [trial_of(one, f"apartment_{FIRST_SEED + number}") for number, one in enumerate(made)]
    if maps is None or choice is None:
        raise SettingError(f"sweep: wanted --maps and --reference, found {'--reference' if choice else '--maps'} alone")
    if apartments is not None or furnished:
        raise SettingError("sweep: wanted either --maps or --apartments and --furnished, found both")
    return read(maps, choice, quiet=quiet)


def _swept(todo: list[Step], trials: list[Trial], jobs: int, *, quiet: bool) -> list[Point]:
    """All points; each is printed on stderr as soon as it is measured."""
    from vdoor.engines import over
    from vdoor.experiments import swept
    from vdoor.experiments.sweep_report import value_text

    points = []
    with over(jobs) as each:
        for number, point in enumerate(swept(todo, trials, over=each), start=1):
            points.append(point)
            if not quiet:
                place = f"{number} of {len(todo)}: {point.setting.name}={value_text(point.value)}"
                say(f"{place}: door F1 {point.figures['door_f1']:.3f}")
                for name, error in point.failed.items():
                    say(f"note: {name} failed: {error.removeprefix(f'{name}: ')}")
    return points
