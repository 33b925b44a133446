"""Records with nothing in them, and maps without virtual doors: what the baselines do without."""

from __future__ import annotations

from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from vdoor.frame import Frame
from vdoor.grid import OccupancyGrid
from vdoor.method.boundary import BoundaryPath
from vdoor.method.corners import Corners
from vdoor.method.final_doors import passages_at
from vdoor.method.final_map import Features, map_of
from vdoor.raster.labels import contacts
from vdoor.record import Record, specs
from vdoor.topology import TopologicalMap

Ints = NDArray[np.int32]
R = TypeVar("R", bound=Record)


def without_corners(frame: Frame) -> tuple[BoundaryPath, Corners]:
    """A path without samples, and no corners on it."""
    return BoundaryPath(**no_rows(BoundaryPath), on_cracks=0, frame=frame), Corners(**no_rows(Corners), frame=frame)


def no_rows(record: type[Record]) -> dict[str, NDArray[Any]]:
    """The tables of a type of record, all empty."""
    return {
        name: np.zeros([int(axis) if axis.isdigit() else 0 for axis in spec.axes], dtype)
        for name, (spec, dtype) in specs(record).items()
        if dtype is not None
    }


def map_of_labels(labels: Ints, grid: OccupancyGrid) -> TopologicalMap:
    """The map of rooms (h, w); wherever two of them touch is a door."""
    return map_of(labels, grid.frame, passages_at(*contacts(labels), grid.frame), Features.none())
