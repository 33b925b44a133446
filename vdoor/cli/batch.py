"""`vdoor batch`: many maps, one result folder each, and an index."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from vdoor.cli.options import Config, Force, Preset, Resolution, Seed, Set, Unknown, chosen_pipeline, grey_or_none
from vdoor.config import DEFAULT_PRESET
from vdoor.errors import say

if TYPE_CHECKING:
    from vdoor.batch.job import Job, Outcome


def batch(
    maps: Annotated[list[Path], typer.Argument(metavar="MAPS...", help="Maps, or folders of maps.")],
    *,
    out: Annotated[Path, typer.Option("--out", metavar="DIR", help="Folder for the results, one folder a map.")],
    processes: Annotated[
        int, typer.Option("--jobs", "-j", min=1, metavar="N", help="Maps at work at a time. Default: one a core.")
    ] = os.cpu_count() or 1,
    preset: Preset = DEFAULT_PRESET,
    config: Config = None,
    set_: Set = None,
    seed: Seed = 0,
    resolution: Resolution = None,
    unknown_value: Unknown = None,
    force: Force = False,
) -> None:
    """Run many maps; what is done already is kept, so a batch that was stopped goes on where it was.

    Leaves a result folder for each map, index.csv and index.html. The exit code is 1 if a map failed; the others are
    done all the same.
    """
    from vdoor.batch.engine import jobs_of, outcomes
    from vdoor.batch.index import write_index
    from vdoor.batch.job import Job
    from vdoor.config import settings_of
    from vdoor.files import make_folder, refuse_folder
    from vdoor.pipeline import METHODS

    refuse_folder(out)
    settings = settings_of(chosen_pipeline(preset, config, set_), METHODS)
    given = {"resolution_m": resolution, "unknown_value": grey_or_none(unknown_value)}
    options = {name: value for name, value in given.items() if value is not None}
    jobs = [
        Job(map_file=path, folder=folder, preset=preset, settings=settings, seed=seed, options=options)
        for path, folder in jobs_of(maps, out)
    ]
    make_folder(out)
    if force:
        _remove(jobs)
    found = _told(outcomes(jobs, processes), len(jobs))
    for path in write_index(out, found):
        say(f"index: {path}")
    failed = [outcome for outcome in found if outcome.error]
    if failed:
        say(f"{len(failed)} of {len(jobs)} maps failed: {', '.join(str(one.map_file) for one in failed)}")
        raise typer.Exit(1)


def _remove(jobs: list[Job]) -> None:
    """Remove the files of earlier results, and of those alone, as they are to be made again."""
    from vdoor.results.writing import NAMES

    for job in jobs:
        for name in NAMES:
            (job.folder / name).unlink(missing_ok=True)
        if job.folder.is_dir() and not any(job.folder.iterdir()):
            job.folder.rmdir()


def _told(ended: Iterable[Outcome], total: int) -> list[Outcome]:
    """The outcomes, each printed as it ends, with a progress bar on a terminal's stderr."""
    from rich.console import Console
    from rich.progress import Progress

    found = []
    with Progress(console=Console(stderr=True), disable=not sys.stderr.isatty(), transient=True) as bar:
        task = bar.add_task("maps", total=total)
        for outcome in ended:
            print(outcome.line, flush=True)
            found.append(outcome)
            bar.advance(task)
    return found
