"""Files that appear under their name only when they are whole."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Iterable
from pathlib import Path

from vdoor.errors import VdoorError


def partial_name(path: Path) -> Path:
    """The name a file has while it is written."""
    return path.with_name(f"{path.name}.partial")


def give_name(path: Path) -> None:
    """Give a file that is whole its name; VdoorError where that cannot be done."""
    try:
        partial_name(path).replace(path)
    except OSError as error:
        raise VdoorError(f"output: cannot be renamed ({error.strerror}): {path}") from error


def write_whole(path: Path, content: bytes) -> Path:
    """Write a file under its partial name and rename it; VdoorError where that cannot be done."""
    partial = partial_name(path)
    try:
        partial.write_bytes(content)
        return partial.replace(path)
    except OSError as error:
        with contextlib.suppress(OSError):  # a read-only folder refuses that as well
            partial.unlink(missing_ok=True)
        raise VdoorError(f"output: cannot be written ({error.strerror}): {path}") from error


def make_folder(path: Path) -> Path:
    """The folder, made with its parents if it is missing."""
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise VdoorError(f"output folder: cannot be made ({error.strerror}): {path}") from error
    return path


def refuse_folder(path: Path) -> None:
    """VdoorError where a folder is not there and cannot be made; nothing is made yet."""
    there = next(folder for folder in (path, *path.absolute().parents) if folder.exists())
    if not there.is_dir() or not os.access(there, os.W_OK):
        found = "a folder that is read-only" if there.is_dir() else "a file"
        raise VdoorError(f"output folder: wanted a folder to write in, found {found}: {there}")


def refuse_existing(
    paths: Iterable[Path], *, force: bool, reads: Iterable[Path] = (), recovers: Path | None = None
) -> None:
    """VdoorError naming the first of `paths`, or of their partial names, that exists, unless `force`.

    What the command `reads` is refused always, as are folders, devices and pipes, since a file that is renamed takes
    their place; and so are two outputs of one name, or of which one is the other's partial file. A partial file is
    what an interrupted run could save; where it is what the command `recovers`, it may stand there.
    """
    seen: set[Path] = set()
    paths = list(paths)
    for path in paths:
        if not path.name:
            raise VdoorError(f"output: wanted a file name, found a folder: {path}")
        for name in (path, partial_name(path)):
            refuse_place(name, force=force or (name != path and name == recovers))
            place = name.parent.resolve() / name.name
            if place in seen:
                raise VdoorError(f"output: wanted another name for each file, found one twice: {name}")
            seen.add(place)
    for read in reads:
        refuse_input(read, paths)


def refuse_place(name: Path, *, force: bool) -> None:
    """VdoorError where no file can be written, or where one is already, unless `force`."""
    try:
        there, file, folder = name.exists(), name.is_file(), name.is_dir()
    except (OSError, ValueError) as error:  # ValueError: a null byte
        reason = getattr(error, "strerror", None) or str(error)
        raise VdoorError(f"output: no file can have that name ({reason}): {name}") from error
    if there and not file:
        found = "a folder" if folder else "a device or pipe"
        raise VdoorError(f"output: wanted a file name, found {found}: {name}")
    if there and not force:
        raise VdoorError(f"output: exists already, --force overwrites it: {name}")


def refuse_input(read: Path, written: Iterable[Path]) -> None:
    """VdoorError where a file that is read would be overwritten by one that is written, or by its partial file."""
    for path in written:
        for name in (path, partial_name(path)):
            if name.resolve() == read.resolve():
                raise VdoorError(f"output: wanted another name than the input's: {name}")
