"""Furniture: pieces against walls and free-standing ones, none of which bars the way to a door."""

from __future__ import annotations

import functools
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy import ndimage

from vdoor.synth.canvas import FINE_M, Axis, Rect, snap, square_to
from vdoor.synth.plan import Door, Plan
from vdoor.synth.settings import Apartment

TRIES = 12
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
        for room in range(len(plan.rooms))
        for piece in _furnish_room(plan, room, settings, rng)
        for part in piece.parts
    ]


def _furnish_room(plan: Plan, room: int, settings: Apartment, rng: np.random.Generator) -> list[Piece]:
    """Return the pieces of one room, those against walls first."""
    floor = plan.rooms[room]
    doors = [door for door in plan.doors if room in door.rooms]
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
        for piece in (make() for _ in range(TRIES)):
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
    along: Axis = 0 if rng.random() < 0.5 else 1  # noqa: PLR2004  # either wall
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
    if rng.random() < 0.5:  # noqa: PLR2004  # either side
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
    if rng.random() < LEGS_CHANCE and min(sides) >= LEGS_FROM_M:
        lefts, lows = ((body.low[k], snap(body.high[k] - LEG_M)) for k in (0, 1))
        parts = tuple(Rect((x, y), (x + LEG_M, y + LEG_M)) for x in lefts for y in lows)
    return Piece(body, parts, body.grown(AROUND_FREE_M, AROUND_FREE_M), against_wall=False)


def _crowds(piece: Piece, other: Piece) -> bool:
    """Whether a new piece takes another's place; what stands free may stand in an aisle."""
    return piece.space.overlaps(other.body) or (piece.against_wall and other.space.overlaps(piece.body))


def _passable(floor: Rect, doors: Sequence[Door], pieces: Sequence[Piece]) -> bool:
    """Whether one can walk between all doors of a room and to most of its floor."""
    shape = round(floor.sides[0] / FINE_M), round(floor.sides[1] / FINE_M)
    open_floor = np.pad(np.ones(shape, dtype=np.bool_), 1)  # x first; the border is the wall
    empty = int((ndimage.distance_transform_edt(open_floor) * FINE_M >= ROOM_TO_PASS_M).sum())
    for piece in pieces:
        low, high = (
            tuple(1 + round((corner[k] - floor.low[k]) / FINE_M) for k in (0, 1))
            for corner in (piece.body.low, piece.body.high)
        )
        open_floor[low[0] : high[0], low[1] : high[1]] = False
    walkable, _ = ndimage.label(ndimage.distance_transform_edt(open_floor) * FINE_M >= ROOM_TO_PASS_M)
    met = {int(walkable[_before(door, floor)]) for door in doors}
    reached = int((walkable == min(met)).sum()) if met else empty
    return len(met) <= 1 and 0 not in met and reached >= empty / 2


def _before(door: Door, floor: Rect) -> tuple[int, int]:
    """Return the cell of the padded floor that lies 0.4 m before a door's middle."""
    point = list(door.gap.middle)
    low, high = floor.low[door.axis], floor.high[door.axis]
    point[door.axis] = low + 0.4 if point[door.axis] < low else high - 0.4
    return int(1 + (point[0] - floor.low[0]) / FINE_M), int(1 + (point[1] - floor.low[1]) / FINE_M)
