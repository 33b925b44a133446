"""From which per cent of occupancy a cell is free or occupied, for values between 0 and 100.

Elsewhere a cell is free below 20 and occupied from 65 (`grid.FREE_TO`, `grid.OCCUPIED_FROM`): Nav2's defaults.
Mappers that publish probabilities, as Cartographer does, write everything between 0 and 100, and most of what the robot
saw would be neither. Such values are read by what is likelier: free below 50, occupied above. That leaves only those
of exactly 50 undecided, and needs no setting that depends on the map.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vdoor.errors import MapError
from vdoor.grid import FREE, FREE_TO, OCCUPIED, OCCUPIED_FROM, UNKNOWN


@dataclass(frozen=True)
class Levels:
    """The limits of free and occupied, in per cent of occupancy."""

    free_below: float
    occupied_from: float

    def __str__(self) -> str:
        return f"--free-below {self.free_below:g} --occupied-from {self.occupied_from:g}"

    def of(self, values: NDArray[np.int8]) -> NDArray[np.int8]:
        """Values of -1 to 100 as -1 unknown, 0 free and 100 occupied, of the same shape."""
        cells = np.full(values.shape, UNKNOWN, np.int8)
        cells[values >= self.occupied_from] = OCCUPIED
        cells[(values >= 0) & (values < self.free_below)] = FREE
        return cells


NAV2 = Levels(FREE_TO + 1, OCCUPIED_FROM)
LIKELIER = Levels(50, 51)


def checked_levels(free_below: object, occupied_from: object, default: Levels) -> Levels | None:
    """The levels that the user set, one that is None taken from the default; None if both are None.

    Raises MapError if a level is not from 0 to 100, or they are the wrong way round.
    """
    if free_below is None and occupied_from is None:
        return None
    free, occupied = _checked("free below", free_below), _checked("occupied from", occupied_from)
    if free is None:
        free = min(default.free_below, occupied if occupied is not None else OCCUPIED)
    if occupied is None:
        occupied = max(default.occupied_from, free)
    if free > occupied:
        raise MapError(f"free below: wanted at most the {occupied:g} per cent of occupied from, found {free:g}")
    return Levels(free, occupied)


def _checked(name: str, value: object) -> float | None:
    if value is None or (isinstance(value, int | float) and not isinstance(value, bool) and 0 <= value <= OCCUPIED):
        return value
    raise MapError(f"{name}: wanted 0 to {OCCUPIED} per cent, found {value!r:.40}")
