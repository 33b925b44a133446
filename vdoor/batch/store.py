"""Where results lie: one folder a map, named by all that the result depends on.

Equal runs have equal folders, byte for byte, whatever did them; what differs from run to run, such as times, is in the
rows beside them. A folder gets its name when it is whole, so that one that has it counts as done.
"""

from __future__ import annotations

import hashlib
import json
import shutil
import tempfile
import time
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from vdoor.emit import RunInfo
from vdoor.errors import VdoorError
from vdoor.files import make_folder
from vdoor.partial import write_whole
from vdoor.results.writing import source_table

DIGITS = 16
"""Of a key, in hexadecimal."""
STALE_S = 3600
"""Age from which an unfinished folder is taken for that of a run that was killed."""


class StoreError(VdoorError):
    """A result that cannot be written, for instance on a full disk."""


def key_of(info: RunInfo) -> str:
    """A hash of all that a result depends on: bytes and names of the map's files, settings, seed and version."""
    table = {
        "vdoor": info.version,
        "source": source_table(info.source),
        "preset": info.preset,
        "settings": info.settings,
        "seed": info.seed,
    }
    text = json.dumps(table, sort_keys=True, default=list)
    return hashlib.sha256(text.encode()).hexdigest()[:DIGITS]


@dataclass(frozen=True)
class Place:
    """Where a map's result is, or will be, below the batch's folder."""

    batch: Path
    name: str
    """The map's stem and the key, with a hyphen in between."""

    @property
    def _shard(self) -> str:
        """The key's first two digits, so that no folder holds them all."""
        return self.name[-DIGITS:][:2]

    @property
    def result(self) -> Path:
        """The result folder."""
        return self.batch / "results" / self._shard / self.name

    @property
    def row_file(self) -> Path:
        """The file with the map's row of the table."""
        return self.batch / "rows" / self._shard / f"{self.name}.json"

    def read_row(self) -> dict[str, Any]:
        """The row of an earlier run; empty if there is none, or none that is whole."""
        try:
            row = json.loads(self.row_file.read_bytes())
        except (OSError, ValueError):
            return {}
        return row if isinstance(row, dict) else {}

    def write_row(self, row: dict[str, Any]) -> None:
        """Write the row; raises `StoreError` if that fails."""
        make_folder(self.row_file.parent)
        try:
            write_whole(self.row_file, json.dumps(row).encode())
        except VdoorError as error:
            raise StoreError(str(error)) from error

    def write_result(self, contents: Iterable[tuple[str, bytes]]) -> None:
        """Write the result folder whole, unless another worker did meanwhile; raises `StoreError` if that fails."""
        partial = _new_folder(self.batch / "partial")
        try:
            for name, content in contents:
                (partial / name).write_bytes(content)
            self.result.parent.mkdir(parents=True, exist_ok=True)
            partial.rename(self.result)
        except OSError as error:
            shutil.rmtree(partial, ignore_errors=True)
            if not self.result.is_dir():
                raise StoreError(f"output: cannot be written ({error.strerror}): {self.result}") from error


def _new_folder(parent: Path) -> Path:
    try:
        parent.mkdir(parents=True, exist_ok=True)
        folder = Path(tempfile.mkdtemp(dir=parent))
        folder.chmod(parent.stat().st_mode)
    except OSError as error:
        raise StoreError(f"output: cannot be written ({error.strerror}): {parent}") from error
    return folder


def remove_stale(batch: Path) -> None:
    """Remove folders that runs left unfinished which were killed long ago."""
    for folder in (batch / "partial").glob("*"):
        if time.time() - folder.stat().st_mtime > STALE_S:
            shutil.rmtree(folder, ignore_errors=True)
