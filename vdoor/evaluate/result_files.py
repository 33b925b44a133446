"""Files of a result folder that belong together: each is the one that map.json was written with."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from vdoor.errors import VdoorError
from vdoor.files import partial_name


def file_in(folder: Path, name: str, document: Mapping[str, Any]) -> Path:
    """Where a file of a result is: under its own name, or, if a run was killed as it named its files, the partial one.

    If neither is the one that map.json was written with, or map.json is of a version without checksums, the former.
    """
    return _found(folder, name, document) or folder / name


def own_file(folder: Path, name: str, document: Mapping[str, Any]) -> Path:
    """Where a file of a result is; raises VdoorError if there is none that map.json was written with."""
    if place := _found(folder, name, document):
        return place
    found = "another" if (folder / name).is_file() else "none"
    raise VdoorError(f"{name}: wanted the file that map.json was written with, found {found}")


def _found(folder: Path, name: str, document: Mapping[str, Any]) -> Path | None:
    places = folder / name, partial_name(folder / name)
    return next((place for place in places if _is_own(place, name, document)), None)


def _is_own(place: Path, name: str, document: Mapping[str, Any]) -> bool:
    """Whether a file is the one that map.json was written with; true as well if that has no checksum of it."""
    sums = document.get("files")
    wanted = sums.get(name) if isinstance(sums, Mapping) else None
    return place.is_file() and wanted in (None, hashlib.sha256(place.read_bytes()).hexdigest())
