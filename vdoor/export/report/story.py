"""How a run came to its map, as far as a report tells it."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from vdoor.emit import RunInfo
from vdoor.errors import RecordingError, VdoorError
from vdoor.evaluate.label_files import read_image
from vdoor.frame import Frame
from vdoor.grid import FREE, OCCUPIED, UNKNOWN, OccupancyGrid
from vdoor.history.convergence import Course
from vdoor.method.search.generation import Generation
from vdoor.record import Record
from vdoor.results.writing import GREY_FREE, GREY_OCCUPIED
from vdoor.topology import TopologicalMap


@dataclass(frozen=True)
class Story:
    """What the run was, and as a sink of it each stage's record, with the search as numbers and packed strings."""

    facts: Mapping[str, str]
    """Version, preset and seed."""
    settings: Mapping[str, Any]
    files: tuple[tuple[str, str], ...] = ()
    """Name and SHA-256 of each file of the map."""
    records: dict[str, Record] = field(default_factory=dict)
    """By topic, in the order of the method, up to the search; the map that the run ends with is told beside it."""
    search: Course = field(default_factory=Course)

    @classmethod
    def of(cls, info: RunInfo) -> Story:
        """Of a run that is recorded or about to begin; its records are still to come."""
        files = tuple((name, hashlib.sha256(data).hexdigest()) for name, data in info.source.files)
        return cls(_facts(info.version, info.preset, info.seed), info.settings, files)

    @classmethod
    def of_result(cls, folder: Path, document: Mapping[str, Any], frame: Frame) -> Story:
        """Of a result folder: what its map.json says of the run, and the map as read; `VdoorError` for what is not so.

        Raises `KeyError` and the like for a document of another shape.
        """
        files = tuple((str(file["name"]), str(file["sha256"])) for file in document["source"]["files"])
        settings: Mapping[str, Any] = dict(document["settings"])
        story = cls(_facts(document["vdoor"], document["preset"], document["seed"]), settings, files)
        story.write(0, read_grid(folder / "grid.png", frame))
        return story

    @property
    def name(self) -> str:
        """What the map is called: its first file."""
        return self.files[0][0] if self.files else "map"

    def write(self, step: int, record: Record) -> None:
        """Take one more record."""
        del step
        if isinstance(record, Generation):
            self.search.add(record)
        elif record.topic in self.records:
            raise RecordingError(f"{record.topic}: wanted one record, found a second")
        elif record.topic != TopologicalMap.topic:
            self.records[record.topic] = record

    def close(self) -> None:
        """Nothing to finish."""


def read_grid(path: Path, frame: Frame) -> OccupancyGrid:
    """The map of a result folder; `VdoorError` where it is not of the frame's size."""
    grey = read_image(path).greys()
    if grey.shape != (frame.height, frame.width):
        found = f"{grey.shape[1]} x {grey.shape[0]}"
        raise VdoorError(f"grid.png: wanted {frame.width} x {frame.height} cells, found {found}")
    cells = np.full(grey.shape, UNKNOWN, np.int8)
    cells[grey == GREY_FREE] = FREE
    cells[grey == GREY_OCCUPIED] = OCCUPIED
    return OccupancyGrid(cells=cells, frame=frame)


def value_text(value: object) -> str:
    """A setting's value as a settings file has it."""
    return value if isinstance(value, str) else json.dumps(value)


def _facts(version: object, preset: object, seed: object) -> dict[str, str]:
    return {"vdoor": str(version), "preset": str(preset), "seed": str(seed)}
