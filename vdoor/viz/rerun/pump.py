"""What Rerun writes, through a pipe into a file: its own writer waits for ever once a disk is full."""

from __future__ import annotations

import array
import contextlib
import fcntl
import os
import select
import termios
import threading
from collections.abc import Callable
from typing import BinaryIO

PIECE = 1 << 20
END_S = 10.0
"""Time limit for the last bytes to arrive once Rerun has let go of the pipe."""


class Pump:
    """A pipe, at `address` in the file system, whose bytes are written to a file by a thread.

    After the first error the bytes are thrown away, so that Rerun's writer never waits; `flush` raises the error.
    """

    def __init__(self, file: BinaryIO) -> None:
        self._file = file
        self._error: OSError | None = None
        self._read, self._write = os.pipe()
        os.set_blocking(self._read, False)
        self._lock = threading.Lock()
        self._ended = False
        self._thread = threading.Thread(target=self._run, name="vdoor-rrd", daemon=True)
        self._thread.start()
        self.address = f"/proc/self/fd/{self._write}"

    def flush(self) -> None:
        """Write all that has arrived; raises OSError if anything could not be written."""
        waiting = array.array("i", [1])
        while waiting[0] and not self._ended:
            self._move()
            fcntl.ioctl(self._read, termios.FIONREAD, waiting)
        self._keep(self._file.flush)
        if self._error is not None:
            raise self._error

    def close(self) -> None:
        """Write what is left and close the file; raises OSError if anything could not be written.

        Rerun must have let go of the pipe before; its writer gets `END_S` to do so.
        """
        os.close(self._write)
        self._thread.join(END_S)
        if self._thread.is_alive():
            self._error = self._error or TimeoutError(0, "the end did not arrive in time")
        else:
            os.close(self._read)
        self._keep(self._file.close)
        with contextlib.suppress(OSError):  # what could not be written cannot be written now either
            self._file.close()
        if self._error is not None:
            raise self._error

    def _run(self) -> None:
        while not self._ended:
            select.select([self._read], [], [])
            self._move()

    def _move(self) -> None:
        """Write one piece, if one has arrived."""
        with self._lock:
            try:
                data = os.read(self._read, PIECE)
            except BlockingIOError:
                return
            self._ended = not data
            self._keep(lambda: self._file.write(data))

    def _keep(self, write: Callable[[], object]) -> None:
        """Call a function that writes, unless writing failed before; keep its error."""
        if self._error is None:
            try:
                write()
            except OSError as error:
                self._error = error
