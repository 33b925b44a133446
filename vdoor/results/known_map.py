"""A finished map to work on: its cells, its rooms and doors, what its file rules out, and distances kept beside it."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from vdoor.errors import RecordingError, VdoorError
from vdoor.grid import Annotations, OccupancyGrid
from vdoor.navigate.room_table import Tables, read_tables, write_tables
from vdoor.pipeline import RECORDS
from vdoor.recording.mcap import read_recording
from vdoor.results.reading import read_finished
from vdoor.topology import TopologicalMap

TABLES = "routes.npz"
"""The file of distances between doors: in a result folder, or beside a recording, behind its name."""


@dataclass(frozen=True, eq=False)
class KnownMap:
    """A map whose rooms and doors are known."""

    grid: OccupancyGrid
    topology: TopologicalMap
    annotations: Annotations | None
    tables_path: Path | None = None
    """The file that keeps distances between doors; None for a map that is not stored."""

    @classmethod
    def read(cls, path: Path) -> KnownMap:
        """The map of a recording or a result folder; `VdoorError` if it is missing, damaged or not finished."""
        finished = read_finished(path, provenance=True)
        assert finished.provenance is not None
        tables = path / TABLES if path.is_dir() else path.with_name(f"{path.name}.{TABLES}")
        return cls(finished.provenance.run.input, finished.topology, finished.annotations, tables)

    @contextmanager
    def tables(self) -> Iterator[Tables]:
        """Distances between doors of earlier queries; those that the block adds are kept, if the file can be written.

        They hold for rooms that are still the same, cell by cell, so that nothing else makes the file invalid.
        """
        found = read_tables(self.tables_path) if self.tables_path else {}
        before = len(found)
        yield found
        if self.tables_path and len(found) > before:
            with contextlib.suppress(VdoorError):  # such as a folder that is read-only
                write_tables(self.tables_path, found)


def is_result(path: Path) -> bool:
    """Whether a path holds a finished map, rather than a map to run: a result folder, or a recording of vdoor's own."""
    if path.is_dir():
        return (path / "map.json").is_file()
    if path.suffix != ".mcap":
        return False
    try:
        read_recording(path, types=RECORDS)
    except RecordingError:
        return False
    return True
