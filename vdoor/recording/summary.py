"""What a recording holds and how it fares, as text and as plain tables."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Sequence
from typing import Any

from vdoor.emit import RunInfo
from vdoor.recording import about
from vdoor.recording.check import Health
from vdoor.recording.diff import Setting
from vdoor.recording.diff_report import setting_line


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
