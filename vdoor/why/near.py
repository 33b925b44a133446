"""What lies nearest to a point."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from vdoor.history import History

Point = tuple[float, float]


def nearest(run: History, point_m: Point, places: NDArray[Any], count: int) -> list[tuple[int, float]]:
    """The `count` nearest of places (k, 2) in working cells: index and metres away, the first one at a tie."""
    away_m = np.hypot(*(run.simplified.frame.world_from_cell(places) - point_m).T).round(9)
    order = np.argsort(away_m, kind="stable")[:count]
    return [(int(index), float(away_m[index])) for index in order]


def point_of(run: History, place: NDArray[Any]) -> Point:
    """A place as row, col of working cells in metres."""
    x_m, y_m = run.simplified.frame.world_from_cell(place)[0].tolist()
    return x_m, y_m
