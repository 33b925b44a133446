"""Packed bytes, unpacked up to a limit: what a small file unpacks to is not for the file to say."""

from __future__ import annotations

import bz2
from collections.abc import Callable, Iterator
from typing import Any

import lz4.frame
import zstandard

from vdoor.errors import MapError

PIECE = 1 << 24
"""Bytes unpacked at a time."""


def unpack_bz2(data: bytes, limit: int) -> bytes:
    """Bytes packed with bzip2; MapError where they are more than `limit` or cut short."""
    return _gathered(_pieces(bz2.BZ2Decompressor(), data), limit)


def unpack_lz4(data: bytes, limit: int) -> bytes:
    """Bytes packed as an LZ4 frame; MapError where they are more than `limit` or cut short."""
    return _gathered(_pieces(lz4.frame.LZ4FrameDecompressor(), data), limit)


def unpack_zstd(data: bytes, limit: int) -> bytes:
    """Bytes packed with Zstandard; MapError where they are more than `limit`."""
    with zstandard.ZstdDecompressor().stream_reader(data, read_across_frames=True) as stream:
        return _gathered(iter(lambda: stream.read(PIECE), b""), limit)


UNPACK: dict[str, Callable[[bytes, int], bytes]] = {"bz2": unpack_bz2, "lz4": unpack_lz4, "zstd": unpack_zstd}
"""By the names that bags have for them."""


def _pieces(unpacker: Any, data: bytes) -> Iterator[bytes]:
    """What a decompressor gives for `data`, piece by piece."""
    yield unpacker.decompress(data, PIECE)
    while not unpacker.eof:
        if unpacker.needs_input:
            raise MapError("packed bytes: wanted them whole, found them cut short")
        yield unpacker.decompress(b"", PIECE)


def _gathered(pieces: Iterator[bytes], limit: int) -> bytes:
    """All pieces as one."""
    gathered = bytearray()
    for piece in pieces:
        gathered += piece
        if len(gathered) > limit:
            raise MapError(f"packed bytes: wanted at most {limit} when unpacked (--max-cells raises it), found more")
    return bytes(gathered)
