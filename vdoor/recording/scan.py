"""MCAP files record by record, with a limit on the work that one file may cause.

A small file can hold any number of records and unpack to any size, so both are bounded by the size of the file.
"""

from __future__ import annotations

import io
import struct
import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, BinaryIO

from vdoor.errors import RecordingError
from vdoor.recording.naming import TooMuchError

if TYPE_CHECKING:
    from mcap.records import Chunk, McapRecord

MAGIC = b"\x89MCAP0\r\n"
HEADER = struct.Struct("<BQ")
"""Kind and content length of a record."""
MESSAGE_HEADER = struct.Struct("<HIQQ")
"""Channel, sequence, log time, publish time."""
NOTHING, FOOTER, SCHEMA, CHANNEL, MESSAGE = 0, 2, 3, 4, 5
CHUNK_BESIDE = 2**24
"""Bytes of a chunk beside its largest message."""
CHUNK_TO = 4 * 100_000_000 + CHUNK_BESIDE
"""Maximum size of an uncompressed chunk in bytes: the labels of the largest map that is read without --max-cells."""
SIZE_UNKNOWN = -1
RECORDS, RECORDS_PER_BYTE = 100_000, 1 / 16
"""Records that any file may have, and more by the bytes of the file; our own take at least 80 bytes each."""
UNPACKED, UNPACKED_PER_BYTE = 2**31, 100
"""Bytes that any file may unpack to, and more by the bytes of the file; a map takes 30 bytes a cell in all."""


@dataclass
class Budget:
    """What is left of the work that one file may cause."""

    records: float
    unpacked: float

    @classmethod
    def of(cls, path: Path) -> Budget:
        """The budget of a file."""
        size = path.stat().st_size
        return cls(RECORDS + size * RECORDS_PER_BYTE, UNPACKED + size * UNPACKED_PER_BYTE)

    def take_record(self) -> None:
        """Use up one record; raises `TooMuchError` once none are left."""
        self.records -= 1
        if self.records < 0:
            raise TooMuchError("recording: wanted a number of records that fits the file's size, found far more")

    def take_unpacked(self, size: int) -> None:
        """Use up some bytes; raises `TooMuchError` once none are left."""
        self.unpacked -= size
        if self.unpacked < 0:
            raise TooMuchError("recording: wanted a total size that fits the file's size, found far more once unpacked")


def scan(path: Path, budget: Budget) -> Iterator[tuple[int, int, McapRecord]]:
    """Begin, end and content of all top-level records of the file; chunks are not unpacked.

    Checks the checksum of the data section, and raises `RecordingError` if bytes follow the last record. Never
    allocates more bytes than the file has left, whatever length a record claims.
    """
    from mcap.exceptions import EndOfFile  # noqa: PLC0415  # only recordings need it

    size = path.stat().st_size
    with path.open("rb") as stream:
        _read_magic(stream)
        begin, kind, crc = len(MAGIC), NOTHING, zlib.crc32(MAGIC)
        while kind != FOOTER:
            budget.take_record()
            kind, length = HEADER.unpack(stream.read(HEADER.size))
            end = begin + HEADER.size + length
            if kind == NOTHING:
                raise RecordingError(f"recording: wanted a record at byte {begin}, found none")
            if end > size:
                raise EndOfFile
            stream.seek(begin)
            data = stream.read(end - begin)
            record = parse(data)
            _check_sum(record, crc)
            crc = zlib.crc32(data, crc)
            if record is not None:
                yield begin, end, record
            begin = end
        _read_magic(stream)
        if stream.read(1):
            raise RecordingError(f"recording: wanted nothing after byte {stream.tell() - 1}, found more")


def _read_magic(stream: BinaryIO) -> None:
    from mcap.exceptions import EndOfFile, InvalidMagic  # noqa: PLC0415  # only recordings need it

    found = stream.read(len(MAGIC))
    if len(found) < len(MAGIC) and MAGIC.startswith(found):
        raise EndOfFile
    if found != MAGIC:
        raise InvalidMagic(found)


def _check_sum(record: McapRecord | None, crc: int) -> None:
    """Compare the checksum at the end of the data section, if there is one, with that of the bytes before it."""
    from mcap.records import DataEnd  # noqa: PLC0415
    from mcap.stream_reader import CRCValidationError  # noqa: PLC0415  # only recordings need it

    if isinstance(record, DataEnd) and record.data_section_crc not in (0, crc):
        raise CRCValidationError(expected=record.data_section_crc, actual=crc, record=record)


def parse(data: bytes) -> McapRecord | None:
    """The record, with its header, in `data`; None for an unknown kind."""
    from mcap.stream_reader import StreamReader  # noqa: PLC0415  # only recordings need it

    reader = StreamReader(io.BytesIO(data), skip_magic=True, emit_chunks=True, record_size_limit=len(data))
    return next(reader.records, None)


def unpacked(record: McapRecord, budget: Budget) -> Iterator[McapRecord]:
    """Contents of a chunk one by one, after a check of its claimed size and its checksum; another record as it is."""
    from mcap.records import Chunk  # noqa: PLC0415  # only recordings need it

    if isinstance(record, Chunk):
        yield from _items(_content(record, budget), budget)
    else:
        yield record


def _content(chunk: Chunk, budget: Budget) -> bytes:
    """The uncompressed bytes of a chunk."""
    import zstandard  # noqa: PLC0415  # only recordings need it
    from mcap.stream_reader import CRCValidationError  # noqa: PLC0415

    if chunk.compression not in {"zstd", ""}:
        raise RecordingError(f"recording: wanted zstd or uncompressed chunks, found {chunk.compression!r}")
    claims = {chunk.uncompressed_size}
    if chunk.compression:
        claims.add(zstandard.frame_content_size(chunk.data))
    if len(claims - {SIZE_UNKNOWN}) > 1 or max(claims) > CHUNK_TO:
        raise RecordingError(
            f"recording: wanted a chunk of at most {CHUNK_TO} bytes, found one that claims {max(claims)}"
        )
    budget.take_unpacked(max(claims))
    data = zstandard.decompress(chunk.data, chunk.uncompressed_size) if chunk.compression else chunk.data
    if chunk.uncompressed_crc not in (0, crc := zlib.crc32(data)):
        raise CRCValidationError(expected=chunk.uncompressed_crc, actual=crc, record=chunk)
    return data


def _items(data: bytes, budget: Budget) -> Iterator[McapRecord]:
    """The schemas, channels and messages in the bytes of a chunk; other kinds are left out."""
    from mcap.exceptions import EndOfFile  # noqa: PLC0415  # only recordings need it
    from mcap.records import Message  # noqa: PLC0415

    at = 0
    while at < len(data):
        budget.take_record()
        kind, length = HEADER.unpack_from(data, at)
        begin, end = at + HEADER.size, at + HEADER.size + length
        if end > len(data):
            raise EndOfFile
        if kind == MESSAGE:
            channel, sequence, log_ns, publish_ns = MESSAGE_HEADER.unpack_from(data, begin)
            content = data[begin + MESSAGE_HEADER.size : end]
            yield Message(channel, log_ns, content, publish_ns, sequence)
        elif kind in (SCHEMA, CHANNEL) and (record := parse(data[at:end])) is not None:
            yield record
        at = end
