"""Whether a recording is whole: every record, every stage, every checksum; and what it holds, as text and tables."""

from __future__ import annotations

import dataclasses
import itertools
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from vdoor.emit import RunInfo
from vdoor.errors import RecordingError
from vdoor.record import Record
from vdoor.recording import about
from vdoor.recording.diff import Setting
from vdoor.recording.diff_report import setting_line
from vdoor.recording.indexes import index_damage
from vdoor.recording.mcap import naming, read_recording

Emits = Callable[[RunInfo], Sequence[type[Record]]]
"""Which records a run emits."""


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


def run_table(run: RunInfo) -> dict[str, Any]:
    """What a run was, without the bytes of its source files."""
    return {
        "version": run.version,
        "preset": run.preset,
        "seed": run.seed,
        "settings": run.settings,
        "map": {
            "files": [{"name": name, "bytes": len(data)} for name, data in run.source.files],
            "options": run.source.options,
            "sha256": about.digest(run.source),
        },
    }


def health_table(health: Health) -> dict[str, Any]:
    """How a recording fares, without what the run was."""
    fields = {field.name: getattr(health, field.name) for field in dataclasses.fields(health) if field.name != "info"}
    return {"whole": health.whole, **fields}


def run_lines(run: RunInfo, changed: Sequence[Setting] | None) -> Iterator[str]:
    """What a run was: version, map, and the settings that are not the preset's (None: there is no such preset)."""
    yield f"version   vdoor {run.version}"
    files = ", ".join(f"{name} ({len(data)} bytes)" for name, data in run.source.files)
    options = "".join(f", {name} {value}" for name, value in run.source.options.items())
    yield f"map       {files or 'no files, the grid alone'}{options}"
    yield f"sha256    {about.digest(run.source)}"
    yield f"preset    {run.preset}{'' if changed is not None else ' (not known here)'}"
    yield f"seed      {run.seed}"
    for setting in changed or ():
        yield f"setting   {setting_line(setting, ('preset', 'here'))}"


def health_lines(health: Health) -> Iterator[str]:
    """How a recording fares: its stages, what is wrong, what is missing."""
    for topic, count in health.records.items():
        yield f"stage     {topic:12s} {count:6d}"
    if health.whole:
        yield "whole     every stage is there, every checksum and index is right"
    for problem in health.damage:
        yield f"damage    {problem}"
    before = " before the damage" if health.damage else ""
    for absent in health.missing:
        yield f"missing   {absent}{before}"
    if not health.whole:
        yield f"ends in   {health.ended_in or 'no stage at all'}"
    if health.damage:
        yield "hint      vdoor recover writes a whole recording of what is left"
