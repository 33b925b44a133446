"""What a file is, by its first bytes, so that a file of the wrong kind is named for what it is."""

from __future__ import annotations

from pathlib import Path

LONGEST = 16
BEGINNINGS: tuple[tuple[bytes, str], ...] = (
    (b"RRF", "a Rerun recording"),
    (b"\x89MCAP0\r\n", "an MCAP recording"),
    (b"SQLite format 3", "an SQLite file, such as a .db3 bag"),
    (b"#ROSBAG", "a ROS 1 bag"),
    (b"\x89PNG", "a PNG image"),
    (b"P2", "a PGM image"),
    (b"P5", "a PGM image"),
    (b"BM", "a BMP image"),
    (b"II*\0", "a TIFF image"),
    (b"MM\0*", "a TIFF image"),
    (b"\x93NUMPY", "a NumPy array"),
    (b"\x28\xb5\x2f\xfd", "a file packed with zstd (unzstd unpacks it)"),
    (b"\x1f\x8b", "a file packed with gzip (gunzip unpacks it)"),
    (b"\x04\x22\x4d\x18", "a file packed with lz4 (unlz4 unpacks it)"),
    (b"BZh", "a file packed with bzip2 (bunzip2 unpacks it)"),
    (b"\xfd7zXZ\0", "a file packed with xz (unxz unpacks it)"),
    (b"{", "a JSON file"),
    (b"<", "an HTML or XML file"),
)
"""The first bytes of a file, and what it is then."""


def kind_of(path: Path) -> str:
    """What a file or folder is, with its article; raises `OSError` if it cannot be read."""
    if path.is_dir():
        return "a result folder" if (path / "map.json").is_file() else "a folder"
    with path.open("rb") as stream:
        begin = stream.read(LONGEST)
    if not begin:
        return "an empty file"
    return next((name for start, name in BEGINNINGS if begin.startswith(start)), "another file")
