"""Files that appear under their name only when they are whole."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from vdoor.errors import VdoorError


def partial_name(path: Path) -> Path:
    """The name a file has while it is written."""
    return path.with_name(f"{path.name}.partial")


def write_whole(path: Path, content: bytes) -> Path:
    """Write a file under its partial name and rename it; VdoorError where that cannot be done."""
    partial = partial_name(path)
    try:
        partial.write_bytes(content)
        return partial.replace(path)
    except OSError as error:
        partial.unlink(missing_ok=True)
        raise VdoorError(f"output: cannot be written ({error.strerror}): {path}") from error


def make_folder(path: Path) -> Path:
    """The folder, made with its parents if it is missing."""
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise VdoorError(f"output folder: cannot be made ({error.strerror}): {path}") from error
    return path


def refuse_existing(paths: Iterable[Path], *, force: bool, reads: Path | None = None) -> None:
    """VdoorError naming the first of `paths`, or of their partial names, that exists, unless `force`.

    A partial file is what an interrupted run could save; where it is what the command `reads`, it may stand there.
    Folders are refused always.
    """
    for path in paths:
        saved = [partial_name(path)] if partial_name(path) != reads else []
        for name in (path, *saved):
            if name.is_dir():
                raise VdoorError(f"output: wanted a file name, found a folder: {name}")
            if name.exists() and not force:
                raise VdoorError(f"output: exists already, --force overwrites it: {name}")
