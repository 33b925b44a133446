"""Maps in all formats: the list of these, and reading a map or what else its file says."""

from __future__ import annotations

import os
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import BinaryIO, NamedTuple

from vdoor.errors import MapError, MapWarning
from vdoor.formats import bag, images, map_server, message, notes, numpy_array, opening, valetudo
from vdoor.formats.notes import histogram, note_cells
from vdoor.formats.source import MAX_CELLS, Options, Request, UnknownValue
from vdoor.grid import Annotations, OccupancyGrid, Source


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


READERS = (
    Reader((".yaml", ".yml"), map_server.read, needs=map_server.image_paths),
    Reader((".pgm", ".png", ".bmp", ".tif", ".tiff"), images.read),
    Reader((".npy",), numpy_array.read),
    Reader((".json",), valetudo.read, annotations=valetudo.read_annotations),
    Reader((message.SUFFIX,), message.read),
    Reader(tuple(opening.BAGS), bag.read),
)


def read_map(
    path: str | os.PathLike[str],
    *,
    resolution_m: float | None = None,
    unknown_value: UnknownValue = None,
    free_below: float | None = None,
    occupied_from: float | None = None,
    topic: str | None = None,
    max_cells: int = MAX_CELLS,
) -> OccupancyGrid:
    """The occupancy grid in a map file; its `source` stores the bytes, so that `read_source` can read it again.

    Parameters
    ----------
    path
        a map; what is inside determines the format: map_server YAML, image (PGM, PNG, BMP, TIFF), .npy, Valetudo JSON,
        bag (.mcap, .db3, .bag, or the folder of a ROS 2 bag), or a recording made by vdoor, which contains its input
        map; also compressed (zstd, gzip, deflate, bzip2, xz, lz4), in base64, or in a PNG's text
    resolution_m
        metres per cell, for files without a resolution (default 0.05, with a warning); an error if the file's differs
    unknown_value
        a grey value, 0 to 255, whose cells are unknown regardless of the thresholds; "none" for no such value. If not
        given, 205 is unknown in trinary images that look as map savers write them: 0, 205 and 254
    free_below, occupied_from
        limits in per cent of occupancy, in place of the thresholds of the file or format; where a bag or array has
        many values between free and occupied, 50 and 51 are used, with a warning
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
    options = _options(
        resolution_m=resolution_m,
        unknown_value=unknown_value,
        free_below=free_below,
        occupied_from=occupied_from,
        topic=topic,
    )
    return _read(opening.opened(Path(path), options, _formats(), max_cells=max_cells))


def read_piped(
    stream: BinaryIO,
    *,
    resolution_m: float | None = None,
    unknown_value: UnknownValue = None,
    free_below: float | None = None,
    occupied_from: float | None = None,
    topic: str | None = None,
    max_cells: int = MAX_CELLS,
) -> OccupancyGrid:
    """The occupancy grid of a map read from a pipe, of any format that is a single file; otherwise like `read_map`."""
    options = _options(
        resolution_m=resolution_m,
        unknown_value=unknown_value,
        free_below=free_below,
        occupied_from=occupied_from,
        topic=topic,
    )
    return _read(opening.piped(stream, options, _formats(), max_cells=max_cells))


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


def described(grid: OccupancyGrid) -> str:
    """The cells of a map in counts, the commonest greys or values, what to set if none is free, and the map's name."""
    files = grid.source.files
    greys = None
    if files and (data := dict(files).get(_image_of(grid.source))):
        greys = histogram(images.decode(data, max_cells=grid.cells.size).greys())
    return f"{notes.described(grid.cells, greys)}: {files[0][0] if files else 'map'}"


def _image_of(source: Source) -> str:
    """The name of the stored image of a map; empty if it has none."""
    suffixes = next(reader for reader in READERS if reader.read is images.read).suffixes
    return next((name for name, _ in source.files if Path(name).suffix.lower() in suffixes), "")


def _options(**given: float | str | None) -> Options:
    """The options that are not None."""
    return {name: value for name, value in given.items() if value is not None}


def _read(request: Request) -> OccupancyGrid:
    """The grid of a request, with its notes issued as warnings."""
    grid = _reader(request).read(request)
    note_cells(grid.cells, request)
    for note in request.notes:
        warnings.warn(note, MapWarning, stacklevel=3)
    return grid


def _reader(request: Request) -> Reader:
    """The reader for a map, chosen by the suffix of its first stored file; raises MapError if there is none."""
    if reader := reader_of(request.name):
        return reader
    suffix = Path(request.name).suffix.lower()
    known = ", ".join(suffix for reader in READERS for suffix in reader.suffixes)
    raise MapError(f"map: wanted a file ending in {known}, found {suffix or 'no suffix'}: {request.path(request.name)}")


def reader_of(name: str) -> Reader | None:
    """The reader for a file of that name, chosen by its suffix; None if there is none."""
    suffix = Path(name).suffix.lower()
    return next((reader for reader in READERS if suffix in reader.suffixes), None)


def _formats() -> opening.Formats:
    """What opening must know of the formats."""

    def needs(name: str, data: bytes) -> tuple[str, ...]:
        reader = reader_of(name)
        return reader.needs(data) if reader else ()

    return opening.Formats(frozenset(suffix for reader in READERS for suffix in reader.suffixes), needs)
