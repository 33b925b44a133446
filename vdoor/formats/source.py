"""What a reader is handed, and the checks that every format shares."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import PureWindowsPath
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vdoor.errors import MapError
from vdoor.grid import OCCUPIED, UNKNOWN, Source

Options = dict[str, float | int | str]
"""What the user said beside the file, by name; kept with the source."""
MAX_CELLS = 100_000_000
DEFAULT_RESOLUTION_M = 0.05
FINEST_M, COARSEST_M = 0.0001, 100.0
GREYS = 256


@dataclass(frozen=True, kw_only=True)
class Request:
    """The bytes of a map's files and how to read them; readers look at nothing else."""

    source: Source
    max_cells: int = MAX_CELLS
    paths: dict[str, str] = field(default_factory=dict)
    """What messages call a file, by its base name; a file that is not here is called by its base name."""
    notes: list[str] = field(default_factory=list)
    """What the user should know, in order; becomes warnings once the map is read."""

    @property
    def name(self) -> str:
        """Base name of the file that the map was opened by; MapError where the source keeps none."""
        if not self.source.files:
            raise MapError("files of the map: wanted at least one, found none")
        return self.source.files[0][0]

    def data(self, name: str) -> bytes:
        """Bytes of the file with this base name; MapError where there is none or it is empty."""
        data = dict(self.source.files).get(name)
        if not data:
            raise MapError(f"file: wanted a map, found {'no such file' if data is None else 'an empty file'}")
        return data

    def path(self, name: str) -> str:
        """Path by which messages call the file with this base name."""
        return self.paths.get(name, name)

    def note(self, text: str, name: str) -> None:
        """Keep something the user should know about one file."""
        self.notes.append(f"{text}: {self.path(name)}")

    @contextmanager
    def naming(self, name: str) -> Iterator[None]:
        """Put the file's path behind any MapError raised inside."""
        try:
            yield
        except MapError as error:
            raise MapError(f"{error}: {self.path(name)}") from error.__cause__

    @property
    def resolution_m(self) -> float | None:
        """Metres a cell as the user said, None where nothing was said; MapError where it cannot be."""
        said = self.source.options.get("resolution_m")
        return None if said is None else checked_resolution_m(said)

    @property
    def unknown_value(self) -> int | None:
        """The grey that the user calls unknown, 0 to 255, None where nothing was said."""
        said = self.source.options.get("unknown_value")
        if said is None or (isinstance(said, int) and not isinstance(said, bool) and 0 <= said < GREYS):
            return said
        raise MapError(f"unknown value: wanted a whole number from 0 to {GREYS - 1}, found {shown(said)}")

    def refuse_unknown_value(self, what: str) -> None:
        """Refuse a grey for unknown where cells have no grey; `what` names the format."""
        if self.unknown_value is not None:
            raise MapError(f"unknown value: wanted none for {what}, where unknown cells are marked, found one")

    def note_turn(self, yaw_rad: float) -> None:
        """Note that a map does not lie along its frame's axes."""
        if yaw_rad != 0:
            self.note(f"origin: the map is turned by {yaw_rad:g} rad; coordinates turn with it", self.name)

    def resolution_or_default_m(self, name: str) -> float:
        """Metres a cell of a format that does not say it itself: as the user said, or 0.05 with a note."""
        if self.resolution_m is not None:
            return self.resolution_m
        self.note(f"resolution: the file says none, {DEFAULT_RESOLUTION_M} m a cell taken (--resolution sets it)", name)
        return DEFAULT_RESOLUTION_M


def checked_resolution_m(value: object) -> float:
    """Metres a cell as float; MapError where it is no number, not finite, or no resolution a map can have."""
    if isinstance(value, (int, float)) and not isinstance(value, bool) and FINEST_M <= value <= COARSEST_M:
        return float(value)
    raise MapError(f"resolution: wanted {FINEST_M} to {COARSEST_M:g} m a cell, found {shown(value)}")


def agreed_resolution_m(written_m: float, said_m: float | None) -> float:
    """Metres a cell as the file has it; MapError where the user says another."""
    if said_m is not None and not math.isclose(written_m, said_m, rel_tol=1e-9):
        raise MapError(f"resolution: wanted {said_m:g} m a cell as asked for, found {written_m:g} m")
    return written_m


def check_values(place: str, values: NDArray[np.int8]) -> None:
    """Refuse cells that are neither unknown nor a per cent of occupancy; `place` names them."""
    if values.min() < UNKNOWN or values.max() > OCCUPIED:
        raise MapError(f"{place}: wanted values of {UNKNOWN} to {OCCUPIED}, found {values.min()} to {values.max()}")


def check_size(height: int, width: int, *, max_cells: int) -> None:
    """Refuse a map without cells or with too many, as its header announces it, before anything is decoded."""
    if height < 1 or width < 1:
        raise MapError(f"size: wanted at least one cell, found {width} x {height}")
    if height * width > max_cells:
        raise MapError(f"size: wanted at most {max_cells} cells, found {width} x {height}")


def number(text: Any) -> float:
    """Value that a YAML scalar writes out, nan included; MapError where it is none."""
    try:
        # YAML writes .nan and .inf, C writes nan and inf: both are met in real files.
        return float(text.lower().replace(".nan", "nan").replace(".inf", "inf"))
    except (AttributeError, ValueError):
        raise MapError(f"wanted a number, found {shown(text)}") from None


def finite(text: Any) -> float:
    """Finite value that a YAML scalar writes out; MapError where it is none."""
    value = number(text)
    if not math.isfinite(value):
        raise MapError(f"wanted a finite number, found {shown(text)}")
    return value


def base_name(path: str) -> str:
    """Last part of a path of any system."""
    return PureWindowsPath(path).name


def shown(value: object) -> str:
    """How a message names what was found: short on one line, whatever a hostile file holds."""
    if isinstance(value, (list, tuple, dict)):
        return f"a {'table' if isinstance(value, dict) else 'list'} of {len(value)}"
    text = repr(value)
    longest = 60
    return text if len(text) <= longest else f"{text[:longest]}..."
