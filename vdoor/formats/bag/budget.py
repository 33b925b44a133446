"""How much work a bag may cause: a small file can hold any number of empty messages, and unpack to any size."""

from __future__ import annotations

from dataclasses import dataclass

from vdoor.errors import MapError
from vdoor.formats.unpacking import UNPACK

RECORDS, RECORDS_PER_BYTE = 1_000_000, 0.125
"""Records that any bag may have, and more by the bytes of its file; a message of a real bag takes at least 31 bytes."""
UNPACKED_PER_BYTE = 20
"""Bytes that a bag may unpack to in total by the bytes of its file, beside four times the limit of one chunk."""


class DamagedError(MapError):
    """A part of a bag that cannot be read; whole messages elsewhere in it may be."""


@dataclass
class Budget:
    """What is left of the work that one bag may cause."""

    most_bytes: int
    """Largest size of a chunk or message once unpacked."""
    records: float = RECORDS
    unpacked: float = 0

    def add_file(self, size: int) -> None:
        """Allow the work for a further file of `size` bytes."""
        self.records += size * RECORDS_PER_BYTE
        self.unpacked += 4 * self.most_bytes + size * UNPACKED_PER_BYTE

    def take_records(self, count: int = 1) -> None:
        """Use up some records; raises MapError once none are left."""
        self.records -= count
        if self.records < 0:
            raise MapError("bag: wanted a number of records that fits the file's size, found far more")

    def unpack(self, packing: str, data: bytes) -> bytes:
        """The content of a chunk or message; raises `DamagedError` if it is damaged, MapError if it is too large."""
        if packing not in UNPACK:
            raise MapError(f"bag: wanted chunks packed with {', '.join(UNPACK)}, found {packing!r}")
        content = UNPACK[packing](data, self.most_bytes)
        self.unpacked -= len(content)
        if self.unpacked < 0:
            raise MapError("bag: wanted a total size that fits the file's size, found far more once unpacked")
        return content
