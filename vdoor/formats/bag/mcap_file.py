"""MCAP files of any writer, whole or cut short; their profile does not matter, nor do topics of other encodings."""

from __future__ import annotations

import io
import struct
from collections.abc import Iterator
from typing import TYPE_CHECKING, BinaryIO

from vdoor.formats.bag.budget import Budget, DamagedError
from vdoor.formats.bag.chunked import Chunk, Message, Topic

if TYPE_CHECKING:
    from mcap.data_stream import ReadDataStream

MAGIC = b"\x89MCAP0\r\n"
RECORD = struct.Struct("<BQ")
"""Kind and length of a record."""
FOOTER, SCHEMA, CHANNEL, MESSAGE, CHUNK, MESSAGE_INDEX, DATA_END, LAST_KIND = 2, 3, 4, 5, 6, 7, 15, 15
FOOTER_BYTES = RECORD.size + 20 + len(MAGIC)
MESSAGE_HEAD, MESSAGE_HEAD_BYTES = struct.Struct("<H4xQ"), 22
CHUNK_HEAD = struct.Struct("<16xQI")
"""Unpacked size and checksum, after the times of the first and the last message."""
INDEX_ENTRY = struct.Struct("<Q8x")
MOST_SUMMARY = 1 << 24
ENCODINGS = {"cdr": "cdr", "ros1": "ros1"}


class McapLayout:
    """The records of an MCAP file."""

    def __init__(self, stream: BinaryIO, size: int, budget: Budget) -> None:
        self._stream, self._size, self._budget = stream, size, budget
        self._schemas: dict[int, str] = {}
        self.channels: dict[int, Topic] = {}
        self.stopped = ""
        self._read_summary()
        self.complete = bool(self.channels)

    def walk(self) -> Iterator[Chunk]:
        """The chunks, and the messages outside chunks, each with its index if it has one."""
        chunk: Chunk | None = None
        for kind, begin, length in self._records():
            if kind == MESSAGE_INDEX:
                if chunk is not None:
                    self._add_index(chunk, begin, length)
                continue
            if chunk is not None:
                yield chunk
            chunk = self._chunk(begin, length) if kind == CHUNK else None
            if kind == MESSAGE:
                yield self._bare(begin, length)
            elif kind in (SCHEMA, CHANNEL):
                self._define(kind, self._read(begin, length))
        if chunk is not None:
            yield chunk

    def messages(self, content: bytes, channels: set[int] | None) -> Iterator[Message]:
        """The messages of some channels in a chunk; raises `DamagedError` where its records end too early."""
        at = 0
        while at < len(content):
            self._budget.take_records()
            if at + RECORD.size > len(content):
                raise DamagedError("a chunk that ends within a record")
            kind, length = RECORD.unpack_from(content, at)
            begin, at = at + RECORD.size, at + RECORD.size + length
            if at > len(content):
                raise DamagedError("a chunk that ends within a record")
            if kind == MESSAGE and length >= MESSAGE_HEAD_BYTES:
                channel, time_ns = MESSAGE_HEAD.unpack_from(content, begin)
                if channels is None or channel in channels:
                    data = content[begin + MESSAGE_HEAD_BYTES : at] if channels is not None else b""
                    yield Message(channel, time_ns, data)
            elif kind in (SCHEMA, CHANNEL):
                self._define(kind, content[begin:at])

    def _records(self) -> Iterator[tuple[int, int, int]]:
        """Kind, first byte and length of the records of the data; sets `stopped` where a file is cut short."""
        at = len(MAGIC)
        while at + RECORD.size <= self._size:
            self._budget.take_records()
            kind, length = RECORD.unpack(self._read(at, RECORD.size))
            begin, at = at + RECORD.size, at + RECORD.size + length
            if kind in (DATA_END, FOOTER):
                whole = self._read(self._size - len(MAGIC), len(MAGIC)) == MAGIC
                self.stopped = "" if whole else f"cut short at byte {self._size}"
                return
            if not 0 < kind <= LAST_KIND and kind < 0x80:  # noqa: PLR2004  # others are of private kinds
                self.stopped = f"damaged at byte {begin - RECORD.size}"
                return
            if at > self._size:
                break
            yield kind, begin, length
        self.stopped = f"cut short at byte {self._size}"

    def _chunk(self, begin: int, length: int) -> Chunk:
        """The chunk in a record."""
        head = self._read(begin, min(length, CHUNK_HEAD.size + 4 + 16 + 8))
        try:
            size, crc = CHUNK_HEAD.unpack_from(head)
            (named,) = struct.unpack_from("<I", head, CHUNK_HEAD.size)
            packing = head[CHUNK_HEAD.size + 4 : CHUNK_HEAD.size + 4 + named].decode(errors="replace")
            (packed,) = struct.unpack_from("<Q", head, CHUNK_HEAD.size + 4 + named)
        except struct.error:
            return Chunk(begin=begin, size=0, unpacked=1)  # cannot be read
        at = CHUNK_HEAD.size + 4 + named + 8
        return Chunk(begin=begin + at, size=min(packed, length - at), packing=packing, unpacked=size, crc=crc)

    def _bare(self, begin: int, length: int) -> Chunk:
        """A message outside any chunk."""
        head = self._read(begin, min(length, MESSAGE_HEAD.size))
        latest_ns = dict([MESSAGE_HEAD.unpack(head)]) if len(head) == MESSAGE_HEAD.size else {}
        return Chunk(begin=begin - RECORD.size, size=length + RECORD.size, latest_ns=latest_ns)

    def _add_index(self, chunk: Chunk, begin: int, length: int) -> None:
        """Take the time of a channel's last message from the index behind a chunk."""
        entries = self._read(begin + 6, max(0, length - 6))
        times_ns = [time_ns for (time_ns,) in INDEX_ENTRY.iter_unpack(entries[: len(entries) // 16 * 16])]
        self._budget.take_records(len(times_ns))
        if times_ns:
            chunk.latest_ns[int.from_bytes(self._read(begin, 2), "little")] = max(times_ns)

    def _read_summary(self) -> None:
        """Take the channels from the end of the file; there are none if it is cut short or was written without."""
        footer = self._read(self._size - FOOTER_BYTES, FOOTER_BYTES) if self._size > FOOTER_BYTES else b""
        if not footer.endswith(MAGIC) or footer[0] != FOOTER:
            return
        start, end = int.from_bytes(footer[9:17], "little"), self._size - FOOTER_BYTES
        if not 0 < start < end or end - start > MOST_SUMMARY:
            return
        summary = self._read(start, end - start)
        try:
            for _ in self.messages(summary, set()):
                pass
        except DamagedError:
            self.channels.clear()

    def _define(self, kind: int, body: bytes) -> None:
        """Take in a schema or channel; the first one with an id counts, and damaged ones are left out."""
        from mcap.data_stream import ReadDataStream  # noqa: PLC0415  # only bags need it
        from mcap.exceptions import EndOfFile  # noqa: PLC0415

        try:
            self._defined(kind, ReadDataStream(io.BytesIO(body)))
        except (EndOfFile, struct.error, UnicodeDecodeError):
            return

    def _defined(self, kind: int, body: ReadDataStream) -> None:
        from mcap.records import Channel, Schema  # noqa: PLC0415  # only bags need it

        if kind == SCHEMA:
            schema = Schema.read(body)
            self._schemas.setdefault(schema.id, schema.name)
            return
        channel = Channel.read(body)
        found = Topic(
            name=channel.topic,
            type=ros2_name(self._schemas.get(channel.schema_id, "no schema")),
            encoding=ENCODINGS.get(channel.message_encoding, channel.message_encoding),
        )
        self.channels.setdefault(channel.id, found)

    def _read(self, begin: int, size: int) -> bytes:
        self._stream.seek(begin)
        return self._stream.read(size)


def ros2_name(name: str) -> str:
    """The name of a message type as ROS 2 writes it: ROS 1 writes nav_msgs/OccupancyGrid."""
    package, slash, kind = name.partition("/")
    return f"{package}/msg/{kind}" if slash and "/" not in kind else name
