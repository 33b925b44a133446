"""Recordings written message by message, and where the chunks of one lie."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import mcap.writer
from small_recording import small_run

from vdoor.grid import Source
from vdoor.record import Record
from vdoor.recording import about, codec
from vdoor.recording.mcap import step_of, time_ns
from vdoor.recording.scan import Budget, scan, unpacked

Message = tuple[str, str, bytes]


def messages_of(records: Sequence[Record]) -> list[tuple[int, Message]]:
    return [
        (step, (topic, name, bytes(data)))
        for step, record in enumerate(records)
        for topic, name, data in codec.encode(record, time_ns=time_ns(step))
    ]


def by_hand(
    path: Path,
    messages: Sequence[tuple[int, Message]],
    *,
    texts: dict[str, str] | None = None,
    source: Source | None = None,
) -> Path:
    """Give a recording of messages as they are, with the small run's metadata."""
    info = small_run()[0]
    with path.open("wb") as stream:
        writer = mcap.writer.Writer(stream, enable_data_crcs=True)
        writer.start("ros2")
        writer.add_metadata("vdoor", texts or about.to_text(info))
        for name, data in (source or info.source).files:
            writer.add_attachment(0, 0, name, "", data)
        channels: dict[str, int] = {}
        for step, (topic, name, data) in messages:
            if topic not in channels:
                schema = writer.register_schema(name, "ros2msg", b"")
                channels[topic] = writer.register_channel(topic, "cdr", schema)
            writer.add_message(channels[topic], time_ns(step), data, time_ns(step))
            writer.flush()  # type: ignore[no-untyped-call]
        writer.finish()  # type: ignore[no-untyped-call]
    return path


def spans(path: Path) -> list[tuple[int, int, set[int]]]:
    """Give where the chunks of a file begin and end, and the steps in them."""
    found = []
    budget = Budget.of(path)
    for begin, end, record in scan(path, budget):
        items = unpacked(record, budget)
        if type(record).__name__ == "Chunk":
            times = [item.log_time for item in items if type(item).__name__ == "Message"]  # type: ignore[attr-defined]
            found.append((begin, end, {step_of("", time_ns) for time_ns in times}))
    return found
