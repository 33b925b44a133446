"""What a recording contains about itself: the run's settings and source as text, and the map's files, packed."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from vdoor.emit import RunInfo
from vdoor.errors import RecordingError
from vdoor.grid import Source

CHECKSUM = "checksum"
"""Entry with the SHA-256 of all others: the file's own checksum comes too late for who reads only the settings."""
LOST = RunInfo(version="unknown", preset="lost", seed=-1, settings={})
"""What is said of a run that was recovered without its settings."""
SCHEMA = "1"
"""Raised when a recording of before can no longer be read; a record's own fields are checked one by one beside it."""


ENDING = ".zst"
LEVEL = 9
"""More packs these maps hardly smaller."""
UNPACKED_TO = 2**28
"""Bytes of all packed files of a recording together, unpacked; what goes beyond that is stored as it is."""


def digest(source: Source) -> str:
    """SHA-256 of a source: of the lines ``digest  name`` of its files, as ``sha256sum FILES | sha256sum`` prints it."""
    lines = "".join(f"{_sha256(data)}  {name}\n" for name, data in source.files)
    return _sha256(lines.encode())


def to_text(info: RunInfo) -> dict[str, str]:
    """All of a run's information but the bytes of its source files, as names and texts."""
    text = {
        "schema": SCHEMA,
        "version": info.version,
        "preset": info.preset,
        "seed": str(info.seed),
        "settings": json.dumps(info.settings, sort_keys=True),
        "source_options": json.dumps(info.source.options, sort_keys=True),
        "source_files": json.dumps([name for name, _ in info.source.files]),
        "source_sha256": json.dumps([_sha256(data) for _, data in info.source.files]),
        "sha256": digest(info.source),
    }
    return text | {CHECKSUM: _checksum(text)}


def from_text(text: Mapping[str, str], attachments: Sequence[Attached]) -> RunInfo:
    """Information on a run from its texts and the source files that were attached to it.

    Raises `RecordingError` where the schema is another, a text is missing, damaged or no such text, or a file is not
    the one that was recorded.
    """
    names, files = source_names(text), files_of(attachments)
    try:
        info = RunInfo(
            version=text["version"],
            preset=text["preset"],
            seed=int(text["seed"]),
            settings=_of(dict, json.loads(text["settings"])),
            source=Source(files=tuple(files), options=_of(dict, json.loads(text["source_options"]))),
        )
        sums = _of(list, json.loads(text["source_sha256"]))
    except KeyError as error:
        raise RecordingError(f"recording metadata: wanted an entry {error}, found {', '.join(text)}") from error
    except (TypeError, ValueError, RecursionError) as error:
        raise RecordingError(f"recording metadata: wanted the texts of a run, found others ({error})") from error
    if [name for name, _ in files] != names or [_sha256(data) for _, data in files] != sums:
        raise RecordingError(
            f"recording attachments: wanted {', '.join(names)} as recorded, found other names or bytes"
        )
    return info


def salvaged(text: Mapping[str, str] | None, attachments: Sequence[Attached]) -> tuple[RunInfo, list[str]]:
    """What is whole of the information on a run, and what is not, one line each.

    Raises `RecordingError` where it is of another schema.
    """
    if text is None or text.get(CHECKSUM) != _checksum(text):
        return LOST, ["preset, settings, seed and source files of the run"]
    names = source_names(text)
    try:
        return from_text(text, attachments), []
    except RecordingError:
        bare = {**text, "source_files": "[]", "source_sha256": "[]"}
        return from_text(bare | {CHECKSUM: _checksum(bare)}, ()), [f"source files: {', '.join(names)}"]


def source_names(text: Mapping[str, str]) -> list[str]:
    """Names of the source files that were stored with a recording, in order.

    Raises `RecordingError` where the texts are damaged or of another schema.
    """
    is_ours = text.get("schema") == SCHEMA
    if (CHECKSUM in text or is_ours) and text.get(CHECKSUM) != _checksum(text):
        raise RecordingError("recording metadata: wanted texts with the recorded checksum, found them damaged")
    if not is_ours:
        found = f"{text.get('schema')} (written by vdoor {text.get('version', 'unknown')})"
        raise RecordingError(
            f"recording schema: wanted {SCHEMA}, found {found}; read it with that version, or record it again"
        )
    try:
        return [str(name) for name in _of(list, json.loads(text["source_files"]))]
    except (KeyError, TypeError, ValueError, RecursionError) as error:
        raise RecordingError(f"recording metadata: wanted a list of source files, found none ({error})") from error


def _of(kind: type, value: Any) -> Any:
    if not isinstance(value, kind):
        raise TypeError(f"{type(value).__name__} for a {kind.__name__}")
    return value


def _checksum(text: Mapping[str, str]) -> str:
    return _sha256(json.dumps({name: text[name] for name in text if name != CHECKSUM}, sort_keys=True).encode())


def _sha256(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()


PACKED, PLAIN = "application/zstd", "application/octet-stream"


class Attached(NamedTuple):
    """One attachment."""

    name: str
    media_type: str
    data: bytes


def attached(files: Iterable[tuple[str, bytes]]) -> Iterator[Attached]:
    """Files by name as they are stored; equal files give equal bytes."""
    import zstandard  # noqa: PLC0415  # only recordings need it

    left = UNPACKED_TO
    for name, data in files:
        if len(data) > left:
            yield Attached(name, PLAIN, data)
            continue
        left -= len(data)
        yield Attached(name + ENDING, PACKED, zstandard.ZstdCompressor(level=LEVEL).compress(data))


def files_of(attachments: Iterable[Attached]) -> list[tuple[str, bytes]]:
    """The files by name; recordings of before hold all of them as they are.

    Raises `RecordingError` where one is damaged, or claims to be larger than those that are stored packed.
    """
    files, left = [], UNPACKED_TO
    for name, media_type, data in attachments:
        if media_type != PACKED:
            files.append((name, data))
            continue
        content = _unpacked(name, data, left)
        left -= len(content)
        files.append((name.removesuffix(ENDING), content))
    return files


def _unpacked(name: str, data: bytes, most: int) -> bytes:
    """Content of one packed file, for which room is made once its size is known to be allowed."""
    import zstandard  # noqa: PLC0415  # only recordings need it

    try:
        size = zstandard.frame_content_size(data)
        if not 0 <= size <= most:
            found = f"one that claims {size}" if size >= 0 else "one that does not say"
            raise RecordingError(f"attachment {name}: wanted at most {most} bytes unpacked, found {found}")
        return zstandard.ZstdDecompressor().decompress(data, allow_extra_data=False)
    except zstandard.ZstdError as error:
        raise RecordingError(f"attachment {name}: wanted bytes packed with zstd, found others ({error})") from error
