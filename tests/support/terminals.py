"""Recordings of small maps, and a real pseudo-terminal to look at them in."""

from __future__ import annotations

import contextlib
import fcntl
import os
import pty
import re
import select
import struct
import subprocess
import termios
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pyte
from commands import environment
from project import VDOOR

from vdoor.config import settings_of
from vdoor.emit import R, Recorder, RunInfo
from vdoor.grid import OccupancyGrid
from vdoor.history import History
from vdoor.pipeline import METHODS, RECORDS, AnyPipeline, Pipeline
from vdoor.record import Record
from vdoor.recording.mcap import McapSink, read_recording

PATIENCE_S = 30.0


def recorded(
    folder: Path,
    grid: OccupancyGrid,
    pipeline: AnyPipeline | None = None,
    *,
    preset: str = "paper",
    seed: int = 0,
    until: type[Record] | None = None,
) -> Path:
    """A recording of a run, which ends after the first record of type `until` where one is given."""
    pipeline = pipeline or Pipeline()
    settings = settings_of(pipeline, METHODS)
    path = folder / "run.mcap"
    sink = McapSink(path, RunInfo(version="0", preset=preset, seed=seed, settings=settings, source=grid.source))
    emit = Recorder([sink])

    def stopping(record: R, /) -> R:
        emit(record)
        if until is not None and isinstance(record, until):
            raise KeyboardInterrupt
        return record

    with contextlib.suppress(KeyboardInterrupt):
        pipeline(grid, np.random.default_rng(seed), stopping)
    sink.close()
    return path


def history(path: Path) -> History:
    return History.read(read_recording(path, types=RECORDS))


@dataclass
class Screen:
    """The command in a pseudo-terminal: what it wrote, and what can be seen of it."""

    process: subprocess.Popen[bytes]
    keyboard: int
    seen: pyte.Screen
    stream: pyte.ByteStream
    written: bytearray = field(default_factory=bytearray)

    @property
    def text(self) -> str:
        return "\n".join(self.seen.display)

    def press(self, keys: str) -> None:
        os.write(self.keyboard, keys.encode())

    def wait(self, good: Callable[[str], object]) -> str:
        """The text of the screen once it is as wanted."""
        deadline = time.monotonic() + PATIENCE_S
        while not good(self.text):
            assert time.monotonic() < deadline, f"never seen; the screen is\n{self.text}"
            ended = self.process.poll() is not None
            assert self._read(0.1) or not ended or good(self.text), f"ended before; the screen is\n{self.text}"
        return self.text

    def tells(self, name: str, value: str) -> None:
        """Wait until a value stands beside a name in the column of facts."""
        line = re.compile(rf"(?:^|\s){re.escape(name)}\s+{re.escape(value)}(?:\s|$)", re.MULTILINE)
        self.wait(line.search)

    def end(self) -> int:
        """Exit code, once all that was written has been read."""
        deadline = time.monotonic() + PATIENCE_S
        while self.process.poll() is None:
            assert time.monotonic() < deadline, f"does not end; the screen is\n{self.text}"
            self._read(0.1)
        while self._read(0):
            pass
        return self.process.returncode

    def _read(self, patience_s: float) -> bool:
        ready, _, _ = select.select([self.keyboard], [], [], patience_s)
        data = os.read(self.keyboard, 65536) if ready else b""
        self.written += data
        self.stream.feed(data)
        return bool(data)


@contextlib.contextmanager
def terminal(words: Sequence[str | Path], *, columns: int = 100, lines: int = 40) -> Iterator[Screen]:
    """The command in a pseudo-terminal of a size, which must find its settings again when the command has ended."""
    keyboard, own = pty.openpty()
    fcntl.ioctl(own, termios.TIOCSWINSZ, struct.pack("HHHH", lines, columns, 0, 0))
    before = termios.tcgetattr(own)
    seen = pyte.Screen(columns, lines)
    env = environment() | {"TERM": "xterm-256color", "COLORTERM": "truecolor"}
    process = subprocess.Popen(
        [VDOOR, *map(str, words)], stdin=own, stdout=own, stderr=own, env=env, start_new_session=True
    )
    try:
        yield Screen(process, keyboard, seen, pyte.ByteStream(seen))
        assert termios.tcgetattr(own) == before
    finally:
        process.kill()
        process.wait()
        os.close(keyboard)
        os.close(own)
