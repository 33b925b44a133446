"""Virtual doors as segments with a direction."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from vdoor.method.doors import VirtualDoors

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


class Segments:
    """Doors as segments between points (row, col) in cells, with unit vectors along and across."""

    def __init__(self, doors: VirtualDoors, rows: Ints) -> None:
        self.cell_m = doors.frame.resolution_m
        self.start = doors.start[rows].astype(np.float64)
        self.end = doors.end[rows].astype(np.float64)
        self.middle = (self.start + self.end) / 2
        span = self.end - self.start
        self.length = np.hypot(*span.T)
        self.along = span / np.maximum(self.length, 1e-9)[:, None]
        self.normal = np.stack([-self.along[:, 1], self.along[:, 0]], axis=1)

    @property
    def length_m(self) -> Floats:
        """Length (k,) in metres between the centres of the end cells."""
        return np.asarray(self.length * self.cell_m)
