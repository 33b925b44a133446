"""Comparison of two runs: records paired by topic and rank, settings by name.

Runs may be of any length: at most one record of each is in memory.
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
    """The records of one topic and rank in both runs; None for a run that has no such record."""

    topic: str
    rank: int
    expected: Record | None
    found: Record | None
    differences: tuple[Difference, ...]

    @property
    def differs(self) -> bool:
        """Whether a field differs or one of the records is missing."""
        return bool(self.differences) or self.expected is None or self.found is None


Listener = Callable[[Pair], None]


def ignore(_: Pair) -> None:
    """Do nothing: the default listener."""


@dataclass(frozen=True, kw_only=True)
class Mismatch:
    """First record of a stage that differs; no differences means that it is missing from one run."""

    rank: int
    differences: tuple[Difference, ...]


@dataclass(frozen=True, kw_only=True)
class Stage:
    """Result of comparing one stage."""

    topic: str
    expected: int
    """Number of records of this stage in the first run."""
    found: int
    """Number of records of this stage in the second run."""
    differing: int
    """Number of records that differ or are in one run only."""
    elements: int
    """Number of elements that differ, over all fields and records."""
    first: Mismatch | None

    @property
    def equal(self) -> bool:
        """Whether both runs have the same records of this stage."""
        return self.differing == 0


@dataclass(frozen=True, kw_only=True)
class Report:
    """Result of comparing two runs, stage by stage."""

    stages: tuple[Stage, ...]
    stopped: str = ""
    """Why the second run stopped early; empty if it finished."""

    @property
    def equal(self) -> bool:
        """Whether all stages are equal and the second run finished."""
        return self.first is None and not self.stopped

    @property
    def first(self) -> Stage | None:
        """First stage that differs; differences in later stages follow from it."""
        return next((stage for stage in self.stages if not stage.equal), None)


@dataclass
class _Tally:
    """Counts of one stage, updated during the comparison."""

    expected: int = 0
    found: int = 0
    differing: int = 0
    elements: int = 0
    first: Mismatch | None = None


class Comparison:
    """An `Emit` that compares each record it receives with the record of the same topic and rank in another run.

    The listener is called with each pair, in order.
    """

    def __init__(self, expected: Iterable[Record], types: Sequence[type[Record]], *, listen: Listener = ignore) -> None:
        self.records = 0
        self._expected = iter(expected)
        self._held: Record | None = None
        self._order = {record.topic: i for i, record in enumerate(types)}
        self._tallies = {record.topic: _Tally() for record in types}
        self._flagged_tables = {
            spec.axes[0] for record in types for spec, _ in specs(record).values() if spec.kind == "bits"
        }
        self._places: dict[str, Places] = {}
        self._listen = listen

    def __call__(self, record: R, /) -> R:
        """Compare a record with its counterpart, and return it."""
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
        """Report at the end of the run; records left over in the other run count as missing in this one."""
        for other in self._until(len(self._order)):
            self._take(other, None)
        stages = tuple(Stage(topic=topic, **vars(tally)) for topic, tally in self._tallies.items())
        return Report(stages=stages, stopped=stopped)

    def _until(self, place: int) -> Iterator[Record]:
        """Next expected records of all stages before `place` in the order, then one of that stage if it is next."""
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
        """Count a pair and pass it to the listener."""
        record = expected if expected is not None else found
        assert record is not None
        tally = self._tallies[record.topic]
        rank = max(tally.expected, tally.found)
        tally.expected += expected is not None
        tally.found += found is not None
        self._places |= {table: at for table in self._flagged_tables if (at := places(record, table)) is not None}
        found_differences: tuple[Difference, ...] = ()
        if expected is not None and found is not None:
            found_differences = tuple(differences(expected, found, elsewhere=self._places))
        pair = Pair(record.topic, rank, expected, found, found_differences)
        if pair.differs:
            tally.differing += 1
            tally.elements += sum(difference.count for difference in found_differences)
            tally.first = tally.first or Mismatch(rank=rank, differences=found_differences)
        self._listen(pair)


def compare(
    expected: Iterable[Record], found: Iterable[Record], *, types: Sequence[type[Record]], listen: Listener = ignore
) -> Report:
    """Result of comparing the records of two runs; `types` are all record types, in the order of the stages."""
    comparison = Comparison(expected, types, listen=listen)
    for record in found:
        comparison(record)
    return comparison.finish()


@dataclass(frozen=True)
class Setting:
    """A setting that differs between two runs; None for a run that does not have it."""

    name: str
    expected: Any
    found: Any


def settings_that_differ(expected: Mapping[str, Any], found: Mapping[str, Any], prefix: str = "") -> list[Setting]:
    """Settings that differ between two nested tables, named ``stage.field``."""
    changed = []
    for name in [*expected, *(name for name in found if name not in expected)]:
        one, other = expected.get(name), found.get(name)
        if isinstance(one, Mapping) and isinstance(other, Mapping):
            changed += settings_that_differ(one, other, f"{prefix}{name}.")
        elif one != other:
            changed.append(Setting(f"{prefix}{name}", one, other))
    return changed


def runs_that_differ(expected: RunInfo, found: RunInfo) -> list[Setting]:
    """Differences of two runs in map, preset, seed and settings; the program version is not compared."""
    return settings_that_differ(_comparable(expected), _comparable(found))


def _comparable(info: RunInfo) -> dict[str, Any]:
    source = {"sha256": about.digest(info.source), "options": json.dumps(info.source.options, sort_keys=True)}
    return {"map": source, "preset": info.preset, "seed": info.seed, **info.settings}


Rerun = Callable[[Recording, Emit], object]
"""Repeats a recorded run and emits its records."""


def verify(recording: Recording, rerun: Rerun, *, listen: Listener = ignore) -> Report:
    """Result of comparing a repeated run with its recording, which is read while the run goes on.

    A run that fails half way counts as stopped, which is a difference. Raises `RecordingError` if the recording is
    damaged, and whatever `rerun` raises before its first record, as there is nothing to compare then.
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
