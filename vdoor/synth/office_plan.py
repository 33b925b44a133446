"""The plan of an office floor: corridors, rows of rooms on both sides, and what lies between the corridors."""

from __future__ import annotations

import itertools

import numpy as np

from vdoor.synth.canvas import Axis, Rect, fine, square_to
from vdoor.synth.layout import Gap, Layout
from vdoor.synth.office_parts import Sketch, add_doors, close_corridors, divide_hall, end_hall, open_hall, put_screens
from vdoor.synth.settings import Office

MARGIN_M = 1.0
CUBICLE_M = (2.0, 3.6)
CUBICLE_GAP_M = (0.9, 2.4)
JAMB_M, FLUSH_M = (0.1, 0.45), (0.0, 0.05)
"""Wall left beside doors near a corner."""
BETWEEN_M = (5.5, 15.0)
"""Depth of what lies between two corridors."""
INSIDE = (("two rows", 0.4), ("one row", 0.15), ("halls", 0.2), ("open", 0.04), ("cubicles", 0.16), ("yard", 0.15))
"""What lies between corridors, and how often."""


def draw_office_plan(settings: Office, rng: np.random.Generator) -> Layout:
    """Return a plan: what no door reaches is part of the sheet but of no room."""
    wall = fine(rng.uniform(settings.wall_min_m, settings.wall_max_m))
    door = fine(rng.uniform(settings.door_min_m, settings.door_max_m))
    sketch = Sketch(settings, rng, wall, door, FLUSH_M if rng.random() < settings.flush_chance else JAMB_M)
    _arrange(sketch)
    for hall in sketch.halls:
        if sketch.chance(settings.divided_hall_chance):
            divide_hall(sketch, hall)
    add_doors(sketch)
    close_corridors(sketch)
    put_screens(sketch)
    floors = sketch.corridors + sketch.rooms + sketch.halls
    far = [max(floor.high[k] for floor in floors) + MARGIN_M for k in (0, 1)]
    return _upright_or_not(
        Layout(tuple(floors), tuple(sketch.gaps), (far[0], far[1]), tuple(sketch.solids), tuple(sketch.pits)), rng
    )


def _upright_or_not(layout: Layout, rng: np.random.Generator) -> Layout:
    """Return the plan with x and y exchanged, as often as not."""
    if rng.random() < 0.5:  # noqa: PLR2004
        return layout

    def swapped(rects: tuple[Rect, ...]) -> tuple[Rect, ...]:
        return tuple(Rect(rect.low[::-1], rect.high[::-1]) for rect in rects)

    gaps = tuple(
        Gap(rect, gap.along, leaf=gap.leaf, unsure=gap.unsure)
        for gap, rect in zip(layout.gaps, swapped(tuple(gap.rect for gap in layout.gaps)), strict=True)
    )
    return Layout(swapped(layout.floors), gaps, layout.size_m[::-1], swapped(layout.solids), swapped(layout.pits))


def _arrange(sketch: Sketch) -> None:
    """Lay out corridors from below to above, cross corridors, and rooms in and around the blocks this leaves."""
    rng, wall = sketch.rng, sketch.wall_m
    low, high = MARGIN_M, fine(MARGIN_M + rng.uniform(sketch.settings.length_min_m, sketch.settings.length_max_m))
    count = int(rng.integers(1, sketch.settings.corridors_max + 1, size=2).max())  # mostly several
    below = sketch.between("room_depth")
    at = MARGIN_M + below + wall
    mains: list[Rect] = []
    for k in range(count):
        mains.append(Rect((low, at), (high, at + sketch.between("corridor"))))
        at = mains[-1].high[1] + wall + (fine(rng.uniform(*BETWEEN_M)) + wall if k < count - 1 else 0.0)
    above = sketch.between("room_depth")
    ends = _end_columns(sketch, low, high) if count > 1 else (low, high)
    mains = [main.spanning(0, *ends) for main in mains]
    sketch.corridors += mains
    crossing = _crossings(sketch, ends) if count > 1 else []
    bottom, top = mains[0].low[1], mains[-1].high[1]
    sketch.corridors += [Rect((x, bottom), (x + width, top)) for x, width in crossing]
    if sketch.chance(sketch.settings.mouth_chance):
        _part_crossings(sketch, mains, crossing)
    for lower, upper in itertools.pairwise(mains):
        edges = [ends[0] - wall, *(edge for x, width in crossing for edge in (x, x + width)), ends[1] + wall]
        for left, right in zip(edges[::2], edges[1::2], strict=True):
            if right - left > 2 * wall + 1.5:  # a room fits
                block = Rect((left + wall, lower.high[1] + wall), (right - wall, upper.low[1] - wall))
                _fill(sketch, block, (lower, upper))
    for bottom, depth in ((MARGIN_M, below), (mains[-1].high[1] + wall, above)):
        _outer_row(sketch, Rect((low, bottom), (high, bottom + depth)), 0)
    if count > 1:
        _beyond_ends(sketch, (low, high), ends, mains)


def _beyond_ends(sketch: Sketch, outer: tuple[float, float], ends: tuple[float, float], mains: list[Rect]) -> None:
    """Fill the columns beyond the main corridors' ends, if any: with rooms, or with a hall that they run into."""
    (low, high), wall = outer, sketch.wall_m
    for left, right, mouth in ((low, ends[0] - wall, ends[0] - wall), (ends[1] + wall, high, ends[1])):
        if right - left <= 2.0:  # noqa: PLR2004  # the corridors run to the floor's edge
            continue
        column = Rect((left, mains[0].low[1]), (right, mains[-1].high[1]))
        if sketch.chance(sketch.settings.end_hall_chance):
            end_hall(sketch, column, mains, mouth)
        else:
            _outer_row(sketch, column, 1)


def _end_columns(sketch: Sketch, low: float, high: float) -> tuple[float, float]:
    """Return where the main corridors begin and end: in some floors columns of rooms lie beyond."""
    ends = [low, high]
    for k, inwards in ((0, 1), (1, -1)):
        depth = sketch.between("room_depth")
        if sketch.chance(0.35) and high - low > 4 * depth:
            ends[k] = fine(ends[k] + inwards * (depth + sketch.wall_m))
    return ends[0], ends[1]


def _crossings(sketch: Sketch, ends: tuple[float, float]) -> list[tuple[float, float]]:
    """Return x and width of the corridors that join the main ones: at either end, and in the middle of long floors."""
    rng = sketch.rng
    found = []
    if left := sketch.chance(0.7):
        found.append((ends[0], sketch.between("corridor")))
    if ends[1] - ends[0] > 24.0 and sketch.chance(0.5):  # noqa: PLR2004
        found.append((fine(rng.uniform(ends[0] + 9.0, ends[1] - 11.0)), sketch.between("corridor")))
    if sketch.chance(0.7) or not left:
        width = sketch.between("corridor")
        found.append((fine(ends[1] - width), width))
    return found


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


def _part_crossings(sketch: Sketch, mains: list[Rect], crossing: list[tuple[float, float]]) -> None:
    """Make cross corridors rooms of their own: people part them where they meet a main one, without any narrowing."""
    for x, width in crossing:
        for lower, upper in itertools.pairwise(mains):
            for low in (lower.high[1], fine(upper.low[1] - sketch.wall_m)):
                mouth = Rect((x, low), (fine(x + width), fine(low + sketch.wall_m)))
                sketch.solids.append(mouth)
                sketch.open_mouth(mouth, 1)


def _with_anteroom(sketch: Sketch, room: Rect, across: Axis) -> list[Rect]:
    """Return a room, or two, one behind the other."""
    if room.sides[across] < 4.0 or not sketch.chance(sketch.settings.anteroom_chance):  # noqa: PLR2004
        return [room]
    at = fine(room.low[across] + room.sides[across] * sketch.rng.uniform(0.35, 0.65))
    return [
        room.spanning(across, room.low[across], at),
        room.spanning(across, at + sketch.wall_m, room.high[across]),
    ]


def _outer_row(sketch: Sketch, rect: Rect, along: Axis) -> None:
    """Add a row of rooms along the outer wall, in some floors without part of it."""
    rooms = _row(sketch, rect, along)
    if sketch.chance(sketch.settings.notch_chance):
        missing = max(1, int(len(rooms) * sketch.rng.uniform(0.1, 0.6)))
        starts = (0, len(rooms) - missing, int(sketch.rng.integers(len(rooms) - missing + 1)))
        first = starts[int(sketch.rng.integers(3))]
        rooms = rooms[:first] + rooms[first + missing :]
    sketch.rooms += rooms


def _fill(sketch: Sketch, block: Rect, mains: tuple[Rect, Rect]) -> None:
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
