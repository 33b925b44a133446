"""A home as a robot with a laser scanner maps it by SLAM: what rays met and crossed, seen from places along its way.

Walls are as thin as their faces are seen, with holes where few rays end; a wall seen from two rooms is double where
the robot's estimate of its place drifted in between; through windows the map goes on outside.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import NDArray

from vdoor.grid import FREE, OCCUPIED, UNKNOWN
from vdoor.synth.canvas import FINE_M, Cells, Placed
from vdoor.synth.drawn_walls import DEEPEST_M, wall_thickness
from vdoor.synth.home import furnish
from vdoor.synth.home_plan import draw_home_plan
from vdoor.synth.layout import Drawn, drawn, faces, laid_on_map
from vdoor.synth.settings import LaserHome, chance, log_uniform
from vdoor.synth.truth import SyntheticMap, with_truth

Mask = NDArray[np.bool_]
Floats = NDArray[np.float64]

AROUND_M = 2.0
"""Of what is seen outside, this much is on the map."""
ROBOT_M = 0.2
"""The scanner keeps this far from all that it sees."""
PASS_M = 0.04
"""Steps along a ray."""
SEEN_TWICE = 2
"""Rays that must reach a cell before anything is known of it."""
GLASS_M = (0.6, 2.5)
THROUGH_GLASS = 0.85
"""Share of the rays on a window that go through."""
FROM_OUTSIDE = 0.4
"""Share of the rays through windows that something outside sends back."""
PERSON_M = 0.12
"""Radius of a leg, with its trousers."""


@dataclass(frozen=True, eq=False)
class World:
    """What a scanner meets, on the fine raster of the plan."""

    solid: Mask
    glass: Mask
    """Solid cells that most rays go through."""


@dataclass(frozen=True)
class Scanner:
    """How one robot sees, drawn from the settings."""

    rays: int
    range_m: float
    noise_m: float
    lost_frees: bool
    """Rays that do not come back free all that is in range."""


@dataclass(frozen=True, eq=False)
class Pose:
    """Where a scan was made, in metres of the plan, and how far off the robot took it to be."""

    place_m: Floats
    """(2,) as x, y."""
    off_m: Floats
    """(2,) as x, y."""
    off_rad: float


def draw_laser_home(settings: LaserHome, rng: np.random.Generator) -> SyntheticMap:
    """Return one home; the same generator state gives the same one."""
    for_plan, for_doors, for_furniture, for_place, for_windows, for_way, for_scan = rng.spawn(7)
    plan = drawn(draw_home_plan(settings, for_plan))
    furnish(plan, settings, for_doors, for_furniture)
    placed = laid_on_map(plan.canvas, settings, AROUND_M, for_place)
    world = World(plan.canvas.rooms == 0, _windows(plan, settings, for_windows))
    poses = list(_poses(plan, settings, for_way))
    cells = _mapped(world, poses, placed, settings, for_scan)
    placed.rooms[cells != FREE] = 0
    return with_truth(cells, placed, plan.opened, settings)


def _windows(plan: Drawn, settings: LaserHome, rng: np.random.Generator) -> Mask:
    """Return the fine cells of windows, which lie in walls with nothing behind."""
    panes, floors = plan.floor.empty(), plan.layout.floors
    for _ in range(rng.poisson(settings.glass)):
        room = int(rng.integers(len(floors)))
        face = faces(room, floors[room])[int(rng.integers(4))]
        low, high = floors[room].low[face.along], floors[room].high[face.along]
        width = min(rng.uniform(*GLASS_M), high - low)
        start = rng.uniform(low, high - width)
        ends = (start + FINE_M, start + width / 2, start + width - FINE_M)
        if all(wall_thickness(face, plan.floor, at_m) == DEEPEST_M for at_m in ends):
            panes.paint(face.strip(start, width, DEEPEST_M), 1)
    return np.asarray((panes.rooms > 0) & (plan.floor.rooms == 0))


def _poses(plan: Drawn, settings: LaserHome, rng: np.random.Generator) -> Iterator[Pose]:
    """Yield where the robot scans: all over the rooms that it visits, and in their doors."""
    rooms = plan.canvas.rooms
    clear = scipy.ndimage.distance_transform_edt(np.pad(rooms, 1) > 0)[1:-1, 1:-1] * FINE_M > ROBOT_M
    visited = _visited(plan, settings, rng)
    per_m2 = rng.uniform(settings.scans_min_per_m2, settings.scans_max_per_m2)
    drift_m = rng.uniform(0.0, settings.drift_max_m)
    drift_rad = math.radians(rng.uniform(0.0, settings.drift_max_deg))
    for room in visited:
        at = np.argwhere(clear & (rooms == room))
        off_m, off_rad = rng.normal(0.0, drift_m, 2), rng.normal(0.0, drift_rad)
        count = max(2, round(len(at) * FINE_M**2 * per_m2)) if len(at) else 0
        for row, col in at[rng.integers(len(at), size=count)] if count else ():
            place = np.array([(col + 0.5) * FINE_M, (rooms.shape[0] - row - 0.5) * FINE_M])
            yield Pose(place, off_m + rng.normal(0.0, drift_m / 3, 2), off_rad + rng.normal(0.0, drift_rad / 3))
    for door in plan.opened:
        if set(door.rooms) <= set(visited):
            yield Pose(np.array(door.gap.rect.middle), rng.normal(0.0, drift_m, 2), rng.normal(0.0, drift_rad))


def _visited(plan: Drawn, settings: LaserHome, rng: np.random.Generator) -> list[int]:
    """Return the rooms that the robot goes into: all, or all but one with a single door."""
    ends = [room for door in plan.opened for room in door.rooms]
    leaves = [room for room in sorted(set(ends)) if ends.count(room) == 1]
    skips = chance(settings.unvisited_chance, rng) and len(plan.opened) > 1 and leaves
    skipped = int(rng.choice(leaves)) if skips else 0
    return [room for room in np.unique(plan.floor.rooms).tolist() if room not in (0, skipped)]


def _mapped(world: World, poses: list[Pose], placed: Placed, settings: LaserHome, rng: np.random.Generator) -> Cells:
    """Return the cells (h, w) after all scans: occupied where enough of the rays that reach a cell end in it."""
    range_m = log_uniform(settings.range_min_m, settings.range_max_m, rng)
    scanner = Scanner(settings.rays, range_m, float(rng.uniform(0.0, settings.noise_max_m)), chance(0.5, rng))
    share = rng.uniform(settings.hit_share_min, settings.hit_share_max)
    near = _passed_by(len(poses), settings, rng)
    size = placed.rooms.size
    hits, passes = np.zeros(size, np.int64), np.zeros(size, np.int64)
    for pose, person in zip(poses, near, strict=True):
        turned = float(rng.uniform(0.0, 2 * math.pi))
        angles = np.arange(scanner.rays, dtype=np.float64) * (2 * math.pi / scanner.rays) + turned
        reach_m, came_back = _ranges(world, pose, angles, scanner, rng)
        if person is not None:
            reach_m, came_back = _shadowed(angles, reach_m, came_back, person)
        ended, crossed = _on_cells(pose, angles, reach_m, came_back, placed)
        hits += np.bincount(ended, minlength=size)
        passes += np.bincount(crossed, minlength=size)
    known = hits + passes >= SEEN_TWICE
    occupied = hits > share * (hits + passes)
    return np.where(known, np.where(occupied, OCCUPIED, FREE), UNKNOWN).astype(np.int8).reshape(placed.rooms.shape)


def _passed_by(scans: int, settings: LaserHome, rng: np.random.Generator) -> list[tuple[float, float] | None]:
    """Return for each scan where a person stands, as direction and distance, if one walks by."""
    near: list[tuple[float, float] | None] = [None] * scans
    for _ in range(rng.poisson(settings.people)):
        angle, away_m = rng.uniform(0.0, 2 * math.pi), rng.uniform(0.5, 2.5)
        first = int(rng.integers(scans)) if scans else 0
        for k in range(first, min(first + int(rng.integers(2, 7)), scans)):
            near[k] = (angle + rng.normal(0.0, 0.4), max(away_m + rng.normal(0.0, 0.3), ROBOT_M))
    return near


def _ranges(
    world: World, pose: Pose, angles: Floats, scanner: Scanner, rng: np.random.Generator
) -> tuple[Floats, Mask]:
    """Return how far each ray (k,) goes, and whether it comes back: beyond the plan it rarely does."""
    steps = np.arange(0.0, scanner.range_m, FINE_M * 0.8)
    x = pose.place_m[0] + np.outer(np.cos(angles), steps)
    y = pose.place_m[1] + np.outer(np.sin(angles), steps)
    col = np.floor(x / FINE_M).astype(np.intp)
    row = world.solid.shape[0] - 1 - np.floor(y / FINE_M).astype(np.intp)
    inside = (row >= 0) & (col >= 0) & (row < world.solid.shape[0]) & (col < world.solid.shape[1])
    at = np.where(inside, row * world.solid.shape[1] + col, 0)
    through = rng.random(len(angles)) < THROUGH_GLASS
    met = world.solid.ravel()[at] & inside & ~(world.glass.ravel()[at] & through[:, np.newaxis])
    outside_m = np.where(inside.all(axis=1), np.inf, steps[np.argmin(inside, axis=1)])
    away_m = np.where(rng.random(len(angles)) < FROM_OUTSIDE, rng.uniform(0.2, 4.0, len(angles)), np.inf)
    reach_m = np.where(met.any(axis=1), steps[np.argmax(met, axis=1)], outside_m + away_m)
    came_back = reach_m < scanner.range_m
    noisy_m = np.maximum(reach_m + rng.normal(0.0, scanner.noise_m, len(angles)), 0.0)
    return np.where(came_back, noisy_m, scanner.range_m * scanner.lost_frees), came_back


def _shadowed(angles: Floats, reach_m: Floats, came_back: Mask, person: tuple[float, float]) -> tuple[Floats, Mask]:
    """Return ranges and what came back with a person in the way; not where a ray would free nothing anyway."""
    turn = (angles - person[0] + math.pi) % (2 * math.pi) - math.pi
    before = (np.abs(turn) < math.atan2(PERSON_M, person[1])) & (reach_m > person[1])
    return np.where(before, person[1], reach_m), came_back | before


def _on_cells(
    pose: Pose, angles: Floats, reach_m: Floats, came_back: Mask, placed: Placed
) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return the cells that rays end in, and those that they cross, each once a ray: as the robot takes them to lie."""
    middle = pose.place_m + pose.off_m
    turned = angles + pose.off_rad
    way = np.stack([np.cos(turned), np.sin(turned)], axis=1)
    steps = np.arange(0.0, max(float(reach_m.max()), PASS_M), PASS_M)
    ends = _flat(middle + way * reach_m[:, np.newaxis], placed)
    along = _flat(middle + way[:, np.newaxis] * steps[:, np.newaxis], placed)
    crossed = (steps < reach_m[:, np.newaxis]) & (along >= 0)
    crossed &= ~((along == ends[:, np.newaxis]) & came_back[:, np.newaxis])
    crossed[:, 1:] &= along[:, 1:] != along[:, :-1]
    return ends[came_back & (ends >= 0)], along[crossed]


def _flat(points_m: Floats, placed: Placed) -> NDArray[np.intp]:
    """Return the numbers of the cells that points (..., 2) of the plan lie in, -1 beyond the map."""
    height, width = placed.rooms.shape
    row, col = np.rint(placed.cells_from_plan(points_m.reshape(-1, 2)).T).astype(np.intp)
    inside = (row >= 0) & (col >= 0) & (row < height) & (col < width)
    return np.where(inside, row * width + col, -1).reshape(points_m.shape[:-1])
