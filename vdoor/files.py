"""The one way to open a file for reading, and what is refused as the name of a file to write."""

from __future__ import annotations

import os
import stat
from collections.abc import Iterable
from pathlib import Path
from typing import BinaryIO

from vdoor.errors import VdoorError


def open_regular(path: Path, wanted: str, *, error: type[VdoorError] = VdoorError) -> BinaryIO:
    """A regular file, opened for reading; never blocks, as opening a pipe could.

    Raises `error`, which says that `wanted` was wanted, if there is none or it cannot be read.
    """
    try:
        number = os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC)
        mode = os.fstat(number).st_mode
    except FileNotFoundError:
        raise error(f"file: wanted {wanted}, found none: {path}") from None
    except (OSError, ValueError) as found:  # ValueError: a path with a null byte
        raise error(f"file: wanted {wanted}, found {getattr(found, 'strerror', None) or found}: {path}") from found
    if stat.S_ISREG(mode):
        return open(number, "rb", opener=None)  # noqa: PTH123  # a file descriptor, not a path
    os.close(number)
    raise error(f"file: wanted {wanted}, found {'a folder' if stat.S_ISDIR(mode) else 'a device or pipe'}: {path}")


def read_regular(path: Path, wanted: str, *, limit: int, error: type[VdoorError] = VdoorError) -> bytes:
    """The bytes of a regular file of at most `limit` bytes; raises like `open_regular`."""
    with open_regular(path, wanted, error=error) as file:
        try:
            data = file.read(limit + 1) if os.fstat(file.fileno()).st_size <= limit else None
        except OSError as found:
            raise error(f"file: wanted {wanted}, found {found.strerror}: {path}") from found
    if data is None or len(data) > limit:
        raise error(f"file: wanted {wanted}, found none of at most {limit} bytes: {path}")
    return data


def partial_name(path: Path) -> Path:
    """The name of a file while it is being written."""
    return path.with_name(f"{path.name}.partial")


def make_folder(path: Path) -> Path:
    """The folder, created with its parents if missing; raises VdoorError if that fails."""
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise VdoorError(f"output folder: cannot be created ({error.strerror}): {path}") from error
    return path


def refuse_folder(path: Path) -> None:
    """Raise VdoorError if a folder is not writable or could not be created; creates nothing."""
    there = next(folder for folder in (path, *path.absolute().parents) if folder.exists())
    if not there.is_dir() or not os.access(there, os.W_OK):
        found = "a read-only folder" if there.is_dir() else "a file"
        raise VdoorError(f"output folder: wanted a writable folder, found {found}: {there}")


def refuse_existing(
    paths: Iterable[Path], *, force: bool, reads: Iterable[Path] = (), recovers: Path | None = None
) -> None:
    """Raise VdoorError for the first of `paths`, or of their partial names, that exists, unless `force`.

    Always refused, even with `force`: files that the command `reads`; folders, devices and pipes, which renaming would
    replace; two outputs with the same name; an output that is the partial file of another. A partial file is what an
    interrupted run saved, so it is refused too, unless it is the one that the command `recovers`.
    """
    seen: set[Path] = set()
    paths = list(paths)
    for path in paths:
        if not path.name:
            raise VdoorError(f"output: wanted a file name, found a folder: {path}")
        for name in (path, partial_name(path)):
            refuse_place(name, force=force or (name != path and (name == recovers or is_empty(name))))
            if name != path and name.is_symlink():
                raise VdoorError(f"output: wanted no link under the name of a file being written, found one: {name}")
            place = name.parent.resolve() / name.name
            if place in seen:
                raise VdoorError(f"output: wanted a different name for each file, found one twice: {name}")
            seen.add(place)
    for read in reads:
        refuse_input(read, paths)


def is_empty(name: Path) -> bool:
    """Whether a file is there with nothing in it, as a run that was killed early leaves one."""
    return name.is_file() and not name.stat().st_size


def refuse_place(name: Path, *, force: bool) -> None:
    """Raise VdoorError if no file can be written under this name, or if one exists, unless `force`."""
    try:
        there, file, folder = name.exists(), name.is_file(), name.is_dir()
    except (OSError, ValueError) as error:  # ValueError: a null byte
        reason = getattr(error, "strerror", None) or str(error)
        raise VdoorError(f"output: invalid file name ({reason}): {name}") from error
    if there and not file:
        found = "a folder" if folder else "a device or pipe"
        raise VdoorError(f"output: wanted a file name, found {found}: {name}")
    if there and not force:
        raise VdoorError(f"output: already exists, --force overwrites it: {name}")


def refuse_input(read: Path, written: Iterable[Path]) -> None:
    """Raise VdoorError if an input file would be overwritten by an output or by its partial file."""
    for path in written:
        for name in (path, partial_name(path)):
            if name.resolve() == read.resolve():
                raise VdoorError(f"output: wanted a different name from the input's: {name}")
