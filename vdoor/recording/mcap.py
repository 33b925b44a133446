"""MCAP files: the sink that records a run, and the reader; the only module that imports mcap.

The file holds nothing of the clock or the host, so that equal runs give equal bytes.
"""

from __future__ import annotations

import contextlib
import dataclasses
import io
import os
import stat
import struct
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from vdoor.emit import RunInfo
from vdoor.errors import RecordingError, printable
from vdoor.grid import OccupancyGrid
from vdoor.interrupts import held_signals
from vdoor.record import Record
from vdoor.recording import about, codec, ros, viewers
from vdoor.recording.about import Attached, attached

if TYPE_CHECKING:
    from mcap.records import McapRecord, Message

METADATA = "vdoor"
EPOCH_NS, STEP_NS = 1_577_836_800 * ros.NS_PER_S, 100_000_000
"""Log time of step 0 (the year 2020), and between steps: any fixed times do, viewers play ten steps a second."""
CHUNK_TO = 2**30
"""Bytes of a chunk unpacked, at most: a raster of 16,384 x 16,384 labels."""
SIZE_UNKNOWN = -1
MAGIC_SIZE = 8


def time_ns(step: int) -> int:
    """Log time, publish time and header stamp of a step."""
    return EPOCH_NS + step * STEP_NS


class McapSink:
    """Records a run in an MCAP file (ROS 2 profile, CDR, zstd, all CRCs and indexes).

    What `write` was given is in the file when it returns. The map's files come behind the first record, the map itself,
    which so comes back out of a file cut short in them. Raises `RecordingError` where the file cannot be written.
    """

    def __init__(self, path: Path, info: RunInfo) -> None:
        from mcap.writer import Writer  # noqa: PLC0415  # only recordings need it

        self.path = path
        self._schemas: dict[str, int] = {}
        self._channels: dict[str, int] = {}
        self._cells: NDArray[np.int8] | None = None
        self._files = info.source.files
        """Those of the map that are not in the file yet."""
        with _naming_unwritable(path):
            self._stream = path.open("wb")
        self._writer = Writer(self._stream, enable_data_crcs=True)
        with self._writing():
            self._writer.start(profile="ros2")
            self._writer.add_metadata(METADATA, about.to_text(info))
            self._writer.flush()  # type: ignore[no-untyped-call]

    def write(self, step: int, record: Record) -> None:
        """Write one record and what viewers get beside it; when this returns, it survives a kill."""
        if isinstance(record, OccupancyGrid):
            self._cells = record.cells
        now_ns = time_ns(step)
        messages = [*codec.encode(record, time_ns=now_ns)]
        messages += viewers.for_viewers(record, time_ns=now_ns, cells=self._cells)
        with self._writing():
            for topic, name, data in messages:
                self._writer.add_message(self._channel(topic, name), now_ns, data, now_ns, step)  # type: ignore[arg-type]  # any buffer will do
            self._writer.flush()  # type: ignore[no-untyped-call]
            self._attach_files()

    def close(self) -> None:
        """Write the indexes and close the file; of a file that could not be written there is nothing left to close."""
        if self._stream.closed:
            return
        with held_signals(), self._writing():  # half a footer could not be finished by closing again
            self._attach_files()
            self._writer.finish()  # type: ignore[no-untyped-call]
            self._stream.close()

    def _attach_files(self) -> None:
        """Write the map's files, once."""
        files, self._files = self._files, ()
        for name, media_type, data in attached(files):
            self._writer.add_attachment(EPOCH_NS, EPOCH_NS, name, media_type, data)
        if files:
            self._writer.flush()  # type: ignore[no-untyped-call]

    def _channel(self, topic: str, name: str) -> int:
        """Give the number of the channel of `topic` with messages of type `name`, made at first use."""
        if name not in self._schemas:
            self._schemas[name] = self._writer.register_schema(name, "ros2msg", ros.definition(name))
        if topic not in self._channels:
            self._channels[topic] = self._writer.register_channel(topic, "cdr", self._schemas[name])
        return self._channels[topic]

    @contextlib.contextmanager
    def _writing(self) -> Iterator[None]:
        """Write, and after an error close the file as it is."""
        try:
            with _naming_unwritable(self.path):
                yield
        except RecordingError:
            with contextlib.suppress(OSError):
                self._stream.close()
            raise


@dataclass(frozen=True)
class Recording:
    """A recorded run: what it was, and when iterated over, each step with its record, in order.

    Iterating reads the file as it goes, with at most one record in memory and every checksum compared. Where the file
    is damaged or cut short, the steps that came whole before are given out first, then `RecordingError` is raised.
    """

    path: Path
    info: RunInfo
    types: tuple[type[Record], ...]
    lost: tuple[str, ...] = ()
    """What of the run's own words was cut off, one line each; its records are found when iterating."""

    def __iter__(self) -> Iterator[tuple[int, Record]]:
        """Pairs of step and record; `RecordingError` for parts that are missing, unknown or do not fit the record."""
        with naming(self.path):
            known = {record.topic: record for record in self.types}
            for step, record in _records(self.path, known, version=self.info.version):
                if isinstance(record, OccupancyGrid):
                    yield step, dataclasses.replace(record, source=self.info.source)
                else:
                    yield step, record
                del record  # or it would stay in memory while the next one is read


def read_recording(path: Path, *, types: Sequence[type[Record]]) -> Recording:
    """Run that is recorded in `path`, with records of the given types.

    Raises `RecordingError` where there is none, or one of another schema; damage further on is found when iterating.
    """
    with naming(path):
        info, lost = _info(path)
        return Recording(path, info, tuple(types), tuple(lost))


def _info(path: Path) -> tuple[RunInfo, list[str]]:
    """Information on the run: metadata, and the map's files, which come behind the first record, or before it, as once.

    Of a file that is cut short before these are all there, it is what is known without them, and what was lost.
    """
    from mcap.exceptions import EndOfFile  # noqa: PLC0415  # only recordings need it
    from mcap.records import Attachment, Metadata  # noqa: PLC0415

    text: dict[str, str] | None = None
    names: list[str] = []
    files: list[Attached] = []
    try:
        for _, _, record in scan(path):
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
    raise RecordingError(
        f"recording: wanted metadata named {METADATA}, {'its source files, ' if text else ''}found none"
    )


def _records(path: Path, known: Mapping[str, type[Record]], *, version: str) -> Iterator[tuple[int, Record]]:
    """Pairs of step and record of the file, each given out as soon as its last part is there."""
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
            del record  # or it would stay in memory while the next one is read
    if gathered:
        missing = codec.parts(known[at[1]]).keys() - gathered.keys()
        raise RecordingError(
            f"step {at[0]} ({at[1]}): wanted one message a part, found none or two of {', '.join(sorted(missing))}"
        )


def decoded(kind: type[Record], gathered: dict[str, bytes]) -> Record:
    """Record of the gathered parts, which are let go, or they would stay in memory beside it."""
    record = codec.decode(kind, gathered)
    gathered.clear()
    return record


def find(topic: str, name: str, *, known: Mapping[str, type[Record]]) -> tuple[type[Record], str]:
    """Type of record and the part that a topic belongs to; its messages are of ROS type `name`."""
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
    """Step of a message of that log time; `RecordingError` naming its topic where there is none."""
    step, rest_ns = divmod(log_time_ns - EPOCH_NS, STEP_NS)
    if step < 0 or rest_ns:
        raise RecordingError(f"topic {topic}: wanted the log time of a step, found {log_time_ns} ns")
    return step


def _messages(path: Path) -> Iterator[tuple[str, str, Message]]:
    """Topic, ROS type and message, of all that are parts of records."""
    topics = Topics()
    for _, _, record in scan(path):
        for item in unpacked(record):
            yield from topics.parts(item)


class Topics:
    """Topics and ROS types of messages, by the schemas and channels that were seen before them."""

    def __init__(self) -> None:
        self._names: dict[int, str] = {}
        self._channels: dict[int, tuple[str, int, str]] = {}

    def parts(self, item: McapRecord) -> Iterator[tuple[str, str, Message]]:
        """Topic, type and message, if the item is a part of a record; of schemas and channels the first ones stand."""
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


def unpacked(record: McapRecord) -> list[McapRecord]:
    """Contents of a chunk, once its size is known to be no lie; any other record as it is."""
    import zstandard  # noqa: PLC0415  # only recordings need it
    from mcap.records import Chunk  # noqa: PLC0415
    from mcap.stream_reader import breakup_chunk  # noqa: PLC0415

    if not isinstance(record, Chunk):
        return [record]
    if record.compression not in {"zstd", ""}:
        raise RecordingError(f"recording: wanted chunks packed with zstd or not at all, found {record.compression!r}")
    claims = {record.uncompressed_size}
    if record.compression:
        claims.add(zstandard.frame_content_size(record.data))
    if len(claims - {SIZE_UNKNOWN}) > 1 or max(claims) > CHUNK_TO:
        raise RecordingError(
            f"recording: wanted a chunk of at most {CHUNK_TO} bytes, found one that claims {max(claims)}"
        )
    return breakup_chunk(record, validate_crc=True)


def scan(path: Path) -> Iterator[tuple[int, int, McapRecord]]:
    """Begin, end and content of all records of the file's own level, chunks in one piece, and no byte after them.

    The checksum of the data section is compared.
    """
    from mcap.stream_reader import StreamReader  # noqa: PLC0415  # only recordings need it

    with _Bounded(io.FileIO(path)) as stream:
        begin = MAGIC_SIZE
        for record in StreamReader(stream, emit_chunks=True, validate_crcs=True, record_size_limit=None).records:
            yield begin, stream.tell(), record
            begin = stream.tell()
        if stream.read(1):
            raise RecordingError(f"recording: wanted nothing after byte {begin + MAGIC_SIZE}, found more")


def parse(data: bytes) -> McapRecord | None:
    """The one record, with its header, that `data` holds; None for a kind that is not known."""
    from mcap.stream_reader import StreamReader  # noqa: PLC0415  # only recordings need it

    reader = StreamReader(io.BytesIO(data), skip_magic=True, emit_chunks=True, record_size_limit=len(data))
    return next(reader.records, None)


class _Bounded(io.BufferedReader):
    """A file that makes room for no more bytes than it has left, however long a record claims to be."""

    def read(self, size: int | None = -1, /) -> bytes:
        left = os.fstat(self.fileno()).st_size - self.tell()
        return super().read(left if size is None else min(size, left))


@contextlib.contextmanager
def naming_version(version: str) -> Iterator[None]:
    """Say which version wrote what cannot be made sense of, and what to do."""
    try:
        yield
    except RecordingError as error:
        raise RecordingError(
            f"{error} (written by vdoor {version}); read it with that version, or record it again"
        ) from error


@contextlib.contextmanager
def naming(path: Path) -> Iterator[None]:
    """Turn what reading raises into a `RecordingError` that ends with the path."""
    import zstandard  # noqa: PLC0415  # only recordings need it
    from mcap.exceptions import EndOfFile, InvalidMagic, McapError  # noqa: PLC0415

    try:
        _refuse_pipe(path)
        yield
    except RecordingError as error:
        raise RecordingError(f"{printable(str(error))}: {path}") from error
    except OSError as error:
        raise RecordingError(f"recording: cannot be read ({error.strerror}): {path}") from error
    except (EndOfFile, struct.error) as error:
        raise RecordingError(f"recording: wanted the end of an MCAP file, found it cut short: {path}") from error
    except InvalidMagic as error:
        raise RecordingError(f"recording: wanted an MCAP file, found none: {path}") from error
    except (McapError, zstandard.ZstdError, ValueError, OverflowError, MemoryError) as error:
        raise RecordingError(f"recording: damaged ({printable(str(error))}): {path}") from error


def _refuse_pipe(path: Path) -> None:
    """RecordingError for what is neither file nor folder: to open it may wait for ever."""
    mode = path.stat().st_mode
    if not (stat.S_ISREG(mode) or stat.S_ISDIR(mode)):
        raise RecordingError("recording: wanted a file, found a device or pipe")


@contextlib.contextmanager
def _naming_unwritable(path: Path) -> Iterator[None]:
    """Turn what writing raises into a `RecordingError` that ends with the path."""
    try:
        yield
    except OSError as error:
        raise RecordingError(f"recording: cannot be written ({error.strerror}): {path}") from error
