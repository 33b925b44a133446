"""What can still be read of a damaged MCAP file: every record that is whole, wherever it is."""

from __future__ import annotations

import mmap
import struct
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from vdoor.errors import RecordingError
from vdoor.recording.mcap import MAGIC_SIZE, naming, parse, unpacked

HEADER = struct.Struct("<BQ")
"""Kind of a record and length of its content."""
SIZE = struct.Struct("<Q")
CHUNK, LAST_KIND = 6, 15
PACKED = b"\x04\x00\x00\x00zstd"
"""Name of the compression, which stands at a fixed place in every chunk."""
PACKED_AT, SIZE_AT, DATA_AT = 37, 45, 53
"""Places in a chunk's record of that name, of the size of the packed data, and of the data."""


def salvage(path: Path) -> Iterator[list[Any] | int]:
    """What is whole of a file, in order, contents of each chunk in one list; where bytes had to be left out, how many.

    A chunk is told by its own sizes and checksum, not by the length of its record, which may be damaged.
    """
    with naming(path), path.open("rb") as stream:
        if path.stat().st_size <= MAGIC_SIZE:
            return
        with mmap.mmap(stream.fileno(), 0, access=mmap.ACCESS_READ) as data:
            at = MAGIC_SIZE
            while at < len(data) and data[at : at + MAGIC_SIZE] != data[:MAGIC_SIZE]:
                found, end = _chunk(data, at, path) if _is_chunk(data, at) else _record(data, at, path)
                if found is None:
                    end = _next(data, at, path)
                    yield end - at
                else:
                    yield found
                at = end


def _record(data: mmap.mmap, at: int, path: Path) -> tuple[list[Any] | None, int]:
    """The record at a place and where it ends, None where there is none, or its length would swallow a chunk."""
    end = _end(data, at)
    if end is None or _next_chunk(data, at + 1, end, path) < end:
        return None, at
    return _tried(data[at:end], path), end


def _chunk(data: mmap.mmap, at: int, path: Path) -> tuple[list[Any] | None, int]:
    """Contents of the chunk at a place and where it ends, None where it is not whole."""
    if at + DATA_AT > len(data):
        return None, at
    end = at + DATA_AT + SIZE.unpack_from(data, at + SIZE_AT)[0]
    if end > len(data):
        return None, at
    header = HEADER.pack(CHUNK, end - at - HEADER.size)
    found = _tried(header + data[at + HEADER.size : end], path)
    if found is not None and end != _end(data, at) and not _fills(data[at + DATA_AT : end]):
        return None, at
    return found, end


def _fills(packed: bytes) -> bool:
    """Whether a packed frame takes all of the bytes: to unpack them, what follows is ignored."""
    import zstandard  # noqa: PLC0415  # only recordings need it

    frame = zstandard.ZstdDecompressor().decompressobj()
    frame.decompress(packed)
    return frame.eof and not frame.unused_data


def _tried(data: bytes, path: Path) -> list[Any] | None:
    try:
        with naming(path):
            record = parse(data)
            return [] if record is None else unpacked(record)
    except RecordingError:
        return None


def _is_chunk(data: mmap.mmap, at: int) -> bool:
    return data[at + PACKED_AT : at + SIZE_AT] == PACKED


def _end(data: mmap.mmap, at: int) -> int | None:
    """Where the record at a place ends by its own account, None where that cannot be."""
    if at + HEADER.size > len(data):
        return None
    kind, length = HEADER.unpack_from(data, at)
    end = at + HEADER.size + int(length)
    return end if 0 < kind <= LAST_KIND and end <= len(data) else None


def _next(data: mmap.mmap, at: int, path: Path) -> int:
    """Where to go on after what is damaged: at its end, unless a chunk begins before."""
    end = _end(data, at)
    return _next_chunk(data, at + 1, len(data) if end is None else end, path)


def _next_chunk(data: mmap.mmap, begin: int, end: int, path: Path) -> int:
    """Where the next whole chunk begins, or `end`."""
    named = data.find(PACKED, begin + PACKED_AT, end + PACKED_AT)
    while named >= 0 and _chunk(data, named - PACKED_AT, path)[0] is None:
        named = data.find(PACKED, named + 1, end + PACKED_AT)
    return end if named < 0 else named - PACKED_AT
