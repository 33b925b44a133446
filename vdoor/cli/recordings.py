"""`vdoor verify`, `vdoor diff`, `vdoor info`, `vdoor check`, `vdoor recover` and `vdoor golden`."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from operator import itemgetter
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from vdoor import __version__
from vdoor.cli.options import Force, Json, MaxCells
from vdoor.errors import RecordingError, SettingError, VdoorError, say

if TYPE_CHECKING:
    from vdoor.emit import Emit, RunInfo
    from vdoor.recording.diff import Listener, Setting
    from vdoor.recording.diff_report import Result
    from vdoor.recording.mcap import Recording

Rec = Annotated[Path, typer.Argument(metavar="REC.mcap", help="Recording of a run.")]


SaveDifferences = Annotated[
    Path | None, typer.Option("--save", metavar="FILE.rrd", help="Both runs over each other, differences marked.")
]


def verify(
    recordings: Annotated[list[Path], typer.Argument(metavar="REC.mcap...", help="Recordings, and folders of them.")],
    *,
    junit: Annotated[Path | None, typer.Option(metavar="FILE.xml", help="The same for a CI system.")] = None,
    save: SaveDifferences = None,
    force: Force = False,
    max_cells: MaxCells = 100_000_000,
    as_json: Json = False,
) -> None:
    """Run recordings again from their own contents: 0 if all is equal, 1 if not, 2 if one cannot be read."""
    from vdoor.files import refuse_existing, write_whole
    from vdoor.recording import diff_report

    files = list(_files(recordings))
    refuse_existing([path for path in (junit, save) if path], force=force, reads=files)
    if save and len(files) > 1:
        raise SettingError(f"--save: wanted one recording to draw, found {len(files)}")
    results = [_verified(path, max_cells, save) for path in files]
    print(
        diff_report.to_json([result.table for result in results]) if as_json else "\n".join(diff_report.table(results))
    )
    if junit is not None:
        write_whole(junit, diff_report.junit(results))
    raise typer.Exit(diff_report.exit_code(results))


def diff(
    one: Annotated[Path, typer.Argument(metavar="A.mcap")],
    other: Annotated[Path, typer.Argument(metavar="B.mcap")],
    *,
    save: SaveDifferences = None,
    force: Force = False,
    as_json: Json = False,
) -> None:
    """Compare two recordings, settings first, then stage by stage: 0 if all is equal, 1 if not."""
    from vdoor.errors import printable
    from vdoor.files import refuse_existing
    from vdoor.pipeline import RECORDS
    from vdoor.recording import diff_report
    from vdoor.recording.diff import compare, runs_that_differ
    from vdoor.recording.mcap import read_recording

    refuse_existing([save] if save else [], force=force, reads=[one, other])
    runs = [read_recording(path, types=RECORDS) for path in (one, other)]
    settings = runs_that_differ(runs[0].info, runs[1].info)
    with _drawn(save, runs[0].info) as listen:
        found = compare(*(map(itemgetter(1), run) for run in runs), types=RECORDS, listen=listen)
    if as_json:
        print(diff_report.to_json({"equal": found.equal and not settings, "settings": settings, "comparison": found}))
    else:
        names = ("A", "B")
        if runs[0].info.version != runs[1].info.version:
            print(printable(f"note: A was written by vdoor {runs[0].info.version}, B by {runs[1].info.version}"))
        lines = [*(diff_report.setting_line(setting, names) for setting in settings), *diff_report.lines(found, names)]
        print("\n".join(lines) if lines else "equal")
    raise typer.Exit(int(bool(settings) or not found.equal))


def info(rec: Rec, *, as_json: Json = False) -> None:
    """Say what a recording holds: run, map, settings, stages, and whether it is whole."""
    from vdoor.errors import printable
    from vdoor.pipeline import RECORDS, emitted
    from vdoor.recording import check as checking
    from vdoor.recording import diff_report

    health = checking.check(rec, types=RECORDS, emits=emitted)
    if health.info is None:
        raise RecordingError(f"{health.damage[0]}: {rec}")
    changed = _changed(health.info)
    if as_json:
        said = checking.run_table(health.info) | {"changed": changed} | checking.health_table(health)
        print(diff_report.to_json(said))
        return
    for line in [*checking.run_lines(health.info, changed), *checking.health_lines(health)]:
        print(printable(line))


def check(rec: Rec, *, as_json: Json = False) -> None:
    """Read all of a recording and compare every checksum and index: 0 if it is whole, 1 if not."""
    from vdoor.errors import printable
    from vdoor.pipeline import RECORDS, emitted
    from vdoor.recording import check as checking
    from vdoor.recording import diff_report

    health = checking.check(rec, types=RECORDS, emits=emitted)
    if as_json:
        print(diff_report.to_json(checking.health_table(health)))
    else:
        print("\n".join(map(printable, checking.health_lines(health))))
    raise typer.Exit(int(not health.whole))


def recover(
    broken: Annotated[Path, typer.Argument(metavar="BROKEN.mcap", help="Damaged, cut short or .partial.")],
    *,
    out: Annotated[Path, typer.Option("--out", "-o", metavar="FIXED.mcap", help="Where to write what is whole.")],
    force: Force = False,
    as_json: Json = False,
) -> None:
    """Write a whole recording of what a damaged one still holds: 1 and no file if that is nothing."""
    from vdoor.errors import printable
    from vdoor.files import refuse_existing
    from vdoor.pipeline import RECORDS, emitted
    from vdoor.recording import diff_report
    from vdoor.recording.recover import recover as recovered

    refuse_existing([out], force=force, recovers=broken)
    found = recovered(broken, out, types=RECORDS, emits=emitted)
    if as_json:
        print(diff_report.to_json(found))
    else:
        lost = [*(f"lost: {text}" for text in (*found.damage, *found.missing))] or ["nothing was lost"]
        kept = [f"{topic:12s} {count:6d}" for topic, count in found.records.items()]
        print("\n".join(map(printable, [*kept, *lost])))
    if not found.records:
        say(f"recover: nothing could be read, no file is written: {broken}")
        raise typer.Exit(1)


def golden(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="Where they are.")] = Path("recordings/golden"),
) -> None:
    """Record the golden maps anew, and print what changed, for the commit message."""
    from vdoor import goldens

    for line in goldens.remade(folder):
        print(line)


def _files(paths: list[Path]) -> Iterator[Path]:
    """The recordings, and those in the folders by name."""
    for path in paths:
        if not path.is_dir():
            yield path
            continue
        found = sorted(path.rglob("*.mcap"))
        if not found:
            raise RecordingError(f"folder: wanted .mcap files, found none: {path}")
        yield from found


@contextmanager
def _drawn(save: Path | None, run: RunInfo) -> Iterator[Listener]:
    """Something that draws each pair of records into `save`, which is whole at the end or not there; or nothing."""
    from vdoor.outputs import interruptible
    from vdoor.recording.diff import ignore

    if save is None:
        yield ignore
        return
    from vdoor.viz.rerun.difference import DifferenceSink

    with interruptible():
        sink = DifferenceSink(save, run, limit_deg=run.settings.get("candidates", {}).get("angle_deg", 155.0))
        try:
            yield sink
            sink.close()
        except BaseException:
            sink.abandon()
            raise


def _verified(path: Path, max_cells: int, save: Path | None) -> Result:
    """One recording run again; an error becomes its result, so that the others are verified too."""
    import warnings

    from vdoor.pipeline import RECORDS
    from vdoor.recording.diff import verify as verified
    from vdoor.recording.diff_report import Result
    from vdoor.recording.mcap import read_recording

    try:
        recording = read_recording(path, types=RECORDS)
        if recording.info.version != __version__:
            say(f"note: written by vdoor {recording.info.version!r}, this is {__version__}: {path}")
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # said when it was recorded
            with _drawn(save, recording.info) as listen:
                report = verified(recording, lambda run, emit: _run_again(run, emit, max_cells), listen=listen)
            return Result(path=path, report=report)
    except VdoorError as error:
        text = str(error).removesuffix(f": {path}")
        say(f"{text}: {path}")
        return Result(path=path, error=text)


def _run_again(recording: Recording, emit: Emit, max_cells: int) -> None:
    """Run the method on the recorded source (or grid, where no files were kept), with its settings and seed."""
    import numpy as np

    from vdoor.formats import read_source
    from vdoor.pipeline import preset_named, recorded

    run = recording.info
    if run.seed < 0:
        raise SettingError(f"seed: wanted 0 or more, found {run.seed}")
    preset_named(run.preset)
    pipeline = recorded(run)
    grid: Any = read_source(run.source, max_cells=max_cells) if run.source.files else next(iter(recording))[1]
    pipeline(grid, np.random.default_rng(run.seed), emit)


def _changed(run: RunInfo) -> list[Setting] | None:
    """Settings that are not the preset's, None where there is no such preset."""
    from vdoor.config import settings_of
    from vdoor.pipeline import METHODS, PRESETS
    from vdoor.recording.diff import settings_that_differ

    if run.preset not in PRESETS:
        return None
    return settings_that_differ(settings_of(PRESETS[run.preset], METHODS), run.settings)
