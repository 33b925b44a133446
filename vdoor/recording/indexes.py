"""The indexes and statistics of an MCAP file, compared with its data."""

from __future__ import annotations

import zlib
from collections import Counter, defaultdict
from collections.abc import Mapping
from pathlib import Path
from typing import Any, TypeAlias

from vdoor.recording.naming import naming
from vdoor.recording.scan import Budget, scan, unpacked

FOOTER_BYTES_BEFORE_CRC = 25
"""Kind, length and two offsets of the footer, which the checksum of the summary covers too."""
SUMMARY = ("Schema", "Channel", "Statistics", "ChunkIndex", "AttachmentIndex", "MetadataIndex")
Fields: TypeAlias = dict[str, Any]


def index_damage(path: Path) -> list[str]:
    """Errors in the summary, checksums and message indexes of a file, one line each.

    Raises `RecordingError` if the file cannot be read to its end or a checksum of the data is wrong.
    """
    data, summary, footer = _Data(Budget.of(path)), defaultdict[str, list[Fields]](list), list[str]()
    with naming(path):
        for begin, end, record in scan(path, data.budget):
            kind = type(record).__name__
            if kind == "Footer":
                footer = _footer_damage(path, begin, vars(record), data_end=data.end)
            elif data.end:
                summary[kind].append(vars(record))
            else:
                data.add(kind, (begin, end), record)
    wanted = data.summary()
    wrong = [f"summary: wanted {kind} records that fit the data, found others" for kind in SUMMARY
             if summary[kind] != wanted[kind]]  # fmt: skip
    return data.wrong + wrong + footer


class _Data:
    """The data section of a file, and the summary records that match it."""

    def __init__(self, budget: Budget) -> None:
        self.budget = budget
        self.end = 0
        """Byte at which the data section ends; 0 until it is reached."""
        self.wrong: list[str] = []
        self._kept: dict[str, dict[int, Fields]] = {kind: {} for kind in SUMMARY}
        """Summary records by kind, then by id or by the byte that they refer to."""
        self._counts: Counter[int] = Counter()
        self._times_ns: list[int] = []
        self._to_index: dict[int, list[int]] = {}
        """Times of the last chunk's messages that have not been indexed yet, by channel."""

    def add(self, kind: str, span: tuple[int, int], record: Any) -> None:
        """Add one record; `span` is its first byte and end in the file."""
        begin, end = span
        place = {"offset": begin, "length": end - begin}
        if kind == "Chunk":
            self._add_chunk(begin, end, record)
        elif kind == "MessageIndex":
            self._add_message_index(begin, end, record)
        elif kind == "Attachment":
            about = {name: value for name, value in vars(record).items() if name != "data"}
            self._kept["AttachmentIndex"][begin] = place | about | {"data_size": len(record.data)}
        elif kind == "Metadata":
            self._kept["MetadataIndex"][begin] = place | {"name": record.name}
        elif kind == "DataEnd":
            self._check_indexed(begin)
            self._want_checksum(begin, record.data_section_crc)
            self.end = end
        elif kind != "Header":
            self.wrong.append(f"byte {begin}: wanted all {kind} records in chunks, found one outside")

    def summary(self) -> Mapping[str, list[Fields]]:
        """Summary records that match the data, by kind."""
        kept = {kind: list(found.values()) for kind, found in self._kept.items()}
        statistics = {
            "attachment_count": len(kept["AttachmentIndex"]),
            "channel_count": len(kept["Channel"]),
            "channel_message_counts": dict(self._counts),
            "chunk_count": len(kept["ChunkIndex"]),
            "message_count": self._counts.total(),
            "message_end_time": max(self._times_ns, default=0),
            "message_start_time": min(self._times_ns, default=0),
            "metadata_count": len(kept["MetadataIndex"]),
            "schema_count": len(kept["Schema"]),
        }
        return kept | {"Statistics": [statistics]}

    def _add_chunk(self, begin: int, end: int, chunk: Any) -> None:
        self._check_indexed(begin)
        self._want_checksum(begin, chunk.uncompressed_crc)
        for item in unpacked(chunk, self.budget):
            kind, fields = type(item).__name__, vars(item)
            if kind == "Message":
                self._to_index.setdefault(fields["channel_id"], []).append(fields["log_time"])
            else:
                self._kept[kind][fields["id"]] = fields
        times_ns = [time_ns for found in self._to_index.values() for time_ns in found]
        self._times_ns += [min(times_ns, default=0), max(times_ns, default=0)]
        self._counts.update({channel: len(found) for channel, found in self._to_index.items()})
        self._kept["ChunkIndex"][begin] = {
            "chunk_length": end - begin,
            "chunk_start_offset": begin,
            "compression": chunk.compression,
            "compressed_size": len(chunk.data),
            "message_end_time": self._times_ns[-1],
            "message_index_length": 0,
            "message_index_offsets": {},
            "message_start_time": self._times_ns[-2],
            "uncompressed_size": chunk.uncompressed_size,
        }
        if (chunk.message_start_time, chunk.message_end_time) != tuple(self._times_ns[-2:]):
            self.wrong.append(f"byte {begin}: wanted a chunk with the times of its messages, found others")

    def _add_message_index(self, begin: int, end: int, index: Any) -> None:
        times_ns = self._to_index.pop(index.channel_id, None)
        if times_ns is None or [time_ns for time_ns, _ in index.records] != times_ns:
            self.wrong.append(f"byte {begin}: wanted an index of the messages before it, found another")
            return
        chunk = next(reversed(self._kept["ChunkIndex"].values()))
        chunk["message_index_offsets"][index.channel_id] = begin
        chunk["message_index_length"] += end - begin

    def _check_indexed(self, begin: int) -> None:
        if self._to_index:
            self.wrong.append(f"byte {begin}: wanted indexes of all messages before it, found some missing")
        self._to_index = {}

    def _want_checksum(self, begin: int, crc: int) -> None:
        if crc == 0:
            self.wrong.append(f"byte {begin}: wanted a checksum, found none")


def _footer_damage(path: Path, begin: int, footer: Fields, *, data_end: int) -> list[str]:
    """Errors in the footer, which begins at byte `begin`, one line each."""
    wrong = []
    if footer["summary_start"] != data_end or not data_end <= footer["summary_offset_start"] <= begin:
        wrong.append(f"footer: wanted a summary from byte {data_end}, found one from {footer['summary_start']}")
    with path.open("rb") as stream:
        stream.seek(data_end)
        crc = zlib.crc32(stream.read(begin - data_end + FOOTER_BYTES_BEFORE_CRC))
    if crc != footer["summary_crc"]:
        wrong.append("footer: wanted the checksum of the summary, found another")
    return wrong
