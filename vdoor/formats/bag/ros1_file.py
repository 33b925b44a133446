"""Bags of ROS 1, whole or cut short (.bag.active)."""

from __future__ import annotations

import struct
from collections.abc import Iterator
from typing import BinaryIO

from vdoor.formats.bag.budget import Budget, DamagedError
from vdoor.formats.bag.chunked import Chunk, Message, Topic
from vdoor.formats.bag.mcap_file import ros2_name
from vdoor.recording.ros import NS_PER_S

MAGIC = b"#ROSBAG V2.0\n"
LENGTH, TIME, INDEX_ENTRY = struct.Struct("<I"), struct.Struct("<II"), struct.Struct("<II4x")
MESSAGE, HEADER, INDEX, CHUNK, CHUNK_INFO, CONNECTION = 2, 3, 4, 5, 6, 7
PACKINGS = {"none": ""}
MOST_HEADER = 1 << 20
Fields = dict[str, bytes]


class Ros1Layout:
    """The records of a ROS 1 bag: each a header of named fields, and data."""

    complete = False

    def __init__(self, stream: BinaryIO, size: int, budget: Budget) -> None:
        self._stream, self._size, self._budget = stream, size, budget
        self.channels: dict[int, Topic] = {}
        self.stopped = ""
        self.complete = self._read_connections()

    def walk(self) -> Iterator[Chunk]:
        """The chunks, each with its index if it has one."""
        chunk: Chunk | None = None
        for fields, begin, size in self._records(len(MAGIC)):
            kind = _number(fields, "op")
            if kind == INDEX and chunk is not None:
                self._add_index(chunk, _number(fields, "conn"), begin, size)
                continue
            if chunk is not None:
                yield chunk
            chunk = _chunk(fields, begin, size) if kind == CHUNK else None
        if chunk is not None:
            yield chunk

    def messages(self, content: bytes, channels: set[int] | None) -> Iterator[Message]:
        """The messages of some connections in a chunk; raises `DamagedError` where its records end too early."""
        at = 0
        while at < len(content):
            self._budget.take_records()
            fields, begin = _fields(content, at)
            at = begin + _length(content, begin - LENGTH.size)
            if at > len(content):
                raise DamagedError("a chunk that ends within a record")
            kind, channel = _number(fields, "op"), _number(fields, "conn")
            if kind == CONNECTION:
                self._define(fields, content[begin:at])
            elif kind == MESSAGE and (channels is None or channel in channels):
                yield Message(channel, _time_ns(fields), content[begin:at] if channels is not None else b"")

    def _records(self, at: int) -> Iterator[tuple[Fields, int, int]]:
        """Header, first byte and size of the data of each record; sets `stopped` where a file is cut short."""
        while at < self._size:
            self._budget.take_records()
            head = self._read(at, LENGTH.size)
            size = LENGTH.unpack(head)[0] if len(head) == LENGTH.size else self._size
            if size > MOST_HEADER or at + size + 2 * LENGTH.size > self._size:
                break
            try:
                fields, begin = _fields(self._read(at, size + 2 * LENGTH.size), 0)
            except DamagedError:
                self.stopped = f"damaged at byte {at}"
                return
            data = _length(self._read(at + size + LENGTH.size, LENGTH.size), 0)
            begin, end = at + begin, at + begin + data
            if end > self._size:
                break
            yield fields, begin, data
            at = end
        if at != self._size or not self.complete:
            self.stopped = f"cut short at byte {self._size}"

    def _read_connections(self) -> bool:
        """Take the connections from the end of the file; whether they are there, as in a bag that was closed."""
        try:
            fields, begin = _fields(self._read(len(MAGIC), MOST_HEADER), 0)
        except DamagedError:
            return False
        start = _number(fields, "index_pos")
        if not begin < start < self._size:
            return False
        for found, at, size in self._records(start):
            if _number(found, "op") == CONNECTION:
                self._define(found, self._read(at, size))
        self.stopped = ""
        return bool(self.channels)

    def _add_index(self, chunk: Chunk, channel: int, begin: int, size: int) -> None:
        """Take the time of a connection's last message from the index behind a chunk."""
        entries = self._read(begin, size)
        entries = entries[: len(entries) // INDEX_ENTRY.size * INDEX_ENTRY.size]
        times_ns = [seconds * NS_PER_S + rest_ns for seconds, rest_ns in INDEX_ENTRY.iter_unpack(entries)]
        self._budget.take_records(len(times_ns))
        if times_ns:
            chunk.latest_ns[channel] = max(times_ns)

    def _define(self, fields: Fields, data: bytes) -> None:
        """Take in a connection; the first one with an id counts, and damaged ones are left out."""
        try:
            about, _ = _fields(LENGTH.pack(len(data)) + data + bytes(LENGTH.size), 0)
        except DamagedError:
            return
        topic = Topic(
            name=_text(fields, "topic"),
            type=ros2_name(_text(about, "type")),
            encoding="ros1",
        )
        self.channels.setdefault(_number(fields, "conn"), topic)

    def _read(self, begin: int, size: int) -> bytes:
        self._stream.seek(begin)
        return self._stream.read(size)


def _chunk(fields: Fields, begin: int, size: int) -> Chunk:
    """The chunk of a record's header."""
    packing = _text(fields, "compression")
    return Chunk(begin=begin, size=size, packing=PACKINGS.get(packing, packing), unpacked=_number(fields, "size"))


def _fields(data: bytes, at: int) -> tuple[Fields, int]:
    """The fields of the header at a byte, and where the data behind it begin; raises `DamagedError` if cut short."""
    begin = at + LENGTH.size
    end = begin + _length(data, at)
    if end + LENGTH.size > len(data):
        raise DamagedError("a header that is cut short")
    fields: Fields = {}
    while begin < end:
        size = _length(data, begin)
        begin += LENGTH.size
        name, equals, value = data[begin : begin + size].partition(b"=")
        if not equals or begin + size > end:
            raise DamagedError("a header without fields")
        fields[name.decode(errors="replace")] = value
        begin += size
    return fields, end + LENGTH.size


def _length(data: bytes, at: int) -> int:
    if at + LENGTH.size > len(data):
        raise DamagedError("a length that is cut short")
    return int(LENGTH.unpack_from(data, at)[0])


def _number(fields: Fields, name: str) -> int:
    """The number in a field; -1 if there is none."""
    return int.from_bytes(fields[name], "little") if name in fields else -1


def _text(fields: Fields, name: str) -> str:
    return fields.get(name, b"").decode(errors="replace")


def _time_ns(fields: Fields) -> int:
    value = fields.get("time", b"")
    if len(value) != TIME.size:
        raise DamagedError("a message without a time")
    seconds, rest_ns = TIME.unpack(value)
    return int(seconds * NS_PER_S + rest_ns)
