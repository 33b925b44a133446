"""Where a run's records go: files, renamed once complete, and live viewers."""

from __future__ import annotations

import signal
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from types import FrameType

from vdoor.emit import RunInfo, Sink
from vdoor.errors import VdoorError, say
from vdoor.partial import Partial, Staged
from vdoor.record import Record

QUIET_S = 1.0


class Interrupted(SystemExit):
    """Ctrl-C or SIGTERM; the exit code is 128 + the signal's number, as in a shell."""

    def __init__(self, number: int) -> None:
        super().__init__(128 + number)


@dataclass(frozen=True, kw_only=True)
class Outputs:
    """The recordings and viewers requested on the command line."""

    save: Path | None = None
    mcap: Path | None = None
    connect: str | None = None
    serve: bool = False
    spawn: bool = False
    force: bool = True
    """Whether files may be replaced."""

    def refuse_suffixes(self) -> None:
        """Raise `VdoorError` for a file name that says another kind of file."""
        for option, path, suffix in (("--save", self.save, ".rrd"), ("--mcap", self.mcap, ".mcap")):
            if path is not None and path.suffix.lower() != suffix:
                other = "; --mcap writes MCAP" if path.suffix.lower() == ".mcap" else ""
                other = "; --save writes Rerun recordings" if path.suffix.lower() == ".rrd" else other
                raise VdoorError(f"{option}: wanted a file name ending in {suffix}{other}: {path}")

    @property
    def files(self) -> list[Path]:
        """The recording files."""
        return [path for path in (self.save, self.mcap) if path is not None]

    def sinks(self, info: RunInfo, staged: Staged) -> Iterator[tuple[Sink, Partial | None]]:
        """The requested sinks, opened, files first; each with its file, None for a viewer.

        Files are written under their partial names and added to `staged`.
        """
        shown = self.save or self.connect or self.serve or self.spawn
        if shown:
            from vdoor.viz.rerun.sink import RerunSink  # noqa: PLC0415  # takes half a second, and may not be there
        if self.mcap is not None:
            from vdoor.recording.mcap import McapSink  # noqa: PLC0415  # only if requested

            file = self._file(self.mcap, staged)
            yield McapSink(file.name, info, file.stream()), file
        if shown:
            if self.save is not None:
                file = self._file(self.save, staged)
                yield RerunSink.to_file(file.name, info, file.stream()), file
            if self.connect:
                yield RerunSink.connect(self.connect, info), None
            if self.serve:
                yield RerunSink.serve(info), None
            if self.spawn:
                yield RerunSink.spawn(info), None

    def _file(self, path: Path, staged: Staged) -> Partial:
        staged.parts.append(Partial(path, force=self.force))
        return staged.parts[-1]


class Opened:
    """The open sinks of a run, each with its file, None for a viewer, and all files that get their names together."""

    def __init__(self) -> None:
        self.pairs: list[tuple[Sink, Partial | None]] = []
        self.staged = Staged()

    @property
    def sinks(self) -> list[Sink]:
        """All open sinks, files and viewers."""
        return [sink for sink, _ in self.pairs]

    def finish_files(self) -> None:
        """Close the files and give names to all that are staged; live viewers stay open."""
        for sink, file in self.pairs:
            if file is not None:
                sink.close()
        self.staged.commit()
        self.pairs = [(sink, file) for sink, file in self.pairs if file is None]

    def abandon(self, *, keep: bool) -> None:
        """Close all sinks; files are kept under their partial names, which stderr lists, or removed unless `keep`."""
        for sink, file in self.pairs:
            try:
                sink.close()
            except VdoorError as late:
                if keep:  # otherwise it says again what ends the run
                    say(str(late))
            if keep and file is not None and file in self.staged.parts:
                say(f"recorded so far: {file.name}")
                self.staged.parts.remove(file)
                file.leave()
        self.staged.abandon()


@contextmanager
def opened(outputs: Outputs, info: RunInfo) -> Iterator[Opened]:
    """The sinks of a run; files are renamed if the block succeeds, after which a server runs until Ctrl-C.

    If the run is interrupted, what was recorded so far is kept. After a `VdoorError` the files are removed.
    """
    run = Opened()
    with interruptible():
        try:
            for pair in outputs.sinks(info, run.staged):
                run.pairs.append(pair)
            yield run
            run.finish_files()
        except BaseException as error:
            run.abandon(keep=not isinstance(error, VdoorError))
            raise
        for sink in run.sinks:
            sink.close()


@contextmanager
def both_recordings(folder: Path, info: RunInfo) -> Iterator[list[Sink]]:
    """The sinks of an .rrd and an .mcap in a folder."""
    with opened(Outputs(save=folder / "run.rrd", mcap=folder / "run.mcap"), info) as recordings:
        yield recordings.sinks


@contextmanager
def interruptible() -> Iterator[None]:
    """Raise `Interrupted` on SIGTERM and Ctrl-C within the block."""

    def stop(number: int, _: FrameType | None) -> None:
        raise Interrupted(number)

    before = {number: signal.signal(number, stop) for number in (signal.SIGTERM, signal.SIGINT)}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


class Progress:
    """A sink that reports finished stages on stderr: all if `verbose`, else at most one per second."""

    def __init__(self, *, verbose: bool) -> None:
        self.verbose = verbose
        self._start = self._last = time.monotonic()

    def write(self, step: int, record: Record) -> None:
        """Write the line if it is due."""
        now = time.monotonic()
        if self.verbose or now - self._last > QUIET_S:
            number = getattr(record, "number", None)
            which = record.topic if number is None else f"{record.topic} {number}"
            say(f"{now - self._start:6.1f} s: {which} done, {step + 1} records")
            self._last = now

    def close(self) -> None:
        """Do nothing: stderr stays open."""
