"""The pages of an SQLite file as they are with its write-ahead log, read without touching either.

A recorder that was killed leaves its newest messages in the log, `NAME-wal`. SQLite itself would write an index beside
the files, or move the log into the database, so the log is laid over the database here, and SQLite reads through that.
"""

from __future__ import annotations

import itertools
import struct
from typing import Any, BinaryIO

import apsw

HEADER, FRAME = struct.Struct(">IIIIIIII"), struct.Struct(">IIIIII")
"""Log: magic, version, page size, checkpoint, two salts, two sums. Page: number, pages after commit, salts, sums."""
LOG_MAGIC = 0x377F0682
"""The last bit says which byte order the sums take."""
PAGE_BYTES_AT, PAGES_AT = 16, 28
"""Where a database's header has the size of a page and the number of pages."""
FORMAT_AT = 18
"""Bytes 18 and 19 of a database say that it has a log; 1 says that it has none."""
COUNT = itertools.count()


class Pages:
    """A database's bytes with the committed pages of its log in their place."""

    def __init__(self, base: BinaryIO, size: int, log: BinaryIO | None) -> None:
        self._base, self._log = base, log
        base.seek(0)
        head = base.read(PAGES_AT + 4)
        self._page_bytes = int.from_bytes(head[PAGE_BYTES_AT : PAGE_BYTES_AT + 2], "big")
        self._found = size
        self.size = max(size, int.from_bytes(head[PAGES_AT:], "big") * self._page_bytes)
        """Bytes of the database by its own account; more than there are if it is cut short."""
        self._at: dict[int, int] = {}
        """Page -> first byte in the log of its newest committed state."""
        if log is not None:
            self._read_log(log)

    @property
    def cut(self) -> bool:
        """Whether the file ends before the database does."""
        return self._found < self.size and not self._at

    def read(self, count: int, begin: int) -> bytes:
        """`count` bytes from byte `begin`; raises apsw's IOError where the file is cut short."""
        if not self._at:
            if begin + count > self._found:
                raise apsw.IOError(f"the file ends at byte {self._found}")
            self._base.seek(begin)
            return self._base.read(count)
        data = bytearray()
        count = min(count, self.size - begin)
        while len(data) < count:
            page, inside = divmod(begin + len(data), self._page_bytes)
            data += self._page(page + 1)[inside : inside + count - len(data)]
        return bytes(data)

    def _page(self, number: int) -> bytes:
        at = self._at.get(number)
        stream = self._base if at is None or self._log is None else self._log
        stream.seek((number - 1) * self._page_bytes if at is None else at)
        page = stream.read(self._page_bytes).ljust(self._page_bytes, b"\0")
        return page[:FORMAT_AT] + b"\1\1" + page[FORMAT_AT + 2 :] if number == 1 else page

    def _read_log(self, log: BinaryIO) -> None:
        """Find the committed pages: frames with the log's salts and right sums, up to the last commit."""
        head = log.read(HEADER.size)
        if len(head) < HEADER.size:
            return
        magic, _, page_bytes, _, *salts = HEADER.unpack(head)[:6]
        order = ">" if magic & 1 else "<"
        sums = _sums(head[:24], (0, 0), order)
        if magic | 1 != LOG_MAGIC | 1 or sums != HEADER.unpack(head)[6:] or not 512 <= page_bytes <= 1 << 16:  # noqa: PLR2004  # SQLite's own limits
            return
        self._page_bytes = page_bytes
        pending: dict[int, int] = {}
        while len(frame := log.read(FRAME.size)) == FRAME.size:
            number, pages, *found, _, _ = FRAME.unpack(frame)
            at, page = log.tell(), log.read(page_bytes)
            sums = _sums(page, _sums(frame[:8], sums, order), order)
            if found != salts or sums != FRAME.unpack(frame)[4:] or len(page) < page_bytes:
                return
            pending[number] = at
            if pages:
                self._at |= pending
                self.size, pending = pages * page_bytes, {}


def _sums(data: bytes, sums: tuple[int, int], order: str) -> tuple[int, int]:
    """The running sums of a log over some bytes, a multiple of eight."""
    one, two = sums
    for first, second in struct.iter_unpack(f"{order}II", data[: len(data) // 8 * 8]):
        one = (one + first + two) & 0xFFFFFFFF
        two = (two + second + one) & 0xFFFFFFFF
    return one, two


class _File(apsw.VFSFile):
    """The pages, as SQLite reads a file."""

    def __init__(self, pages: Pages) -> None:
        self._pages = pages

    def xRead(self, amount: int, offset: int) -> bytes:  # noqa: N802  # SQLite's names
        return self._pages.read(amount, offset)

    def xFileSize(self) -> int:  # noqa: N802
        return self._pages.size

    def xDeviceCharacteristics(self) -> int:  # noqa: N802
        return 0

    def xSectorSize(self) -> int:  # noqa: N802
        return 0

    def xFileControl(self, op: int, ptr: int) -> bool:  # noqa: N802
        del op, ptr
        return False

    def xClose(self) -> None:  # noqa: N802
        pass


class _Files(apsw.VFS):
    """One file, and no others."""

    def __init__(self, name: str, pages: Pages) -> None:
        self._pages = pages
        super().__init__(name, "")

    def xOpen(self, name: Any, flags: list[int]) -> apsw.VFSFile:  # noqa: N802
        return super().xOpen(name, flags) if name is None else _File(self._pages)


def connect(pages: Pages) -> tuple[apsw.Connection, object]:
    """A connection that reads the pages, and what must live as long as it."""
    name = f"vdoor{next(COUNT)}"
    files = _Files(name, pages)
    flags = apsw.SQLITE_OPEN_READONLY | apsw.SQLITE_OPEN_URI
    return apsw.Connection("file:bag?immutable=1", flags=flags, vfs=name), files
