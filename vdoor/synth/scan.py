"""What a robot sees of homes and offices, cell by cell: the faces of walls only, roughly, and not every corner."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import NDArray

from vdoor.grid import FREE, OCCUPIED, UNKNOWN
from vdoor.synth.canvas import Cells, Placed, Rooms
from vdoor.synth.settings import chance, log_uniform

Mask = NDArray[np.bool_]
EIGHT = np.ones((3, 3), np.bool_)
FOUR = scipy.ndimage.generate_binary_structure(2, 1)


def leave_corners(rooms: Rooms, keep: NDArray[np.float64], share_max: float, rng: np.random.Generator) -> Mask:
    """Take what lies beyond a straight line from one room, and return those cells: none within 16 cells of `keep`.

    The line cuts off up to `share_max` of the room, in any direction; where a place in `keep` (k, 2) is that near,
    nothing is taken.
    """
    taken = np.zeros(rooms.shape, np.bool_)
    present = np.unique(rooms[rooms > 0])
    if not present.size:
        return taken
    cells = np.argwhere(rooms == rng.choice(present))
    angle = rng.uniform(0.0, 2 * math.pi)
    far = cells @ np.array([math.cos(angle), math.sin(angle)])
    gone = cells[far > np.quantile(far, 1 - rng.uniform(0.02, share_max))]
    distance = np.abs(gone[:, np.newaxis] - keep).max(axis=2)
    if gone.size and not (distance < 16).any():  # noqa: PLR2004  # 0.8 m at 5 cm
        taken[tuple(gone.T)] = True
        rooms[taken] = 0
    return taken


def roughen(rooms: Rooms, share: float, rng: np.random.Generator) -> None:
    """Move the faces of walls by a cell, in or out as often, along `share` of their length, in runs of up to 3."""
    free = rooms > 0
    inner = free & ~scipy.ndimage.binary_erosion(free, FOUR)
    rooms[_runs(inner, share / 2, rng)] = 0
    dents = _runs(scipy.ndimage.binary_dilation(free, FOUR) & ~free, share / 2, rng)
    rows, cols = np.nonzero(dents)
    inside = (rows > 0) & (cols > 0) & (rows < rooms.shape[0] - 1) & (cols < rooms.shape[1] - 1)
    for row, col in zip(rows[inside].tolist(), cols[inside].tolist(), strict=True):
        near = rooms[row - 1 : row + 2, col - 1 : col + 2]
        most = int(near.max())
        if ((near == 0) | (near == most)).all():  # no dent goes through a wall to another room
            rooms[row, col] = most


def _runs(faces: Mask, share: float, rng: np.random.Generator) -> Mask:
    """Return about `share` of the cells of faces, in runs."""
    seeds = faces & (rng.random(faces.shape) < share / 2.5)
    wide = seeds & (rng.random(faces.shape) < 0.75)  # noqa: PLR2004  # three in four runs are of three cells
    return seeds | (scipy.ndimage.binary_dilation(wide, EIGHT) & faces)


def outlined(rooms: Rooms, unseen: Mask, depth: int = 1) -> Cells:
    """Return cells (h, w): free, occupied as deep behind a face as the robot shows it, all else unknown."""
    free = rooms > 0
    near = scipy.ndimage.binary_dilation(free, EIGHT, iterations=depth)
    return np.where(free, FREE, np.where(near & ~unseen, OCCUPIED, UNKNOWN)).astype(np.int8)


def forget_walls(cells: Cells, share: float, rng: np.random.Generator) -> None:
    """Make about that share of the occupied cells unknown."""
    cells[_runs(cells == OCCUPIED, share, rng)] = UNKNOWN


def pierce(rooms: Rooms, cells: Cells, count: int, rng: np.random.Generator) -> None:
    """Open holes of one to three cells in walls."""
    walls = np.argwhere(cells == OCCUPIED)
    for row, col in walls[rng.integers(len(walls), size=count)].tolist() if len(walls) else []:
        near = rooms[max(row - 1, 0) : row + 2, max(col - 1, 0) : col + 2]
        room = int(near.max())
        height, width = rng.integers(1, 4, size=2)
        hole = np.s_[row : row + height, col : col + width]
        if room and 0 in near:
            shut = rooms[hole] == 0
            rooms[hole][shut], cells[hole][shut] = room, FREE


@dataclass(frozen=True)
class Fan:
    """What is seen from a place: directions within `half_rad` of `angle_rad`, up to about `reach` cells away."""

    eye: tuple[float, float]
    """As row, col."""
    angle_rad: float
    """From columns to rows: clockwise on the picture."""
    half_rad: float
    reach: float


def cast(rooms: Rooms, cells: Cells, view: Fan, rng: np.random.Generator) -> None:
    """Free what is seen, as part of the room of the eye.

    Nothing is seen behind what belongs to other rooms; the far ends of some rays are occupied.
    """
    eye = view.eye
    room = int(rooms[round(eye[0]), round(eye[1])])
    count = max(3, math.ceil(2 * view.half_rad * view.reach / 0.7))
    angles = view.angle_rad + np.linspace(-view.half_rad, view.half_rad, count)
    ends = _ends(count, view.reach, rng)
    steps = np.arange(0.0, max(float(ends.max()), 0.5), 0.5)
    row, col = (np.rint(eye[k] + np.outer(way(angles), steps)).astype(np.intp) for k, way in ((0, np.sin), (1, np.cos)))
    row, col = np.clip(row, 2, rooms.shape[0] - 3), np.clip(col, 2, rooms.shape[1] - 3)
    low, high = (row.min(), col.min()), (row.max() + 1, col.max() + 1)
    around = np.s_[max(low[0] - 3, 0) : high[0] + 3, max(low[1] - 3, 0) : high[1] + 3]
    others = scipy.ndimage.binary_dilation((rooms[around] > 0) & (rooms[around] != room), EIGHT, iterations=2)
    blocked = others[row - around[0].start, col - around[1].start] | (steps >= ends[:, np.newaxis])
    seen = ~np.logical_or.accumulate(blocked, axis=1)
    last = seen.sum(axis=1) - 1
    tips = np.stack([row[np.arange(count), last], col[np.arange(count), last]], axis=1)[(last > 0) & (ends > 0)]
    new = seen & (rooms[row, col] == 0)
    rooms[row[new], col[new]], cells[row[new], col[new]] = room, FREE
    _cap(rooms, cells, tips, rng)


def _ends(count: int, reach: float, rng: np.random.Generator) -> NDArray[np.float64]:
    """Return how far each ray is seen: equal over a few neighbouring rays, here and there not at all."""
    pieces = int(rng.integers(1, 5))
    bounds = np.sort(rng.integers(0, count, size=pieces - 1))
    far = reach * rng.uniform(0.35, 1.0, size=pieces) * (rng.random(pieces) > 0.15)  # noqa: PLR2004  # one in seven
    if not far.any():
        far[0] = reach
    slope = 1 + rng.uniform(-0.3, 0.3) * np.linspace(0.0, 1.0, count)
    ends = far[np.searchsorted(bounds, np.arange(count), side="right")] * slope
    return np.asarray(ends + rng.normal(0.0, 0.7, size=count) * (ends > 0))


def _cap(rooms: Rooms, cells: Cells, tips: NDArray[np.intp], rng: np.random.Generator) -> None:
    """Show most of what ended the rays as occupied, or nothing of it."""
    if chance(0.6, rng):
        for row, col in tips[rng.random(len(tips)) < 0.8].tolist():  # noqa: PLR2004
            near = np.s_[row - 1 : row + 2, col - 1 : col + 2]
            cells[near][rooms[near] == 0] = OCCUPIED


def cast_through_window(placed: Placed, cells: Cells, reach_m: tuple[float, float], rng: np.random.Generator) -> None:
    """Cast one fan through a window, where a wall with nothing behind it is found in a dozen tries."""
    rooms, cell_m = placed.rooms, placed.cell_m
    inside = np.argwhere(rooms > 0)
    steps = np.arange(0.0, 4.0 / cell_m, 0.5)
    for _ in range(12 if len(inside) else 0):
        eye = inside[rng.integers(len(inside))]
        angle = -placed.canvas.yaw_rad + rng.integers(4) * math.pi / 2 + rng.uniform(-0.5, 0.5)
        row, col = (np.rint(eye[k] + way(angle) * steps).astype(np.intp) for k, way in ((0, math.sin), (1, math.cos)))
        met = rooms[np.clip(row, 0, rooms.shape[0] - 1), np.clip(col, 0, rooms.shape[1] - 1)]
        wall = int(np.argmax(met == 0))
        if wall * 0.5 * cell_m > 0.3 and not met[wall:].any():  # noqa: PLR2004
            away_m = wall * 0.5 * cell_m
            half = math.atan(rng.uniform(0.15, 0.7) / away_m)
            reach = away_m + log_uniform(reach_m[0], reach_m[1], rng)
            cast(rooms, cells, Fan((float(eye[0]), float(eye[1])), angle, half, reach / cell_m), rng)
            return


def draw_pockets(rooms: Rooms, cells: Cells, cell_m: float, rng: np.random.Generator) -> None:
    """Make broken lines unknown, one cell wide, along two or three sides of a box within a room: a rug, a table."""
    inside = np.argwhere(scipy.ndimage.binary_erosion(rooms > 0, EIGHT, iterations=4))
    if not len(inside):
        return
    top, left = inside[rng.integers(len(inside))].tolist()
    height, width = (rng.uniform(0.3, 1.5, size=2) / cell_m).astype(int).tolist()
    line = np.zeros(rooms.shape, np.bool_)
    for part in rng.permutation(4)[: int(rng.integers(2, 4))].tolist():
        row = top + height * (part == 1)
        col = left + width * (part == 3)  # noqa: PLR2004  # the fourth side
        line[(row, slice(left, left + width)) if part < 2 else (slice(top, top + height), col)] = True  # noqa: PLR2004
    line &= (rooms > 0) & (rng.random(rooms.shape) < 0.8)  # noqa: PLR2004
    rooms[line], cells[line] = 0, UNKNOWN


def speckle(rooms: Rooms, cells: Cells, count: int, rng: np.random.Generator) -> None:
    """Add blots, free or occupied, where nothing is known, near the rooms: free ones belong to no room."""
    seen = np.argwhere(rooms > 0)
    if not len(seen):
        return
    low, high = np.maximum(seen.min(axis=0) - 20, 3), np.minimum(seen.max(axis=0) + 20, np.array(cells.shape) - 7)
    for _ in range(count):
        row, col = rng.integers(low, high).tolist()
        height, width = rng.integers(1, 4, size=2).tolist()
        around = np.s_[row - 3 : row + height + 3, col - 3 : col + width + 3]
        if not (rooms[around] > 0).any():
            cells[row : row + height, col : col + width] = FREE if chance(0.5, rng) else OCCUPIED
