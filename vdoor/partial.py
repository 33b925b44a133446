"""Files that get their final name only once they are complete, alone or several together.

While a file is written, it has a partial name, is created exclusively (no link is followed) and is locked. So two runs
never write into one file: the second is refused, or, once the first was killed, takes the name over.
"""

from __future__ import annotations

import contextlib
import fcntl
import os
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO

from vdoor.errors import VdoorError
from vdoor.files import is_empty, make_folder, partial_name
from vdoor.interrupts import held_signals

CREATE = os.O_RDWR | os.O_CREAT | os.O_EXCL | os.O_NOFOLLOW | os.O_CLOEXEC


class Partial:
    """A new, locked file under the partial name of `path`; a file that a killed run left there is replaced.

    Raises VdoorError if another process is writing there, or if there is a file already and not `force`.
    """

    def __init__(self, path: Path, *, force: bool = True, name: Path | None = None) -> None:
        self.path, self.force = path, force
        self.name = name or partial_name(path)
        with _output_errors(path, "written"), _one_at_a_time(self.name.parent):
            self._number: int | None = _created(self.name, force=force)
        try:
            self.refuse_taken()
        except VdoorError:
            self.remove()
            raise

    def stream(self) -> BinaryIO:
        """The file, open for writing; to be closed by the caller."""
        assert self._number is not None
        return open(os.dup(self._number), "wb")  # noqa: PTH123  # a file descriptor

    def fill(self, content: bytes) -> None:
        """Write the whole file; raises VdoorError if that fails."""
        with _output_errors(self.path, "written"), self.stream() as stream:
            stream.write(content)

    def refuse_taken(self) -> None:
        """Raise VdoorError if the final name is in use and may not be, or the partial name is no longer this file's."""
        if not self.force and os.path.lexists(self.path):
            raise VdoorError(f"output: already exists, --force overwrites it: {self.path}")
        with _output_errors(self.path, "renamed"):
            is_own = self._number is not None and os.path.samestat(os.fstat(self._number), self.name.lstat())
        if not is_own:
            raise VdoorError(f"output: cannot be renamed (something else has its place): {self.name}")

    def give_name(self) -> None:
        """Rename the file, which must be complete, to its own name; raises VdoorError if that fails."""
        self.refuse_taken()
        with _output_errors(self.path, "renamed"):
            self.name.replace(self.path)
        self.leave()

    def remove(self) -> None:
        """Remove the file, if it still has its partial name."""
        if self._number is not None:
            with contextlib.suppress(OSError):  # a read-only folder does not allow that either
                if os.path.samestat(os.fstat(self._number), self.name.lstat()):
                    self.name.unlink()
        self.leave()

    def leave(self) -> None:
        """Leave the file as it is; others may take its place."""
        if self._number is not None:
            os.close(self._number)
        self._number = None


class Staged:
    """Files, each complete under its partial name, that get their names together by `commit`."""

    def __init__(self) -> None:
        self.parts: list[Partial] = []
        self._folders: list[Path] = []

    def make_folder(self, path: Path) -> None:
        """Create a folder for files if it is missing; raises VdoorError if that fails."""
        if not path.exists():
            self._folders.append(path)
        make_folder(path)

    def add(self, path: Path, content: bytes, *, force: bool = True) -> None:
        """Write a file under its partial name; raises VdoorError if that fails."""
        self.parts.append(Partial(path, force=force))
        self.parts[-1].fill(content)

    def commit(self) -> None:
        """Rename all files, in order; raises VdoorError, before the first, if one of them cannot be."""
        with held_signals():
            for part in self.parts:
                part.refuse_taken()
            while self.parts:
                self.parts[0].give_name()
                del self.parts[0]

    def abandon(self) -> None:
        """Remove all files that have no name yet, and folders made for them."""
        for part in self.parts:
            part.remove()
        for folder in self._folders:
            with contextlib.suppress(OSError):  # not empty
                folder.rmdir()


@contextlib.contextmanager
def together() -> Iterator[Staged]:
    """Files that get their names when the block ends; none of them does after an error."""
    staged = Staged()
    try:
        yield staged
        staged.commit()
    except BaseException:
        staged.abandon()
        raise


def write_whole(path: Path, content: bytes, *, force: bool = True) -> Path:
    """Write a file under its partial name, then rename it; raises VdoorError if that fails."""
    partial = Partial(path, force=force)
    try:
        partial.fill(content)
        partial.give_name()
    except BaseException:
        partial.remove()
        raise
    return path


def _created(name: Path, *, force: bool) -> int:
    """A descriptor of a new, locked file; the lock ends with the process."""
    try:
        number = os.open(name, CREATE, 0o666)
    except FileExistsError:
        _refuse_in_use(name, force=force)
        name.unlink()
        number = os.open(name, CREATE, 0o666)
    with contextlib.suppress(OSError):  # a file system without locks
        fcntl.flock(number, fcntl.LOCK_EX | fcntl.LOCK_NB)
    return number


def _refuse_in_use(name: Path, *, force: bool) -> None:
    """Raise VdoorError unless a file under a partial name may be replaced."""
    if name.is_symlink() or not name.is_file():
        raise VdoorError(f"output: wanted a file's name, found a link, folder or device: {name}")
    number = os.open(name, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC)
    try:
        fcntl.flock(number, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        raise VdoorError(f"output: another run is writing it: {name}") from None
    except OSError:  # a file system without locks
        pass
    finally:
        os.close(number)
    if not force and not is_empty(name):
        raise VdoorError(f"output: already exists, --force overwrites it: {name}")


@contextlib.contextmanager
def _one_at_a_time(folder: Path) -> Iterator[None]:
    """Let no other process create a file in the folder meanwhile, so that a name is taken over once."""
    number = os.open(folder, os.O_RDONLY | os.O_CLOEXEC)
    try:
        with contextlib.suppress(OSError):  # a file system without locks
            fcntl.flock(number, fcntl.LOCK_EX)
        yield
    finally:
        os.close(number)


@contextlib.contextmanager
def _output_errors(path: Path, what: str) -> Iterator[None]:
    try:
        yield
    except OSError as error:
        raise VdoorError(f"output: cannot be {what} ({error.strerror}): {path}") from error
