"""How records leave the pipeline: `emit` returns what it is given; a recorder numbers it and hands it to the sinks."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Protocol, TypeVar

from vdoor.grid import Source
from vdoor.interrupts import held_signals
from vdoor.record import Record

R = TypeVar("R", bound=Record)


class Emit(Protocol):
    """Called by the pipeline with every record, in order."""

    def __call__(self, record: R, /) -> R:
        """Return the record unchanged."""
        ...


def silent(record: R, /) -> R:
    """Emit to nobody."""
    return record


@dataclass(frozen=True, kw_only=True)
class RunInfo:
    """All that is needed to run again, beside the code: what a recording says about itself."""

    version: str
    preset: str
    seed: int
    settings: Mapping[str, Any]
    """Every setting as nested tables, as in a settings file."""
    source: Source = field(default_factory=Source)


class Sink(Protocol):
    """Somewhere records are written as they are made."""

    def write(self, step: int, record: Record) -> None:
        """Write one record; when this returns, it survives a kill."""
        ...

    def close(self) -> None:
        """Finish the file or connection."""
        ...


class Stopwatch:
    """CPU and wall seconds of each stage, with what the listeners behind it take left out."""

    def __init__(self, emit: Emit) -> None:
        self.emit = emit
        self.cpu_s: dict[str, float] = {}
        self.wall_s: dict[str, float] = {}
        self._since = (time.process_time(), time.perf_counter())

    def __call__(self, record: R, /) -> R:
        """Charge the time since the last record to this one's stage, then pass it on."""
        now = (time.process_time(), time.perf_counter())
        for table, then, until in zip((self.cpu_s, self.wall_s), self._since, now, strict=True):
            table[record.topic] = table.get(record.topic, 0.0) + until - then
        self.emit(record)
        self._since = (time.process_time(), time.perf_counter())
        return record


class Recorder:
    """Numbers the records of one run and forwards them to its sinks, all of them or, after a signal, none."""

    def __init__(self, sinks: Sequence[Sink]) -> None:
        self.sinks = tuple(sinks)
        self.step = 0

    def __call__(self, record: R, /) -> R:
        """Forward one record and return it."""
        with held_signals():
            for sink in self.sinks:
                sink.write(self.step, record)
            self.step += 1
        return record
