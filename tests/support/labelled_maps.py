"""Topological maps made from drawn labels, and the finished maps that have doors."""

from __future__ import annotations

import finished_maps
import numpy as np
import pytest
from numpy.typing import NDArray

from vdoor.frame import Frame
from vdoor.results.reading import _assembled
from vdoor.topology import Door, TopologicalMap

WITH_DOORS = [name for name in finished_maps.NAMES if name != "one room"]
with_doors = pytest.mark.parametrize("name", WITH_DOORS)
Point = tuple[float, float]


def labelled(
    labels: str | NDArray[np.int32], *doors: tuple[tuple[int, int], Point], cell_m: float = 1.0
) -> TopologicalMap:
    """A map of digits, the rooms, with doors of one cell given by their two rooms and their row, col."""
    if isinstance(labels, str):
        labels = np.array([[int(sign) for sign in line] for line in labels.split()], np.int32)
    frame = Frame(*labels.shape, resolution_m=cell_m)
    made = []
    for number, (rooms, place) in enumerate(doors, start=1):
        ((x_m, y_m),) = frame.world_from_cell(np.array([place])).tolist()
        made.append(Door(number, rooms, (x_m, y_m), (x_m, y_m), cell_m, cell_m, 0.0, "passage"))
    return _assembled(labels, frame, made, [], {})


def bent(wide: int, down: int, right: int) -> TopologicalMap:
    """A corridor that goes down and then to the right, in cells of 5 cm, with a small room at either end."""
    labels = np.zeros((down + 8, right + 8), np.int32)
    labels[4 : down + 4, 4 : 4 + wide] = 1
    labels[down + 4 - wide : down + 4, 4 : right + 4] = 1
    labels[:4, 4 : 4 + wide], labels[down + 4 - wide : down + 4, right + 4 :] = 2, 3
    doors = ((1, 2), (3.5, 4 + wide // 2)), ((1, 3), (down + 3 - wide // 2, right + 3.5))
    return labelled(labels, *doors, cell_m=0.05)
