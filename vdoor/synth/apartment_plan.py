"""The plan of an apartment: rooms by recursive subdivision, joined by doors, and furniture. In metres, y up."""

from __future__ import annotations

import functools
import itertools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import scipy

from vdoor.errors import SettingError
from vdoor.synth.canvas import FINE_M, LATTICE_M, Axis, Rect, lattice_range, snap, square_to
from vdoor.synth.layout import Gap, Groups, Opened, placed_door, walls_between
from vdoor.synth.settings import Apartment, chance

PLAN_TRIES = 300
NEAR_CORNER_M = 0.2
CORRIDOR_NEEDS_ROOMS = 4
PIECE_TRIES = 12
ROOM_TO_PASS_M = 0.34
"""Half the width of the passage left to every door: any 20 cm cell that holds a point so far from furniture and its
roughness (5 cm) is free, however the map is turned: 0.2 m times the square root of 2 is 0.283 m."""
BESIDE_DOOR_M = 0.3
AROUND_FREE_M = 0.45
NICHE_M = 0.5
"""Nothing stands so near to a corner, or to its neighbour on the same wall: it is pushed into the corner."""
LEG_M = 0.05
LEGS_CHANCE = 0.3
LEGS_FROM_M = 0.4


@dataclass(frozen=True)
class Plan:
    """Rooms (their free floor), the doors between them, and what is around: `shell` is the outer walls' outside."""

    rooms: tuple[Rect, ...]
    """Numbered from 1 in this order."""
    doors: tuple[Opened, ...]
    inside: Rect
    shell: Rect
    size_m: tuple[float, float]
    """Of all that is drawn, with the margin around the shell."""


def draw_plan(settings: Apartment, rng: np.random.Generator) -> Plan:
    """Return a plan whose rooms are all joined by doors.

    Raises `SettingError` if so many rooms of that size do not fit.
    """
    for _ in range(PLAN_TRIES):
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
            return Plan(tuple(rooms), tuple(doors), inside, shell, far)
    raise SettingError(
        f"Apartment.rooms: wanted {settings.rooms} rooms of at least {settings.room_side_min_m:g} m "
        f"a side in {settings.area_m2:g} m2, found no plan in {PLAN_TRIES} tries"
    )


def _between(low_m: float, high_m: float, rng: np.random.Generator) -> float:
    """Draw a multiple of the lattice between the two, both included."""
    return float(rng.choice(lattice_range(low_m, high_m))) * LATTICE_M


def _subdivide(inside: Rect, count: int, settings: Apartment, rng: np.random.Generator) -> tuple[list[Rect], bool]:
    """Return up to `count` rooms, fewer where they do not fit, and whether the first of them is a corridor."""
    rooms: list[Rect] = []
    parts = [inside]
    if count >= CORRIDOR_NEEDS_ROOMS and chance(settings.corridor_chance, rng):
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


def _join(rooms: Sequence[Rect], corridor: bool, settings: Apartment, rng: np.random.Generator) -> list[Opened] | None:
    """Return the doors of a random spanning tree and a few more, or None if some room has no wall for a door.

    Doors to the corridor (the first room) come before others, as in homes.
    """
    needs_m = settings.door_max_m + 2 * settings.jamb_m
    walls = [
        (pair, wall)
        for pair in itertools.combinations(range(len(rooms)), 2)
        for wall in walls_between(rooms[pair[0]], rooms[pair[1]], settings.wall_max_m, needs_m)
    ]
    rank = [rng.random() + (0 if corridor and 0 in pair else 1) for pair, _ in walls]
    groups = Groups(len(rooms))
    doors = []
    for k in np.argsort(rank, kind="stable"):
        pair, wall = walls[k]
        if groups.apart(*pair) or chance(settings.extra_door_chance, rng):
            lower, upper = sorted(pair, key=lambda room: rooms[room].low[wall.axis])
            doors.append(Opened(_door(wall, settings, rng), (lower + 1, upper + 1)))
            groups.join(*pair)
    return doors if groups.all_joined(range(len(rooms))) else None


def _door(wall: Gap, settings: Apartment, rng: np.random.Generator) -> Gap:
    """Return a door somewhere in a wall, mostly near one of its ends."""
    width = _between(settings.door_min_m, settings.door_max_m, rng)
    jamb = math.ceil(settings.jamb_m / LATTICE_M - 1e-6) * LATTICE_M
    corner, near = settings.door_corner_chance, (jamb, jamb + NEAR_CORNER_M)
    return placed_door(wall, width, rng, jamb_m=near, corner=corner, snapped=snap)


@dataclass(frozen=True)
class Piece:
    """One piece of furniture: its outline, what of it meets the floor, and the space it needs around it."""

    body: Rect
    parts: tuple[Rect, ...]
    space: Rect
    against_wall: bool


def furnish(plan: Plan, settings: Apartment, rng: np.random.Generator) -> list[Rect]:
    """Return what stands on the floor of all rooms; nothing if furniture is off."""
    if not settings.furniture:
        return []
    return [
        part
        for number, floor in enumerate(plan.rooms, start=1)
        for piece in _furnish_room(floor, [door.gap for door in plan.doors if number in door.rooms], settings, rng)
        for part in piece.parts
    ]


def _furnish_room(floor: Rect, doors: Sequence[Gap], settings: Apartment, rng: np.random.Generator) -> list[Piece]:
    """Return the pieces of one room, those against walls first."""
    keep_out = [door.clear(settings.door_clear_m, BESIDE_DOOR_M) for door in doors]
    propose: list[Callable[[], Piece]] = []
    propose += [functools.partial(_against_wall, floor, settings.aisle_m, rng)] * int(
        rng.poisson(settings.wall_pieces_per_m2 * floor.area)
    )
    propose += [functools.partial(_free_standing, floor, rng)] * int(
        rng.poisson(settings.free_pieces_per_m2 * floor.area)
    )
    kept: list[Piece] = []
    for make in propose:
        for piece in (make() for _ in range(PIECE_TRIES)):
            if (
                floor.holds(piece.space)
                and not any(piece.body.overlaps(zone) for zone in keep_out)
                and not any(_crowds(piece, other) for other in kept)
                and _passable(floor, doors, [*kept, piece])
            ):
                kept.append(piece)
                break
    return kept


def _against_wall(floor: Rect, aisle_m: float, rng: np.random.Generator) -> Piece:
    """Return a cupboard, sofa or bed along one of the four walls, with the aisle in front of it as its space."""
    along: Axis = 0 if chance(0.5, rng) else 1  # either wall
    across = square_to(along)
    length, depth = snap(rng.uniform(0.4, 2.0)), snap(rng.uniform(0.3, 0.8))
    slack = floor.sides[along] - length
    offset = rng.uniform(0.0, 1.0) * slack
    offset = 0.0 if offset < NICHE_M else slack if slack - offset < NICHE_M else offset
    start = snap(floor.low[along] + offset)
    strip = floor.spanning(along, start, snap(start + length))
    beside = floor.spanning(
        along, max(start - NICHE_M, floor.low[along]), min(start + length + NICHE_M, floor.high[along])
    )
    low, high = floor.low[across], floor.high[across]
    if chance(0.5, rng):  # either side
        body, space = (low, snap(low + depth)), (low, low + depth + aisle_m)
    else:
        body, space = (snap(high - depth), high), (high - depth - aisle_m, high)
    outline = strip.spanning(across, *body)
    return Piece(outline, (outline,), beside.spanning(across, *space), against_wall=True)


def _free_standing(floor: Rect, rng: np.random.Generator) -> Piece:
    """Return a stool, a box or a table, away from the walls; some meet the floor with four legs only.

    None is over 0.8 m a side, so that at 20 cm it covers at most 1 m.
    """
    sides = [snap(rng.uniform(0.1, 0.8)) for _ in range(2)]
    at = [snap(floor.low[k] + rng.uniform(0.0, 1.0) * max(0.0, floor.sides[k] - sides[k])) for k in (0, 1)]
    body = Rect((at[0], at[1]), (snap(at[0] + sides[0]), snap(at[1] + sides[1])))
    parts: tuple[Rect, ...] = (body,)
    if chance(LEGS_CHANCE, rng) and min(sides) >= LEGS_FROM_M:
        lefts, lows = ((body.low[k], snap(body.high[k] - LEG_M)) for k in (0, 1))
        parts = tuple(Rect((x, y), (x + LEG_M, y + LEG_M)) for x in lefts for y in lows)
    return Piece(body, parts, body.grown(AROUND_FREE_M, AROUND_FREE_M), against_wall=False)


def _crowds(piece: Piece, other: Piece) -> bool:
    """Whether a new piece takes another's place; what stands free may stand in an aisle."""
    return piece.space.overlaps(other.body) or (piece.against_wall and other.space.overlaps(piece.body))


def _passable(floor: Rect, doors: Sequence[Gap], pieces: Sequence[Piece]) -> bool:
    """Whether one can walk between all doors of a room and to most of its floor."""
    shape = round(floor.sides[0] / FINE_M), round(floor.sides[1] / FINE_M)
    open_floor = np.pad(np.ones(shape, dtype=np.bool_), 1)  # x first; the border is the wall
    empty = int((scipy.ndimage.distance_transform_edt(open_floor) * FINE_M >= ROOM_TO_PASS_M).sum())
    for piece in pieces:
        low, high = (
            tuple(1 + round((corner[k] - floor.low[k]) / FINE_M) for k in (0, 1))
            for corner in (piece.body.low, piece.body.high)
        )
        open_floor[low[0] : high[0], low[1] : high[1]] = False
    walkable, _ = scipy.ndimage.label(scipy.ndimage.distance_transform_edt(open_floor) * FINE_M >= ROOM_TO_PASS_M)
    met = {int(walkable[_before(door, floor)]) for door in doors}
    reached = int((walkable == min(met)).sum()) if met else empty
    return len(met) <= 1 and 0 not in met and reached >= empty / 2


def _before(door: Gap, floor: Rect) -> tuple[int, int]:
    """Return the cell of the padded floor that lies 0.4 m before a door's middle."""
    point = list(door.rect.middle)
    low, high = floor.low[door.axis], floor.high[door.axis]
    point[door.axis] = low + 0.4 if point[door.axis] < low else high - 0.4
    return int(1 + (point[0] - floor.low[0]) / FINE_M), int(1 + (point[1] - floor.low[1]) / FINE_M)
