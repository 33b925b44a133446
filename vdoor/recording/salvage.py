"""Reading a damaged MCAP file: every intact record, wherever it is."""

from __future__ import annotations

import mmap
import struct
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from vdoor.errors import RecordingError
from vdoor.recording.mcap import MAGIC_SIZE, naming, parse, unpacked

HEADER = struct.Struct("<BQ")
"""Kind and content length of a record."""
SIZE = struct.Struct("<Q")
CHUNK, LAST_KIND = 6, 15
PACKED = b"\x04\x00\x00\x00zstd"
"""Name of the compression, at a fixed offset in every chunk."""
PACKED_AT, SIZE_AT, DATA_AT = 37, 45, 53
"""Byte offsets in a chunk's record: compression name, compressed size, data."""


def salvage(path: Path) -> Iterator[list[Any] | int]:
    """Intact contents of a file in order, one list per chunk; an int is the number of bytes skipped at that point.

    A chunk is recognised by its own sizes and checksum, not by the length of its record, which may be damaged.
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
    """Record at a byte and its end; None if there is no record, or if its length would run over a chunk."""
    end = _end(data, at)
    if end is None or _next_chunk(data, at + 1, end, path) < end:
        return None, at
    return _tried(data[at:end], path), end


def _chunk(data: mmap.mmap, at: int, path: Path) -> tuple[list[Any] | None, int]:
    """Contents of the chunk at a byte and its end; None if it is not intact."""
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
    """Whether a compressed frame uses all of the bytes; decompression ignores anything after the frame."""
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
    """End of the record at a byte according to its header; None if the header is not valid."""
    if at + HEADER.size > len(data):
        return None
    kind, length = HEADER.unpack_from(data, at)
    end = at + HEADER.size + int(length)
    return end if 0 < kind <= LAST_KIND and end <= len(data) else None


def _next(data: mmap.mmap, at: int, path: Path) -> int:
    """Where to continue after a damaged record: at its end, or earlier if a chunk begins before that."""
    end = _end(data, at)
    return _next_chunk(data, at + 1, len(data) if end is None else end, path)


def _next_chunk(data: mmap.mmap, begin: int, end: int, path: Path) -> int:
    """Start of the next intact chunk before `end`, or `end`."""
    named = data.find(PACKED, begin + PACKED_AT, end + PACKED_AT)
    while named >= 0 and _chunk(data, named - PACKED_AT, path)[0] is None:
        named = data.find(PACKED, named + 1, end + PACKED_AT)
    return end if named < 0 else named - PACKED_AT
