"""Two runs compared: their records paired by topic and rank, their settings by name.

The runs may be as long as they like: no more than one record of each is held.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from operator import itemgetter
from typing import Any, TypeVar

from vdoor.emit import Emit, RunInfo
from vdoor.errors import RecordingError, VdoorError
from vdoor.record import Record, specs
from vdoor.recording import about
from vdoor.recording.compare import Difference, Places, differences, places
from vdoor.recording.mcap import Recording

R = TypeVar("R", bound=Record)


@dataclass(frozen=True)
class Pair:
    """The record of one topic and rank in both runs; None in a run that has no such record."""

    topic: str
    rank: int
    expected: Record | None
    found: Record | None
    differences: tuple[Difference, ...]

    @property
    def differs(self) -> bool:
        """Whether a field differs, or one of the two is missing."""
        return bool(self.differences) or self.expected is None or self.found is None


Listener = Callable[[Pair], None]


def ignore(_: Pair) -> None:
    """Listen to nothing."""


@dataclass(frozen=True, kw_only=True)
class Mismatch:
    """What is wrong with the first record of a stage that differs; without differences it is missing in one run."""

    rank: int
    differences: tuple[Difference, ...]


@dataclass(frozen=True, kw_only=True)
class Stage:
    """How one stage compares."""

    topic: str
    expected: int
    """Records of this stage in the one run,"""
    found: int
    """and in the other."""
    differing: int
    """Records that differ or are in one run alone."""
    elements: int
    """Elements that differ, of all fields of all records."""
    first: Mismatch | None

    @property
    def equal(self) -> bool:
        """Whether all its records are there twice and equal."""
        return self.differing == 0


@dataclass(frozen=True, kw_only=True)
class Report:
    """How two runs compare, stage by stage."""

    stages: tuple[Stage, ...]
    stopped: str = ""
    """Why the other run did not come to its end, where it did not."""

    @property
    def equal(self) -> bool:
        """Whether all stages are equal."""
        return self.first is None and not self.stopped

    @property
    def first(self) -> Stage | None:
        """First stage that differs; what comes after it follows from it."""
        return next((stage for stage in self.stages if not stage.equal), None)


@dataclass
class _Tally:
    """What is known of a stage while the runs go on."""

    expected: int = 0
    found: int = 0
    differing: int = 0
    elements: int = 0
    first: Mismatch | None = None


class Comparison:
    """Compares a run, whose records it is called with one by one, with the records of another; it is an `Emit`.

    The listener is called with each pair, in order.
    """

    def __init__(self, expected: Iterable[Record], types: Sequence[type[Record]], *, listen: Listener = ignore) -> None:
        self.records = 0
        self._expected = iter(expected)
        self._held: Record | None = None
        self._order = {record.topic: i for i, record in enumerate(types)}
        self._tallies = {record.topic: _Tally() for record in types}
        self._asked = {spec.axes[0] for record in types for spec, _ in specs(record).values() if spec.kind == "bits"}
        self._places: dict[str, Places] = {}
        self._listen = listen

    def __call__(self, record: R, /) -> R:
        """Compare a record with the one of its topic and rank, and return it."""
        self.records += 1
        expected = None
        for other in self._until(self._order[record.topic]):
            if other.topic == record.topic:
                expected = other
            else:
                self._take(other, None)
        self._take(expected, record)
        return record

    def finish(self, *, stopped: str = "") -> Report:
        """The report, once the run is over; what the other run has left is missing in this one."""
        for other in self._until(len(self._order)):
            self._take(other, None)
        stages = tuple(Stage(topic=topic, **vars(tally)) for topic, tally in self._tallies.items())
        return Report(stages=stages, stopped=stopped)

    def _until(self, place: int) -> Iterator[Record]:
        """Records of stages before the one in this place of the order, and then one of that stage if it is next."""
        while True:
            held = self._held if self._held is not None else next(self._expected, None)
            self._held = held
            if held is None or self._order[held.topic] > place:
                return
            self._held = None
            yield held
            if self._order[held.topic] == place:
                return

    def _take(self, expected: Record | None, found: Record | None) -> None:
        """Count a pair, and tell the listener."""
        there = expected if expected is not None else found
        assert there is not None
        tally = self._tallies[there.topic]
        rank = max(tally.expected, tally.found)
        tally.expected += expected is not None
        tally.found += found is not None
        self._places |= {table: at for table in self._asked if (at := places(there, table)) is not None}
        found_differences: tuple[Difference, ...] = ()
        if expected is not None and found is not None:
            found_differences = tuple(differences(expected, found, elsewhere=self._places))
        pair = Pair(there.topic, rank, expected, found, found_differences)
        if pair.differs:
            tally.differing += 1
            tally.elements += sum(difference.count for difference in found_differences)
            tally.first = tally.first or Mismatch(rank=rank, differences=found_differences)
        self._listen(pair)


def compare(
    expected: Iterable[Record], found: Iterable[Record], *, types: Sequence[type[Record]], listen: Listener = ignore
) -> Report:
    """How the records of two runs compare; `types` are all types of record, in the order of the stages."""
    comparison = Comparison(expected, types, listen=listen)
    for record in found:
        comparison(record)
    return comparison.finish()


@dataclass(frozen=True)
class Setting:
    """A setting that has another value in another run; None where it has none."""

    name: str
    expected: Any
    found: Any


def settings_that_differ(expected: Mapping[str, Any], found: Mapping[str, Any], prefix: str = "") -> list[Setting]:
    """Settings with another value in nested tables, by name as ``stage.field``."""
    changed = []
    for name in [*expected, *(name for name in found if name not in expected)]:
        one, other = expected.get(name), found.get(name)
        if isinstance(one, Mapping) and isinstance(other, Mapping):
            changed += settings_that_differ(one, other, f"{prefix}{name}.")
        elif one != other:
            changed.append(Setting(f"{prefix}{name}", one, other))
    return changed


def runs_that_differ(expected: RunInfo, found: RunInfo) -> list[Setting]:
    """Map, preset, seed and settings in which two runs differ; the version of the program makes no other run."""
    return settings_that_differ(_said(expected), _said(found))


def _said(info: RunInfo) -> dict[str, Any]:
    source = {"sha256": about.digest(info.source), "options": json.dumps(info.source.options, sort_keys=True)}
    return {"map": source, "preset": info.preset, "seed": info.seed, **info.settings}


Rerun = Callable[[Recording, Emit], object]
"""Does a recorded run again and emits its records."""


def verify(recording: Recording, rerun: Rerun, *, listen: Listener = ignore) -> Report:
    """How a run done again compares with its recording, which is read as the run goes.

    A run that is refused half way has stopped: that is a difference. Raises `RecordingError` where the recording is
    damaged, and what `rerun` raises before its first record: then there is nothing to compare.
    """
    comparison = Comparison(map(itemgetter(1), recording), recording.types, listen=listen)
    try:
        rerun(recording, comparison)
    except RecordingError:
        raise
    except VdoorError as error:
        if comparison.records == 0:
            raise
        return comparison.finish(stopped=str(error))
    return comparison.finish()
