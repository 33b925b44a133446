"""`vdoor batch`: many maps, one result folder each, a table and a page of all."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from vdoor.cli.options import Config, Force, Preset, Resolution, Seed, Set, Unknown, chosen_pipeline, grey_or_none
from vdoor.config import DEFAULT_PRESET
from vdoor.errors import SettingError, no_such, say

if TYPE_CHECKING:
    from vdoor.batch.job import Row

REPORT = "report"
SHOWN = 5
"""Names of failed maps that are listed."""


def batch(
    maps: Annotated[
        list[str],
        typer.Argument(
            metavar="MAPS...",
            help="Maps, folders, globs, lists (.txt), manifests (.csv, .parquet), URLs; or: report DIR.",
        ),
    ],
    *,
    out: Annotated[
        Path | None, typer.Option("--out", metavar="DIR", help="Folder for the results, one folder a map.")
    ] = None,
    engine: Annotated[
        str, typer.Option(metavar="NAME", help="processes: of this machine; dask: a cluster.")
    ] = "processes",
    scheduler: Annotated[
        str, typer.Option(metavar="tcp://HOST:PORT", help="With --engine dask: the cluster's scheduler.")
    ] = "",
    jobs: Annotated[
        int, typer.Option("--jobs", "-j", min=1, metavar="N", help="Maps at work at a time. Default: one a core.")
    ] = os.cpu_count() or 1,
    memory: Annotated[int, typer.Option(min=0, metavar="MB", help="Most memory of each worker; 0: no limit.")] = 0,
    preset: Preset = DEFAULT_PRESET,
    config: Config = None,
    set_: Set = None,
    seed: Seed = 0,
    resolution: Resolution = None,
    unknown_value: Unknown = None,
    force: Force = False,
) -> None:
    """Run many maps; what is done already is kept, so a batch that was stopped goes on where it was.

    Leaves a result folder for each map, table.parquet, index.csv and index.html, which `vdoor batch report DIR` makes
    again. A map with a truth beside it (NAME_truth.json or .png), or in a manifest's column reference, is measured.
    The exit code is 1 if a map failed; the others are done all the same.
    """
    from vdoor.batch.job import Recipe, rows_of
    from vdoor.batch.report import write_report
    from vdoor.batch.sources import items_of
    from vdoor.batch.store import remove_stale
    from vdoor.batch.table import table_of, write_tables
    from vdoor.config import settings_of
    from vdoor.engines import ENGINES, Limits
    from vdoor.files import make_folder, refuse_folder
    from vdoor.pipeline import METHODS

    if maps[0] == REPORT and len(maps) == len((REPORT, "DIR")):
        say(f"report: {write_report(Path(maps[1]))}")
        return
    if out is None:
        meant = "; `vdoor batch report DIR` takes the folder of a batch" if maps[0] == REPORT else ""
        raise SettingError(f"batch: wanted --out DIR, found none{meant}")
    if engine not in ENGINES:
        raise SettingError(f"--engine: {no_such('engine', engine, ENGINES)}")
    refuse_folder(out)
    settings = settings_of(chosen_pipeline(preset, config, set_), METHODS)
    given = {"resolution_m": resolution, "unknown_value": grey_or_none(unknown_value)}
    options = {name: value for name, value in given.items() if value is not None}
    recipe = Recipe(batch=out.absolute(), preset=preset, settings=settings, seed=seed, options=options, force=force)
    items = items_of(maps)
    make_folder(out)
    remove_stale(out)
    limits = Limits(workers=jobs, memory_mb=memory, scheduler=scheduler)
    failed: list[str] = []
    table = table_of(_told(rows_of(items, recipe, ENGINES[engine], limits), len(items), failed))
    for path in [*write_tables(out, table), write_report(out)]:
        say(f"index: {path}")
    if failed:
        more = ", ..." if len(failed) > SHOWN else ""
        say(f"{len(failed)} of {len(items)} maps failed: {', '.join(failed[:SHOWN])}{more}")
        raise typer.Exit(1)


def _told(rows: Iterable[Row], total: int, failed: list[str]) -> Iterator[Row]:
    """The rows, each printed as it ends, with a progress bar on a terminal's stderr; `failed` gets maps that failed."""
    from rich.console import Console
    from rich.progress import Progress

    from vdoor.batch.job import line_of

    with Progress(console=Console(stderr=True), disable=not sys.stderr.isatty(), transient=True) as bar:
        task = bar.add_task("maps", total=total)
        for row in rows:
            print(line_of(row), flush=True)
            if "error" in row:
                failed.append(row["map"])
            bar.advance(task)
            yield row
