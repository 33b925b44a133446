"""The request that a reader gets, and the checks shared by all formats."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import PureWindowsPath
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from vdoor.errors import MapError
from vdoor.formats.levels import NAV2, Levels, checked_levels
from vdoor.grid import OCCUPIED, UNKNOWN, Source

Options = dict[str, float | int | str]
"""The user's options for reading the file, by name; stored with the source."""
UnknownValue = int | Literal["none"] | None
"""A grey value that is read as unknown; "none" for no such value, None to look at the image."""
MAX_CELLS = 100_000_000
DEFAULT_RESOLUTION_M = 0.05
FINEST_M, COARSEST_M = 0.0001, 100.0
GREYS = 256


@dataclass(frozen=True, kw_only=True)
class Request:
    """The bytes of a map's files and how to read them; readers use nothing else."""

    source: Source
    max_cells: int = MAX_CELLS
    paths: dict[str, str] = field(default_factory=dict)
    """Base name of a file -> its path for messages; the base name is used for files without an entry."""
    notes: list[str] = field(default_factory=list)
    """Notes for the user, in order; issued as warnings once the map is read."""

    @property
    def name(self) -> str:
        """The base name of the file that was opened; raises MapError if the source has no files."""
        if not self.source.files:
            raise MapError("files of the map: wanted at least one, found none")
        return self.source.files[0][0]

    def data(self, name: str) -> bytes:
        """The bytes of the file with this base name; raises MapError if it is missing or empty."""
        data = dict(self.source.files).get(name)
        if not data:
            raise MapError(f"file: wanted a map, found {'no such file' if data is None else 'an empty file'}")
        return data

    def path(self, name: str) -> str:
        """The path, for messages, of the file with this base name."""
        return self.paths.get(name, name)

    def note(self, text: str, name: str) -> None:
        """Add a note for the user about a file."""
        self.notes.append(f"{text}: {self.path(name)}")

    @contextmanager
    def naming(self, name: str) -> Iterator[None]:
        """Append the file's path to any MapError raised in the block."""
        try:
            yield
        except MapError as error:
            raise MapError(f"{error}: {self.path(name)}") from error.__cause__

    @property
    def resolution_m(self) -> float | None:
        """The user's resolution in metres per cell, None if not given; raises MapError if it is invalid."""
        given = self.source.options.get("resolution_m")
        return None if given is None else checked_resolution_m(given)

    @property
    def unknown_value(self) -> UnknownValue:
        """The grey value for unknown cells, 0 to 255, or "none"; None if not given. Raises MapError if invalid."""
        given = self.source.options.get("unknown_value")
        if given is None or given == "none":
            return None if given is None else "none"
        if isinstance(given, int) and not isinstance(given, bool) and 0 <= given < GREYS:
            return given
        raise MapError(f"unknown value: wanted a whole number from 0 to {GREYS - 1}, or none, found {shown(given)}")

    def refuse_unknown_value(self, what: str) -> None:
        """Raise MapError if a grey value is given for a format without greys; `what` is the format's name."""
        if self.unknown_value is not None:
            raise MapError(f"unknown value: wanted none for {what}, which marks its unknown cells, found one")

    def levels(self, default: Levels = NAV2) -> Levels | None:
        """The user's limits of free and occupied, one that is not given as in `default`; None if none is given.

        Raises MapError if they are invalid.
        """
        given = self.source.options
        return checked_levels(given.get("free_below"), given.get("occupied_from"), default)

    def refuse_levels(self, what: str) -> None:
        """Raise MapError if limits of free and occupied are given for a format whose cells are one or the other."""
        if self.levels() is not None:
            raise MapError(
                f"free below, occupied from: wanted none for {what}, whose cells say what they are, found one"
            )

    def with_levels(self, levels: Levels) -> Source:
        """The source with limits of free and occupied, so that it is read with the same ones again."""
        chosen: Options = {"free_below": levels.free_below, "occupied_from": levels.occupied_from}
        return Source(self.source.files, self.source.options | chosen)

    def note_turn(self, yaw_rad: float) -> None:
        """Add a note if the map is rotated in its frame."""
        if yaw_rad != 0:
            self.note(f"origin: the map is rotated by {yaw_rad:g} rad, and coordinates with it", self.name)

    def resolution_or_default_m(self, name: str) -> float:
        """The resolution in metres per cell for a format without one: the user's, or 0.05 with a note."""
        if self.resolution_m is not None:
            return self.resolution_m
        self.note(f"resolution: none in the file, using {DEFAULT_RESOLUTION_M} m per cell (--resolution sets it)", name)
        return DEFAULT_RESOLUTION_M


def checked_resolution_m(value: object) -> float:
    """A resolution in metres per cell as float; raises MapError if it is not a number in the valid range."""
    if isinstance(value, (int, float)) and not isinstance(value, bool) and FINEST_M <= value <= COARSEST_M:
        return float(value)
    raise MapError(f"resolution: wanted {FINEST_M} to {COARSEST_M:g} m per cell, found {shown(value)}")


def agreed_resolution_m(written_m: float, requested_m: float | None) -> float:
    """The file's resolution in metres per cell; raises MapError if the user's is different."""
    if requested_m is not None and not math.isclose(written_m, requested_m, rel_tol=1e-9):
        raise MapError(f"resolution: wanted {requested_m:g} m per cell as requested, found {written_m:g} m")
    return written_m


def check_values(place: str, values: NDArray[np.int8]) -> None:
    """Refuse cells that are neither unknown nor a per cent of occupancy; `place` names them."""
    if values.min() < UNKNOWN or values.max() > OCCUPIED:
        raise MapError(f"{place}: wanted values of {UNKNOWN} to {OCCUPIED}, found {values.min()} to {values.max()}")


def check_size(height: int, width: int, *, max_cells: int) -> None:
    """Raise MapError for the size in a map's header, before decoding, if it has no cells or too many."""
    if height < 1 or width < 1:
        raise MapError(f"size: wanted at least one cell, found {width} x {height}")
    if height * width > max_cells:
        raise MapError(f"size: wanted at most {max_cells} cells, found {width} x {height}")


def number(text: Any) -> float:
    """The number in a YAML scalar, which may be nan; raises MapError if it is not a number."""
    try:
        # YAML writes .nan and .inf, C writes nan and inf; both occur in real files.
        return float(text.lower().replace(".nan", "nan").replace(".inf", "inf"))
    except (AttributeError, ValueError):
        raise MapError(f"wanted a number, found {shown(text)}") from None


def finite(text: Any) -> float:
    """The number in a YAML scalar; raises MapError if it is not a finite number."""
    value = number(text)
    if not math.isfinite(value):
        raise MapError(f"wanted a finite number, found {shown(text)}")
    return value


def base_name(path: str) -> str:
    """The last part of a path of any operating system."""
    return PureWindowsPath(path).name


def shown(value: object) -> str:
    """A found value as short text on one line for messages, safe for any content of a file."""
    if isinstance(value, (list, tuple, dict)):
        return f"a {'table' if isinstance(value, dict) else 'list'} of {len(value)}"
    text = repr(value)
    longest = 60
    return text if len(text) <= longest else f"{text[:longest]}..."
