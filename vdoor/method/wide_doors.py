"""Virtual doors for real maps: from convex corners to everything they face nearby, and in line with their walls."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated

import numpy as np
from numpy.typing import NDArray

from vdoor.config import Within
from vdoor.grid import FREE
from vdoor.method.boundary import BoundaryPath
from vdoor.method.corners import Corners
from vdoor.method.curvature import EPSILON
from vdoor.method.doors import (
    PROPOSED,
    VERDICTS,
    DoorCandidates,
    VirtualDoors,
    measured,
    measures,
    pairs_within,
    same_wall,
)
from vdoor.method.simplify import SimplifiedGrid
from vdoor.method.wall_direction import wall_direction_rad
from vdoor.raster.lines import lines_between
from vdoor.raster.raycast import CHUNK, STEP, Padded
from vdoor.topology import KINDS

Floats = NDArray[np.float64]
Ints = NDArray[np.int32]
Mask = NDArray[np.bool_]

DIRECTIONS = 128
"""Number of rays from each corner, a multiple of 8."""


@dataclass(frozen=True, kw_only=True)
class ProposeWideDoors:
    """Join convex corners to each other, to the nearest boundaries around them, and in line with their own walls."""

    pair_m: Annotated[float, Within(0, 20)] = 2.6
    """Longest door between two corners."""
    single_m: Annotated[float, Within(0, 20)] = 2.3
    """Longest door from a corner to a boundary."""
    extension_m: Annotated[float, Within(0, 20)] = 3.2
    """Longest door in line with a wall that ends in a corner."""
    least_m: Annotated[float, Within(0, 20)] = 0.3
    """Narrowest door: no robot fits through less."""
    apart_cosine: Annotated[float, Within(-1, 1)] = 0.3
    """Of two boundaries whose directions from a corner have a greater cosine, only the nearer one is joined."""
    pair_detour: Annotated[float, Within(0, 100)] = 2.5
    """A door between two corners of one contour requires a path between them longer than this times the door."""
    single_detour: Annotated[float, Within(0, 100)] = 2.5
    """The same factor for a door between a corner and a boundary."""
    wall_m: Annotated[float, Within(0.01, 5)] = 0.5
    """Length of the wall beside a corner from which the wall's direction is measured."""
    snap_deg: Annotated[float, Within(0, 45)] = 20.0
    """Directions of walls within this angle of the map's dominant one are set to it."""

    def __call__(self, simplified: SimplifiedGrid, path: BoundaryPath, corners: Corners) -> VirtualDoors:
        """Pairs, then singles, then extensions; of equal doors only the first is kept."""
        free = simplified.cells == FREE
        convex = np.flatnonzero(corners.convex).astype(np.int32)
        found = self._pairs(path, corners, convex)
        found = found.followed_by(self._singles(free, path, corners, convex))
        found = found.followed_by(self._extensions(free, path, corners, convex))
        clear, _, _ = lines_between(free, found.start, found.end)
        found.verdict[~clear & (found.verdict == PROPOSED)] = VERDICTS.index("blocked")
        found.verdict[np.abs(found.end - found.start).max(axis=1, initial=0) <= 1] = VERDICTS.index("no gap")
        _, width_m, _ = measures(found.start, found.end, path.frame.resolution_m)
        narrow = (width_m < self.least_m - EPSILON) & (found.verdict == PROPOSED)
        found.verdict[narrow] = VERDICTS.index("too narrow")
        return measured(free, found, path.frame)

    def _pairs(self, path: BoundaryPath, corners: Corners, convex: Ints) -> DoorCandidates:
        """All pairs of convex corners within reach, those along one wall marked."""
        both = pairs_within(corners, convex, self.pair_m / path.frame.resolution_m + EPSILON)
        verdict = np.full(len(both), PROPOSED, np.uint8)
        same = same_wall(path, corners.sample[both[:, 0]], corners.sample[both[:, 1]], self.pair_detour)
        verdict[same] = VERDICTS.index("same wall")
        return DoorCandidates(
            corners.cell[both[:, 0]], corners.cell[both[:, 1]], np.zeros(len(both), np.uint8), verdict, both
        )

    def _singles(self, free: Mask, path: BoundaryPath, corners: Corners, convex: Ints) -> DoorCandidates:
        """Doors from each corner to the nearest boundaries in clearly different directions."""
        reach = self.single_m / path.frame.resolution_m
        offset = _rays(reach)
        start = corners.cell[convex]
        hit = _first_hits(free, start, offset)  # step index, -1 for none
        number, squared, cell = _local_nearest(start, offset, hit)
        own = self._own_wall(path, corners.sample[convex[number]], cell)
        own |= np.abs(cell - start[number]).max(axis=1, initial=0) <= 1
        number, squared, cell = number[~own], squared[~own], cell[~own]
        keep = _apart(number, squared, (cell - start[number]).astype(np.float64), self.apart_cosine)
        number, cell = number[keep], cell[keep]
        both = np.stack([convex[number], np.full(len(number), -1, np.int32)], axis=1)
        kind = np.full(len(number), KINDS.index("single"), np.uint8)
        return DoorCandidates(start[number], cell, kind, np.full(len(number), PROPOSED, np.uint8), both)

    def _own_wall(self, path: BoundaryPath, sample: Ints, cell: Ints) -> Mask:
        """Whether each cell (k, 2) is on the same wall as its corner's sample (k,), or has no sample of the path.

        One sample of a cell that is near along the path is enough.
        """
        row, other = samples_at(path, cell)
        near = same_wall(path, sample[row], other.astype(np.int32), self.single_detour)
        own = np.ones(len(cell), np.bool_)
        own[row] = False
        own[row[near]] = True
        return own

    def _extensions(self, free: Mask, path: BoundaryPath, corners: Corners, convex: Ints) -> DoorCandidates:
        """Doors from each corner in line with the two walls that meet in it, to the first obstacle."""
        cell_m = path.frame.resolution_m
        samples = max(3, round(self.wall_m / cell_m))
        dominant = wall_direction_rad(path)
        direction, number = [], []
        for sign in (-1, 1):
            before = _along(path, corners.sample[convex], sign, samples)
            inner = _along(path, corners.sample[convex], sign, 1 + samples // 4)
            wall = (inner - before).astype(np.float64)
            angle = np.arctan2(wall[:, 0], wall[:, 1])
            off = (angle - dominant + np.pi / 4) % (np.pi / 2) - np.pi / 4
            snapped = np.abs(off) <= math.radians(self.snap_deg)
            direction.append(np.where(snapped, angle - off, angle))
            number.append(np.arange(len(convex)))
        angle, which = np.concatenate(direction), np.concatenate(number)
        steps = np.arange(1, int(self.extension_m / cell_m / STEP) + 1) * STEP
        start = corners.cell[convex[which]]
        away = np.stack([np.sin(angle), np.cos(angle)], axis=1)
        grid = Padded(free, False)
        row = start[:, 0, None] + away[:, 0, None] * steps
        col = start[:, 1, None] + away[:, 1, None] * steps
        blocked = ~grid.at(row, col).astype(np.bool_)
        near = steps < max(1.5, 0.1 / cell_m)
        blocked[:, near] = False  # the corner's own cell, and a rough edge
        first = blocked.argmax(axis=1) if len(steps) else np.zeros(len(start), np.intp)
        hit = blocked.any(axis=1) & (first > 0)
        index = np.flatnonzero(hit)
        end = np.stack([np.rint(row[index, first[index]]), np.rint(col[index, first[index]])], axis=1).astype(np.int32)
        beside = ((end >= -1) & (end <= free.shape)).all(axis=1)  # a ray may leave the map right beside its corner
        index, end = index[beside], end[beside]
        both = np.stack([convex[which[index]], np.full(len(index), -1, np.int32)], axis=1)
        kind = np.full(len(index), KINDS.index("extension"), np.uint8)
        return DoorCandidates(start[index], end, kind, np.full(len(index), PROPOSED, np.uint8), both)


def _rays(reach: float) -> Ints:
    """Cell offsets (directions, steps, 2) of rays in all directions, invariant under quarter turns and mirroring."""
    eighth = DIRECTIONS // 8
    angle = np.arange(eighth + 1) * (math.pi / 4 / eighth)
    steps = np.arange(1, max(1, int(reach / STEP)) + 1) * STEP
    down, right = (np.rint(f(angle)[:, None] * steps).astype(np.int32) for f in (np.sin, np.cos))
    first = np.stack([down, right], axis=-1)
    quarter = np.concatenate([first, first[-2:0:-1, :, ::-1]])
    turned = [quarter]
    for _ in range(3):
        quarter = np.stack([quarter[..., 1], -quarter[..., 0]], axis=-1)
        turned.append(quarter)
    return np.concatenate(turned)


def _first_hits(free: Mask, start: Ints, offset: Ints) -> Ints:
    """The step (k, directions) at which each ray from cells (k, 2) hits an obstacle after free cells; -1 for none."""
    grid = np.pad(free, 1)
    height, width = grid.shape
    flat = grid.reshape(-1)
    out = np.full((len(start), len(offset)), -1, np.int32)
    at_once = max(1, CHUNK // offset[..., 0].size)
    for begin in range(0, len(start), at_once):
        part = slice(begin, begin + at_once)
        row = np.clip(start[part, 0, None, None] + offset[..., 0] + 1, 0, height - 1)
        col = np.clip(start[part, 1, None, None] + offset[..., 1] + 1, 0, width - 1)
        blocked = ~flat[row * width + col]
        own = np.abs(offset).max(axis=-1) == 0
        blocked[:, own] = False
        first = blocked.argmax(axis=2)
        out[part] = np.where(blocked.any(axis=2) & (first > 0), first, -1)
    return out


def _local_nearest(start: Ints, offset: Ints, hit: Ints) -> tuple[NDArray[np.intp], NDArray[np.int64], Ints]:
    """The corner (m,), squared distance (m,) and cell (m, 2) of hits no farther than those of the rays beside them."""
    directions = np.arange(len(offset))
    span = offset[directions, np.maximum(hit, 0)].astype(np.int64)
    squared = np.where(hit >= 0, (span**2).sum(axis=2), np.iinfo(np.int64).max)
    lowest = (squared <= np.roll(squared, 1, axis=1)) & (squared <= np.roll(squared, -1, axis=1)) & (hit >= 0)
    number, at = np.nonzero(lowest)
    cell = (start[number] + span[number, at]).astype(np.int32)
    _, first = np.unique(np.column_stack([number, cell]), axis=0, return_index=True)
    return number[first], squared[number[first], at[first]], cell[first]


def samples_at(path: BoundaryPath, cell: Ints) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Rows (m,) of `cell` (k, 2) and samples (m,) of the path: all pairs in which the cell is the sample's obstacle."""
    width = path.frame.width + 2
    key = (path.cell[:, 0].astype(np.int64) + 1) * width + path.cell[:, 1] + 1
    order = np.argsort(key, kind="stable")
    wanted = (cell[:, 0].astype(np.int64) + 1) * width + cell[:, 1] + 1
    begin = np.searchsorted(key[order], wanted, "left")
    count = np.searchsorted(key[order], wanted, "right") - begin
    row = np.repeat(np.arange(len(cell)), count)
    within = np.arange(len(row)) - np.repeat(np.cumsum(count) - count, count)
    return row, order[begin[row] + within]


def _apart(number: NDArray[np.intp], squared: NDArray[np.int64], span: Floats, cosine: float) -> Mask:
    """Which hits (k,), sorted by corner, have no nearer hit of the same corner in a similar direction."""
    unit = span / np.hypot(*span.T)[:, None]
    keep = np.ones(len(number), np.bool_)
    most = int(np.bincount(number).max(initial=0))
    for step in range(1, most):
        a, b = np.arange(len(number) - step), np.arange(step, len(number))
        alike = (number[a] == number[b]) & ((unit[a] * unit[b]).sum(axis=1) > cosine)
        keep[a[alike & (squared[b] < squared[a])]] = False
        keep[b[alike & (squared[a] < squared[b])]] = False
    return keep


def _along(path: BoundaryPath, sample: Ints, sign: int, samples: int) -> Ints:
    """Positions (k, 2) in half cells that are `samples` before (-1) or after (1) each sample on its contour."""
    contour = path.contour[sample]
    count = np.diff(np.append(path.first, len(path.cell)))[contour]
    local = (sample - path.first[contour] + sign * np.minimum(samples, count // 2)) % count
    return np.asarray(path.half[path.first[contour] + local])
