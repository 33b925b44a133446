"""Bags: the last ``nav_msgs/OccupancyGrid`` of a topic in an .mcap, a ROS 2 .db3, a ROS 1 .bag or a ROS 2 bag's folder.

Only that message of a bag is stored, as the .cdr file that `message` reads. A recording then does not contain gigabytes
of other topics, and can read the map again without the bag. For a recording made by vdoor, the stored files are those
of its input map.

Only the topic that is read matters: others may have any encoding. Type definitions contained in a bag are ignored: this
type has long been the same everywhere, and rosbags would execute code generated from them.
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import BinaryIO, NamedTuple, NoReturn, Protocol

from vdoor.errors import MapError, RecordingError
from vdoor.formats import message
from vdoor.formats.bag import mcap_file, ros1_file, sqlite_file
from vdoor.formats.bag.budget import Budget
from vdoor.formats.bag.chunked import ChunkedBag, Topic
from vdoor.formats.source import Options, Request, shown
from vdoor.grid import Source
from vdoor.recording import ros
from vdoor.recording.mcap import read_recording

BESIDE_CELLS = 1 << 25
"""Bytes that a decompressed chunk of a bag may have in addition to one byte per allowed cell."""
USUAL_TOPIC = "/map"
RECORDED_TOPIC = "/vdoor/input/cells"
"""The topic that identifies a recording made by vdoor."""
ZSTD_BEGIN = b"\x28\xb5\x2f\xfd"
MOST_NAMED = 8
MAGICS = {mcap_file.MAGIC: ".mcap", sqlite_file.MAGIC: ".db3", ros1_file.MAGIC: ".bag"}
"""First bytes -> kind of bag."""


class Part(NamedTuple):
    """A file of a bag."""

    file: BinaryIO
    """Opened for reading."""
    path: Path | None
    """Where it lies, if it does: SQLite keeps its newest changes in a file beside it."""


class Opened(Protocol):
    """An open file of a bag."""

    @property
    def topics(self) -> list[Topic]:
        """All topics."""
        ...

    @property
    def problems(self) -> list[str]:
        """What of the file could not be read so far."""
        ...

    def latest(self, topic: str) -> tuple[int, bytes, Topic] | None:
        """Time, data and topic of the latest message; None if there is none."""
        ...


def keep(parts: Sequence[Part], path: Path, options: Options, *, max_cells: int) -> Request:
    """The request to read the stored part of a bag, whose files are given in order.

    `path` is the bag's, for names and messages. Raises MapError if there is no whole map on a suitable topic.
    """
    budget = Budget(max_cells + BESIDE_CELLS)
    wanted = options.get("topic")
    with _naming(path), ExitStack() as stack:
        bags = [_opened(part, budget, stack) for part in parts]
        topics = _topics(bags)
        if wanted is None and RECORDED_TOPIC in topics and (source := _recorded(parts[0].file, path)).files:
            first = source.files[0][0]
            return Request(
                source=Source(source.files, source.options | options), max_cells=max_cells, paths={first: str(path)}
            )
        topic = _chosen(list(topics), wanted, bags)
        data = _last(bags, topic, budget)
        problems = [problem for bag in bags for problem in bag.problems]
    name = stored_name(path)
    request = Request(
        source=Source(((name, data),), {**options, "topic": topic}), max_cells=max_cells, paths={name: str(path)}
    )
    if wanted is None and len(topics) > 1:
        request.note(f"topic: using {topic} of {_listed(topics)} (--topic selects another)", name)
    for problem in problems:
        request.note(f"bag: {problem}; using the last whole map in the rest", name)
    return request


def stored_name(path: Path) -> str:
    """The name under which the message of a bag is stored."""
    name = f"{path.name if path.is_dir() else path.stem}{message.SUFFIX}"
    return name.encode(errors="surrogateescape").decode(errors="replace")  # recordings store names as UTF-8


def read(request: Request) -> NoReturn:
    """Raise MapError for stored bytes that are named like a bag: only a part of a bag is ever stored."""
    raise MapError(f"map: wanted the stored part of a bag, found a bag: {request.path(request.name)}")


def _opened(part: Part, budget: Budget, stack: ExitStack) -> Opened:
    """The file as the kind of bag that its first bytes name; raises MapError if they name none."""
    file = part.file
    file.seek(0)
    begin = file.read(max(map(len, MAGICS)))
    size = file.seek(0, os.SEEK_END)
    budget.add_file(size)
    kind = next((kind for magic, kind in MAGICS.items() if begin.startswith(magic)), None)
    if kind == ".mcap":
        return ChunkedBag(file, mcap_file.McapLayout(file, size, budget), budget)
    if kind == ".bag":
        return ChunkedBag(file, ros1_file.Ros1Layout(file, size, budget), budget)
    if kind == ".db3":
        log = Path(f"{part.path}-wal")
        stream = stack.enter_context(log.open("rb")) if part.path and log.is_file() else None
        bag = sqlite_file.SqliteBag(file, size, budget, stream)
        stack.callback(bag.close)
        return bag
    raise MapError(f"bag: wanted an MCAP, SQLite or ROS 1 file, found {'other bytes' if begin else 'an empty file'}")


def _topics(bags: Iterable[Opened]) -> list[str]:
    """The names of the topics with occupancy grids."""
    return list(dict.fromkeys(topic.name for bag in bags for topic in bag.topics if topic.type == message.TYPE))


def _chosen(topics: Sequence[str], wanted: float | str | None, bags: Iterable[Opened]) -> str:
    """The requested topic or, if none was requested, the only one or else the usual one."""
    if not topics:
        others = {topic.name: topic.type for bag in bags for topic in bag.topics}
        problems = [problem for bag in bags for problem in bag.problems]
        found = f"none among {len(others)} topics" if others or not problems else f"it {problems[0]}"
        raise MapError(f"topic: wanted one of type {message.TYPE}, found {found}")
    if wanted in topics:
        return str(wanted)
    if wanted is None and (len(topics) == 1 or USUAL_TOPIC in topics):
        return topics[0] if len(topics) == 1 else USUAL_TOPIC
    found = "none selected (--topic selects one)" if wanted is None else shown(wanted)
    raise MapError(f"topic: wanted one of {_listed(topics)}, found {found}")


def _listed(topics: Iterable[str]) -> str:
    """The topics as a list for messages, shortened if there are many."""
    names = sorted(map(shown, topics))
    return ", ".join(names[:MOST_NAMED] + ["..."] * (len(names) > MOST_NAMED))


def _last(bags: Iterable[Opened], topic: str, budget: Budget) -> bytes:
    """The message with the latest time, as CDR; of equal times the last."""
    found = [latest for bag in bags if (latest := bag.latest(topic)) is not None]
    if not found:
        problems = [problem for bag in bags for problem in bag.problems]
        raise MapError(f"topic: wanted a whole message on {topic}, found {f'it {problems[0]}' if problems else 'none'}")
    _, data, about = max(reversed(found), key=lambda one: one[0])
    if about.encoding not in ("cdr", "ros1"):
        raise MapError(f"topic: wanted messages in cdr or ros1 on {topic}, found {shown(about.encoding)}")
    if data.startswith(ZSTD_BEGIN):
        data = budget.unpack("zstd", data)
    return data if about.encoding == "cdr" else _from_ros1(data)


def _from_ros1(data: bytes) -> bytes:
    """A ROS 1 message converted to CDR."""
    try:
        return bytes(ros.store().ros1_to_cdr(data, message.TYPE))
    except Exception as error:  # a damaged message may raise anything
        raise MapError(f"message: wanted a complete {message.TYPE}, found a damaged one ({error})") from error


def _recorded(file: BinaryIO, path: Path) -> Source:
    """The files of the input map of a recording made by vdoor; none if the map was an array.

    Raises `RecordingError` if they cannot be read because the recording is damaged.
    """
    recording = read_recording(Path(f"/proc/self/fd/{file.fileno()}"), types=())
    if recording.lost:
        raise RecordingError(f"recording: damaged, cannot read its {', '.join(recording.lost)}: {path}")
    return recording.info.source


@contextmanager
def _naming(path: Path) -> Iterator[None]:
    """End errors of reading a bag with its path."""
    try:
        yield
    except RecordingError as error:
        text = str(error)
        raise MapError(text if text.endswith(f": {path}") else f"{text.rpartition(': ')[0]}: {path}") from error
    except MapError as error:
        raise MapError(f"{error}: {path}") from error
    except OSError as error:
        raise MapError(f"file: wanted a map, found {error.strerror}: {path}") from error
