"""What an office floor is made of: rows of rooms, blocks between corridors, halls, doors."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass, field

import numpy as np

from vdoor.synth.canvas import Axis, Rect, fine, square_to
from vdoor.synth.layout import Gap, Groups, placed_door, walls_between
from vdoor.synth.settings import Office, chance

DOUBLE_M = (1.4, 2.0)
OPENING_M = (1.2, 2.6)
BLOCK_M, BLOCK_GAP_M = (0.1, 0.8), (0.45, 1.8)
"""Thickness of what parts a hall, and the openings left in it."""
SCREEN_NEEDS_M, AWAY_M = 4.0, 1.2
"""Least side of rooms with screens in them, and how far these stay away from walls that they do not touch."""
CUBICLE_M = (2.0, 3.6)
CUBICLE_GAP_M = (0.9, 2.4)
INSIDE = (("two rows", 0.4), ("one row", 0.15), ("halls", 0.2), ("open", 0.04), ("cubicles", 0.16), ("yard", 0.15))
"""What lies between corridors, and how often."""


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
        return chance(share, self.rng)


def add_outer_row(sketch: Sketch, rect: Rect, along: Axis) -> None:
    """Add a row of rooms along the outer wall, in some floors without part of it."""
    rooms = _row(sketch, rect, along)
    if sketch.chance(sketch.settings.notch_chance):
        missing = max(1, int(len(rooms) * sketch.rng.uniform(0.1, 0.6)))
        starts = (0, len(rooms) - missing, int(sketch.rng.integers(len(rooms) - missing + 1)))
        first = starts[int(sketch.rng.integers(3))]
        rooms = rooms[:first] + rooms[first + missing :]
    sketch.rooms += rooms


def _row(sketch: Sketch, rect: Rect, along: Axis) -> list[Rect]:
    """Return a strip as a row of rooms: mostly alike, in some floors not."""
    settings, rng = sketch.settings, sketch.rng
    usual = sketch.between("room_width")
    spread = rng.choice([0.0, 0.1, 0.7])
    at, end = rect.low[along], rect.high[along]
    rooms: list[Rect] = []
    while end - at >= settings.room_width_min_m:
        width = fine(max(usual * (1 + rng.uniform(-spread, spread)), settings.room_width_min_m))
        width *= 2 if sketch.chance(0.08) else 1
        if end - at - width - sketch.wall_m < settings.room_width_min_m:
            width = end - at
        rooms.append(rect.spanning(along, at, at + width))
        at += width + sketch.wall_m
    return [part for room in rooms for part in _with_anteroom(sketch, room, square_to(along))]


def _with_anteroom(sketch: Sketch, room: Rect, across: Axis) -> list[Rect]:
    """Return a room, or two, one behind the other."""
    if room.sides[across] < 4.0 or not sketch.chance(sketch.settings.anteroom_chance):  # noqa: PLR2004
        return [room]
    at = fine(room.low[across] + room.sides[across] * sketch.rng.uniform(0.35, 0.65))
    return [
        room.spanning(across, room.low[across], at),
        room.spanning(across, at + sketch.wall_m, room.high[across]),
    ]


def fill_block(sketch: Sketch, block: Rect, mains: tuple[Rect, Rect]) -> None:
    """Put something into a block between corridors, of which the main ones lie below and above."""
    rng, wall = sketch.rng, sketch.wall_m
    shares = np.array([share for _, share in INSIDE])
    kind = INSIDE[int(rng.choice(len(INSIDE), p=shares / shares.sum()))][0]
    depth = block.sides[1]
    if kind == "two rows" and depth > 2 * sketch.settings.room_depth_min_m:
        middle = fine(block.low[1] + depth * rng.uniform(0.4, 0.6))
        sketch.rooms += _row(sketch, block.spanning(1, block.low[1], middle - wall), 0)
        sketch.rooms += _row(sketch, block.spanning(1, middle, block.high[1]), 0)
    elif kind in ("two rows", "one row"):
        sketch.rooms += _row(sketch, block, 0)
    elif kind == "halls":
        pieces = max(1, round(block.sides[0] / rng.uniform(8.0, 16.0)))
        edges = np.linspace(block.low[0], block.high[0] + wall, pieces + 1)
        halls = [block.spanning(0, fine(a), fine(b) - wall) for a, b in itertools.pairwise(edges.tolist())]
        for hall in halls:
            if sketch.chance(sketch.settings.open_hall_chance):
                open_hall(sketch, hall, mains)
            else:
                sketch.halls.append(hall)
    elif kind in ("open", "cubicles"):
        sketch.corridors.append(block.grown(wall, wall))
        if kind == "cubicles":
            _cubicles(sketch, block.grown(-rng.uniform(1.0, 1.8), -rng.uniform(0.3, 1.2)))
        else:
            _pillars(sketch, block)


def _cubicles(sketch: Sketch, area: Rect) -> None:
    """Put islands of cubicles on an open floor, each with an opening to the aisle beside it."""
    rng = sketch.rng
    wide, deep = (fine(rng.uniform(*CUBICLE_M)) for _ in range(2))
    screen, gap = fine(rng.uniform(0.075, 0.15)), fine(min(rng.uniform(*CUBICLE_GAP_M), wide - 0.3))
    aisle = rng.uniform(1.1, 2.2)
    y = fine(area.low[1])
    while y + deep + 2 * screen < area.high[1]:
        double = y + 2 * deep + 3 * screen < area.high[1] and sketch.chance(0.7)
        for x in _places(area, wide, screen, aisle, rng):
            for k, up in ((0, -1), (1, 1)) if double else ((0, int(rng.choice([-1, 1]))),):
                low = fine(y + k * (deep + screen))
                cubicle = Rect((x, low), (fine(x + wide), fine(low + deep)))
                sketch.solids.append(cubicle.grown(screen, screen))
                sketch.pits.append(cubicle)
                face = (
                    (cubicle.high[1], cubicle.high[1] + screen) if up > 0 else (cubicle.low[1] - screen, cubicle.low[1])
                )
                side = cubicle.spanning(1, *face)
                at = fine(side.low[0] + rng.choice([0.0, 0.5, 1.0]) * (wide - gap))
                sketch.gaps.append(
                    Gap(side, 1).in_wall(at, gap, leaf=False, unsure=gap >= sketch.settings.unsure_from_m)
                )
        y = fine(y + (2 if double else 1) * (deep + screen) + aisle)


def _places(area: Rect, wide: float, screen: float, aisle: float, rng: np.random.Generator) -> list[float]:
    """Return where the cubicles of a row begin: side by side, with an aisle after every few."""
    found, x, run = [], fine(area.low[0]), int(rng.integers(3, 7))
    while x + wide + screen < area.high[0]:
        found.append(x)
        x = fine(x + wide + screen + (aisle if len(found) % run == 0 else 0.0))
    return found


def _pillars(sketch: Sketch, block: Rect) -> None:
    """Put a row of pillars on an open floor."""
    side, apart = fine(sketch.rng.uniform(0.3, 0.7)), sketch.rng.uniform(3.0, 6.0)
    for x in np.arange(block.low[0] + apart / 2, block.high[0] - side, apart).tolist():
        low = fine(x), fine(block.middle[1])
        sketch.solids.append(Rect(low, (low[0] + side, low[1] + side)))


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
