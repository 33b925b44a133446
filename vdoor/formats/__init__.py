"""Map formats: one file per format, and the list of them."""

from __future__ import annotations

import os
import warnings
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

from vdoor.errors import MapError, MapWarning
from vdoor.formats import images, map_server, numpy_array
from vdoor.formats.reading import MAX_CELLS, Request, base_name
from vdoor.grid import OccupancyGrid, Source

__all__ = ["MAX_CELLS", "READERS", "Reader", "read_map", "read_source"]

BYTES_PER_CELL, BYTES_BESIDE = 16, 1 << 20
"""No format here needs more for a cell, and for all that is not cells; a larger file is not even opened."""


def _nothing(_: bytes) -> tuple[str, ...]:
    """Paths of further files that a format of one file needs: none."""
    return ()


class Reader(NamedTuple):
    """One format: the suffixes that tell it, the function that reads it, and the paths of further files it needs."""

    suffixes: tuple[str, ...]
    read: Callable[[Request], OccupancyGrid]
    needs: Callable[[bytes], tuple[str, ...]] = _nothing


READERS = (
    Reader((".yaml", ".yml"), map_server.read, map_server.image_paths),
    Reader((".pgm", ".png", ".bmp", ".tif", ".tiff"), images.read),
    Reader((".npy",), numpy_array.read),
)


def read_map(
    path: str | os.PathLike[str],
    *,
    resolution_m: float | None = None,
    unknown_value: int | None = None,
    max_cells: int = MAX_CELLS,
) -> OccupancyGrid:
    """Occupancy grid in a map file; its `source` keeps the bytes, so that `read_source` gives it again.

    Parameters
    ----------
    path
        a map_server YAML, an image (PGM, PNG, BMP, TIFF) or a .npy, told by its suffix
    resolution_m
        metres a cell where the file does not say (0.05 with a warning if nothing does); an error if it says another
    unknown_value
        the grey, 0 to 255, whose cells are unknown whatever the thresholds say
    max_cells
        larger maps are refused before they are decoded; 100 million by default

    Raises
    ------
    MapError
        where a file is missing, damaged, too large, or no map

    Warns
    -----
    MapWarning
        where the file is legal but likely not meant so, or something had to be assumed

    """
    given = {"resolution_m": resolution_m, "unknown_value": unknown_value}
    options: dict[str, float | int | str] = {name: value for name, value in given.items() if value is not None}
    request = _opened(Path(path), options, max_cells=max_cells)
    grid = _reader(request).read(request)
    for note in request.notes:
        warnings.warn(note, MapWarning, stacklevel=2)
    return grid


def read_source(source: Source, *, max_cells: int = MAX_CELLS) -> OccupancyGrid:
    """Occupancy grid in bytes kept from an earlier `read_map`; no file is touched, errors and warnings as there."""
    request = Request(source=source, max_cells=max_cells)
    grid = _reader(request).read(request)
    for note in request.notes:
        warnings.warn(note, MapWarning, stacklevel=2)
    return grid


def _reader(request: Request) -> Reader:
    """Format of a map, told by the suffix of its first file."""
    suffix = Path(request.name).suffix.lower()
    for reader in READERS:
        if suffix in reader.suffixes:
            return reader
    known = ", ".join(suffix for reader in READERS for suffix in reader.suffixes)
    msg = f"map: wanted a file that ends in {known}, found {suffix or 'no suffix'}: {request.path(request.name)}"
    raise MapError(msg)


def _opened(path: Path, options: dict[str, float | int | str], *, max_cells: int) -> Request:
    """Request to read the map at `path`, with the bytes of all its files, the one at `path` first."""
    name = path.name.encode(errors="surrogateescape").decode(errors="replace")  # recordings hold text
    first = (name, _bytes(path, max_cells=max_cells))
    alone = Request(source=Source((first,), options), max_cells=max_cells, paths={name: str(path)})
    needs = _reader(alone).needs
    with alone.naming(name):
        further = {base_name(needed): path.parent / needed for needed in needs(alone.data(name))}
    kept = ((name, _bytes(place, max_cells=max_cells)) for name, place in further.items())
    paths = {name: str(place) for name, place in further.items()}
    return replace(alone, source=Source((first, *kept), options), paths=alone.paths | paths)


def _bytes(path: Path, *, max_cells: int) -> bytes:
    """All bytes of a regular file; MapError where there is none or it is larger than any map of `max_cells`."""
    limit = max_cells * BYTES_PER_CELL + BYTES_BESIDE
    try:
        if path.is_file() and path.stat().st_size <= limit:
            return path.read_bytes()
        found = "a folder" if path.is_dir() else "none" if not path.exists() else f"none of at most {limit} bytes"
    except (OSError, ValueError) as error:  # ValueError: a path with a null byte
        found = getattr(error, "strerror", None) or str(error)
    msg = f"file: wanted a map, found {found}: {path}"
    raise MapError(msg)
