"""Bags made of chunks, which MCAP and ROS 1 have in common: the latest message of a topic, also of a file cut short.

The file is walked once from chunk to chunk. A chunk is unpacked only if the index behind it names the topic, or if
there is no index, so that of a large bag little more than the chunks with maps are read.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from typing import BinaryIO, NamedTuple, Protocol

from vdoor.formats.bag.budget import Budget, DamagedError
from vdoor.formats.unpacking import PackedError


class Topic(NamedTuple):
    """What the messages of a topic are."""

    name: str
    type: str
    """The type as ROS 2 writes it, such as nav_msgs/msg/OccupancyGrid."""
    encoding: str
    """How messages are encoded: cdr, ros1, or what the bag says."""


class Message(NamedTuple):
    """A message in an unpacked chunk."""

    channel: int
    time_ns: int
    data: bytes


@dataclass(kw_only=True)
class Chunk:
    """A chunk, or a message outside any chunk."""

    begin: int
    """First byte of its packed content in the file."""
    size: int
    packing: str = ""
    unpacked: int | None = None
    """Size and checksum of the content once unpacked; None if the file does not say."""
    crc: int | None = None
    latest_ns: dict[int, int] = field(default_factory=dict)
    """Time of the last message of each channel in it; empty until its index is read or it is unpacked."""


class Layout(Protocol):
    """How a kind of bag lays out its records."""

    channels: dict[int, Topic]
    """The channels known so far."""
    stopped: str
    """Why the walk ended before the end of the data; empty if it did not."""
    complete: bool
    """Whether `channels` was read from the file's summary, so that chunks need not be unpacked to find them."""

    def walk(self) -> Iterator[Chunk]:
        """The chunks in the order of the file, each with its index if it has one."""
        ...

    def messages(self, content: bytes, channels: set[int] | None) -> Iterator[Message]:
        """The messages of some channels, None for all, in an unpacked chunk; takes in the channels defined in it."""
        ...


class ChunkedBag:
    """The topics of one file, and the latest message of each."""

    def __init__(self, stream: BinaryIO, layout: Layout, budget: Budget) -> None:
        self._stream, self._layout, self._budget = stream, layout, budget
        self._problems: list[str] = []
        self._chunks = [chunk for chunk in layout.walk() if self._indexed(chunk)]
        if layout.stopped:
            self._problems.append(layout.stopped)

    @property
    def topics(self) -> list[Topic]:
        """The topics of all channels."""
        return list(self._layout.channels.values())

    @property
    def problems(self) -> list[str]:
        """What of the file could not be read so far."""
        return self._problems

    def latest(self, topic: str) -> tuple[int, bytes, Topic] | None:
        """Time, data and topic of the latest message; None if there is none."""
        ids = {at for at, channel in self._layout.channels.items() if channel.name == topic}
        held = [(max(chunk.latest_ns[at] for at in here), chunk) for chunk in self._chunks
                if (here := ids & chunk.latest_ns.keys())]  # fmt: skip
        for _, chunk in sorted(held, key=lambda one: (one[0], one[1].begin), reverse=True):
            found = self._tried(chunk, ids)
            if found is not None:
                return found.time_ns, found.data, self._layout.channels[found.channel]
        return None

    def _indexed(self, chunk: Chunk) -> bool:
        """Whether a chunk can be read; looks into it if it has no index."""
        if not chunk.latest_ns or not self._layout.complete:
            latest_ns: dict[int, int] = {}
            for message in self._opened(chunk, None):
                latest_ns[message.channel] = max(message.time_ns, latest_ns.get(message.channel, 0))
            chunk.latest_ns = latest_ns
        return True

    def _tried(self, chunk: Chunk, channels: set[int]) -> Message | None:
        """The latest message of some channels in a chunk, of equal times the last; None if there is none."""
        found = None
        for message in self._opened(chunk, channels):
            if found is None or message.time_ns >= found.time_ns:
                found = message
        return found

    def _opened(self, chunk: Chunk, channels: set[int] | None) -> Iterable[Message]:
        """The messages of a chunk up to the first damage, which is put on record."""
        try:
            yield from self._layout.messages(self._content(chunk), channels)
        except (DamagedError, PackedError) as error:
            problem = f"damaged at byte {chunk.begin} ({error})"
            if problem not in self._problems:
                self._problems.append(problem)

    def _content(self, chunk: Chunk) -> bytes:
        """The unpacked content of a chunk; raises `DamagedError` if it does not fit its size or checksum."""
        import zlib  # noqa: PLC0415

        self._stream.seek(chunk.begin)
        content = self._budget.unpack(chunk.packing, self._stream.read(chunk.size))
        if chunk.unpacked not in (None, len(content)):
            raise DamagedError(f"wanted {chunk.unpacked} bytes unpacked, found {len(content)}")
        if chunk.crc and zlib.crc32(content) != chunk.crc:
            raise DamagedError("wrong checksum")
        return content
