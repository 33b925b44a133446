"""Bags: the last ``nav_msgs/OccupancyGrid`` of a topic in an .mcap, a ROS 2 .db3, a ROS 1 .bag or a ROS 2 bag's folder.

Only that message of a bag is stored, as the .cdr file that `message` reads. A recording then does not contain gigabytes
of other topics, and can read the map again without the bag. For a recording made by vdoor, the stored files are those
of its input map.

Type definitions contained in a bag are ignored: this type has long been the same everywhere, and rosbags would execute
code generated from them.
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
"""Bytes that a decompressed chunk of a bag may have in addition to one byte per allowed cell."""
USUAL_TOPIC = "/map"
RECORDED_TOPIC = "/vdoor/input/cells"
"""The topic that identifies a recording made by vdoor."""
ZSTD_BEGIN = b"\x28\xb5\x2f\xfd"
MOST_NAMED = 8

Places = dict[str, list[tuple[Bag, list["Connection"]]]]
"""Topic -> the files and connections with its occupancy grids."""


def keep(path: Path, options: Options, *, max_cells: int) -> Request:
    """The request to read the stored part of a bag; raises MapError if it is damaged or has no suitable topic."""
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
    name = name.encode(errors="surrogateescape").decode(errors="replace")  # recordings store names as UTF-8
    request = Request(
        source=Source(((name, data),), {**options, "topic": topic}), max_cells=max_cells, paths={name: str(path)}
    )
    if wanted is None and len(grids) > 1:
        request.note(f"topic: using {topic} of {_listed(grids)} (--topic selects another)", name)
    return request


def read(request: Request) -> NoReturn:
    """Raise MapError for stored bytes that are named like a bag: only a part of a bag is ever stored."""
    raise MapError(f"map: wanted the stored part of a bag, found a bag: {request.path(request.name)}")


def _files(path: Path) -> list[Path]:
    """The file itself, or the files in a ROS 2 bag's folder; raises MapError if there are none."""
    if not path.is_dir():
        return [path]
    if not (path / "metadata.yaml").exists():
        raise MapError("file: wanted a map, found a folder")
    found = sorted(entry for entry in path.iterdir() if entry.suffix.lower() in (".mcap", ".db3"))
    if not found:
        packed = any(entry.suffix.lower() == ".zstd" for entry in path.iterdir())
        raise MapError(f"bag: wanted .mcap or .db3 files, found {'compressed ones' if packed else 'none'}")
    return found


def _grids(bags: Sequence[Bag]) -> tuple[Places, int]:
    """The files and connections with occupancy grids, by topic, and the number of all topics."""
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
    """The requested topic or, if none was requested, the only one or else the usual one."""
    if not topics:
        raise MapError(f"topic: wanted one of type {message.TYPE}, found none among {total} topics")
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


def _last(places: Iterable[tuple[Bag, list[Connection]]], limit: int) -> bytes:
    """The message with the latest time, as CDR."""
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
    """The files of the input map of a recording made by vdoor; none if the map was an array.

    Raises `RecordingError` if they cannot be read because the recording is damaged.
    """
    recording = read_recording(path, types=())
    if recording.lost:
        raise RecordingError(f"recording: damaged, cannot read its {', '.join(recording.lost)}: {path}")
    return recording.info.source


@contextmanager
def _naming(path: Path) -> Iterator[None]:
    """Convert any exception from reading a bag to a MapError that ends with the path."""
    try:
        yield
    except RecordingError as error:  # already contains the path
        raise MapError(str(error)) from error
    except MapError as error:
        raise MapError(f"{error}: {path}") from error
    except PermissionError as error:
        raise MapError(f"file: wanted a map, found {error.strerror}: {path}") from error
    except Exception as error:  # a damaged bag may raise anything
        reason = (str(error) or type(error).__name__).replace(str(path), path.name)
        raise MapError(f"bag: wanted a complete file, found a damaged one ({shown(reason)}): {path}") from error
