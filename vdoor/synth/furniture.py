"""What stands on the floors of homes and offices: furniture, clutter, open doors; none of it cuts a door off."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import scipy

from vdoor.synth.canvas import Axis, Canvas, Rect, Shape, around, box, fine, square_to, turned_box
from vdoor.synth.layout import Drawn, Gap
from vdoor.synth.settings import chance

LEAF_M = 0.05
PASSAGE_M = 0.6
"""Left free in front of what stands against a wall."""
Span = tuple[float, float]
"""Least and most of a length in metres."""


def against_wall(
    floor: Rect, length_m: Span, depth_m: Span, rng: np.random.Generator, *, jagged_chance: float = 0.0
) -> list[Rect]:
    """Return a piece along one of the walls, often in a corner: nothing where it would leave no passage.

    A jagged one has a front of several depths, as where things stand side by side.
    """
    along: Axis = 0 if chance(0.5, rng) else 1  # either wall
    across = square_to(along)
    length, depth = fine(rng.uniform(*length_m)), fine(rng.uniform(*depth_m))
    slack = floor.sides[along] - length
    if slack < 0 or floor.sides[across] - depth < PASSAGE_M:
        return []
    offset = rng.uniform(-0.3, 1.3) * slack  # what would go through a wall stands in the corner
    start = fine(floor.low[along] + min(max(offset, 0.0), slack))
    upper = chance(0.5, rng)  # either side
    count = int(rng.integers(2, 6)) if chance(jagged_chance, rng) else 1
    bounds = [start, *np.sort(rng.uniform(start, start + length, size=count - 1)).tolist(), start + length]
    depths = depth * rng.uniform(0.4, 1.0, size=count) if count > 1 else [depth]
    low, high = floor.low[across], floor.high[across]
    return [
        floor.spanning(along, fine(one), fine(two)).spanning(
            across, *((fine(high - deep), high) if upper else (low, fine(low + deep)))
        )
        for one, two, deep in zip(bounds[:-1], bounds[1:], depths, strict=True)
    ]


def free_standing(floor: Rect, side_m: Span, rng: np.random.Generator, *, turned_chance: float) -> Shape | None:
    """Return a box away from the walls, turned or not, or None where the floor is too small."""
    sides = rng.uniform(*side_m), rng.uniform(*side_m)
    room = [floor.sides[k] - sides[k] - 2 * 0.4 for k in (0, 1)]
    if min(room) < 0:
        return None
    x, y = (floor.low[k] + 0.4 + sides[k] / 2 + rng.uniform(0.0, 1.0) * room[k] for k in (0, 1))
    return turned_box((x, y), sides, rng.uniform(0.0, math.pi) if chance(turned_chance, rng) else 0.0)


def legs(outline: Shape, leg_m: float) -> list[Shape]:
    """Return what touches the floor of a table or chair of that outline."""
    middle = outline.mean(axis=0)
    return [turned_box(tuple(middle + 0.9 * (corner - middle)), (leg_m, leg_m)) for corner in outline]


def clutter(floor: Rect, rng: np.random.Generator) -> Shape:
    """Return something small anywhere on a floor."""
    x, y = (rng.uniform(floor.low[k], floor.high[k]) for k in (0, 1))
    if chance(0.2, rng):  # a cable, a broom
        return turned_box((x, y), (rng.uniform(0.2, 0.7), LEAF_M), rng.uniform(0.0, math.pi))
    return turned_box((x, y), (rng.uniform(0.04, 0.14), rng.uniform(0.04, 0.14)), rng.uniform(0.0, math.pi))


def shaft(floor: Rect, rng: np.random.Generator) -> list[Rect]:
    """Return a box in a corner of a room, or on one of its walls."""
    if chance(0.3, rng):  # not in the corner
        return against_wall(floor, (0.2, 0.8), (0.1, 0.4), rng)
    sides = [min(fine(rng.uniform(0.2, 0.9)), floor.sides[k] / 3) for k in (0, 1)]
    low = [floor.low[k] if chance(0.5, rng) else floor.high[k] - sides[k] for k in (0, 1)]
    return [Rect((low[0], low[1]), (low[0] + sides[0], low[1] + sides[1]))]


def leaf(gap: Gap, rng: np.random.Generator) -> Shape:
    """Return a door's open leaf: from one jamb into one of the rooms, mostly at a right angle to the wall."""
    sign, end = (1 if chance(0.5, rng) else -1 for _ in range(2))  # either
    angle = math.pi / 2 + rng.normal(0.0, 0.12) if chance(0.7, rng) else rng.uniform(1.05, 2.6)
    face = (gap.rect.high if sign > 0 else gap.rect.low)[gap.axis]
    hinge = (gap.rect.high if end > 0 else gap.rect.low)[gap.along] - end * LEAF_M / 2
    way = np.array([math.sin(angle) * sign, -math.cos(angle) * end])  # across and along the wall; 0 would be shut
    length = 0.95 * gap.width_m
    middle = np.array([face, hinge]) + way * length / 2
    if gap.axis == 1:
        middle, way = middle[::-1], way[::-1]
    return turned_box((middle[0], middle[1]), (length, LEAF_M), math.atan2(way[1], way[0]))


def niche(gap: Gap, rng: np.random.Generator) -> list[Shape]:
    """Return what stands beside a door on one side of the wall, flush with a jamb, or with both."""
    sign = 1 if chance(0.5, rng) else -1  # either
    face = (gap.rect.high if sign > 0 else gap.rect.low)[gap.axis]
    ends = [-1, 1] if chance(0.3, rng) else [1 if chance(0.5, rng) else -1]
    depth = fine(rng.uniform(0.1, 0.6))
    found = []
    for end in ends:
        at, length = (gap.rect.high if end > 0 else gap.rect.low)[gap.along], fine(rng.uniform(0.1, 0.6))
        outer = sorted((at, at + end * length)), sorted((face, face + sign * depth))
        found.append(box(gap.rect.spanning(gap.along, *outer[0]).spanning(gap.axis, *outer[1])))
    return found


def clear_of(shape: Shape, zones: Sequence[Rect]) -> bool:
    """Whether the box around a shape overlaps none of the zones."""
    return not any(around(shape).overlaps(zone) for zone in zones)


def keep_passable(plan: Drawn, things: Sequence[tuple[Rect, Shape]]) -> None:
    """Block the canvas with things (each with the floor it stands on), but no floor's where that cuts a door off."""
    canvas, opened = plan.canvas, plan.opened
    banned: set[Rect] = set()
    for _ in range(4):
        canvas.rooms[:] = plan.floor.rooms
        for floor, shape in things:
            if floor not in banned:
                canvas.block(shape)
        part, _ = scipy.ndimage.label(canvas.rooms[::2, ::2])
        small = Canvas(part.astype(np.int32))
        met = [_parts_before(small, door.gap) for door in opened]
        counts = np.bincount([part for parts in met for part in parts], minlength=2)
        counts[0] = 0
        main = int(counts.argmax())
        cut = [door.gap for door, parts in zip(opened, met, strict=True) if parts != (main, main)]
        more = {floor for floor, _ in things if any(floor.overlaps(gap.clear(0.3)) for gap in cut)} - banned
        if not more:
            return
        banned |= more


def _parts_before(half: Canvas, gap: Gap) -> tuple[int, int]:
    """Return what is 20 cm before both sides of a gap, on a canvas of half the resolution."""
    below, above = (tuple(x / 2 for x in gap.before(sign, 0.2)) for sign in (-1, 1))
    return half.at((below[0], below[1])), half.at((above[0], above[1]))
