"""Doors and halls of an office floor, and the floor itself while it is drawn."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass, field

import numpy as np

from vdoor.synth.canvas import Axis, Rect, fine, square_to
from vdoor.synth.layout import Gap, Groups, placed_door, walls_between
from vdoor.synth.settings import Office

DOUBLE_M = (1.4, 2.0)
OPENING_M = (1.2, 2.6)
BLOCK_M, BLOCK_GAP_M = (0.1, 0.8), (0.45, 1.8)
"""Thickness of what parts a hall, and the openings left in it."""
SCREEN_NEEDS_M, AWAY_M = 4.0, 1.2
"""Least side of rooms with screens in them, and how far these stay away from walls that they do not touch."""


@dataclass
class Sketch:
    """A floor while it is drawn."""

    settings: Office
    rng: np.random.Generator
    wall_m: float
    door_m: float
    jamb_m: tuple[float, float]
    """Wall left beside doors near a corner, least and most."""
    corridors: list[Rect] = field(default_factory=list)
    rooms: list[Rect] = field(default_factory=list)
    halls: list[Rect] = field(default_factory=list)
    """Rooms with wide doors."""
    solids: list[Rect] = field(default_factory=list)
    pits: list[Rect] = field(default_factory=list)
    gaps: list[Gap] = field(default_factory=list)

    def between(self, name: str) -> float:
        """Draw one of the settings that come as `_min_m` and `_max_m`, on the fine raster."""
        return fine(self.rng.uniform(getattr(self.settings, f"{name}_min_m"), getattr(self.settings, f"{name}_max_m")))

    def open_mouth(self, rect: Rect, axis: Axis) -> None:
        """Let a corridor end in an opening of all its width, unless it does so there; `axis` is the corridor's."""
        width_m = rect.sides[1 - axis]
        if any(gap.rect.grown(0.01, 0.01).holds(rect) for gap in self.gaps):
            return
        self.gaps.append(Gap(rect, axis, leaf=False, unsure=width_m >= self.settings.unsure_from_m))

    def chance(self, share: float) -> bool:
        """Whether something of that chance happens."""
        return bool(self.rng.random() < share)


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
    groups = Groups(len(rooms), itertools.pairwise(np.flatnonzero(reached).tolist()))
    for n in sketch.rng.permutation(len(pairs)).tolist():
        a, b, wall = pairs[n]
        if groups.apart(a, b) or sketch.chance(settings.extra_door_chance):
            _add(sketch, _door(sketch, wall, hall=False))
            groups.join(a, b)


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


def end_hall(sketch: Sketch, column: Rect, mains: list[Rect], mouth: float) -> None:
    """Add a hall that the main corridors run into, in all their width."""
    sketch.halls.append(column)
    for main in mains:
        rect = Rect((mouth, main.low[1]), (fine(mouth + sketch.wall_m), main.high[1]))
        sketch.open_mouth(rect, 0)


def open_hall(sketch: Sketch, hall: Rect, mains: tuple[Rect, Rect]) -> None:
    """Add a hall that takes in the main corridor below or above, or both; people part it where that goes on."""
    wall = sketch.wall_m
    for main in mains[: 1 + sketch.chance(0.4)] if sketch.chance(0.5) else mains[1:]:
        hall = hall.spanning(1, min(hall.low[1], main.low[1]), max(hall.high[1], main.high[1]))
        for x, beyond_m in ((fine(hall.low[0] - wall), -1.0), (hall.high[0], 1.0)):
            mouth = Rect((x, main.low[1]), (fine(x + wall), main.high[1]))
            if main.low[0] < mouth.middle[0] + beyond_m < main.high[0]:
                sketch.solids.append(mouth)
                sketch.open_mouth(mouth, 0)
    sketch.corridors.append(hall)


def divide_hall(sketch: Sketch, hall: Rect) -> None:
    """Part a hall by a row of blocks with openings between them, through all of which one can walk."""
    rng = sketch.rng
    along: Axis = 0 if hall.sides[0] < hall.sides[1] else 1
    across = square_to(along)
    at = fine(hall.low[across] + hall.sides[across] * rng.uniform(0.3, 0.7))
    row = hall.spanning(across, at, fine(at + rng.uniform(*BLOCK_M)))
    count = int(rng.integers(1, 6))
    share = hall.sides[along] / count
    if share < BLOCK_GAP_M[1] + 0.5:
        return
    sketch.solids.append(row)
    for k in range(count):
        width = fine(rng.uniform(*BLOCK_GAP_M))
        low = fine(row.low[along] + k * share + rng.uniform(0.1, share - width - 0.1))
        sketch.gaps.append(Gap(row, across).in_wall(low, width, leaf=False))


def put_screens(sketch: Sketch) -> None:
    """Put walls into large rooms that part nothing: most of the way past their ends is open."""
    for floor in sketch.rooms + sketch.halls + sketch.corridors:
        if min(floor.sides) > SCREEN_NEEDS_M and sketch.chance(sketch.settings.screen_chance):
            screen = _screen(floor, sketch)
            near = [gap.clear(1.0, 0.1) for gap in sketch.gaps] + [solid.grown(0.6, 0.6) for solid in sketch.solids]
            if not any(screen.overlaps(rect) for rect in near):
                sketch.solids.append(screen)


def _screen(floor: Rect, sketch: Sketch) -> Rect:
    """Return a short thin wall on a floor, free or from one of its walls on."""
    rng = sketch.rng
    along: Axis = 0 if sketch.chance(0.5) else 1
    across = square_to(along)
    length = fine(rng.uniform(0.6, min(3.0, 0.4 * floor.sides[along])))
    beside_m = 0.0 if sketch.chance(0.4) else AWAY_M
    low = fine(rng.uniform(floor.low[along] + beside_m, floor.high[along] - beside_m - length))
    if not beside_m:
        low = floor.low[along] if sketch.chance(0.5) else fine(floor.high[along] - length)
    at = fine(rng.uniform(floor.low[across] + AWAY_M, floor.high[across] - AWAY_M - 0.2))
    return floor.spanning(along, low, fine(low + length)).spanning(across, at, fine(at + rng.uniform(0.05, 0.25)))
