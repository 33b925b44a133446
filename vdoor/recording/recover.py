"""A valid recording written from the intact records of a damaged one."""

from __future__ import annotations

from collections import Counter, deque
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from vdoor.errors import RecordingError
from vdoor.files import partial_name
from vdoor.partial import Partial
from vdoor.record import Record
from vdoor.recording import about, codec
from vdoor.recording.about import Attached
from vdoor.recording.check import Emits, lost, wanted
from vdoor.recording.foreign import METADATA, foreign, is_own, refuse_foreign
from vdoor.recording.mcap import McapSink, Topics, decoded, find, step_of
from vdoor.recording.naming import naming
from vdoor.recording.salvage import salvage


@dataclass(frozen=True, kw_only=True)
class Recovery:
    """Result of recovering a recording."""

    records: dict[str, int]
    """Number of recovered records, by topic; if empty, no file was written."""
    damage: tuple[str, ...]
    """Other losses than records, one line each."""
    missing: tuple[str, ...]
    """Stages without a record, and gaps between records."""


def recover(path: Path, out: Path, *, types: Sequence[type[Record]], emits: Emits | None = None) -> Recovery:
    """Write the intact records, of `types`, of the recording at `path` to a new recording `out`.

    Raises `RecordingError` if `path` cannot be read, is of another kind or program, or has another schema, or if `out`
    cannot be written; no file is left behind then.
    """
    with naming(path):
        refuse_foreign(path)
    contents = _Contents(path)
    with naming(path):
        contents.refuse_foreign()
        info, damage = about.salvaged(contents.text, contents.attachments)
    name, steps = partial_name(out), list[tuple[int, str]]()
    if name.exists() and name.samefile(path):
        name = partial_name(name)
    partial = Partial(out, name=name)
    sink: McapSink | None = None
    try:
        for step, record in contents.records({record.topic: record for record in types}):
            sink = sink or McapSink(partial.name, info, partial.stream())
            sink.write(step, record)
            steps.append((step, record.topic))
        if sink is not None:
            sink.close()
            partial.give_name()
    finally:
        partial.remove()
    missing = lost(steps, wanted(info, steps, types=types, emits=emits))
    return Recovery(
        records=dict(Counter(topic for _, topic in steps)),
        damage=(*damage, *contents.damage()),
        missing=tuple(missing),
    )


class _Contents:
    """Intact contents of a damaged file."""

    def __init__(self, path: Path) -> None:
        self.text: Mapping[str, str] | None = None
        self.attachments: list[Attached] = []
        self._path = path
        self._topics = Topics()
        self._bytes_lost = 0
        self._refused: list[str] = []
        for found in salvage(path):
            if isinstance(found, int):
                self._bytes_lost += found
            else:
                for item in found:
                    self._take(item)

    def refuse_foreign(self) -> None:
        """Raise `RecordingError` if all that is left are topics of other programs."""
        topics = self._topics.names
        if topics and self.text is None and not any(map(is_own, topics)):
            raise RecordingError(foreign(topics))

    def damage(self) -> Iterator[str]:
        """Losses other than the run's metadata and source files, one line each."""
        if self._bytes_lost:
            yield f"{self._bytes_lost} bytes that do not form a complete record"
        yield from dict.fromkeys(self._refused)

    def records(self, known: Mapping[str, type[Record]]) -> Iterator[tuple[int, Record]]:
        """Pairs of step and record, for all records whose parts are intact."""
        gathered: dict[str, bytes] = {}
        last, at = -1, (-1, "")
        for topic, name, message in self._messages():
            try:
                kind, part = find(topic, name, known=known)
                here = (step_of(topic, message.log_time), kind.topic)
                if here != at:
                    gathered, at = {}, here
                gathered[part] = message.data
                if here[0] <= last or gathered.keys() != codec.parts(kind).keys():
                    continue
                record = decoded(kind, gathered)
            except RecordingError as error:
                self._refused.append(str(error))
                continue
            last = here[0]
            yield last, record
            del record  # otherwise it stays in memory while the next one is read

    def _take(self, item: Any) -> None:
        """Store everything but messages, which are read in pass 2, when all channels are known."""
        kind = type(item).__name__
        if kind == "Metadata" and item.name == METADATA:
            self.text = self.text or item.metadata
        elif kind == "Attachment":
            self.attachments.append(Attached(item.name, item.media_type, item.data))
        elif kind != "Message":
            deque(self._topics.parts(item), maxlen=0)

    def _messages(self) -> Iterator[tuple[str, str, Any]]:
        for found in salvage(self._path):
            for item in () if isinstance(found, int) else found:
                yield from self._topics.parts(item)
