"""What a file is, by its first bytes: names say little, as maps are renamed, piped and packed."""

from __future__ import annotations

import re
from typing import NamedTuple

BEGIN = 1 << 12
"""Number of bytes that tell what a file is."""
BYTE_ORDER_MARKS = (b"\xef\xbb\xbf", b"\xff\xfe", b"\xfe\xff")


class Kind(NamedTuple):
    """What bytes are; at most one of the texts is not empty."""

    suffix: str = ""
    """The suffix of a format that is read."""
    packing: str = ""
    """The compression or encoding around something else."""
    other: str = ""
    """What it is if it cannot be read, for messages, with what to do."""


MAPS = (
    (b"P2", ".pgm"), (b"P5", ".pgm"), (b"\x89PNG\r\n\x1a\n", ".png"), (b"II*\0", ".tif"), (b"MM\0*", ".tif"),
    (b"\x93NUMPY", ".npy"), (b"\x89MCAP0\r\n", ".mcap"), (b"SQLite format 3\0", ".db3"), (b"#ROSBAG V2.0\n", ".bag"),
)  # fmt: skip
PACKINGS = (
    (b"\x28\xb5\x2f\xfd", "zstd"), (b"\x1f\x8b", "gzip"), (b"BZh", "bz2"), (b"\xfd7zXZ\0", "xz"),
    (b"\x04\x22\x4d\x18", "lz4"),
)  # fmt: skip
UNPACK_FIRST = "unpack it first"
OTHERS = (
    (b"PK\x03\x04", f"a ZIP archive ({UNPACK_FIRST})"),
    (b"PK\x05\x06", "an empty ZIP archive"),
    (b"7z\xbc\xaf", f"a 7z archive ({UNPACK_FIRST})"),
    (b"Rar!", f"a RAR archive ({UNPACK_FIRST})"),
    (b"#ROSBAG V1", "a bag of the old version 1 (rosbag fix converts it)"),
    (b"RRF", "a Rerun recording (give the .mcap recording or the map)"),
    (b"version https://git-lfs", "a pointer of Git LFS, not the file itself (git lfs pull fetches it)"),
    (b"\xff\xd8\xff", "a JPEG picture, whose greys are not exact (save the map as PNG or PGM)"),
    (b"GIF8", "a GIF picture (save the map as PNG or PGM)"),
    (b"P1", "a PBM picture (save the map as PGM)"),
    (b"P4", "a PBM picture (save the map as PGM)"),
    (b"P3", "a PPM picture (save the map as PGM)"),
    (b"P6", "a PPM picture (save the map as PGM)"),
    (b"%PDF", "a PDF document (save the map as PNG or PGM)"),
    (b"\x7fELF", "a program"),
)
INNER = (
    (257, b"ustar", f"a tar archive ({UNPACK_FIRST})"),
    (8, b"WEBP", "a WebP picture (save the map as PNG or PGM)"),
)
"""Magic numbers that are not at the begin."""
HTML = re.compile(rb"\s*<(!doctype|html|\?xml|svg)", re.IGNORECASE)
YAML = re.compile(rb"^\s*[\"']?(image|resolution|occupied_thresh|free_thresh)[\"']?\s*:", re.MULTILINE)
LEAST_KEYS = 2
"""Keys of a map_server YAML that must be found in a text without a name."""
BMP = re.compile(rb"BM.{4}\0\0\0\0.{4}[\x0c\x28\x34\x38\x40\x6c\x7c]\0\0\0", re.DOTALL)
SPACE = b" \t\r\n\0"


def kind_of(begin: bytes) -> Kind:
    """What a file is by its first bytes, `BEGIN` of them if there are as many; an empty `Kind` if it is unknown."""
    for magic, suffix in MAPS:
        if begin.startswith(magic) and (suffix != ".pgm" or begin[2:3] in b" \t\r\n\v\f#"):
            return Kind(suffix=suffix)
    if BMP.match(begin):
        return Kind(suffix=".bmp")
    for magic, packing in PACKINGS:
        if begin.startswith(magic):
            return Kind(packing=packing)
    for magic, other in OTHERS:
        if begin.startswith(magic):
            return Kind(other=other)
    return _text_or_archive(begin)


def _text_or_archive(begin: bytes) -> Kind:
    """What a file without a magic number is."""
    for at, magic, other in INNER:
        if begin[at:].startswith(magic):
            return Kind(other=other)
    text = _without_mark(begin).lstrip(SPACE)
    if text[:1] in (b"{", b"["):
        return Kind(suffix=".json")
    if HTML.match(text):
        return Kind(other="a web page or XML, not a map (does the address need a login?)")
    if len(set(YAML.findall(text))) >= LEAST_KEYS:
        return Kind(suffix=".yaml")
    # Two bytes are a weak sign, so it is the last one looked for.
    if len(begin) > 2 and begin[0] & 0x0F == 8 and int.from_bytes(begin[:2]) % 31 == 0:  # noqa: PLR2004  # RFC 1950
        return Kind(packing="zlib")
    return Kind()


def _without_mark(text: bytes) -> bytes:
    """The text without a byte order mark."""
    mark = next((mark for mark in BYTE_ORDER_MARKS if text.startswith(mark)), b"")
    return text[len(mark) :]
