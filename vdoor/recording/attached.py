"""A map's files as attachments of a recording: packed, and unpacked up to a limit."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import NamedTuple

from vdoor.errors import RecordingError

PACKED, PLAIN = "application/zstd", "application/octet-stream"
ENDING = ".zst"
LEVEL = 9
"""More packs these maps hardly smaller."""
UNPACKED_TO = 2**28
"""Bytes of all packed files of a recording together, unpacked; what goes beyond that is stored as it is."""


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
