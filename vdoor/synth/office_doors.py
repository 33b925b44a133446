"""Doors of an office floor: of rooms, between rooms, and across corridors."""

from __future__ import annotations

import itertools
import math

import numpy as np

from vdoor.synth.canvas import Axis, fine
from vdoor.synth.layout import Gap, connected, placed_door, walls_between
from vdoor.synth.office_sketch import Sketch

DOUBLE_M = (1.4, 2.0)
OPENING_M = (1.2, 2.6)


def add_doors(sketch: Sketch) -> None:
    """Give every room a door: to a corridor where it has one, else to a neighbour; and some a second one."""
    settings, corridors = sketch.settings, sketch.corridors
    needs = DOUBLE_M[1] + 2 * sketch.jamb_m[0]
    rooms = sketch.rooms + sketch.halls
    reached = []
    for k, room in enumerate(rooms):
        hall = k >= len(sketch.rooms)
        walls = [wall for corridor in corridors for wall in walls_between(room, corridor, sketch.wall_m, needs)]
        count = (2 if hall else 1) + sketch.chance(0.5 if hall else settings.extra_door_chance)
        order = sketch.rng.permutation(len(walls))[:count].tolist()
        for n in order:
            _add(sketch, _door(sketch, walls[n], hall=hall))
        reached.append(bool(walls))
    pairs = [
        (a, b, wall)
        for a, b in itertools.combinations(range(len(rooms)), 2)
        for wall in walls_between(rooms[a], rooms[b], sketch.wall_m, needs)
    ]
    group = connected(len(rooms), list(itertools.pairwise(np.flatnonzero(reached).tolist())))
    for n in sketch.rng.permutation(len(pairs)).tolist():
        a, b, wall = pairs[n]
        if group[a] != group[b] or sketch.chance(settings.extra_door_chance):
            _add(sketch, _door(sketch, wall, hall=False))
            group = [group[b] if g == group[a] else g for g in group]


def _add(sketch: Sketch, gap: Gap) -> None:
    """Add a door, unless there is one already where two corridors meet along the same wall."""
    if not any(gap.rect.grown(0.3, 0.3).overlaps(other.rect) for other in sketch.gaps):
        sketch.gaps.append(gap)


def _door(sketch: Sketch, wall: Gap, *, hall: bool) -> Gap:
    """Return a door in a wall: of the floor's usual width, double, or an opening."""
    settings, rng = sketch.settings, sketch.rng
    if not hall and sketch.chance(settings.open_chance):
        width = fine(rng.uniform(OPENING_M[0], min(OPENING_M[1], wall.rect.sides[wall.along] - 2 * sketch.jamb_m[0])))
        gap = placed_door(wall, width, rng, jamb_m=sketch.jamb_m, corner=0.5)
        return Gap(gap.rect, gap.axis, leaf=False, unsure=width >= settings.unsure_from_m)
    width = sketch.between("door") if sketch.chance(0.15) else sketch.door_m
    if sketch.chance(0.6 if hall else settings.double_chance):
        width = fine(rng.uniform(*DOUBLE_M))
    return placed_door(wall, width, rng, jamb_m=sketch.jamb_m, corner=settings.door_corner_chance)


def close_corridors(sketch: Sketch) -> None:
    """Put doors across corridors, clear of all other doors and of corners."""
    rng = sketch.rng
    for corridor in [corridor for corridor in sketch.corridors if max(corridor.sides) > 4 * min(corridor.sides)]:
        along: Axis = 0 if corridor.sides[0] > corridor.sides[1] else 1
        for _ in range(max(1, math.floor(corridor.sides[along] / 20.0))):
            at = fine(rng.uniform(corridor.low[along] + 2.0, corridor.high[along] - 2.0))
            wall = corridor.spanning(along, at, fine(at + 0.15))
            wide = Gap(wall, along).clear(1.0, sketch.wall_m)
            others = [other for other in sketch.corridors if other is not corridor]
            if sketch.chance(sketch.settings.corridor_door_chance) and not any(
                wide.overlaps(rect) for rect in others + [gap.rect for gap in sketch.gaps] + sketch.solids
            ):
                sketch.solids.append(wall)
                width = fine(min(corridor.sides[1 - along] - 0.2, rng.choice([sketch.door_m, 1.6])))
                sketch.gaps.append(placed_door(Gap(wall, along), width, rng, jamb_m=sketch.jamb_m, corner=0.2))
