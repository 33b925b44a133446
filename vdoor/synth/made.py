"""What is drawn: a map and the truth about its rooms and doors."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vdoor.grid import OccupancyGrid
from vdoor.synth.settings import Apartment, Home, Office


@dataclass(frozen=True)
class TrueDoor:
    """A real door: from jamb to jamb in the middle of its wall, in metres of the map frame."""

    start_m: tuple[float, float]
    end_m: tuple[float, float]
    width_m: float
    rooms: tuple[int, int]
    """Labels of the two rooms, the lower one first."""
    unsure: bool = False
    """An opening of which a person could not say whether it parts two rooms: found or not, it counts for nobody."""


@dataclass(frozen=True, eq=False)
class SyntheticMap:
    """A map and the truth about it."""

    grid: OccupancyGrid
    rooms: NDArray[np.int32]
    """Room of each free cell (h, w), from 1; 0 where not free, free but out of reach of the rooms, or within a wall."""
    doors: tuple[TrueDoor, ...]
    settings: Apartment | Home | Office
