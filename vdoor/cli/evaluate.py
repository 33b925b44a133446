"""`vdoor evaluate`, `vdoor ablate` and `vdoor robust`."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from vdoor.cli.options import Force, Jobs, Json, Preset, Resolution, Seed, Set, chosen_pipeline
from vdoor.config import DEFAULT_PRESET
from vdoor.errors import say

if TYPE_CHECKING:
    from vdoor.experiments import Choice, Row, Trial


Maps = Annotated[Path, typer.Argument(metavar="MAPS", help="Folder of maps, or a map.")]
Reference = Annotated[
    Path,
    typer.Option("--reference", metavar="REF", help="Truth: labels, rooms in white, or doors in JSON; or a folder."),
]
BareMap = Annotated[
    Path | None, typer.Option(metavar="MAP", help="Unfurnished map on which REF's rooms were drawn, or a folder.")
]
FreeFrom = Annotated[
    int | None, typer.Option(min=0, max=255, metavar="GREY", help="Only cells at least this grey are measured.")
]
Only = Annotated[list[str] | None, typer.Option(metavar="TEXT", help="Only maps with TEXT in their name; repeatable.")]
Exclude = Annotated[list[str] | None, typer.Option(metavar="TEXT", help="No maps with TEXT in their name; repeatable.")]
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="Only errors on stderr.")]


def evaluate(
    result: Annotated[
        Path, typer.Argument(metavar="RESULT", help="Folder from `vdoor run --out`, label image, or folder of these.")
    ],
    *,
    reference: Annotated[
        Path,
        typer.Option(
            "--reference", metavar="REF", help="Truth: labels, rooms in white, or doors in JSON; or a folder."
        ),
    ],
    map_: Annotated[
        Path | None, typer.Option("--map", metavar="MAP", help="Map that belongs to a label image, or folder of maps.")
    ] = None,
    bare_map: Annotated[
        Path | None, typer.Option(metavar="MAP", help="Unfurnished map on which REF's rooms were drawn, or a folder.")
    ] = None,
    resolution: Resolution = None,
    free_from: Annotated[
        int | None, typer.Option(min=0, max=255, metavar="GREY", help="Cells of --map at least this grey are free.")
    ] = None,
    min_: Annotated[
        list[str] | None,
        typer.Option("--min", metavar="FIGURE=X", help="Exit code 1 if FIGURE is below X; repeatable."),
    ] = None,
    save: Annotated[Path | None, typer.Option(metavar="FILE.rrd", help="Hits and misses over the map.")] = None,
    jobs: Jobs = 1,
    force: Force = False,
    as_json: Json = False,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="Only errors on stderr.")] = False,
) -> None:
    """Evaluate rooms and doors against ground truth."""
    from vdoor.engines import over
    from vdoor.errors import SettingError
    from vdoor.evaluate import MapChoice, evaluate_case, matched, tables
    from vdoor.files import refuse_existing

    if free_from is not None and map_ is None:
        raise SettingError("--free-from: wanted --map as well, found none")
    given = [path for path in (result, reference, map_, bare_map) if path]
    refuse_existing([save] if save else [], force=force, reads=given)
    cases = matched(result, reference)
    maps = MapChoice(path=map_, resolution_m=resolution, free_from=free_from)
    with _notes_on_stderr(quiet=quiet), over(jobs) as each:
        evaluations = list(each(partial(evaluate_case, maps=maps, bare=bare_map), cases.cases))
    short = tables.shortfalls(tables.summary(evaluations), min_ or ())
    for name, partner in tables.lonely(cases) if not quiet else ():
        say(f"note: {name} has no {partner} and is not measured")
    if save is not None:
        from vdoor.viz.rerun.evaluation import save_evaluations

        save_evaluations(save, evaluations)
    if as_json:
        print(json.dumps(tables.document(evaluations, cases), indent=1, allow_nan=False))
    else:
        print("\n".join(tables.lines(evaluations)))
    for text in short:
        say(text)
    raise typer.Exit(int(bool(short)))


@contextmanager
def _notes_on_stderr(*, quiet: bool) -> Iterator[None]:
    """Write the warnings of readers to stderr, each one once."""
    import warnings

    with warnings.catch_warnings(record=True) as notes:
        warnings.simplefilter("always")
        yield
    for text in () if quiet else dict.fromkeys(str(note.message) for note in notes):
        say(f"note: {text}")


def ablate(
    maps: Maps,
    *,
    reference: Reference,
    bare_map: BareMap = None,
    free_from: FreeFrom = None,
    resolution: Resolution = None,
    only: Only = None,
    exclude: Exclude = None,
    model: Annotated[
        list[Path] | None, typer.Option(metavar="FILE", help="Also with curves from `vdoor train`; repeatable.")
    ] = None,
    preset: Preset = DEFAULT_PRESET,
    set_: Set = None,
    seed: Seed = 0,
    jobs: Jobs = 1,
    as_json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Measure the effect of each part of the method, on maps with known rooms or doors."""
    from vdoor.engines import over
    from vdoor.experiments import ablation, tables, variants_with

    pipeline = chosen_pipeline(preset, None, set_)
    variants, models = variants_with(model or ())
    choice = chosen(reference, bare_map, resolution_m=resolution, free_from=free_from, only=only, exclude=exclude)
    trials = read(maps, choice, quiet=quiet)
    with over(jobs) as each:
        found = ablation(trials, pipeline, variants=variants, models=models, seed=seed, over=each)
        rows = _with_progress(found, quiet=quiet)
    table = tables.table(rows, tables.ABLATION, "variant")
    _print(tables.document(rows, trials, preset, seed) if as_json else table)


def robust(
    maps: Maps,
    *,
    reference: Reference,
    bare_map: BareMap = None,
    free_from: FreeFrom = None,
    resolution: Resolution = None,
    only: Only = None,
    exclude: Exclude = None,
    preset: Preset = DEFAULT_PRESET,
    set_: Set = None,
    seed: Seed = 0,
    jobs: Jobs = 1,
    as_json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Measure how door detection degrades on rotated maps, larger cells and noisy walls."""
    from vdoor.engines import over
    from vdoor.experiments import robustness, tables

    pipeline = chosen_pipeline(preset, None, set_)
    choice = chosen(reference, bare_map, resolution_m=resolution, free_from=free_from, only=only, exclude=exclude)
    trials = read(maps, choice, quiet=quiet)
    with over(jobs) as each:
        rows = _with_progress(robustness(trials, pipeline, seed=seed, over=each), quiet=quiet)
    table = tables.table(rows, tables.ROBUSTNESS, "maps")
    _print(tables.document(rows, trials, preset, seed) if as_json else table)


def chosen(
    reference: Path,
    bare: Path | None,
    *,
    resolution_m: float | None,
    free_from: int | None,
    only: list[str] | None,
    exclude: list[str] | None,
) -> Choice:
    """Selection of maps, and how to read them, from the options."""
    from vdoor.experiments import Choice

    return Choice(
        reference=reference, bare=bare, resolution_m=resolution_m, free_from=free_from,
        only=only or (), exclude=exclude or (),
    )  # fmt: skip


def read(maps: Path, choice: Choice, *, quiet: bool) -> list[Trial]:
    """Maps with references; notes on maps without, and readers' warnings, go to stderr."""
    from vdoor.experiments import read_trials

    with _notes_on_stderr(quiet=quiet):
        found = read_trials(maps, choice)
    for name in () if quiet else found.without_reference:
        say(f"note: {name} has no reference and is not measured")
    if not quiet:
        say(f"{len(found.trials)} maps")
    return found.trials


def _with_progress(rows: Iterable[Row], *, quiet: bool) -> list[Row]:
    """All rows; each is written to stderr as soon as it is measured."""
    found = []
    for row in rows:
        found.append(row)
        if not quiet:
            say(f"{row.name}: door F1 {row.figures['door_f1']:.3f}")
    return found


def _print(result: Mapping[str, Any] | Iterable[str]) -> None:
    """Print the lines of a table, or a document as JSON."""
    print(json.dumps(result, indent=1, allow_nan=False) if isinstance(result, Mapping) else "\n".join(result))
