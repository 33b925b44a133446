"""Where a raster of cells lies in the map frame."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

LEAST_DECIMALS = 3


@dataclass(frozen=True)
class Frame:
    """The shape of a raster in cells, and its pose in the map frame (x right, y up, metres).

    The origin is the pose of the lower left corner of the lower left cell, as in ROS map_server.
    """

    height: int
    width: int
    resolution_m: float
    x_m: float = 0.0
    y_m: float = 0.0
    yaw_rad: float = 0.0

    @property
    def decimals(self) -> int:
        """Decimals of coordinates in metres that are worth writing: millimetres, and more for cells under a centimetre.

        Centres and sides of cells keep to what they are in maps whose cells are whole millimetres and do not lie askew.
        """
        fine = 0 < self.resolution_m < 1
        return min(max(LEAST_DECIMALS, math.ceil(-math.log10(self.resolution_m)) + 1), 9) if fine else LEAST_DECIMALS

    def world_from_cell(self, cells: NDArray[Any]) -> NDArray[np.float64]:
        """Map coordinates x, y (k, 2) of points row, col (k, 2); integers are cell centres."""
        rows, cols = np.asarray(cells, dtype=np.float64).reshape(-1, 2).T
        right_m = (cols + 0.5) * self.resolution_m
        up_m = (self.height - rows - 0.5) * self.resolution_m
        cos, sin = math.cos(self.yaw_rad), math.sin(self.yaw_rad)
        return np.stack([self.x_m + cos * right_m - sin * up_m, self.y_m + sin * right_m + cos * up_m], axis=1)

    def cell_from_world(self, points_m: NDArray[Any]) -> NDArray[np.float64]:
        """Row, col (k, 2), not rounded, of map coordinates x, y (k, 2); the inverse of `world_from_cell`."""
        x_m, y_m = np.asarray(points_m, dtype=np.float64).reshape(-1, 2).T
        cos, sin = math.cos(self.yaw_rad), math.sin(self.yaw_rad)
        right_m = cos * (x_m - self.x_m) + sin * (y_m - self.y_m)
        up_m = -sin * (x_m - self.x_m) + cos * (y_m - self.y_m)
        return np.stack([self.height - up_m / self.resolution_m - 0.5, right_m / self.resolution_m - 0.5], axis=1)
