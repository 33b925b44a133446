"""Decompression up to a limit, since a small file can decompress to any size."""

from __future__ import annotations

import bz2
from collections.abc import Callable, Iterator
from typing import Any

import lz4.frame
import zstandard

from vdoor.errors import MapError

PIECE = 1 << 24
"""Bytes decompressed at a time."""


def unpack_bz2(data: bytes, limit: int) -> bytes:
    """The content of bzip2 data; raises MapError if it is larger than `limit` or cut short."""
    return _gathered(_pieces(bz2.BZ2Decompressor(), data), limit)


def unpack_lz4(data: bytes, limit: int) -> bytes:
    """The content of an LZ4 frame; raises MapError if it is larger than `limit` or cut short."""
    return _gathered(_pieces(lz4.frame.LZ4FrameDecompressor(), data), limit)


def unpack_zstd(data: bytes, limit: int) -> bytes:
    """The content of Zstandard data; raises MapError if it is larger than `limit`."""
    with zstandard.ZstdDecompressor().stream_reader(data, read_across_frames=True) as stream:
        return _gathered(iter(lambda: stream.read(PIECE), b""), limit)


UNPACK: dict[str, Callable[[bytes, int], bytes]] = {"bz2": unpack_bz2, "lz4": unpack_lz4, "zstd": unpack_zstd}
"""Name of a compression in bags -> the function that decompresses it."""


def _pieces(unpacker: Any, data: bytes) -> Iterator[bytes]:
    """The output of a decompressor for `data`, piece by piece; raises MapError if `data` is cut short."""
    yield unpacker.decompress(data, PIECE)
    while not unpacker.eof:
        if unpacker.needs_input:
            raise MapError("compressed data: wanted it complete, found it cut short")
        yield unpacker.decompress(b"", PIECE)


def _gathered(pieces: Iterator[bytes], limit: int) -> bytes:
    """The pieces joined; raises MapError as soon as they exceed the limit."""
    gathered = bytearray()
    for piece in pieces:
        gathered += piece
        if len(gathered) > limit:
            raise MapError(
                f"compressed data: wanted at most {limit} bytes decompressed (--max-cells raises it), found more"
            )
    return bytes(gathered)
