"""Whether a recording is whole: every record, every stage; every checksum and the indexes see `indexes`."""

from __future__ import annotations

import itertools
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from vdoor.emit import RunInfo
from vdoor.errors import RecordingError
from vdoor.record import Record
from vdoor.recording.indexes import index_damage
from vdoor.recording.mcap import naming, read_recording


@dataclass(frozen=True, kw_only=True)
class Health:
    """What was found in a recording."""

    path: Path
    info: RunInfo | None
    """None where not even the settings can be read."""
    records: dict[str, int]
    """Records that came whole, by topic."""
    damage: tuple[str, ...]
    """What is wrong with the file, one line each."""
    missing: tuple[str, ...]
    """What a run to its end would have recorded beside that; nothing is known of it where `info` is None."""
    ended_in: str
    """Topic of the last record that came whole, empty if there is none."""

    @property
    def whole(self) -> bool:
        """Whether nothing is damaged or missing."""
        return not self.damage and not self.missing


Emits = Callable[[RunInfo], Sequence[type[Record]]]
"""Which records a run emits."""


def check(path: Path, *, types: Sequence[type[Record]], emits: Emits | None = None) -> Health:
    """Health of a recording of a run that emits records of `types`, in this order; damage is found, never raised.

    Raises `RecordingError` where there is no such file or it cannot be opened.
    """
    with naming(path):
        path.open("rb").close()
    info: RunInfo | None = None
    absent: list[str] = []
    steps: list[tuple[int, str]] = []
    damage: list[str] = []
    try:
        recording = read_recording(path, types=types)
        info = recording.info
        absent.extend(recording.lost)
        steps.extend((step, record.topic) for step, record in recording)
    except RecordingError as error:
        damage.append(str(error))
    try:
        damage += index_damage(path)
    except RecordingError as error:
        damage.append(str(error))
    order = [record.topic for record in types]
    damage += _out_of_order(steps, order)
    return Health(
        path=path,
        info=info,
        records=dict(Counter(topic for _, topic in steps)),
        damage=tuple(dict.fromkeys(text.removesuffix(f": {path}") for text in damage)),
        missing=(*absent, *lost(steps, wanted(info, steps, types=types, emits=emits))) if info else (),
        ended_in=steps[-1][1] if steps else "",
    )


def wanted(
    info: RunInfo, steps: Sequence[tuple[int, str]], *, types: Sequence[type[Record]], emits: Emits | None
) -> list[str]:
    """Topics that a run emits, and those it has beside, in the order of `types`."""
    there = {topic for _, topic in steps} | {record.topic for record in (emits(info) if emits else types)}
    return [record.topic for record in types if record.topic in there]


def lost(steps: Sequence[tuple[int, str]], order: Sequence[str]) -> Iterator[str]:
    """What is missing among steps with their topics: stages without a record, and records that left a gap."""
    there = {topic for _, topic in steps}
    for topic in order:
        if topic not in there:
            yield f"{topic}: no record"
    for (before, topic), (after, following) in itertools.pairwise([(-1, ""), *steps]):
        skipped = order[order.index(topic) + 1 if topic else 0 : order.index(following)]
        gap = after - before - 1 - len([stage for stage in skipped if stage not in there])
        if gap > 0:
            yield f"{gap} record{'s' * (gap > 1)} between step {before} and step {after} ({following})"


def _out_of_order(steps: Sequence[tuple[int, str]], order: Sequence[str]) -> Iterator[str]:
    for (_, before), (step, topic) in itertools.pairwise(steps):
        if order.index(topic) < order.index(before):
            yield f"step {step}: wanted no {topic} after {before}, found one"
