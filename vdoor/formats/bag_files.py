"""The files of bags, opened with rosbags and reduced to what is needed: topics, messages, conversion to CDR."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import AbstractContextManager, closing, contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple
from urllib.parse import quote

from vdoor.formats.message import TYPE
from vdoor.formats.unpacking import UNPACK
from vdoor.recording import ros

if TYPE_CHECKING:
    from rosbags.interfaces import Connection

Messages = Iterable[tuple["Connection", int, bytes]]
"""Messages, each with its connection, time in nanoseconds and data."""


class Bag(NamedTuple):
    """An open file of a bag."""

    connections: Sequence[Connection]
    """The connections: topics and their publishers."""
    messages: Callable[[Sequence[Connection]], Messages]
    """Returns the messages of some connections."""
    to_cdr: Callable[[bytes], bytes] = bytes
    """Converts a message to ROS 2's encoding, CDR."""


def open_bag(path: Path, limit: int) -> AbstractContextManager[Bag]:
    """The open file; chunks may decompress to `limit` bytes at most. A damaged file raises whatever rosbags raises."""
    from rosbags.rosbag1 import reader  # noqa: PLC0415  # only bags need it
    from rosbags.rosbag2 import storage_mcap  # noqa: PLC0415

    # rosbags has no limit for decompressing chunks; it is set by replacing the functions in its tables.
    for name, unpack in UNPACK.items():
        reader.decompressors[name] = storage_mcap.DECOMPRESSORS[name] = _bounded(unpack, limit)
    return OPEN[path.suffix.lower()](path)


@contextmanager
def _ros1(path: Path) -> Iterator[Bag]:
    from rosbags.rosbag1 import Reader  # noqa: PLC0415

    with Reader(path) as reader:
        yield Bag(reader.connections, reader.messages, _from_ros1)


@contextmanager
def _sqlite(path: Path) -> Iterator[Bag]:
    from rosbags.rosbag2.storage_sqlite3 import Sqlite3Reader  # noqa: PLC0415

    reader = Sqlite3Reader(Path(quote(str(path.absolute()))))  # the reader puts the path into a URI
    reader.open()
    with closing(reader):
        yield Bag(reader.connections, reader.messages)


@contextmanager
def _mcap(path: Path) -> Iterator[Bag]:
    from rosbags.rosbag2.storage_mcap import McapReader  # noqa: PLC0415

    reader = McapReader(path)
    reader.open()
    with closing(reader):
        if not reader.connections:  # the summary may not list the topics
            reader.meta_scan()
        # Without a message index rosbags finds no messages, or requires them in order; then the whole file is scanned.
        indexed = any(chunk.channel_count for chunk in reader.chunks)
        yield Bag(reader.connections, reader.messages if indexed else reader.messages_scan)


OPEN: dict[str, Callable[[Path], AbstractContextManager[Bag]]] = {".bag": _ros1, ".db3": _sqlite, ".mcap": _mcap}
"""Suffix of a bag's file -> the function that opens it."""


def _bounded(unpack: Callable[[bytes, int], bytes], limit: int) -> Callable[..., bytes]:
    """`unpack` with its limit set; further arguments are ignored, as the size that rosbags passes may be wrong."""
    return lambda data, *_: unpack(data, limit)


def _from_ros1(data: bytes) -> bytes:
    """A ROS 1 message converted to CDR."""
    return bytes(ros.store().ros1_to_cdr(data, TYPE))
