"""Features of a virtual door: the space on both sides of it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from vdoor.method.scoring.segments import Segments
from vdoor.raster.morphology import EXACT_CELLS, distances, exact
from vdoor.raster.raycast import Padded, ray_lengths

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]

CLEARANCE_REACHES_M = (0.6, 1.2, 2.0)
BESIDE_M = (-0.3, -0.15, 0.0, 0.15, 0.3)
BESIDE = ("wider_min_m", "wider_max_m", "wider_far_min_m", "wider_far_max_m", "depth_min_m", "depth_max_m")
CLEARANCE = tuple(f"clear_{reach_m:g}_{which}_m" for reach_m in CLEARANCE_REACHES_M for which in ("min", "max"))
"""Features measured by rays into the space on both sides of a door."""
WIDTHS_AT_M = (0.4, 0.7)
"""Distances from the door at which the width of the space is measured: past the wall, and past furniture beside it."""
FAR_M = 3.0
"""Longest ray: anything farther away is no evidence about a door."""
UNSEEN = 1.5
"""Correction in cells for the sum of two opposite rays, to the distance between the cells that stop them (which is also
how doors are measured): half a cell each, and a quarter on average, as rays advance by half cells."""


def space_beside(open_: Padded, door: Segments) -> dict[str, Floats]:
    """How much wider than the door the space on each side is, and how deep it is."""
    wider = {}
    for away_m in WIDTHS_AT_M:
        for name, sign in (("l", -1), ("r", 1)):
            point = door.middle + sign * door.normal * (away_m / door.cell_m)
            inside = open_.at(*point.T).astype(np.bool_)
            width = ray_lengths(open_, point, door.along, FAR_M / door.cell_m)
            width += ray_lengths(open_, point, -door.along, FAR_M / door.cell_m)
            wider[away_m, name] = np.where(inside, width + UNSEEN, 0.0) * door.cell_m - door.length_m
    rays = [ray_lengths(open_, door.middle, sign * door.normal, FAR_M / door.cell_m) for sign in (-1, 1)]
    depth = np.stack(rays) * door.cell_m
    near_m, far_m = WIDTHS_AT_M
    return {
        "wider_min_m": np.minimum(wider[near_m, "l"], wider[near_m, "r"]),
        "wider_max_m": np.maximum(wider[near_m, "l"], wider[near_m, "r"]),
        "wider_far_min_m": np.minimum(wider[far_m, "l"], wider[far_m, "r"]),
        "wider_far_max_m": np.maximum(wider[far_m, "l"], wider[far_m, "r"]),
        "depth_min_m": depth.min(axis=0),
        "depth_max_m": depth.max(axis=0),
    }


def room_around(free: Mask) -> Padded:
    """The distance in cells of each free cell from the nearest one that is not free, or from outside the map."""
    distance = distances(np.pad(free, 1))
    if distance.max(initial=0) <= EXACT_CELLS:
        return Distances(distance)
    from scipy import ndimage  # noqa: PLC0415  # for halls over 4000 cells wide

    return Padded(ndimage.distance_transform_edt(np.pad(free, 1))[1:-1, 1:-1], 0.0)


class Distances(Padded):
    """Distances in cells, stored in 32 bits and read to the last of 64; the raster has a margin of one cell of 0."""

    def __init__(self, distance: NDArray[np.float32]) -> None:
        self._hold(distance)

    def at(self, row: NDArray[np.floating], col: NDArray[np.floating]) -> NDArray[np.generic]:
        """The distances at points, 0 outside the raster."""
        return exact(super().at(row, col).astype(np.float32))


def clearance(distance: Padded, open_: Padded, door: Segments) -> dict[str, Floats]:
    """How much the space opens up on each side: the largest clearance along rays, minus half the door's length."""
    half_m = door.length_m / 2
    found = {"clear_middle_m": distance.at(*door.middle.T).astype(np.float64) * door.cell_m - half_m}
    steps = np.arange(1, max(1, int(max(CLEARANCE_REACHES_M) / door.cell_m * 2)) + 1) / 2
    most = np.zeros((len(CLEARANCE_REACHES_M), 2, len(half_m)))
    for side, sign in enumerate((-1, 1)):
        for beside_m in BESIDE_M:
            base = door.middle + door.along * (beside_m / door.cell_m)
            row = base[:, 0, None] + sign * door.normal[:, 0, None] * steps
            col = base[:, 1, None] + sign * door.normal[:, 1, None] * steps
            seen = np.logical_and.accumulate(open_.at(row, col).astype(np.bool_), axis=1)
            best = np.maximum.accumulate(np.where(seen, distance.at(row, col), 0.0), axis=1)
            for number, reach_m in enumerate(CLEARANCE_REACHES_M):
                last = max(1, min(len(steps), int(reach_m / door.cell_m * 2))) - 1
                most[number, side] = np.maximum(most[number, side], best[:, last])
    for number, reach_m in enumerate(CLEARANCE_REACHES_M):
        by_side = most[number] * door.cell_m - half_m
        found[f"clear_{reach_m:g}_min_m"] = by_side.min(axis=0)
        found[f"clear_{reach_m:g}_max_m"] = by_side.max(axis=0)
    return found
