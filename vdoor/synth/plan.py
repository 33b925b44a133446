"""The floor plan: rooms by recursive subdivision, joined by doors. All lengths in metres, x right, y up."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from vdoor.errors import SettingError
from vdoor.synth.canvas import LATTICE_M, Axis, Rect, lattice_range, snap, square_to
from vdoor.synth.settings import Apartment

TRIES = 300
NEAR_CORNER_M = 0.2
CORRIDOR_NEEDS_ROOMS = 4


@dataclass(frozen=True)
class Door:
    """A gap through the wall between two rooms: `rooms` are their places in the plan, lower side first."""

    rooms: tuple[int, int]
    gap: Rect
    axis: Axis
    """Along which one walks through it."""

    def clear(self, depth_m: float, beside_m: float = 0.0) -> Rect:
        """Return the gap with the space `depth_m` before both sides of it, and `beside_m` more of the wall."""
        return self.gap.grown(depth_m, beside_m) if self.axis == 0 else self.gap.grown(beside_m, depth_m)


@dataclass(frozen=True)
class Plan:
    """Rooms (their free floor), the doors between them, and what is around: `shell` is the outer walls' outside."""

    rooms: tuple[Rect, ...]
    doors: tuple[Door, ...]
    inside: Rect
    shell: Rect
    sheet: Rect
    """All that is drawn: the shell and its margin, from (0, 0)."""


def draw_plan(settings: Apartment, rng: np.random.Generator) -> Plan:
    """Return a plan whose rooms are all joined by doors.

    Raises `SettingError` if so many rooms of that size do not fit.
    """
    for _ in range(TRIES):
        count = int(rng.integers(settings.rooms - settings.rooms_spread, settings.rooms + settings.rooms_spread + 1))
        long_m = math.sqrt(settings.area_m2 * rng.uniform(1.0, settings.aspect_max))
        sides = snap(long_m), snap(settings.area_m2 / long_m)
        start = snap(settings.margin_m) + (wall := _between(settings.wall_min_m, settings.wall_max_m, rng))
        inside = Rect((start, start), (snap(start + sides[0]), snap(start + sides[1])))
        rooms, corridor = _subdivide(inside, count, settings, rng)
        doors = _join(rooms, corridor, settings, rng)
        if len(rooms) == count and doors is not None:
            shell = inside.grown(wall, wall)
            far = shell.grown(snap(settings.margin_m), snap(settings.margin_m)).high
            return Plan(tuple(rooms), tuple(doors), inside, shell, Rect((0.0, 0.0), far))
    raise SettingError(
        f"Apartment.rooms: wanted {settings.rooms} rooms of at least {settings.room_side_min_m:g} m "
        f"a side in {settings.area_m2:g} m2, found no plan in {TRIES} tries"
    )


def _between(low_m: float, high_m: float, rng: np.random.Generator) -> float:
    """Draw a multiple of the lattice between the two, both included."""
    return float(rng.choice(lattice_range(low_m, high_m))) * LATTICE_M


def _subdivide(inside: Rect, count: int, settings: Apartment, rng: np.random.Generator) -> tuple[list[Rect], bool]:
    """Return up to `count` rooms, fewer where they do not fit, and whether the first of them is a corridor."""
    rooms: list[Rect] = []
    parts = [inside]
    if count >= CORRIDOR_NEEDS_ROOMS and rng.random() < settings.corridor_chance:
        axis: Axis = 1 if inside.sides[0] >= inside.sides[1] else 0
        width = _between(settings.corridor_min_m, settings.corridor_max_m, rng)
        wall = _between(settings.wall_min_m, settings.wall_max_m, rng)
        if len(sides := _cut(inside, axis, width + 2 * wall, settings, rng)) > 1:
            parts = sides
            rooms = [inside.spanning(axis, snap(parts[0].high[axis] + wall), snap(parts[1].low[axis] - wall))]
    corridor = bool(rooms)
    while len(rooms) + len(parts) < count:
        largest = max(parts, key=lambda part: part.area * rng.uniform(0.7, 1.3))
        axis = int(largest.sides[1] > largest.sides[0] * rng.uniform(0.8, 1.25))  # type: ignore[assignment]  # 0 or 1
        pieces = _cut(largest, axis, _between(settings.wall_min_m, settings.wall_max_m, rng), settings, rng)
        if len(pieces) == 1:
            break
        parts = [part for part in parts if part is not largest] + pieces
    return rooms + parts, corridor


def _cut(part: Rect, axis: Axis, gap_m: float, settings: Apartment, rng: np.random.Generator) -> list[Rect]:
    """Return two pieces of `part`, `gap_m` apart along `axis`, or the whole if a piece would be too small."""
    left_m = part.sides[axis] - gap_m
    at_m = snap(left_m * rng.uniform(0.35, 0.65))
    if min(at_m, left_m - at_m) < settings.room_side_min_m:
        return [part]
    low, high = part.low[axis], part.high[axis]
    return [part.spanning(axis, low, snap(low + at_m)), part.spanning(axis, snap(low + at_m + gap_m), high)]


def _join(rooms: Sequence[Rect], corridor: bool, settings: Apartment, rng: np.random.Generator) -> list[Door] | None:
    """Return the doors of a random spanning tree and a few more, or None if some room has no wall for a door.

    Doors to the corridor (the first room) come before others, as in homes.
    """
    walls = [
        wall for pair in itertools.combinations(range(len(rooms)), 2) for wall in _shared_walls(rooms, pair, settings)
    ]
    rank = [rng.random() + (0 if corridor and 0 in wall.rooms else 1) for wall in walls]
    group = list(range(len(rooms)))
    doors = []
    for k in np.argsort(rank, kind="stable"):
        a, b = (group[room] for room in walls[k].rooms)
        if a != b or rng.random() < settings.extra_door_chance:
            doors.append(_place(walls[k], settings, rng))
            group = [a if g == b else g for g in group]
    return doors if len(set(group)) == 1 else None


def _shared_walls(rooms: Sequence[Rect], pair: tuple[int, int], settings: Apartment) -> Iterator[Door]:
    """Yield the wall between two rooms as one wide gap, if it can hold the widest door and its jambs."""
    axes: tuple[Axis, Axis] = (0, 1)
    for axis, (a, b) in itertools.product(axes, (pair, pair[::-1])):
        along = square_to(axis)
        faces = rooms[a].high[axis], rooms[b].low[axis]
        low, high = max(rooms[k].low[along] for k in pair), min(rooms[k].high[along] for k in pair)
        near = 0.0 < faces[1] - faces[0] <= settings.wall_max_m + 1e-6
        if near and high - low >= settings.door_max_m + 2 * settings.jamb_m - 1e-6:
            yield Door((a, b), rooms[a].spanning(axis, *faces).spanning(along, low, high), axis)


def _place(wall: Door, settings: Apartment, rng: np.random.Generator) -> Door:
    """Return a door somewhere in a shared wall, mostly near one of its ends."""
    along = square_to(wall.axis)
    width = _between(settings.door_min_m, settings.door_max_m, rng)
    jamb = math.ceil(settings.jamb_m / LATTICE_M - 1e-6) * LATTICE_M
    slack = max(0.0, wall.gap.sides[along] - 2 * jamb - width)
    offset = rng.uniform(0.0, slack)
    if rng.random() < settings.door_corner_chance:
        offset = min(rng.uniform(0.0, NEAR_CORNER_M), slack)
        offset = offset if rng.random() < 0.5 else slack - offset  # noqa: PLR2004  # either end
    low = snap(wall.gap.low[along] + jamb + offset)
    return Door(wall.rooms, wall.gap.spanning(along, low, snap(low + width)), wall.axis)
