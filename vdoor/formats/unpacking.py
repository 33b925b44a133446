"""Decompression up to a limit, since a small file can decompress to any size."""

from __future__ import annotations

import bz2
import lzma
import zlib
from collections.abc import Callable, Iterator
from typing import Any

import lz4.frame
import zstandard

from vdoor.errors import MapError

PIECE = 1 << 24
"""Bytes decompressed at a time."""
GZIP, ZLIB, RAW = 31, 15, -15
"""zlib's names for what surrounds deflated data: gzip's header, zlib's, or nothing."""
Unpack = Callable[[bytes, int], bytes]


class PackedError(MapError):
    """Compressed data that is damaged or cut short."""


def unpack_bz2(data: bytes, limit: int) -> bytes:
    """The content of bzip2 data; raises MapError if it is larger than `limit`, `PackedError` if it is damaged."""
    return _gathered(_pieces(bz2.BZ2Decompressor(), data), limit)


def unpack_lz4(data: bytes, limit: int) -> bytes:
    """The content of an LZ4 frame; raises MapError if it is larger than `limit`, `PackedError` if it is damaged."""
    return _gathered(_pieces(lz4.frame.LZ4FrameDecompressor(), data), limit)


def unpack_xz(data: bytes, limit: int) -> bytes:
    """The content of xz data; raises MapError if it is larger than `limit`, `PackedError` if it is damaged."""
    return _gathered(_pieces(lzma.LZMADecompressor(memlimit=1 << 28), data), limit)


def unpack_zstd(data: bytes, limit: int) -> bytes:
    """The content of Zstandard data; raises MapError if it is larger than `limit`, `PackedError` if it is damaged."""
    return _gathered(_unzstd(data), limit)


def unpack_gzip(data: bytes, limit: int) -> bytes:
    """The content of gzip data; raises MapError if it is larger than `limit`, `PackedError` if it is damaged."""
    return _gathered(_inflated(data, GZIP), limit)


def unpack_zlib(data: bytes, limit: int) -> bytes:
    """The content of zlib data; raises MapError if it is larger than `limit`, `PackedError` if it is damaged."""
    return _gathered(_inflated(data, ZLIB), limit)


def unpack_deflate(data: bytes, limit: int) -> bytes:
    """The content of deflated data; raises MapError if it is larger than `limit`, `PackedError` if it is damaged."""
    return _gathered(_inflated(data, RAW), limit)


def unpack_nothing(data: bytes, limit: int) -> bytes:
    """The data itself; raises MapError if it is larger than `limit`."""
    return _gathered(iter([data]), limit)


UNPACK: dict[str, Unpack] = {"": unpack_nothing, "bz2": unpack_bz2, "lz4": unpack_lz4, "zstd": unpack_zstd}
"""Name of a compression in bags -> the function that decompresses it."""


def _unzstd(data: bytes) -> Iterator[bytes]:
    """The content of all frames in `data`, piece by piece; raises `PackedError` if `data` is cut short."""
    least = zstandard.frame_content_size(data)  # -1 if the frame does not say
    with zstandard.ZstdDecompressor().stream_reader(data, read_across_frames=True) as stream:
        while piece := stream.read(PIECE):
            yield piece
            least -= len(piece)
    if least > 0:
        raise PackedError("compressed data: wanted it complete, found it cut short")


def _pieces(unpacker: Any, data: bytes) -> Iterator[bytes]:
    """The output of a decompressor for `data`, piece by piece; raises `PackedError` if `data` is cut short."""
    yield unpacker.decompress(data, PIECE)
    while not unpacker.eof:
        if unpacker.needs_input:
            raise PackedError("compressed data: wanted it complete, found it cut short")
        yield unpacker.decompress(b"", PIECE)


def _inflated(data: bytes, kind: int) -> Iterator[bytes]:
    """The output of zlib for `data`, piece by piece; raises `PackedError` if `data` is cut short."""
    unpacker = zlib.decompressobj(kind)
    yield unpacker.decompress(data, PIECE)
    while not unpacker.eof:
        if not unpacker.unconsumed_tail:
            raise PackedError("compressed data: wanted it complete, found it cut short")
        yield unpacker.decompress(unpacker.unconsumed_tail, PIECE)


def _gathered(pieces: Iterator[bytes], limit: int) -> bytes:
    """The pieces joined; raises MapError as soon as they exceed the limit."""
    gathered = bytearray()
    try:
        for piece in pieces:
            gathered += piece
            if len(gathered) > limit:
                raise MapError(
                    f"compressed data: wanted at most {limit} bytes decompressed (--max-cells raises it), found more"
                )
    except (OSError, EOFError, ValueError, RuntimeError, zlib.error, lzma.LZMAError, zstandard.ZstdError) as error:
        if isinstance(error, MapError):
            raise
        raise PackedError(f"compressed data: wanted it intact, found it damaged ({error})") from error
    return bytes(gathered)
