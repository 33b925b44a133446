"""`vdoor evaluate`."""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated

import typer

from vdoor.cli.options import Force, Json, Resolution
from vdoor.errors import say


def evaluate(
    result: Annotated[
        Path, typer.Argument(metavar="RESULT", help="Folder of `vdoor run --out`, label image, or folder of these.")
    ],
    *,
    reference: Annotated[
        Path,
        typer.Option("--reference", metavar="REF", help="True labels, rooms drawn white, doors in JSON; or folder."),
    ],
    map_: Annotated[
        Path | None, typer.Option("--map", metavar="MAP", help="Map of a label image, or a folder of maps.")
    ] = None,
    bare_map: Annotated[
        Path | None, typer.Option(metavar="MAP", help="Unfurnished map that REF's rooms were drawn on, or a folder.")
    ] = None,
    resolution: Resolution = None,
    free_from: Annotated[
        int | None, typer.Option(min=0, max=255, metavar="GREY", help="Cells of --map are free from this grey on.")
    ] = None,
    min_: Annotated[
        list[str] | None, typer.Option("--min", metavar="FIGURE=X", help="Exit code 1 below it; repeatable.")
    ] = None,
    save: Annotated[Path | None, typer.Option(metavar="FILE.rrd", help="Hits and misses over the map.")] = None,
    force: Force = False,
    as_json: Json = False,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="Nothing on stderr but errors.")] = False,
) -> None:
    """Measure rooms and doors against the truth."""
    from vdoor.errors import SettingError
    from vdoor.evaluate import MapChoice, evaluate_case, matched, tables
    from vdoor.files import refuse_existing

    if free_from is not None and map_ is None:
        raise SettingError("--free-from: wanted --map beside it, found none")
    given = [path for path in (result, reference, map_, bare_map) if path]
    refuse_existing([save] if save else [], force=force, reads=given)
    cases = matched(result, reference)
    maps = MapChoice(path=map_, resolution_m=resolution, free_from=free_from)
    with _notes_said(quiet=quiet):
        evaluations = [evaluate_case(case, maps, bare_map) for case in cases.cases]
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
def _notes_said(*, quiet: bool) -> Iterator[None]:
    """Say on stderr what readers warn of, each thing once."""
    import warnings

    with warnings.catch_warnings(record=True) as notes:
        warnings.simplefilter("always")
        yield
    for text in () if quiet else dict.fromkeys(str(note.message) for note in notes):
        say(f"note: {text}")
