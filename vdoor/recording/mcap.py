"""MCAP files: the sink that records a run, and the reader; the only module that imports mcap.

The file contains nothing that depends on the clock or the host, so equal runs give equal bytes.
"""

from __future__ import annotations

import contextlib
import dataclasses
import struct
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, BinaryIO

import numpy as np
from numpy.typing import NDArray

from vdoor.emit import RunInfo
from vdoor.errors import RecordingError
from vdoor.grid import OccupancyGrid
from vdoor.interrupts import held_signals
from vdoor.record import Record
from vdoor.recording import about, codec, ros, viewers
from vdoor.recording.about import Attached, attached
from vdoor.recording.foreign import METADATA, refuse_foreign
from vdoor.recording.naming import naming, naming_version
from vdoor.recording.scan import CHUNK_BESIDE, CHUNK_TO, Budget, scan, unpacked

if TYPE_CHECKING:
    from mcap.records import McapRecord, Message

EPOCH_NS, STEP_NS = 1_577_836_800 * ros.NS_PER_S, 100_000_000
"""Log time of step 0 (1 January 2020) and time between steps: arbitrary but fixed; viewers play ten steps a second."""


def time_ns(step: int) -> int:
    """Log time, publish time and header stamp of a step."""
    return EPOCH_NS + step * STEP_NS


class McapSink:
    """Records a run in an MCAP file (ROS 2 profile, CDR, zstd, all CRCs and indexes).

    A record is in the file when `write` returns. The map's files are written after the first record, the map itself,
    so that the map can be read from a file that is cut short in them. Raises `RecordingError` if the file cannot be
    written.
    """

    def __init__(self, path: Path, info: RunInfo, stream: BinaryIO | None = None) -> None:
        """Record in `stream`, a new file at `path` without it; the stream is closed with the sink."""
        from mcap.writer import Writer  # noqa: PLC0415  # only recordings need it

        self.path = path
        self._schemas: dict[str, int] = {}
        self._channels: dict[str, int] = {}
        self._cells: NDArray[np.int8] | None = None
        self._files = info.source.files
        """Files of the map that have not been written yet."""
        with _naming_unwritable(path):
            self._stream = stream or path.open("wb")
        self._writer = Writer(self._stream, enable_data_crcs=True)
        with self._writing():
            self._writer.start(profile="ros2")
            self._writer.add_metadata(METADATA, about.to_text(info))
            self._writer.flush()  # type: ignore[no-untyped-call]

    def write(self, step: int, record: Record) -> None:
        """Write one record and its viewer messages; once this returns, they survive a kill."""
        if isinstance(record, OccupancyGrid):
            self._cells = record.cells
        now_ns = time_ns(step)
        messages = [*codec.encode(record, time_ns=now_ns)]
        messages += viewers.for_viewers(record, time_ns=now_ns, cells=self._cells)
        self._refuse_large(record, max(len(data) for _, _, data in messages))
        with self._writing():
            for topic, name, data in messages:
                self._writer.add_message(self._channel(topic, name), now_ns, data, now_ns, step)  # type: ignore[arg-type]  # any buffer works
            self._writer.flush()  # type: ignore[no-untyped-call]
            self._attach_files()

    def close(self) -> None:
        """Write the indexes and close the file; does nothing if a write failed, as the file is closed then."""
        if self._stream.closed:
            return
        with held_signals(), self._writing():  # closing again could not complete half a footer
            self._attach_files()
            self._writer.finish()  # type: ignore[no-untyped-call]
            self._stream.close()

    def _refuse_large(self, record: Record, size: int) -> None:
        """Raise `RecordingError` for a message that could not be read again; the largest map is far below that."""
        if size > CHUNK_TO - CHUNK_BESIDE:
            raise RecordingError(
                f"recording: wanted at most {CHUNK_TO} bytes for {record.topic}, found {size}; "
                f"a map as large as this can be run without --mcap: {self.path}"
            )

    def _attach_files(self) -> None:
        """Write the map's files, once."""
        files, self._files = self._files, ()
        for name, media_type, data in attached(files):
            self._writer.add_attachment(EPOCH_NS, EPOCH_NS, name, media_type, data)
        if files:
            self._writer.flush()  # type: ignore[no-untyped-call]

    def _channel(self, topic: str, name: str) -> int:
        """Return the number of the channel of `topic` with messages of type `name`, registered at first use."""
        if name not in self._schemas:
            self._schemas[name] = self._writer.register_schema(name, "ros2msg", ros.definition(name))
        if topic not in self._channels:
            self._channels[topic] = self._writer.register_channel(topic, "cdr", self._schemas[name])
        return self._channels[topic]

    @contextlib.contextmanager
    def _writing(self) -> Iterator[None]:
        """Write; after an error, close the file as it is."""
        try:
            with _naming_unwritable(self.path):
                yield
        except RecordingError:
            with contextlib.suppress(OSError):
                self._stream.close()
            raise


@dataclass(frozen=True)
class Recording:
    """A recorded run: its information, and by iteration, each step with its record, in order.

    Iteration reads the file with at most one record in memory and checks every checksum. If the file is damaged or cut
    short, the complete steps before the damage are yielded first, then `RecordingError` is raised.
    """

    path: Path
    info: RunInfo
    types: tuple[type[Record], ...]
    lost: tuple[str, ...] = ()
    """Losses of the run's metadata and source files, one line each; lost records are found during iteration."""

    def __iter__(self) -> Iterator[tuple[int, Record]]:
        """Pairs of step and record; `RecordingError` for parts that are missing, unknown or do not fit their record."""
        with naming(self.path):
            known = {record.topic: record for record in self.types}
            for step, record in _records(self.path, known, version=self.info.version):
                if isinstance(record, OccupancyGrid):
                    yield step, dataclasses.replace(record, source=self.info.source)
                else:
                    yield step, record
                del record  # otherwise it stays in memory while the next one is read


def read_recording(path: Path, *, types: Sequence[type[Record]]) -> Recording:
    """Run that is recorded in `path`, with records of the given types.

    Raises `RecordingError` if there is none or its schema is another; later damage is found during iteration.
    """
    with naming(path):
        info, lost = _info(path)
        return Recording(path, info, tuple(types), tuple(lost))


def _info(path: Path) -> tuple[RunInfo, list[str]]:
    """Run information from the metadata and the map's files, and a list of what was lost.

    The map's files follow the first record; older versions wrote them before it. If the file is cut short before the
    last of them, the information is what is known without them.
    """
    from mcap.exceptions import EndOfFile  # noqa: PLC0415  # only recordings need it
    from mcap.records import Attachment, Metadata  # noqa: PLC0415

    text: dict[str, str] | None = None
    names: list[str] = []
    files: list[Attached] = []
    try:
        for _, _, record in scan(path, Budget.of(path)):
            if isinstance(record, Metadata) and record.name == METADATA:
                text, names = record.metadata, about.source_names(record.metadata)
            elif isinstance(record, Attachment):
                files.append(Attached(record.name, record.media_type, record.data))
            if text is not None and len(files) >= len(names):
                return about.from_text(text, files), []
    except (EndOfFile, struct.error, UnicodeDecodeError):
        if text is None:
            raise
        return about.salvaged(text, files)
    refuse_foreign(path)
    raise RecordingError(
        f"recording: wanted metadata named {METADATA}, {'its source files, ' if text else ''}found none"
    )


def _records(path: Path, known: Mapping[str, type[Record]], *, version: str) -> Iterator[tuple[int, Record]]:
    """Pairs of step and record of the file, each yielded as soon as its last part has been read."""
    gathered: dict[str, bytes] = {}
    at = (-1, "")
    for topic, name, message in _messages(path):
        with naming_version(version):
            kind, part = find(topic, name, known=known)
        here = (step_of(topic, message.log_time), kind.topic)
        if (gathered and here != at) or part in gathered:
            break
        if not gathered and here[0] <= at[0]:
            raise RecordingError(f"{topic}: wanted a step after {at[0]}, found {here[0]}")
        at = here
        gathered[part] = message.data
        if gathered.keys() == codec.parts(kind).keys():
            with naming_version(version):
                record = decoded(kind, gathered)
            yield at[0], record
            del record  # otherwise it stays in memory while the next one is read
    if gathered:
        missing = codec.parts(known[at[1]]).keys() - gathered.keys()
        raise RecordingError(
            f"step {at[0]} ({at[1]}): wanted one message per part, found none or two of {', '.join(sorted(missing))}"
        )


def decoded(kind: type[Record], gathered: dict[str, bytes]) -> Record:
    """Record from the gathered parts, which are cleared so that they do not stay in memory beside it."""
    record = codec.decode(kind, gathered)
    gathered.clear()
    return record


def find(topic: str, name: str, *, known: Mapping[str, type[Record]]) -> tuple[type[Record], str]:
    """Record type and part name that a topic belongs to; `RecordingError` unless its ROS type is `name`."""
    prefix, _, part = topic.rpartition("/")
    kind = known.get(prefix.removeprefix(f"{codec.PREFIX}/"))
    if kind is None or part not in codec.parts(kind) or topic != f"{codec.PREFIX}/{kind.topic}/{part}":
        wanted = ", ".join(
            f"{codec.PREFIX}/{t}/({'|'.join(codec.parts(known[t]))})" for t in ([kind.topic] if kind else known)
        )
        raise RecordingError(f"topic {topic}: unknown, wanted {wanted}")
    if codec.parts(kind)[part].message != name:
        raise RecordingError(f"topic {topic}: wanted {codec.parts(kind)[part].message} in cdr, found {name}")
    return kind, part


def step_of(topic: str, log_time_ns: int) -> int:
    """Step that a log time stands for; `RecordingError` with the topic if it is not the time of a step."""
    step, rest_ns = divmod(log_time_ns - EPOCH_NS, STEP_NS)
    if step < 0 or rest_ns:
        raise RecordingError(f"topic {topic}: wanted the log time of a step, found {log_time_ns} ns")
    return step


def _messages(path: Path) -> Iterator[tuple[str, str, Message]]:
    """Topic, ROS type and message, for all messages that are parts of records."""
    topics = Topics()
    budget = Budget.of(path)
    for _, _, record in scan(path, budget):
        for item in unpacked(record, budget):
            yield from topics.parts(item)


class Topics:
    """Topics and ROS types of messages, from the schemas and channels read before them."""

    def __init__(self) -> None:
        self._names: dict[int, str] = {}
        self._channels: dict[int, tuple[str, int, str]] = {}

    @property
    def names(self) -> set[str]:
        """The topics so far."""
        return {topic for topic, _, _ in self._channels.values()}

    def parts(self, item: McapRecord) -> Iterator[tuple[str, str, Message]]:
        """Topic, type and message, if the item is a part of a record.

        Schemas and channels are stored; the first one with an id counts.
        """
        from mcap.records import Channel, Message, Schema  # noqa: PLC0415  # only recordings need it

        if isinstance(item, Schema):
            self._names.setdefault(
                item.id, item.name if item.encoding == "ros2msg" else f"{item.name} ({item.encoding})"
            )
        elif isinstance(item, Channel):
            encoding = "" if item.message_encoding == "cdr" else f" ({item.message_encoding})"
            self._channels.setdefault(item.id, (item.topic, item.schema_id, encoding))
        elif isinstance(item, Message):
            unknown = f"of unknown channel {item.channel_id}"
            topic, schema, encoding = self._channels.get(item.channel_id, (unknown, 0, ""))
            if topic not in viewers.TOPICS:
                yield topic, self._names.get(schema, "no schema") + encoding, item


@contextlib.contextmanager
def _naming_unwritable(path: Path) -> Iterator[None]:
    """Turn errors of writing into a `RecordingError` that ends with the path."""
    try:
        yield
    except OSError as error:
        raise RecordingError(f"recording: cannot be written ({error.strerror}): {path}") from error
