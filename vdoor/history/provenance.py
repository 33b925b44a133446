"""Where a finished map comes from: version, settings and files of its run, and the records of its stages."""

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
    """What the run was, and the records of its stages as far as they are known."""

    facts: Mapping[str, str]
    """Version, preset and seed."""
    settings: Mapping[str, Any]
    files: tuple[tuple[str, str], ...] = ()
    """Name and SHA-256 of each file of the map."""
    run: RunRecords = field(default_factory=RunRecords)

    @classmethod
    def of(cls, info: RunInfo) -> Provenance:
        """Of a run that is recorded or about to begin; its records are still to come."""
        files = tuple((name, hashlib.sha256(data).hexdigest()) for name, data in info.source.files)
        return cls(facts_of(info.version, info.preset, info.seed), info.settings, files)

    @property
    def name(self) -> str:
        """What the map is called: its first file."""
        return self.files[0][0] if self.files else "map"

    @property
    def records(self) -> tuple[Record, ...]:
        """Of the stages before the final map, in the order of the method, the search left out."""
        return tuple(record for record in self.run.records.values() if not isinstance(record, TopologicalMap))


def value_text(value: object) -> str:
    """A setting's value as a settings file has it."""
    return value if isinstance(value, str) else json.dumps(value)


def facts_of(version: object, preset: object, seed: object) -> dict[str, str]:
    """What a run is named by: version, preset and seed."""
    return {"vdoor": str(version), "preset": str(preset), "seed": str(seed)}
