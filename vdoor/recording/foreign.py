"""Files that no recorder of ours wrote: told from damaged recordings, so that nobody tries to mend them."""

from __future__ import annotations

import struct
from collections.abc import Iterable
from pathlib import Path

from vdoor.errors import RecordingError
from vdoor.kinds import kind_of
from vdoor.recording import codec, viewers
from vdoor.recording.naming import wanted
from vdoor.recording.scan import MAGIC, Budget, scan, unpacked

METADATA = "vdoor"
"""Name of the metadata that our recordings begin with."""
MOST_NAMED = 3
UNCERTAIN = ("an MCAP recording", "another file", "an empty file")
"""Kinds that a damaged recording may look like."""


def refuse_foreign(path: Path) -> None:
    """Raise `RecordingError` for a file that is surely none of ours: of another kind, or with topics of others."""
    with path.open("rb") as stream:
        begin = stream.read(len(MAGIC))
    if kind_of(path) not in UNCERTAIN and begin[1:] != MAGIC[1:]:
        raise RecordingError(f"recording: {wanted(path)}")
    topics = _topics_of_others(path)
    if topics:
        raise RecordingError(foreign(topics))


def foreign(topics: Iterable[str]) -> str:
    """What to say of an MCAP file with topics of other programs."""
    names = sorted(set(topics))
    more = f" and {len(names) - MOST_NAMED} more" if len(names) > MOST_NAMED else ""
    found = f"one of another program, with {', '.join(names[:MOST_NAMED])}{more}"
    return f"recording: wanted one that `vdoor run --mcap` wrote, found {found} (`vdoor run` reads the map in a bag)"


def is_own(topic: str) -> bool:
    """Whether a recording of ours may have a topic."""
    return topic.startswith(f"{codec.PREFIX}/") or topic in viewers.TOPICS


def _topics_of_others(path: Path) -> set[str]:
    """The topics before the first message that is outside a chunk, or in the first chunk; none if any is ours."""
    from mcap.exceptions import McapError  # noqa: PLC0415  # only recordings need it
    from mcap.records import Channel, Chunk, Message, Metadata  # noqa: PLC0415
    from zstandard import ZstdError  # noqa: PLC0415

    topics: set[str] = set()
    budget = Budget.of(path)
    try:
        for _, _, record in scan(path, budget):
            if isinstance(record, Metadata) and record.name == METADATA:
                return set()
            topics |= {item.topic for item in unpacked(record, budget) if isinstance(item, Channel)}
            if topics and isinstance(record, (Chunk, Message)):
                break
    except (McapError, ZstdError, RecordingError, struct.error, ValueError):
        pass  # damaged, so what was found until then counts
    return set() if any(map(is_own, topics)) else topics
