"""What must hold for the truth of any home or office, as questions to ask of one."""

from __future__ import annotations

from collections import Counter
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from vdoor.synth import SyntheticMap, TrueDoor

SOLID: dict[str, Any] = {"hollow_chance": 0.0, "dashed_chance": 0.0, "antialiased_chance": 0.0}
"""No home or office has walls that are drawn otherwise."""


def contacts(rooms: NDArray[np.int32]) -> Counter[tuple[int, int]]:
    """How many sides of cells each pair of labels has in common."""
    found: Counter[tuple[int, int]] = Counter()
    for one, other in ((rooms[1:], rooms[:-1]), (rooms[:, 1:], rooms[:, :-1])):
        differ = (one != other) & (one > 0) & (other > 0)
        low, high = np.minimum(one, other)[differ], np.maximum(one, other)[differ]
        found.update(zip(low.tolist(), high.tolist(), strict=True))
    return found


def reached(made: SyntheticMap) -> NDArray[np.bool_]:
    """Free cells that are 4-connected to a cell with a label."""
    part, _ = ndimage.label(made.grid.free)
    return np.isin(part, np.unique(part[made.rooms > 0])) & made.grid.free


def cells_on(made: SyntheticMap, door: TrueDoor) -> NDArray[np.intp]:
    """Cells (k, 2) on a door's line from jamb to jamb, each as often as steps of 1 cm fall on it."""
    share = np.arange(0.005, door.width_m, 0.01)[:, np.newaxis] / door.width_m
    points = np.array(door.start_m) * (1 - share) + np.array(door.end_m) * share
    return np.rint(made.grid.frame.cell_from_world(points)).astype(np.intp)


def touch_near(made: SyntheticMap, door: TrueDoor, reach_m: float) -> bool:
    """Whether the door's two rooms touch in the box around its line, grown by `reach_m`."""
    cells = cells_on(made, door)
    away = round(reach_m / made.grid.frame.resolution_m)
    low, high = np.maximum(cells.min(axis=0) - away, 0), cells.max(axis=0) + away + 1
    return door.rooms in contacts(made.rooms[low[0] : high[0], low[1] : high[1]])
