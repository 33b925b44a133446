"""Empty records, and maps without virtual doors, for the baselines."""

from __future__ import annotations

from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from vdoor.frame import Frame
from vdoor.grid import OccupancyGrid
from vdoor.method.boundary import BoundaryPath
from vdoor.method.corners import Corners
from vdoor.method.final_doors import passages_at
from vdoor.method.finished import Features, map_of
from vdoor.raster.components import contacts
from vdoor.record import Record, specs
from vdoor.topology import TopologicalMap

Ints = NDArray[np.int32]
R = TypeVar("R", bound=Record)


def without_corners(frame: Frame) -> tuple[BoundaryPath, Corners]:
    """A boundary path without samples, and corners without rows."""
    return BoundaryPath(**no_rows(BoundaryPath), on_cracks=0, frame=frame), Corners(**no_rows(Corners), frame=frame)


def no_rows(record: type[Record]) -> dict[str, NDArray[Any]]:
    """The columns of a record type, all with zero rows."""
    return {
        name: np.zeros([int(axis) if axis.isdigit() else 0 for axis in spec.axes], dtype)
        for name, (spec, dtype) in specs(record).items()
        if dtype is not None
    }


def map_of_labels(labels: Ints, grid: OccupancyGrid) -> TopologicalMap:
    """The topological map of rooms (h, w), with a door wherever two of them touch."""
    return map_of(labels, grid.frame, passages_at(*contacts(labels), grid.frame), Features.none())
