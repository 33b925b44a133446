"""Bags: the last ``nav_msgs/OccupancyGrid`` of a topic in an .mcap, a ROS 2 .db3, a ROS 1 .bag or a ROS 2 bag's folder.

Of a bag only that message is kept, as the .cdr file that `message` reads: a recording does not swallow gigabytes of
other topics, and reads it again without the bag. Of a recording of vdoor's own the files are kept that it was made of.

Type definitions that a bag brings along are not looked at: the type has long been the same everywhere, and rosbags
would run code that it makes of them.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, NoReturn

from vdoor.errors import MapError, RecordingError
from vdoor.formats import message
from vdoor.formats.bag_files import Bag, open_bag
from vdoor.formats.source import Options, Request, shown
from vdoor.formats.unpacking import unpack_zstd
from vdoor.grid import Source
from vdoor.recording.mcap import read_recording

if TYPE_CHECKING:
    from rosbags.interfaces import Connection

BESIDE_CELLS = 1 << 25
"""Bytes that a chunk of a bag may unpack to beyond a byte for each cell allowed."""
USUAL_TOPIC = "/map"
RECORDED_TOPIC = "/vdoor/input/cells"
"""What tells a recording of vdoor's own."""
ZSTD_BEGIN = b"\x28\xb5\x2f\xfd"
MOST_NAMED = 8

Places = dict[str, list[tuple[Bag, list["Connection"]]]]
"""Where occupancy grids are, by topic."""


def keep(path: Path, options: Options, *, max_cells: int) -> Request:
    """Request to read what is kept of a bag; MapError where it is damaged or has no such topic."""
    limit = max_cells + BESIDE_CELLS
    wanted = options.get("topic")
    with _naming(path), ExitStack() as stack:
        bags = [stack.enter_context(open_bag(file, limit)) for file in _files(path)]
        grids, total = _grids(bags)
        if wanted is None and RECORDED_TOPIC in grids and (source := _recorded(path)).files:
            first = source.files[0][0]
            return Request(
                source=Source(source.files, source.options | options), max_cells=max_cells, paths={first: str(path)}
            )
        topic = _chosen(list(grids), wanted, total=total)
        data = _last(grids[topic], limit)
    name = f"{path.name if path.is_dir() else path.stem}{message.SUFFIX}"
    name = name.encode(errors="surrogateescape").decode(errors="replace")  # recordings hold text
    request = Request(
        source=Source(((name, data),), {**options, "topic": topic}), max_cells=max_cells, paths={name: str(path)}
    )
    if wanted is None and len(grids) > 1:
        request.note(f"topic: {topic} taken of {_listed(grids)} (--topic chooses)", name)
    return request


def read(request: Request) -> NoReturn:
    """Refuse kept bytes that are called a bag: of a bag, other things are kept."""
    raise MapError(f"map: wanted what is kept of a bag, found a bag: {request.path(request.name)}")


def _files(path: Path) -> list[Path]:
    """The file, or the files in a ROS 2 bag's folder."""
    if not path.is_dir():
        return [path]
    if not (path / "metadata.yaml").exists():
        raise MapError("file: wanted a map, found a folder")
    found = sorted(entry for entry in path.iterdir() if entry.suffix.lower() in (".mcap", ".db3"))
    if not found:
        packed = any(entry.suffix.lower() == ".zstd" for entry in path.iterdir())
        raise MapError(f"bag: wanted .mcap or .db3 files, found {'packed ones' if packed else 'none'}")
    return found


def _grids(bags: Sequence[Bag]) -> tuple[Places, int]:
    """Where occupancy grids are, by topic; and the number of all topics."""
    found: Places = defaultdict(list)
    topics = set()
    for bag in bags:
        own = defaultdict(list)
        for connection in bag.connections:
            topics.add(connection.topic)
            if connection.msgtype == message.TYPE:
                own[connection.topic].append(connection)
        for topic, connections in own.items():
            found[topic].append((bag, connections))
    return found, len(topics)


def _chosen(topics: Sequence[str], wanted: float | str | None, *, total: int) -> str:
    """The topic that was asked for, else the only one, else the usual one."""
    if not topics:
        raise MapError(f"topic: wanted one of type {message.TYPE}, found none among {total} topics")
    if wanted in topics:
        return str(wanted)
    if wanted is None and (len(topics) == 1 or USUAL_TOPIC in topics):
        return topics[0] if len(topics) == 1 else USUAL_TOPIC
    found = "several to choose from with --topic" if wanted is None else shown(wanted)
    raise MapError(f"topic: wanted one of {_listed(topics)}, found {found}")


def _listed(topics: Iterable[str]) -> str:
    """Topics as a message names them."""
    names = sorted(map(shown, topics))
    return ", ".join(names[:MOST_NAMED] + ["..."] * (len(names) > MOST_NAMED))


def _last(places: Iterable[tuple[Bag, list[Connection]]], limit: int) -> bytes:
    """The message of the latest time, as CDR."""
    latest = None
    for bag, connections in places:
        for _, time_ns, data in bag.messages(connections):
            if latest is None or time_ns >= latest[0]:
                latest = time_ns, data, bag
    if latest is None:
        raise MapError("topic: wanted a message, found none")
    _, data, bag = latest
    if data.startswith(ZSTD_BEGIN):
        data = unpack_zstd(data, limit)
    return bag.to_cdr(data)


def _recorded(path: Path) -> Source:
    """The files that a recording of vdoor's own was made of; none where it was made of an array.

    Raises `RecordingError` where they cannot be read: the recording is damaged.
    """
    recording = read_recording(path, types=())
    if recording.lost:
        raise RecordingError(f"recording: damaged, its {', '.join(recording.lost)} cannot be read: {path}")
    return recording.info.source


@contextmanager
def _naming(path: Path) -> Iterator[None]:
    """Turn whatever reading a bag raises into a MapError that ends with the path."""
    try:
        yield
    except RecordingError as error:  # has the path
        raise MapError(str(error)) from error
    except MapError as error:
        raise MapError(f"{error}: {path}") from error
    except PermissionError as error:
        raise MapError(f"file: wanted a map, found {error.strerror}: {path}") from error
    except Exception as error:  # damaged bags raise whatever the parsers do
        reason = (str(error) or type(error).__name__).replace(str(path), path.name)
        raise MapError(f"bag: wanted a whole file, found a damaged one ({shown(reason)}): {path}") from error
