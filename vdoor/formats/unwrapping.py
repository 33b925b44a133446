"""Maps inside other things: compressed, as base64, in a text chunk of a PNG, one in another."""

from __future__ import annotations

import base64
import binascii
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass

from vdoor.errors import MapError
from vdoor.formats import unpacking
from vdoor.formats.content import BEGIN, Kind, kind_of
from vdoor.formats.unpacking import PackedError

DEEPEST = 4
"""Largest number of wrappings around each other."""
KEYWORD = b"ValetudoMap"
PNG_MAGIC_SIZE, CHUNK_EXTRA = 8, 12
"""Bytes of a PNG's magic number, and of a chunk besides its content."""
BASE64 = re.compile(rb"(?:data:[\w/+.-]*;base64,)?([A-Za-z0-9+/_\s-]{16,}={0,2})\s*", re.ASCII)
MOST_BASE64 = 1 << 26

UNPACK: dict[str, unpacking.Unpack] = {
    "zstd": unpacking.unpack_zstd,
    "gzip": unpacking.unpack_gzip,
    "zlib": unpacking.unpack_zlib,
    "bz2": unpacking.unpack_bz2,
    "xz": unpacking.unpack_xz,
    "lz4": unpacking.unpack_lz4,
}
"""Packing -> the function that removes it."""


@dataclass(frozen=True)
class Content:
    """What was found inside."""

    data: bytes
    kind: Kind
    wrappings: tuple[str, ...] = ()
    """What was around it, the outermost first."""


def unwrapped(data: bytes, limit: int, *, deepest: int = DEEPEST) -> Content:
    """The innermost content of some bytes, which may be their own content.

    Raises MapError if a wrapping is damaged, or its content is larger than `limit`.
    """
    kind = kind_of(data[:BEGIN])
    if deepest == 0:
        return Content(data, kind)
    for wrapping, unwrap in _ways(data, kind):
        try:
            inner = unwrapped(unwrap(data, limit), limit, deepest=deepest - 1)
        except PackedError:
            if kind.packing and kind.packing != "zlib":  # its magic number is too short to be sure
                raise
            continue
        if inner.kind != Kind() or kind.packing not in ("", "zlib"):
            return Content(inner.data, inner.kind, (wrapping, *inner.wrappings))
    return Content(data, Kind() if kind.packing == "zlib" else kind)


def _ways(data: bytes, kind: Kind) -> Iterator[tuple[str, unpacking.Unpack]]:
    """The ways in which the bytes may contain something else."""
    if kind.packing:
        yield kind.packing, UNPACK[kind.packing]
    elif kind.suffix == ".png" and (text := _map_text(data)) is not None:
        yield "PNG", text
    elif kind == Kind() and BASE64.fullmatch(_unquoted(data[:BEGIN])):
        yield "base64", _from_base64
    elif kind == Kind() and data:
        yield "deflate", unpacking.unpack_deflate


def _unquoted(data: bytes) -> bytes:
    return data.strip().strip(b"\"'")


def _from_base64(data: bytes, limit: int) -> bytes:
    """The bytes in base64, of either alphabet; raises `PackedError` if they are none."""
    match = BASE64.fullmatch(_unquoted(data)) if len(data) <= MOST_BASE64 else None
    if match is None:
        raise PackedError("base64: wanted it complete, found other characters")
    text = b"".join(match[1].split()).translate(bytes.maketrans(b"-_", b"+/")).rstrip(b"=")
    try:
        return unpacking.unpack_nothing(base64.b64decode(text + b"=" * (-len(text) % 4)), limit)
    except binascii.Error as error:
        raise PackedError(f"base64: wanted it complete, found it damaged ({error})") from error


def _map_text(data: bytes) -> unpacking.Unpack | None:
    """The function that takes the map from a PNG's text chunk; None if there is no such chunk."""
    for name, content in _png_chunks(data):
        keyword, _, text = content.partition(b"\0")
        if keyword == KEYWORD and name in TEXTS:
            return lambda _, limit: TEXTS[name](text, limit)
    return None


def _png_chunks(data: bytes) -> Iterator[tuple[bytes, bytes]]:
    """Name and content of a PNG's chunks, up to one that is cut short."""
    at = PNG_MAGIC_SIZE
    while at + CHUNK_EXTRA <= len(data):
        size, name = int.from_bytes(data[at : at + 4]), data[at + 4 : at + 8]
        if at + CHUNK_EXTRA + size > len(data):
            return
        yield name, data[at + 8 : at + 8 + size] if name in TEXTS else b""
        at += CHUNK_EXTRA + size


def _international(text: bytes, limit: int) -> bytes:
    """The text of an iTXt chunk, behind a flag, a method, a language and a translated keyword."""
    packed, rest = text[:1], text[2:].split(b"\0", 2)
    if len(rest) < 3:  # noqa: PLR2004
        raise MapError("PNG: wanted a complete iTXt chunk, found it cut short")
    return (unpacking.unpack_zlib if packed == b"\1" else unpacking.unpack_nothing)(rest[2], limit)


TEXTS: dict[bytes, Callable[[bytes, int], bytes]] = {
    b"zTXt": lambda text, limit: unpacking.unpack_zlib(text[1:], limit),
    b"tEXt": unpacking.unpack_nothing,
    b"iTXt": _international,
}
"""Text chunk of a PNG -> the function that gives its text, from what follows the keyword."""
