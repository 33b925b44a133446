"""The one place where maps are opened: from a path, a folder or a pipe, by what is inside them."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from typing import BinaryIO, NamedTuple

from vdoor.errors import MapError
from vdoor.files import open_regular, read_regular
from vdoor.formats import bag, message
from vdoor.formats.content import BEGIN, Kind, kind_of
from vdoor.formats.source import Options, Request, base_name
from vdoor.formats.unwrapping import Content, unwrapped
from vdoor.grid import Source

BAGS = frozenset(bag.MAGICS.values())
PACKED = (".zstd", ".zst", ".gz", ".bz2", ".xz", ".lz4", ".active")
BYTES_PER_CELL, BYTES_BESIDE = 16, 1 << 20
"""Upper limits of all formats for the bytes per cell and for everything else; a larger file is not opened."""
UNPACKED_PER_CELL, UNPACKED_BESIDE = 2, 1 << 25
"""The same for what is packed: 16-bit samples, and the other topics of a small bag."""
PIPE, PIPE_PIECE = "stdin", 1 << 20
MOST_TEXT = 1 << 26
"""Largest size of piped data that no magic number tells to be a map."""
MOST_LISTED = 1000
"""Entries of a folder that are looked at for a file."""
Needs = Callable[[str, bytes], tuple[str, ...]]
"""The paths of further files that a file, by its stored name, refers to."""


class Formats(NamedTuple):
    """What opening must know of the formats."""

    suffixes: frozenset[str]
    """All suffixes that are read."""
    needs: Needs


def opened(path: Path, options: Options, formats: Formats, *, max_cells: int) -> Request:
    """The request to read the map at `path`, with the bytes of all its files, the one at `path` first."""
    if os.path.isdir(path):  # noqa: PTH112  # pathlib's raises for an invalid file name
        return _folder(path, options, max_cells=max_cells)
    with open_regular(path, "a map", error=MapError) as file:
        kind = kind_of(_read(file, BEGIN, path))
        if kind.suffix in BAGS:
            return bag.keep([bag.Part(file, path)], path, options, max_cells=max_cells)
    limit = most_bytes(max_cells)
    content = _content(read_regular(path, "a map", limit=limit, error=MapError), path, max_cells=max_cells)
    if content.kind.suffix in BAGS:
        return _bag_in(content, path, options, max_cells=max_cells)
    name = _name(path, content.kind, formats.suffixes)
    if "topic" in options:
        raise MapError(f"--topic: wanted a bag, found a {Path(name).suffix}: {path}")
    request = Request(source=Source(((name, content.data),), options), max_cells=max_cells, paths={name: str(path)})
    return _with_further(request, path, formats.needs)


def piped(stream: BinaryIO, options: Options, formats: Formats, *, max_cells: int) -> Request:
    """The request to read a map from a pipe, which must be one file."""
    path = Path(PIPE)
    data = _piped_bytes(stream, path, max_cells=max_cells)
    content = _content(data, path, max_cells=max_cells)
    if content.kind.suffix in BAGS:
        return _bag_in(content, path, options, max_cells=max_cells)
    if "topic" in options:
        raise MapError(f"--topic: wanted a bag, found {content.kind.suffix or 'other bytes'}: {path}")
    if content.kind.suffix == ".yaml":
        raise MapError(f"map: wanted a whole map, found a YAML that names an image (give the YAML's path): {path}")
    name = _name(path, content.kind, formats.suffixes)
    return Request(source=Source(((name, content.data),), options), max_cells=max_cells)


def most_bytes(max_cells: int) -> int:
    """The size of the largest possible file with a map of `max_cells`."""
    return max_cells * BYTES_PER_CELL + BYTES_BESIDE


def _content(data: bytes, path: Path, *, max_cells: int) -> Content:
    """What is inside the bytes of a file; raises MapError if it is nothing that is read."""
    try:
        content = unwrapped(data, max_cells * UNPACKED_PER_CELL + UNPACKED_BESIDE)
    except MapError as error:
        raise MapError(f"{error}: {path}") from error
    inside = f", inside {', '.join(content.wrappings)}" if content.wrappings else ""
    if content.kind.other:
        raise MapError(f"map: wanted a map or a bag, found {content.kind.other}{inside}: {path}")
    return content


def _name(path: Path, kind: Kind, suffixes: frozenset[str]) -> str:
    """The name under which a file is stored: its own, with the suffix of what it is; raises MapError if unknown."""
    name = path.name.encode(errors="surrogateescape").decode(errors="replace")  # recordings store names as UTF-8
    own = Path(name).suffix.lower()
    if (own and kind.suffix == own) or (own in suffixes and own not in BAGS and _alike(own, kind.suffix)):
        return name
    if kind.suffix:
        stem = Path(name).stem if own in suffixes or own in PACKED else name
        return f"{Path(stem).stem if Path(stem).suffix.lower() in suffixes else stem}{kind.suffix}"
    known = ", ".join(sorted(suffixes - {message.SUFFIX}))
    raise MapError(f"map: wanted one of {known}, found bytes that are none of them: {path}")


def _alike(own: str, found: str) -> bool:
    """Whether one reader takes both suffixes: all images, all YAML; a text that is unknown is left to its reader."""
    images = (".pgm", ".png", ".bmp", ".tif", ".tiff")
    return not found or {own, found} <= set(images) or {own, found} <= {".yaml", ".yml"}


def _read(file: BinaryIO, size: int, path: Path) -> bytes:
    try:
        return file.read(size)
    except OSError as error:
        raise MapError(f"file: wanted a map, found {error.strerror}: {path}") from error


def _piped_bytes(stream: BinaryIO, path: Path, *, max_cells: int) -> bytes:
    """All bytes of a pipe; raises MapError as soon as it is clear that they are no map, or too many for one."""
    pieces = [_read(stream, BEGIN, path)]
    kind = kind_of(pieces[0])
    if kind.other:
        raise MapError(f"map: wanted a map or a bag, found {kind.other}: {path}")
    limit = most_bytes(max_cells) if kind != Kind() else min(most_bytes(max_cells), MOST_TEXT)
    left = limit - len(pieces[0])
    while left >= 0 and (piece := _read(stream, PIPE_PIECE, path)):
        pieces.append(piece)
        left -= len(piece)
    if left < 0:
        raise MapError(f"file: wanted a map, found none of at most {limit} bytes: {path}")
    return b"".join(pieces)


# --- bags


def _bag_in(content: Content, path: Path, options: Options, *, max_cells: int) -> Request:
    """The request for a bag that was packed or piped, read from memory without a file."""
    with _memory_file(content.data) as file:
        return bag.keep([bag.Part(file, None)], path, options, max_cells=max_cells)


def _memory_file(data: bytes) -> BinaryIO:
    """A file without a name that holds some bytes, and is gone once it is closed, even by a kill."""
    number = os.memfd_create("vdoor", os.MFD_CLOEXEC)
    file = open(number, "w+b")  # noqa: PTH123, SIM115  # a file descriptor, closed by the caller
    file.write(data)
    file.flush()
    return file


def _folder(path: Path, options: Options, *, max_cells: int) -> Request:
    """The request for the folder of a ROS 2 bag, with or without its metadata.yaml."""
    with ExitStack() as stack:
        parts = [_part(place, stack, max_cells=max_cells) for place in _bag_files(path)]
        return bag.keep(parts, path, options, max_cells=max_cells)


def _bag_files(folder: Path) -> list[Path]:
    """The bag files in a folder, by name, in order; raises MapError if there are none."""
    names = sorted(_listed(folder))
    found = [folder / name for name in names if _suffix_within(name) in BAGS]
    if not found:
        maps = [name for name in names if Path(name).suffix.lower() in (".yaml", ".yml") and name != "metadata.yaml"]
        hint = f" ({maps[0]} lies in it)" if maps else ""
        raise MapError(f"file: wanted a map, found a folder without .mcap, .db3 or .bag files{hint}: {folder}")
    return found


def _suffix_within(name: str) -> str:
    """The suffix of a bag's file, without that of its packing."""
    path = Path(name.lower())
    return Path(path.stem).suffix if path.suffix in PACKED else path.suffix


def _part(place: Path, stack: ExitStack, *, max_cells: int) -> bag.Part:
    """A file of a bag, opened; unpacked in memory if it is packed."""
    file = stack.enter_context(open_regular(place, "a bag's file", error=MapError))
    if kind_of(_read(file, BEGIN, place)).packing:
        limit = most_bytes(max_cells)
        content = _content(read_regular(place, "a bag's file", limit=limit, error=MapError), place, max_cells=max_cells)
        return bag.Part(stack.enter_context(_memory_file(content.data)), None)
    return bag.Part(file, place)


def _listed(folder: Path) -> Iterator[str]:
    """The names in a folder, `MOST_LISTED` at most; none if it cannot be read."""
    try:
        with os.scandir(folder) as entries:
            for entry, _ in zip(entries, range(MOST_LISTED), strict=False):
                yield entry.name
    except OSError:
        return


# --- files that a file names


def _with_further(request: Request, path: Path, needs: Needs) -> Request:
    """The request with the files that its first file names."""
    name = request.name
    with request.naming(name):
        needed = needs(name, request.data(name))
    files, paths = list(request.source.files), dict(request.paths)
    for image in needed:
        place = path.parent / image
        data = _named_file(place, path, limit=most_bytes(request.max_cells))
        files.append((base_name(image), _content(data, place, max_cells=request.max_cells).data))
        paths[base_name(image)] = str(place)
    return replace(request, source=Source(tuple(files), request.source.options), paths=paths)


def _named_file(place: Path, path: Path, *, limit: int) -> bytes:
    """The bytes of a file that the file at `path` names; if there is none, the error says where one lies."""
    wanted = f"the image that {path} names"
    try:
        return read_regular(place, wanted, limit=limit, error=MapError)
    except MapError as error:
        near = _lies_near(place, path)
        if near is None or os.path.lexists(place):
            raise
        text = str(error).removesuffix(f": {place}")
        raise MapError(f"{text}; {near} lies there (image: {near} in the YAML would find it): {place}") from error


def _lies_near(place: Path, path: Path) -> str | None:
    """The path from the file at `path` to a file of the wanted name, or else stem; None if none is near."""
    folder = path.parent
    folders = [".", "..", *(name for name in sorted(_listed(folder)) if (folder / name).is_dir())]
    for alike in (lambda name: name == place.name, lambda name: _is_image_of(name, place)):
        for inner in folders:
            for name in sorted(_listed(folder / inner)):
                if alike(name):
                    return os.path.normpath(os.path.join(inner, name))  # noqa: PTH118  # `..` stays
    return None


def _is_image_of(name: str, place: Path) -> bool:
    """Whether a file is an image with the wanted stem, in other letters or with another suffix."""
    one = Path(name.lower())
    return one.stem == place.stem.lower() and one.suffix in (".pgm", ".png", ".bmp", ".tif", ".tiff")
