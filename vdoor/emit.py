"""How records leave the pipeline: `emit` returns its argument; a recorder numbers records and passes them to sinks."""

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
    """The function that the pipeline calls with every record, in order."""

    def __call__(self, record: R, /) -> R:
        """Return the record unchanged."""
        ...


def silent(record: R, /) -> R:
    """The record, sent nowhere."""
    return record


@dataclass(frozen=True, kw_only=True)
class RunInfo:
    """Everything needed to repeat a run, apart from the code; stored in each recording."""

    version: str
    preset: str
    seed: int
    settings: Mapping[str, Any]
    """All settings as nested tables, as in a settings file."""
    source: Source = field(default_factory=Source)


class Sink(Protocol):
    """A destination for records: a file or a viewer."""

    def write(self, step: int, record: Record) -> None:
        """Write one record; once this returns, the record survives a kill."""
        ...

    def close(self) -> None:
        """Finish the file or connection."""
        ...


class Stopwatch:
    """CPU and wall time of each stage in seconds, without the time that the emitters behind it take."""

    def __init__(self, emit: Emit) -> None:
        self.emit = emit
        self.cpu_s: dict[str, float] = {}
        self.wall_s: dict[str, float] = {}
        self._since = (time.process_time(), time.perf_counter())

    def __call__(self, record: R, /) -> R:
        """Add the time since the last record to this record's stage, then pass the record on."""
        now = (time.process_time(), time.perf_counter())
        for table, then, until in zip((self.cpu_s, self.wall_s), self._since, now, strict=True):
            table[record.topic] = table.get(record.topic, 0.0) + until - then
        self.emit(record)
        self._since = (time.process_time(), time.perf_counter())
        return record


class Recorder:
    """Numbers the records of a run and forwards each to all its sinks, even if a signal arrives meanwhile."""

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
