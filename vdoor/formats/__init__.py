"""Map formats: one module per format, and the list of them."""

from __future__ import annotations

import os
import warnings
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import BinaryIO, NamedTuple, Protocol

from vdoor.errors import MapError, MapWarning
from vdoor.formats import bags, images, map_server, message, numpy_array, valetudo
from vdoor.formats.source import MAX_CELLS, Options, Request, UnknownValue, base_name
from vdoor.grid import Annotations, OccupancyGrid, Source

__all__ = ["MAX_CELLS", "READERS", "Reader", "read_annotations", "read_map", "read_piped", "read_source"]

BYTES_PER_CELL, BYTES_BESIDE = 16, 1 << 20
"""Upper limits of all formats for the bytes per cell and for everything else; a larger file is not opened."""
PIPE_PIECE = 1 << 20
PIPED = ((b"{", "stdin.json"), (b"\x93NUMPY", "stdin.npy"), (b"", "stdin.pgm"))
"""The first bytes of piped data and the file name it gets; image formats are recognised by content."""


class Keep(Protocol):
    """A function that opens a file too large to store, and extracts the part to store."""

    def __call__(self, path: Path, options: Options, *, max_cells: int) -> Request:
        """The request to read the extracted part; raises MapError if there is none."""
        ...


def _no_paths(_: bytes) -> tuple[str, ...]:
    """No further files, for a format with a single file."""
    return ()


def _no_annotations(_: Request) -> None:
    """No annotations, for a format that contains only cells."""


class Reader(NamedTuple):
    """A map format: its suffixes and its functions."""

    suffixes: tuple[str, ...]
    read: Callable[[Request], OccupancyGrid]
    """Reads the grid."""
    needs: Callable[[bytes], tuple[str, ...]] = _no_paths
    """Returns the paths of further files that the first file refers to."""
    annotations: Callable[[Request], Annotations | None] = _no_annotations
    """Returns what the map contains besides the cells."""
    keep: Keep | None = None
    """Opens a file of which only a part is stored; None if the files are stored whole."""


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
    unknown_value: UnknownValue = None,
    topic: str | None = None,
    max_cells: int = MAX_CELLS,
) -> OccupancyGrid:
    """The occupancy grid in a map file; its `source` stores the bytes, so that `read_source` can read it again.

    Parameters
    ----------
    path
        a map; its suffix determines the format: map_server YAML, image (PGM, PNG, BMP, TIFF), .npy, Valetudo JSON, bag
        (.mcap, .db3, .bag, or the folder of a ROS 2 bag), or a recording made by vdoor, which contains its input map
    resolution_m
        metres per cell, for files without a resolution (default 0.05, with a warning); an error if the file's differs
    unknown_value
        a grey value, 0 to 255, whose cells are unknown regardless of the thresholds; "none" for no such value. If not
        given, 205 is unknown in trinary images that look as map savers write them: 0, 205 and 254
    topic
        the nav_msgs/OccupancyGrid topic to read from a bag; its last message is read
    max_cells
        larger maps are refused before they are decoded; 100 million by default

    Raises
    ------
    MapError
        if a file is missing, damaged, too large, or not a map

    Warns
    -----
    MapWarning
        if the file is valid but probably wrong, or something had to be assumed

    """
    options = _options(resolution_m=resolution_m, unknown_value=unknown_value, topic=topic)
    return _read(_opened(Path(path), options, max_cells=max_cells))


def read_piped(
    stream: BinaryIO,
    *,
    resolution_m: float | None = None,
    unknown_value: UnknownValue = None,
    max_cells: int = MAX_CELLS,
) -> OccupancyGrid:
    """The occupancy grid of a Valetudo map, an image or a .npy read from a pipe; otherwise like `read_map`."""
    limit, data = _most_bytes(max_cells), bytearray()
    while len(data) <= limit and (piece := stream.read(PIPE_PIECE)):
        data += piece
    name = next(name for begin, name in PIPED if data[:PIPE_PIECE].lstrip().startswith(begin))
    if len(data) > limit:
        raise MapError(f"file: wanted a map, found none of at most {limit} bytes: {name}")
    options = _options(resolution_m=resolution_m, unknown_value=unknown_value)
    return _read(Request(source=Source(((name, bytes(data)),), options), max_cells=max_cells))


def read_source(source: Source, *, max_cells: int = MAX_CELLS) -> OccupancyGrid:
    """The occupancy grid in the bytes stored by an earlier `read_map`; opens no file, raises and warns like it."""
    return _read(Request(source=source, max_cells=max_cells))


def read_annotations(source: Source, *, max_cells: int = MAX_CELLS) -> Annotations | None:
    """The annotations in the bytes stored by an earlier `read_map`; None for formats that contain only cells.

    Raises the same errors as `read_map`.
    """
    if not source.files:
        return None
    request = Request(source=source, max_cells=max_cells)
    return _reader(request).annotations(request)


def _options(**given: float | str | None) -> Options:
    """The options that are not None."""
    return {name: value for name, value in given.items() if value is not None}


def _read(request: Request) -> OccupancyGrid:
    """The grid of a request, with its notes issued as warnings."""
    grid = _reader(request).read(request)
    for note in request.notes:
        warnings.warn(note, MapWarning, stacklevel=3)
    return grid


def _reader(request: Request) -> Reader:
    """The reader for a map, chosen by the suffix of its first file; raises MapError if there is none."""
    suffix = Path(request.name).suffix.lower()
    for reader in READERS:
        if suffix in reader.suffixes:
            return reader
    known = ", ".join(suffix for reader in READERS for suffix in reader.suffixes)
    raise MapError(f"map: wanted a file ending in {known}, found {suffix or 'no suffix'}: {request.path(request.name)}")


def _opened(path: Path, options: Options, *, max_cells: int) -> Request:
    """The request to read the map at `path`, with the bytes of all its files, the one at `path` first."""
    name = path.name.encode(errors="surrogateescape").decode(errors="replace")  # recordings store names as UTF-8
    bare = Request(source=Source(((name, b""),), options), max_cells=max_cells, paths={name: str(path)})
    if os.path.isdir(path):  # noqa: PTH112  # pathlib's raises for an invalid file name
        return bags.keep(path, options, max_cells=max_cells)
    reader = _reader(bare)
    if reader.keep is not None:
        _check_file(path)
        return reader.keep(path, options, max_cells=max_cells)
    if "topic" in options:
        raise MapError(f"--topic: wanted a bag, found a {Path(name).suffix}: {path}")
    first = (name, _bytes(path, max_cells=max_cells))
    alone = replace(bare, source=Source((first,), options))
    with alone.naming(name):
        further = {base_name(needed): path.parent / needed for needed in reader.needs(alone.data(name))}
    kept = ((name, _bytes(place, max_cells=max_cells)) for name, place in further.items())
    paths = {name: str(place) for name, place in further.items()}
    return replace(alone, source=Source((first, *kept), options), paths=alone.paths | paths)


def _most_bytes(max_cells: int) -> int:
    """The size of the largest possible file with a map of `max_cells`."""
    return max_cells * BYTES_PER_CELL + BYTES_BESIDE


def _bytes(path: Path, *, max_cells: int) -> bytes:
    """The bytes of a regular file; raises MapError if there is none, or it is too large for a map of `max_cells`."""
    _check_file(path, _most_bytes(max_cells))
    try:
        return path.read_bytes()
    except OSError as error:
        raise MapError(f"file: wanted a map, found {error.strerror}: {path}") from error


def _check_file(path: Path, limit: float = float("inf")) -> None:
    """Raise MapError unless the path is a regular file of at most `limit` bytes."""
    try:
        if path.is_file() and path.stat().st_size <= limit:
            return
        found = "a folder" if path.is_dir() else "none" if not path.exists() else "a device or pipe"
        found = f"none of at most {limit:.0f} bytes" if path.is_file() else found
    except (OSError, ValueError) as error:  # ValueError: a path with a null byte
        found = getattr(error, "strerror", None) or str(error)
    raise MapError(f"file: wanted a map, found {found}: {path}")
