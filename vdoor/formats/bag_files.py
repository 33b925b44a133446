"""Files of bags, opened with rosbags, of which this makes the three things that are wanted: topics, messages, CDR."""

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
"""Messages with the topic they are from and their times."""


class Bag(NamedTuple):
    """An open file of a bag."""

    connections: Sequence[Connection]
    """Topics, and who wrote to them."""
    messages: Callable[[Sequence[Connection]], Messages]
    """Messages of some of them."""
    to_cdr: Callable[[bytes], bytes] = bytes
    """What turns a message into ROS 2's."""


def open_bag(path: Path, limit: int) -> AbstractContextManager[Bag]:
    """The file, no part of which is unpacked to more than `limit` bytes; damage raises whatever rosbags raises."""
    from rosbags.rosbag1 import reader  # noqa: PLC0415  # only bags need it
    from rosbags.rosbag2 import storage_mcap  # noqa: PLC0415

    # rosbags knows no limit when it unpacks chunks; its tables of decompressors are where it takes one.
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

    reader = Sqlite3Reader(Path(quote(str(path.absolute()))))  # it makes a URI of the path
    reader.open()
    with closing(reader):
        yield Bag(reader.connections, reader.messages)


@contextmanager
def _mcap(path: Path) -> Iterator[Bag]:
    from rosbags.rosbag2.storage_mcap import McapReader  # noqa: PLC0415

    reader = McapReader(path)
    reader.open()
    with closing(reader):
        if not reader.connections:  # a summary need not repeat the topics
            reader.meta_scan()
        # Without an index of messages rosbags finds none, or wants them in order: these are read from end to end.
        indexed = any(chunk.channel_count for chunk in reader.chunks)
        yield Bag(reader.connections, reader.messages if indexed else reader.messages_scan)


OPEN: dict[str, Callable[[Path], AbstractContextManager[Bag]]] = {".bag": _ros1, ".db3": _sqlite, ".mcap": _mcap}
"""By the suffix of the file."""


def _bounded(unpack: Callable[[bytes, int], bytes], limit: int) -> Callable[..., bytes]:
    """`unpack` with its limit set; some of rosbags' readers say a size after the data, which need not be true."""
    return lambda data, *_: unpack(data, limit)


def _from_ros1(data: bytes) -> bytes:
    """A message of ROS 1 as one of ROS 2."""
    return bytes(ros.store().ros1_to_cdr(data, TYPE))
