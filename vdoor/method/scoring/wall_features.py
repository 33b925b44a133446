"""Features of a virtual door: the walls that it continues."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from vdoor.grid import FREE, OCCUPIED
from vdoor.method.scoring.segments import Segments
from vdoor.method.simplify import SimplifiedGrid
from vdoor.raster.raycast import Padded, ray_lengths

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]

WALL_RUN_M = 1.5
"""How far walls are followed from a door's ends: past a wardrobe, not past the next door."""
CAPPED_RUN_M = 0.4
"""Length at which capped runs stop counting: long enough to be a wall."""
IN_WALL_M = 0.3
"""How far the door's line is followed inside the wall: walls of homes are up to 0.3 m thick."""
JAMB_M = 0.1
"""How far behind a door's end the wall's thickness is measured, and radius of the cells that count as its end."""
THICKEST_M = 0.5
"""How far the thickness is measured to each side."""
FACE_M = 0.35
"""Largest distance of the wall's face from the door's line: half the thickest wall, plus a cell."""
BAD_STEPS = 2
"""Number of steps off the face that are tolerated: a gap of one cell, and a speck."""
FACE_CELLS = 1.1
"""Tolerance of the face's offset from the first one in cells: one cell, as walls are drawn, plus rounding."""
FACE_SLOPE = 0.05
"""Additional tolerance per step: walls are slanted by up to 3 degrees."""


ROWS_AT_ONCE = 128
"""Rows of the map that are read at a time, to limit memory."""


def in_wall(free: Mask, door: Segments) -> dict[str, Floats]:
    """How far the door's line continues inside the wall at each end, and how thick the wall is there."""
    solid = Padded(~free, True)
    reach = IN_WALL_M / door.cell_m
    on = np.stack([ray_lengths(solid, door.start, -door.along, reach), ray_lengths(solid, door.end, door.along, reach)])
    thick = []
    for point, sign in ((door.start, -1), (door.end, 1)):
        inside = point + sign * door.along * (JAMB_M / door.cell_m)
        set_ = solid.at(*inside.T).astype(np.bool_)
        sides = [ray_lengths(solid, inside, s * door.normal, THICKEST_M / door.cell_m) for s in (-1, 1)]
        thick.append(np.where(set_, sides[0] + sides[1] + 1, 0.0))  # + 1: the cell in which the rays start
    both = np.stack(thick)
    return {
        "in_wall_min_m": on.min(axis=0) * door.cell_m,
        "in_wall_max_m": on.max(axis=0) * door.cell_m,
        "thick_min_m": both.min(axis=0) * door.cell_m,
        "thick_max_m": both.max(axis=0) * door.cell_m,
        "thick_apart_m": np.abs(both[0] - both[1]) * door.cell_m,
    }


def ends_known(simplified: SimplifiedGrid, door: Segments) -> dict[str, Floats]:
    """The share of wall cells among the cells around each end that are not free; the minimum over the ends."""
    window = 2 * max(1, round(JAMB_M / door.cell_m)) + 1
    ends = []
    for point in (door.start.astype(np.int64), door.end.astype(np.int64)):
        share = shares_at(simplified.cells == OCCUPIED, point, window, outside=0.0, edge=False)
        solid = shares_at(simplified.cells != FREE, point, window, outside=1.0, edge=True)
        ends.append(share / np.maximum(solid, 1e-9))
    return {"end_is_wall": np.stack(ends).min(axis=0)}


def shares_at(mask: Mask, point: NDArray[np.int64], window: int, *, outside: float, edge: bool) -> Floats:
    """The share (k,) of set cells in the window around each point, `outside` for points outside the raster.

    With `edge` the raster goes on as at its edge, otherwise no cell is set there. The sums are those of SciPy's uniform
    filter to the last bit, but only of the rows with points, and a few at a time.
    """
    found = np.full(len(point), outside)
    inside = ((point >= 0) & (point < mask.shape)).all(axis=1)
    steps = np.arange(-(window // 2), window // 2 + 1)
    rows = np.unique(point[inside, 0])
    for some in np.split(rows, np.arange(ROWS_AT_ONCE, len(rows), ROWS_AT_ONCE)):
        near = some[:, None] + steps
        cells = mask[np.clip(near, 0, len(mask) - 1)]
        if not edge:
            cells &= ((near >= 0) & (near < len(mask)))[..., None]
        share = _running_means(cells.sum(axis=1) / window, window, edge=edge)
        at = np.flatnonzero(inside & np.isin(point[:, 0], some))
        found[at] = share[np.searchsorted(some, point[at, 0]), point[at, 1]]
    return found


def _running_means(value: Floats, window: int, *, edge: bool) -> Floats:
    """The mean of the values (n, w) around each, along rows, as a running sum."""
    side = window // 2
    padded = np.pad(value, ((0, 0), (side, side)), mode="edge" if edge else "constant")
    first = np.add.accumulate(padded[:, :window], axis=1)[:, -1:]
    changes = padded[:, window:] - padded[:, :-window]
    return np.asarray(np.add.accumulate(np.concatenate([first, changes], axis=1), axis=1) / window)


def wall_runs(free: Mask, door: Segments) -> dict[str, Floats]:
    """How far the faces of the walls continue straight in the door's direction beyond each end."""
    grid = Padded(free, False)
    steps = max(1, int(WALL_RUN_M / door.cell_m))
    run, face = np.zeros((2, 2, len(door.length))), np.zeros((2, 2, len(door.length)))
    depth = np.arange(0, math.ceil(FACE_M / door.cell_m) + 1, dtype=np.float64)
    for e, (point, out) in enumerate(((door.start, -1), (door.end, 1))):
        for s, sign in enumerate((-1, 1)):
            run[e, s], face[e, s] = _face_run(grid, point, (out * door.along, sign * door.normal), depth, steps)
    run_m, face_m = run * door.cell_m, face * door.cell_m
    capped = np.minimum(run_m, CAPPED_RUN_M)
    by_side = run_m.min(axis=0)  # over the ends
    return {
        "run_best_side_m": by_side.max(axis=0),
        "run_other_side_m": by_side.min(axis=0),
        "run_mean_m": run_m.mean(axis=(0, 1)),
        "run_end_min_m": run_m.max(axis=1).min(axis=0),
        "run_end_max_m": run_m.max(axis=1).max(axis=0),
        "run_capped_side_m": capped.min(axis=0).max(axis=0),
        "run_capped_end_m": capped.max(axis=1).min(axis=0),
        "run_capped_mean_m": capped.mean(axis=(0, 1)),
        "face_apart_m": np.minimum(*np.abs(face_m[0] - face_m[1])),
    }


def _face_run(
    grid: Padded, point: Floats, ways: tuple[Floats, Floats], depth: Floats, steps: int
) -> tuple[Floats, Floats]:
    """The number of steps that the wall's face continues outward from an end, and its offset there in cells.

    The face is the first free cell sideways from the door's line. `BAD_STEPS` are tolerated, and the offset may drift.
    """
    out, across = ways
    at = np.arange(1, steps + 1, dtype=np.float64)
    row = point[:, 0, None, None] + out[:, 0, None, None] * at[:, None] + across[:, 0, None, None] * depth
    col = point[:, 1, None, None] + out[:, 1, None, None] * at[:, None] + across[:, 1, None, None] * depth
    free = grid.at(row, col).astype(np.bool_)  # door, step, depth
    offset = np.where(free.any(axis=2), free.argmax(axis=2), len(depth)).astype(np.float64)
    offset[free[:, :, 0]] = -1.0  # the line itself is free: no wall here
    first = offset[:, :1]
    good = (offset > 0) & (offset < len(depth)) & (np.abs(offset - first) <= FACE_CELLS + FACE_SLOPE * at)
    bad = np.cumsum(~good, axis=1)
    reached = np.where(good & (bad <= BAD_STEPS), at, 0.0).max(axis=1, initial=0.0)
    return np.where(good[:, 0], reached, 0.0), np.clip(first[:, 0], 0.0, None)
