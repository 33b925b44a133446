"""Provenance of a finished map: version, settings and files of its run, and the records of its stages."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from vdoor.emit import RunInfo
from vdoor.history.records import RunRecords
from vdoor.record import Record
from vdoor.topology import TopologicalMap


@dataclass(frozen=True)
class Provenance:
    """Information on a run, and those records of its stages that are known."""

    facts: Mapping[str, str]
    """Version, preset and seed."""
    settings: Mapping[str, Any]
    files: tuple[tuple[str, str], ...] = ()
    """Name and SHA-256 of each file of the map."""
    run: RunRecords = field(default_factory=RunRecords)
    info: RunInfo | None = None
    """The run as a recording knows it; None for a result folder."""

    @classmethod
    def of(cls, info: RunInfo) -> Provenance:
        """Provenance of a run, without records yet."""
        files = tuple((name, hashlib.sha256(data).hexdigest()) for name, data in info.source.files)
        return cls(facts_of(info.version, info.preset, info.seed), info.settings, files, info=info)

    @property
    def name(self) -> str:
        """Name of the map: its first file."""
        return self.files[0][0] if self.files else "map"

    @property
    def records(self) -> tuple[Record, ...]:
        """Records of the stages before the final map, in the order of the method, without the search."""
        return tuple(record for record in self.run.records.values() if not isinstance(record, TopologicalMap))


def value_text(value: object) -> str:
    """Value of a setting as text for display; strings without quotes."""
    return value if isinstance(value, str) else json.dumps(value)


def facts_of(version: object, preset: object, seed: object) -> dict[str, str]:
    """Version, preset and seed of a run."""
    return {"vdoor": str(version), "preset": str(preset), "seed": str(seed)}
