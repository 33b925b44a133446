"""Map formats: one file per format, and the list of them."""

from __future__ import annotations

import os
import warnings
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import BinaryIO, NamedTuple, Protocol

from vdoor.errors import MapError, MapWarning
from vdoor.formats import bags, images, map_server, message, numpy_array, valetudo
from vdoor.formats.source import MAX_CELLS, Options, Request, base_name
from vdoor.grid import Annotations, OccupancyGrid, Source

__all__ = ["MAX_CELLS", "READERS", "Reader", "read_annotations", "read_map", "read_piped", "read_source"]

BYTES_PER_CELL, BYTES_BESIDE = 16, 1 << 20
"""No format here needs more for a cell, and for all that is not cells; a larger file is not even opened."""
PIPE_PIECE = 1 << 20
PIPED = ((b"{", "stdin.json"), (b"\x93NUMPY", "stdin.npy"), (b"", "stdin.pgm"))
"""What piped bytes are called, by how they begin; images are told apart by their content."""


class Keep(Protocol):
    """Opens a file that is too large to keep, and gives what is kept of it."""

    def __call__(self, path: Path, options: Options, *, max_cells: int) -> Request:
        """Request to read what is kept; MapError where there is nothing."""
        ...


def _nothing(_: bytes) -> tuple[str, ...]:
    """Paths of further files that a format of one file needs: none."""
    return ()


def _cells_alone(_: Request) -> None:
    """What a format of nothing but cells says beside them: nothing."""


class Reader(NamedTuple):
    """One format: the suffixes that tell it, the function that reads it, and the paths of further files it needs."""

    suffixes: tuple[str, ...]
    read: Callable[[Request], OccupancyGrid]
    needs: Callable[[bytes], tuple[str, ...]] = _nothing
    annotations: Callable[[Request], Annotations | None] = _cells_alone
    """What it says beside the cells."""
    keep: Keep | None = None
    """How a file is opened of which only a part is kept."""


READERS = (
    Reader((".yaml", ".yml"), map_server.read, needs=map_server.image_paths),
    Reader((".pgm", ".png", ".bmp", ".tif", ".tiff"), images.read),
    Reader((".npy",), numpy_array.read),
    Reader((".json",), valetudo.read, annotations=valetudo.read_annotations),
    Reader((message.SUFFIX,), message.read),
    Reader((".mcap", ".db3", ".bag"), bags.read, keep=bags.keep),
)


def read_map(
    path: str | os.PathLike[str],
    *,
    resolution_m: float | None = None,
    unknown_value: int | None = None,
    topic: str | None = None,
    max_cells: int = MAX_CELLS,
) -> OccupancyGrid:
    """Occupancy grid in a map file; its `source` keeps the bytes, so that `read_source` gives it again.

    Parameters
    ----------
    path
        a map, told by its suffix: map_server YAML, image (PGM, PNG, BMP, TIFF), .npy, Valetudo JSON, bag (.mcap, .db3,
        .bag, or the folder of a ROS 2 bag), or a recording of vdoor's own, which gives the map that it was made of
    resolution_m
        metres a cell where the file does not say (0.05 with a warning if nothing does); an error if it says another
    unknown_value
        the grey, 0 to 255, whose cells are unknown whatever the thresholds say
    topic
        which nav_msgs/OccupancyGrid of a bag; its last message is read
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
    options = _options(resolution_m=resolution_m, unknown_value=unknown_value, topic=topic)
    return _read(_opened(Path(path), options, max_cells=max_cells))


def read_piped(
    stream: BinaryIO,
    *,
    resolution_m: float | None = None,
    unknown_value: int | None = None,
    max_cells: int = MAX_CELLS,
) -> OccupancyGrid:
    """Occupancy grid of a Valetudo map, an image or a .npy that comes out of a pipe; else as from `read_map`."""
    limit, data = _most_bytes(max_cells), bytearray()
    while len(data) <= limit and (piece := stream.read(PIPE_PIECE)):
        data += piece
    name = next(name for begin, name in PIPED if data[:PIPE_PIECE].lstrip().startswith(begin))
    if len(data) > limit:
        raise MapError(f"file: wanted a map, found none of at most {limit} bytes: {name}")
    options = _options(resolution_m=resolution_m, unknown_value=unknown_value)
    return _read(Request(source=Source(((name, bytes(data)),), options), max_cells=max_cells))


def read_source(source: Source, *, max_cells: int = MAX_CELLS) -> OccupancyGrid:
    """Occupancy grid in bytes kept from an earlier `read_map`; no file is touched, errors and warnings as there."""
    return _read(Request(source=source, max_cells=max_cells))


def read_annotations(source: Source, *, max_cells: int = MAX_CELLS) -> Annotations | None:
    """What a map says beside its cells, from bytes kept from an earlier `read_map`; None for formats of cells alone.

    Errors as from there.
    """
    if not source.files:
        return None
    request = Request(source=source, max_cells=max_cells)
    return _reader(request).annotations(request)


def _options(**given: float | str | None) -> Options:
    """Options that were given."""
    return {name: value for name, value in given.items() if value is not None}


def _read(request: Request) -> OccupancyGrid:
    """Grid of a request, its notes as warnings."""
    grid = _reader(request).read(request)
    for note in request.notes:
        warnings.warn(note, MapWarning, stacklevel=3)
    return grid


def _reader(request: Request) -> Reader:
    """Format of a map, told by the suffix of its first file."""
    suffix = Path(request.name).suffix.lower()
    for reader in READERS:
        if suffix in reader.suffixes:
            return reader
    known = ", ".join(suffix for reader in READERS for suffix in reader.suffixes)
    raise MapError(
        f"map: wanted a file that ends in {known}, found {suffix or 'no suffix'}: {request.path(request.name)}"
    )


def _opened(path: Path, options: Options, *, max_cells: int) -> Request:
    """Request to read the map at `path`, with the bytes of all its files, the one at `path` first."""
    name = path.name.encode(errors="surrogateescape").decode(errors="replace")  # recordings hold text
    bare = Request(source=Source(((name, b""),), options), max_cells=max_cells, paths={name: str(path)})
    if os.path.isdir(path):  # noqa: PTH112  # pathlib's raises where no file can have that name
        return bags.keep(path, options, max_cells=max_cells)
    reader = _reader(bare)
    if reader.keep is not None:
        _check_file(path)
        return reader.keep(path, options, max_cells=max_cells)
    if "topic" in options:
        raise MapError(f"--topic: wanted a bag to choose from, found a {Path(name).suffix}: {path}")
    first = (name, _bytes(path, max_cells=max_cells))
    alone = replace(bare, source=Source((first,), options))
    with alone.naming(name):
        further = {base_name(needed): path.parent / needed for needed in reader.needs(alone.data(name))}
    kept = ((name, _bytes(place, max_cells=max_cells)) for name, place in further.items())
    paths = {name: str(place) for name, place in further.items()}
    return replace(alone, source=Source((first, *kept), options), paths=alone.paths | paths)


def _most_bytes(max_cells: int) -> int:
    """Size of the largest file that a map of `max_cells` can be."""
    return max_cells * BYTES_PER_CELL + BYTES_BESIDE


def _bytes(path: Path, *, max_cells: int) -> bytes:
    """All bytes of a regular file; MapError where there is none or it is larger than any map of `max_cells`."""
    _check_file(path, _most_bytes(max_cells))
    try:
        return path.read_bytes()
    except OSError as error:
        raise MapError(f"file: wanted a map, found {error.strerror}: {path}") from error


def _check_file(path: Path, limit: float = float("inf")) -> None:
    """MapError unless there is a regular file of at most `limit` bytes."""
    try:
        if path.is_file() and path.stat().st_size <= limit:
            return
        found = "a folder" if path.is_dir() else "none" if not path.exists() else "a device or pipe"
        found = f"none of at most {limit:.0f} bytes" if path.is_file() else found
    except (OSError, ValueError) as error:  # ValueError: a path with a null byte
        found = getattr(error, "strerror", None) or str(error)
    raise MapError(f"file: wanted a map, found {found}: {path}")
