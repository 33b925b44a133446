"""Integrity check of a recording (every record, stage and checksum), and its contents as text and tables."""

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
from vdoor.recording.foreign import refuse_foreign
from vdoor.recording.indexes import index_damage
from vdoor.recording.mcap import read_recording
from vdoor.recording.naming import TooMuchError, naming

Emits = Callable[[RunInfo], Sequence[type[Record]]]
"""Record types that a run emits, from its settings."""


@dataclass(frozen=True, kw_only=True)
class Health:
    """Result of checking a recording."""

    path: Path
    info: RunInfo | None
    """None if the settings cannot be read."""
    records: dict[str, int]
    """Number of complete records, by topic."""
    damage: tuple[str, ...]
    """Errors in the file, one line each."""
    missing: tuple[str, ...]
    """Records that a finished run would also contain; empty if `info` is None."""
    ended_in: str
    """Topic of the last complete record, empty if there is none."""

    @property
    def whole(self) -> bool:
        """Whether nothing is damaged or missing."""
        return not self.damage and not self.missing


def check(path: Path, *, types: Sequence[type[Record]], emits: Emits | None = None) -> Health:
    """Health of a recording of a run that emits records of `types`, in this order; damage is reported, never raised.

    Raises `RecordingError` if the file cannot be opened, is of another kind or program, or would take too much work.
    """
    with naming(path):
        refuse_foreign(path)
    info: RunInfo | None = None
    absent: list[str] = []
    steps: list[tuple[int, str]] = []
    damage: list[str] = []
    try:
        recording = read_recording(path, types=types)
        info = recording.info
        absent.extend(recording.lost)
        steps.extend((step, record.topic) for step, record in recording)
    except TooMuchError:
        raise
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
    """Topics that a run should emit, plus any others that were found, in the order of `types`."""
    topics = {topic for _, topic in steps} | {record.topic for record in (emits(info) if emits else types)}
    return [record.topic for record in types if record.topic in topics]


def lost(steps: Sequence[tuple[int, str]], order: Sequence[str]) -> Iterator[str]:
    """Stages without a record, and gaps in the step numbers, one line each; `steps` are pairs of step and topic."""
    present = {topic for _, topic in steps}
    for topic in order:
        if topic not in present:
            yield f"{topic}: no record"
    for (before, topic), (after, following) in itertools.pairwise([(-1, ""), *steps]):
        skipped = order[order.index(topic) + 1 if topic else 0 : order.index(following)]
        gap = after - before - 1 - len([stage for stage in skipped if stage not in present])
        if gap > 0:
            yield f"{gap} record{'s' * (gap > 1)} between step {before} and step {after} ({following})"


def _out_of_order(steps: Sequence[tuple[int, str]], order: Sequence[str]) -> Iterator[str]:
    for (_, before), (step, topic) in itertools.pairwise(steps):
        if order.index(topic) < order.index(before):
            yield f"step {step}: wanted {topic} before {before}, found it after"


def run_table(run: RunInfo) -> dict[str, Any]:
    """Version, preset, seed, settings and map of a run; source files by name and size only."""
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
    """Health of a recording, without the run information."""
    fields = {field.name: getattr(health, field.name) for field in dataclasses.fields(health) if field.name != "info"}
    return {"whole": health.whole, **fields}


def run_lines(run: RunInfo, changed: Sequence[Setting] | None) -> Iterator[str]:
    """Version, map, preset, seed and the settings changed from the preset (None if the preset is unknown)."""
    yield f"version   vdoor {run.version}"
    files = ", ".join(f"{name} ({len(data)} bytes)" for name, data in run.source.files)
    options = "".join(f", {name} {value}" for name, value in run.source.options.items())
    yield f"map       {files or 'no files, only the grid'}{options}"
    yield f"sha256    {about.digest(run.source)}"
    yield f"preset    {run.preset}{'' if changed is not None else ' (unknown to this version)'}"
    yield f"seed      {run.seed}"
    for setting in changed or ():
        yield f"setting   {setting_line(setting, ('preset', 'here'))}"


def health_lines(health: Health) -> Iterator[str]:
    """Health of a recording: its stages, damage and missing records."""
    for topic, count in health.records.items():
        yield f"stage     {topic:12s} {count:6d}"
    if health.whole:
        yield "whole     every stage is present, every checksum and index is correct"
    for problem in health.damage:
        yield f"damage    {problem}"
    before = " before the damage" if health.damage else ""
    for absent in health.missing:
        yield f"missing   {absent}{before}"
    if not health.whole:
        yield f"ends in   {health.ended_in or 'no stage'}"
    if health.damage:
        yield "hint      vdoor recover saves what is left as a valid recording"
