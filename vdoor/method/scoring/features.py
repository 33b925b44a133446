"""Features of virtual doors: their geometry and the space around them, in metres."""

from __future__ import annotations

import numpy as np
import scipy
from numpy.typing import NDArray

from vdoor.grid import FREE
from vdoor.method.boundary import BoundaryPath
from vdoor.method.doors import VirtualDoors
from vdoor.method.scoring.closed_features import SHUT
from vdoor.method.scoring.detour_features import detours
from vdoor.method.scoring.segments import Segments
from vdoor.method.scoring.space_features import clearance, space_beside
from vdoor.method.scoring.wall_features import ends_known, in_wall, wall_runs
from vdoor.method.simplify import REASONS, SimplifiedGrid
from vdoor.raster.raycast import Padded
from vdoor.topology import KINDS

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

FIRST = (
    "length_m",
    "pair",
    "extension",
    "in_wall_min_m",
    "in_wall_max_m",
    "thick_min_m",
    "thick_max_m",
    "thick_apart_m",
    "end_is_wall",
    "wider_min_m",
    "wider_max_m",
    "wider_far_min_m",
    "wider_far_max_m",
    "depth_min_m",
    "depth_max_m",
    "clear_middle_m",
    "clear_0.6_min_m",
    "clear_0.6_max_m",
    "clear_1.2_min_m",
    "clear_1.2_max_m",
    "clear_2_min_m",
    "clear_2_max_m",
    "run_best_side_m",
    "run_other_side_m",
    "run_mean_m",
    "run_end_min_m",
    "run_end_max_m",
    "run_capped_side_m",
    "run_capped_end_m",
    "run_capped_mean_m",
    "face_apart_m",
    "same_contour",
    "arc_log",
    "arc_ratio_log",
    "cut_off_log",
    "cut_off_ratio_log",
    "islet_log",
    "island_m",
    "longer_than_rival_m",
)
"""Features of pass 1, which finds the surest doors."""
CONFLICT_M = 0.6
"""Doors whose middles are closer than this compete for the same opening."""
FEATURES = (*FIRST, *SHUT)
"""Features of pass 2, in which the surest doors are closed."""


def first_features(
    simplified: SimplifiedGrid,
    path: BoundaryPath,
    doors: VirtualDoors,
    rows: Ints,
    corner_sample: NDArray[np.int32],
    *,
    distance: Padded,
) -> Floats:
    """The values (k, features) of `FIRST` for some rows of `doors`; `distance` is the result of `room_around`."""
    free = simplified.cells == FREE
    door = Segments(doors, rows)
    found: dict[str, Floats] = {"length_m": door.length_m}
    for name, number in (("pair", KINDS.index("pair")), ("extension", KINDS.index("extension"))):
        found[name] = (doors.kind[rows] == number).astype(np.float64)
    found |= in_wall(free, door)
    found |= ends_known(simplified, door)
    open_ = Padded(free, False)
    found |= space_beside(open_, door)
    found |= clearance(distance, open_, door)
    found |= wall_runs(free, door)
    found |= detours(path, door, doors, rows, corner_sample)
    found |= removed_on_the_line(simplified, doors, rows)
    found["longer_than_rival_m"] = longer_than_rival(door)
    return np.stack([found[name] for name in FIRST], axis=1)


def removed_on_the_line(simplified: SimplifiedGrid, doors: VirtualDoors, rows: Ints) -> dict[str, Floats]:
    """The length of removed islands on the door's own cells."""
    number = np.full(len(doors.verdict), -1)
    number[rows] = np.arange(len(rows))
    on = number[doors.line_door] >= 0
    cell, door = doors.line_cell[on], number[doors.line_door[on]]
    reason = simplified.reason[cell[:, 0], cell[:, 1]]
    island = np.bincount(door, weights=reason == REASONS.index("island"), minlength=len(rows))
    return {"island_m": np.asarray(island * simplified.frame.resolution_m, np.float64)}


def longer_than_rival(door: Segments, near_m: float = CONFLICT_M) -> Floats:
    """How much longer (k,) each door is, in metres, than the shortest of those that compete for its opening."""
    if not len(door.length):
        return np.zeros(0)
    pairs = scipy.spatial.cKDTree(door.middle).query_pairs(near_m / door.cell_m, output_type="ndarray")
    shortest = door.length.copy()
    np.minimum.at(shortest, pairs[:, 0], door.length[pairs[:, 1]])
    np.minimum.at(shortest, pairs[:, 1], door.length[pairs[:, 0]])
    return np.asarray((door.length - shortest) * door.cell_m)
