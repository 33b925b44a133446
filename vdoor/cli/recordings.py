"""`vdoor verify`, `vdoor diff`, `vdoor info`, `vdoor check`, `vdoor recover` and `vdoor golden`."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from operator import itemgetter
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from vdoor import __version__
from vdoor.cli.options import Force, Jobs, Json, MaxCells
from vdoor.errors import RecordingError, SettingError, VdoorError, no_such, say

if TYPE_CHECKING:
    from vdoor.emit import Emit, RunInfo
    from vdoor.recording.diff import Listener, Pair, Setting
    from vdoor.recording.diff_report import Result
    from vdoor.recording.mcap import Recording

Rec = Annotated[Path, typer.Argument(metavar="REC.mcap", help="Recording of a run.")]


SaveDifferences = Annotated[
    Path | None, typer.Option("--save", metavar="FILE.rrd", help="Rerun recording of both runs, differences marked.")
]


def verify(
    recordings: Annotated[list[Path], typer.Argument(metavar="REC.mcap...", help="Recordings, or folders of them.")],
    *,
    only: Annotated[
        str | None, typer.Option("--only", metavar="map", help="Compare rooms and doors alone, not every record.")
    ] = None,
    within: Annotated[
        float | None, typer.Option("--within", min=0.0, metavar="M", help="With --only map: how far these may move.")
    ] = None,
    junit: Annotated[Path | None, typer.Option(metavar="FILE.xml", help="Also write a JUnit report, for CI.")] = None,
    save: SaveDifferences = None,
    jobs: Jobs = 1,
    force: Force = False,
    max_cells: MaxCells = 100_000_000,
    as_json: Json = False,
) -> None:
    """Repeat recorded runs and compare the results: 0 if all are equal, 1 if not, 2 if one cannot be read."""
    from vdoor.engines import over
    from vdoor.files import refuse_existing
    from vdoor.partial import write_whole
    from vdoor.recording import diff_report

    if only not in (None, "map"):
        raise SettingError(f"--only: {no_such('level', str(only), ['map'])}")
    if within is not None and only is None:
        raise SettingError("--within: wanted --only map with it, found none")
    files = list(_files(recordings))
    refuse_existing([path for path in (junit, save) if path], force=force, reads=files)
    if save and len(files) > 1:
        raise SettingError(f"--save: wanted one recording to draw, found {len(files)}")
    within_m = None if only is None else within or 0.0
    with over(jobs) as each:
        work = partial(_verified, max_cells=max_cells, save=save, within_m=within_m)
        results = list(each(work, files))
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
    """Compare two recordings, rooms and doors first, then settings, then stage by stage: 0 if equal, 1 if not."""
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
        maps = _Maps(listen)
        found = compare(*(map(itemgetter(1), run) for run in runs), types=RECORDS, listen=maps)
    changes = maps.changes()
    if as_json:
        table = {"equal": found.equal and not settings, "map": changes, "settings": settings, "comparison": found}
        print(diff_report.to_json(table))
    else:
        names = ("A", "B")
        if runs[0].info.version != runs[1].info.version:
            print(printable(f"note: A was written by vdoor {runs[0].info.version}, B by {runs[1].info.version}"))
        lines = [
            *changes,
            *(diff_report.setting_line(setting, names) for setting in settings),
            *diff_report.lines(found, names),
        ]
        print("\n".join(lines) if lines else "equal")
    raise typer.Exit(int(bool(settings) or not found.equal))


def info(rec: Rec, *, as_json: Json = False) -> None:
    """Describe a recording: run, map, settings, stages, and whether it is complete."""
    from vdoor.errors import printable
    from vdoor.pipeline import RECORDS, emitted
    from vdoor.recording import check as checking
    from vdoor.recording import diff_report

    health = checking.check(rec, types=RECORDS, emits=emitted)
    if health.info is None:
        raise RecordingError(f"{health.damage[0]}: {rec}")
    changed = _changed(health.info)
    if as_json:
        document = checking.run_table(health.info) | {"changed": changed} | checking.health_table(health)
        print(diff_report.to_json(document))
        return
    for line in [*checking.run_lines(health.info, changed), *checking.health_lines(health)]:
        print(printable(line))


def check(rec: Rec, *, as_json: Json = False) -> None:
    """Read a whole recording and check every checksum and index: 0 if it is intact and complete, 1 if not."""
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
    out: Annotated[Path, typer.Option("--out", "-o", metavar="FIXED.mcap", help="Recording to write.")],
    force: Force = False,
    as_json: Json = False,
) -> None:
    """Save the intact records of a damaged recording as a valid one: 1 and no file if there are none."""
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
        say(f"recover: no record could be read, no file was written: {broken}")
        raise typer.Exit(1)


def golden(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="Folder of recordings.")] = Path("recordings/golden"),
) -> None:
    """Record the golden maps again, and print the differences, for the commit message."""
    from vdoor import goldens

    for line in goldens.remade(folder):
        print(line)


def _files(paths: list[Path]) -> Iterator[Path]:
    """The given recordings, and those in the given folders, sorted by name."""
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
    """A listener that draws each pair of records into `save`, written completely or not at all; without it, ignore."""
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


def _verified(path: Path, max_cells: int, save: Path | None, within_m: float | None = None) -> Result:
    """Result of repeating one recorded run; an error becomes its result, so that the others are still verified."""
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
            warnings.simplefilter("ignore")  # reported when it was recorded
            with _drawn(save, recording.info) as listen:
                maps = _Maps(listen)
                report = verified(recording, lambda run, emit: _run_again(run, emit, max_cells), listen=maps)
            return Result(path=path, report=report, changes=None if within_m is None else maps.changes(within_m))
    except VdoorError as error:
        text = str(error).removesuffix(f": {path}")
        say(f"{text}: {path}")
        return Result(path=path, error=text)


class _Maps:
    """A listener that keeps the final maps of both runs, and passes every pair on."""

    def __init__(self, listen: Listener) -> None:
        self._listen = listen
        self._pair: Pair | None = None

    def __call__(self, pair: Pair) -> None:
        self._pair = pair if pair.topic == "map" else self._pair
        self._listen(pair)

    def changes(self, within_m: float = 0.0) -> tuple[str, ...]:
        """What changed between the two final maps; nothing if one run has none."""
        from vdoor.matching.result_changes import result_changes
        from vdoor.topology import TopologicalMap

        if self._pair is None:
            return ()
        one, other = self._pair.expected, self._pair.found
        if isinstance(one, TopologicalMap) and isinstance(other, TopologicalMap):
            try:
                return tuple(result_changes(one, other, within_m=within_m))
            except RecordingError:
                return ("one of the final maps is damaged",)
        return ("only one run has a final map",)


def _run_again(recording: Recording, emit: Emit, max_cells: int) -> None:
    """Run the method on the recorded source (or the grid, if no files were stored), with its settings and seed."""
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
    """Settings that differ from the preset; None if the preset is unknown."""
    from vdoor.config import settings_of
    from vdoor.pipeline import METHODS, PRESETS
    from vdoor.recording.diff import settings_that_differ

    if run.preset not in PRESETS:
        return None
    return settings_that_differ(settings_of(PRESETS[run.preset], METHODS), run.settings)
