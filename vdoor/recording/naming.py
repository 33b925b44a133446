"""Errors of reading a recording, each with the file that it concerns."""

from __future__ import annotations

import contextlib
import stat
import struct
from collections.abc import Iterator
from pathlib import Path

from vdoor.errors import RecordingError, printable
from vdoor.kinds import kind_of

FROM_RUNS_OR_MAPS = ("a Rerun recording", "a result folder", "a JSON file", "a PNG image", "a PGM image")
"""What is given by those who have a map, and have run it or not, but have no recording of the run."""


class TooMuchError(RecordingError):
    """A file that would cause far more work than its size explains."""


@contextlib.contextmanager
def naming_version(version: str) -> Iterator[None]:
    """Add to a `RecordingError` the version that wrote the recording, and what to do."""
    try:
        yield
    except RecordingError as error:
        raise RecordingError(
            f"{error} (written by vdoor {version}); read it with that version, or record it again"
        ) from error


@contextlib.contextmanager
def naming(path: Path) -> Iterator[None]:
    """Turn errors of reading into a `RecordingError` that ends with the path."""
    import zstandard  # noqa: PLC0415  # only recordings need it
    from mcap.exceptions import EndOfFile, InvalidMagic, McapError  # noqa: PLC0415

    try:
        _refuse_pipe(path)
        yield
    except RecordingError as error:
        text = printable(str(error)).removesuffix(f": {path}")  # named already where reading is nested
        raise type(error)(f"{text}: {path}") from error
    except OSError as error:
        raise RecordingError(f"recording: cannot be read ({error.strerror}): {path}") from error
    except (EndOfFile, struct.error) as error:
        raise RecordingError(f"recording: wanted a complete MCAP file, found it cut short: {path}") from error
    except InvalidMagic as error:
        raise RecordingError(f"recording: {wanted(path)}: {path}") from error
    except (McapError, zstandard.ZstdError, ValueError, OverflowError, MemoryError) as error:
        raise RecordingError(f"recording: damaged ({printable(str(error))}): {path}") from error


def wanted(path: Path) -> str:
    """What was wanted, for a file that is no MCAP, and how to get one."""
    kind = kind_of(path)
    advice = "; `vdoor run MAP --mcap FILE` writes what this command reads" if kind in FROM_RUNS_OR_MAPS else ""
    return f"wanted an MCAP file, found {kind}{advice}"


def _refuse_pipe(path: Path) -> None:
    """Raise `RecordingError` for anything but a file or folder: opening it could block forever."""
    mode = path.stat().st_mode
    if not (stat.S_ISREG(mode) or stat.S_ISDIR(mode)):
        raise RecordingError("recording: wanted a file, found a device or pipe")
    if stat.S_ISDIR(mode):
        raise RecordingError(f"recording: {wanted(path)}")
