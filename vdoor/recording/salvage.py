"""Reading a damaged MCAP file: every intact record, wherever it is."""

from __future__ import annotations

import mmap
import struct
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from vdoor.errors import RecordingError
from vdoor.recording.naming import TooMuchError, naming
from vdoor.recording.scan import HEADER, MAGIC, Budget, parse, unpacked

SIZE = struct.Struct("<Q")
CHUNK, LAST_KIND = 6, 15
PACKED = b"\x04\x00\x00\x00zstd"
"""Name of the compression, at a fixed offset in every chunk."""
FRAME = b"\x28\xb5\x2f\xfd"
"""First bytes of compressed data."""
PACKED_AT, SIZE_AT, DATA_AT = 37, 45, 53
"""Byte offsets in a chunk's record: compression name, compressed size, data."""


def salvage(path: Path) -> Iterator[list[Any] | int]:
    """Intact contents of a file in order, one list per chunk; an int is the number of bytes skipped at that point.

    A chunk is recognised by its own sizes and checksum, not by the length of its record, which may be damaged. Raises
    `TooMuchError` for a file with far more records, bytes once unpacked, or beginnings of chunks than fit its size.
    """
    with naming(path), path.open("rb") as stream:
        if path.stat().st_size <= len(MAGIC):
            return
        with mmap.mmap(stream.fileno(), 0, access=mmap.ACCESS_READ) as data:
            yield from _Salvage(data, path).contents()


class _Salvage:
    """The search for intact records in the bytes of a file."""

    def __init__(self, data: mmap.mmap, path: Path) -> None:
        self._data, self._path = data, path
        self._budget = Budget.of(path)

    def contents(self) -> Iterator[list[Any] | int]:
        """What `salvage` yields."""
        at, data = len(MAGIC), self._data
        while at < len(data) and data[at : at + len(MAGIC)] != MAGIC:
            found, end = self._chunk(at) if self._is_chunk(at) else self._record(at)
            if found is None:
                end = self._next(at)
                yield end - at
            else:
                yield found
            at = end

    def _record(self, at: int) -> tuple[list[Any] | None, int]:
        """Record at a byte and its end; None if there is no record, or if its length would run over a chunk."""
        end = self._end(at)
        if end is None or self._next_chunk(at + 1, end) < end:
            return None, at
        self._budget.take_record()
        return self._tried(self._data[at:end]), end

    def _chunk(self, at: int) -> tuple[list[Any] | None, int]:
        """Contents of the chunk at a byte and its end; None if it is not intact."""
        if at + DATA_AT > len(self._data):
            return None, at
        end = at + DATA_AT + SIZE.unpack_from(self._data, at + SIZE_AT)[0]
        if end > len(self._data) or self._data[at + DATA_AT : at + DATA_AT + len(FRAME)] != FRAME:
            return None, at
        self._budget.take_unpacked(end - at)
        header = HEADER.pack(CHUNK, end - at - HEADER.size)
        found = self._tried(header + self._data[at + HEADER.size : end])
        if found is not None and end != self._end(at) and not _fills(self._data[at + DATA_AT : end]):
            return None, at
        return found, end

    def _tried(self, data: bytes) -> list[Any] | None:
        try:
            with naming(self._path):
                record = parse(data)
                return [] if record is None else list(unpacked(record, self._budget))
        except TooMuchError:
            raise
        except RecordingError:
            return None

    def _is_chunk(self, at: int) -> bool:
        return self._data[at + PACKED_AT : at + SIZE_AT] == PACKED

    def _end(self, at: int) -> int | None:
        """End of the record at a byte according to its header; None if the header is not valid."""
        if at + HEADER.size > len(self._data):
            return None
        kind, length = HEADER.unpack_from(self._data, at)
        end = at + HEADER.size + int(length)
        return end if 0 < kind <= LAST_KIND and end <= len(self._data) else None

    def _next(self, at: int) -> int:
        """Where to continue after a damaged record: at its end, or earlier if a chunk begins before that."""
        end = self._end(at)
        return self._next_chunk(at + 1, len(self._data) if end is None else end)

    def _next_chunk(self, begin: int, end: int) -> int:
        """Start of the next intact chunk before `end`, or `end`."""
        named = self._data.find(PACKED, begin + PACKED_AT, end + PACKED_AT)
        while named >= 0 and self._chunk(named - PACKED_AT)[0] is None:
            named = self._data.find(PACKED, named + 1, end + PACKED_AT)
        return end if named < 0 else named - PACKED_AT


def _fills(packed: bytes) -> bool:
    """Whether a compressed frame uses all of the bytes; decompression ignores anything after the frame."""
    import zstandard  # noqa: PLC0415  # only recordings need it

    frame = zstandard.ZstdDecompressor().decompressobj()
    frame.decompress(packed)
    return frame.eof and not frame.unused_data
