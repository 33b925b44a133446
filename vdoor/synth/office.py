"""From settings and a random generator to a floor of an office building: its corridors, its furniture, its map."""

from __future__ import annotations

import itertools

import numpy as np

from vdoor.synth import furniture, scan
from vdoor.synth.canvas import Cells, Rect, Shape, box, disc, fine, turned_box
from vdoor.synth.drawn_walls import Walls, draw_walls
from vdoor.synth.layout import Gap, Layout, drawn, laid_on_map
from vdoor.synth.office_parts import (
    Sketch,
    add_doors,
    add_outer_row,
    close_corridors,
    divide_hall,
    end_hall,
    fill_block,
    put_screens,
)
from vdoor.synth.settings import Office, chance
from vdoor.synth.truth import SyntheticMap, with_truth
from vdoor.synth.wall_style import drawn_style, planned

AROUND_M = 2.0
"""As far as rays may go beyond the plan."""
MARGIN_M = 1.0
JAMB_M, FLUSH_M = (0.1, 0.45), (0.0, 0.05)
"""Wall left beside doors near a corner."""
BETWEEN_M = (5.5, 15.0)
"""Depth of what lies between two corridors."""
CLEAR_M = 0.7
"""Left free by furniture before both sides of a door."""


def draw_office(settings: Office, rng: np.random.Generator) -> SyntheticMap:
    """Return one floor; the same generator state gives the same plan, furnished or not."""
    for_plan, for_furniture, for_place, for_scan, for_style, for_walls = rng.spawn(6)
    style = drawn_style(settings, for_style)
    built = planned(settings, style)
    plan = drawn(_plan(built, for_plan))
    if settings.furniture and chance(settings.furnished_chance, for_furniture):
        furniture.keep_passable(plan, _furniture(plan.layout, for_furniture))
    placed = laid_on_map(plan.canvas, settings, AROUND_M, for_place)
    walls = Walls(style, for_walls, plan, placed, built.wall_max_m)
    return with_truth(_scanned(walls, settings, for_scan), placed, plan.opened, settings)


def _plan(settings: Office, rng: np.random.Generator) -> Layout:
    """Return a plan: what no door reaches is drawn but part of no room."""
    wall = fine(rng.uniform(settings.wall_min_m, settings.wall_max_m))
    door = fine(rng.uniform(settings.door_min_m, settings.door_max_m))
    sketch = Sketch(settings, rng, wall, door, FLUSH_M if chance(settings.flush_chance, rng) else JAMB_M)
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
    if chance(0.5, rng):
        return layout

    def swapped(rects: tuple[Rect, ...]) -> tuple[Rect, ...]:
        return tuple(Rect(rect.low[::-1], rect.high[::-1]) for rect in rects)

    gaps = tuple(
        Gap(rect, gap.along, leaf=gap.leaf, unsure=gap.unsure)
        for gap, rect in zip(layout.gaps, swapped(tuple(gap.rect for gap in layout.gaps)), strict=True)
    )
    return Layout(swapped(layout.floors), gaps, layout.size_m[::-1], swapped(layout.solids), swapped(layout.pits))


def _arrange(sketch: Sketch) -> None:
    """Lay out main corridors, cross corridors, and rooms in and around the blocks between them."""
    settings = sketch.settings
    low, high = MARGIN_M, fine(MARGIN_M + sketch.rng.uniform(settings.length_min_m, settings.length_max_m))
    mains, below, above = _main_corridors(sketch, low, high)
    ends = _end_columns(sketch, low, high) if len(mains) > 1 else (low, high)
    mains = [main.spanning(0, *ends) for main in mains]
    crossings = _cross_corridors(sketch, mains) if len(mains) > 1 else []
    sketch.corridors += mains + crossings
    if sketch.chance(settings.mouth_chance):
        _part_crossings(sketch, mains, crossings)
    for lower, upper in itertools.pairwise(mains):
        _fill_between(sketch, lower, upper, crossings)
    for bottom, depth in ((MARGIN_M, below), (mains[-1].high[1] + sketch.wall_m, above)):
        add_outer_row(sketch, Rect((low, bottom), (high, bottom + depth)), 0)
    if len(mains) > 1:
        _beyond_ends(sketch, (low, high), mains)


def _main_corridors(sketch: Sketch, low: float, high: float) -> tuple[list[Rect], float, float]:
    """Return the corridors along the floor from below to above, and the depth of the rooms below and above them."""
    count = int(sketch.rng.integers(1, sketch.settings.corridors_max + 1, size=2).max())  # mostly several
    below = sketch.between("room_depth")
    at = MARGIN_M + below + sketch.wall_m
    mains: list[Rect] = []
    for k in range(count):
        mains.append(Rect((low, at), (high, at + sketch.between("corridor"))))
        beyond = fine(sketch.rng.uniform(*BETWEEN_M)) + sketch.wall_m if k < count - 1 else 0.0
        at = mains[-1].high[1] + sketch.wall_m + beyond
    return mains, below, sketch.between("room_depth")


def _fill_between(sketch: Sketch, lower: Rect, upper: Rect, crossings: list[Rect]) -> None:
    """Fill the blocks that cross corridors leave between two main ones."""
    wall = sketch.wall_m
    inner = [edge for crossing in crossings for edge in (crossing.low[0], crossing.high[0])]
    edges = [lower.low[0] - wall, *inner, lower.high[0] + wall]
    for left, right in zip(edges[::2], edges[1::2], strict=True):
        if right - left > 2 * wall + 1.5:  # a room fits
            block = Rect((left + wall, lower.high[1] + wall), (right - wall, upper.low[1] - wall))
            fill_block(sketch, block, (lower, upper))


def _end_columns(sketch: Sketch, low: float, high: float) -> tuple[float, float]:
    """Return where the main corridors begin and end: in some floors columns of rooms lie beyond."""
    ends = [low, high]
    for k, inwards in ((0, 1), (1, -1)):
        depth = sketch.between("room_depth")
        if sketch.chance(0.35) and high - low > 4 * depth:
            ends[k] = fine(ends[k] + inwards * (depth + sketch.wall_m))
    return ends[0], ends[1]


def _cross_corridors(sketch: Sketch, mains: list[Rect]) -> list[Rect]:
    """Return the corridors that join the main ones: at either end, and in the middle of long floors."""
    (left, bottom), (right, top) = mains[0].low, (mains[0].high[0], mains[-1].high[1])
    found = []
    if at_left := sketch.chance(0.7):
        found.append((left, sketch.between("corridor")))
    if right - left > 24.0 and sketch.chance(0.5):  # noqa: PLR2004
        found.append((fine(sketch.rng.uniform(left + 9.0, right - 11.0)), sketch.between("corridor")))
    if sketch.chance(0.7) or not at_left:
        width = sketch.between("corridor")
        found.append((fine(right - width), width))
    return [Rect((x, bottom), (x + width, top)) for x, width in found]


def _part_crossings(sketch: Sketch, mains: list[Rect], crossings: list[Rect]) -> None:
    """Make cross corridors rooms of their own: people part them where they meet a main one, without any narrowing."""
    for crossing in crossings:
        for lower, upper in itertools.pairwise(mains):
            for low in (lower.high[1], fine(upper.low[1] - sketch.wall_m)):
                mouth = Rect((crossing.low[0], low), (fine(crossing.high[0]), fine(low + sketch.wall_m)))
                sketch.solids.append(mouth)
                sketch.open_mouth(mouth, 1)


def _beyond_ends(sketch: Sketch, outer: tuple[float, float], mains: list[Rect]) -> None:
    """Fill the columns beyond the main corridors' ends, if any: with rooms, or with a hall that they run into."""
    (low, high), wall = outer, sketch.wall_m
    left_end, right_end = mains[0].low[0], mains[0].high[0]
    for left, right, mouth in ((low, left_end - wall, left_end - wall), (right_end + wall, high, right_end)):
        if right - left <= 2.0:  # noqa: PLR2004  # the corridors run to the floor's edge
            continue
        column = Rect((left, mains[0].low[1]), (right, mains[-1].high[1]))
        if sketch.chance(sketch.settings.end_hall_chance):
            end_hall(sketch, column, mains, mouth)
        else:
            add_outer_row(sketch, column, 1)


def _furniture(layout: Layout, rng: np.random.Generator) -> list[tuple[Rect, Shape]]:
    """Return shelves, desks, chairs and bins, each with its floor: as boxes, or as the legs they stand on."""
    zones = [gap.clear(CLEAR_M, 0.1) for gap in layout.gaps]
    leg_m = rng.uniform(0.05, 0.12)
    on_legs, bins = rng.choice([0.0, 0.7, 1.0, 1.0]), rng.choice([0.0, 0.2, 0.6])
    found: list[tuple[Rect, Shape]] = []
    for floor in (*layout.floors, *layout.pits):
        if min(floor.sides) < 3.2:  # noqa: PLR2004  # corridors keep free
            continue
        near = [zone for zone in zones if zone.overlaps(floor)] + [
            solid for solid in layout.solids if floor.holds(solid)
        ]
        shapes = _shelves(floor, rng) + _desks(floor, on_legs, leg_m, rng) + _bins(floor, bins, rng)
        found += [(floor, shape) for shape in shapes if furniture.clear_of(shape, near)]
    return found


def _shelves(floor: Rect, rng: np.random.Generator) -> list[Shape]:
    """Return up to three shelves against the walls of a room."""
    return [
        box(rect)
        for _ in range(int(rng.integers(0, 4)))
        for rect in furniture.against_wall(floor, (0.6, 2.4), (0.3, 0.6), rng)
    ]


def _desks(floor: Rect, on_legs: float, leg_m: float, rng: np.random.Generator) -> list[Shape]:
    """Return desks with their chairs, as many as the room has places for."""
    found: list[Shape] = []
    for _ in range(int(rng.integers(0, 3 + min(int(floor.area / 5), 14)))):
        desk = furniture.free_standing(floor, (0.7, 1.7), rng, turned_chance=0.05)
        if desk is not None:
            place = desk.mean(axis=0) + rng.uniform(-0.9, 0.9, size=2)
            chair = turned_box((place[0], place[1]), (0.5, 0.5), rng.uniform(0.0, 1.5))
            solid = rng.random() >= on_legs
            found += [desk] if solid else furniture.legs(desk, leg_m) + furniture.legs(chair, leg_m)
    return found


def _bins(floor: Rect, share: float, rng: np.random.Generator) -> list[Shape]:
    """Return a bin near the wall of some rooms."""
    if not chance(share, rng):
        return []
    rect = furniture.against_wall(floor, (0.4, 0.4), (0.4, 0.4), rng)
    return [disc(piece.middle, 0.2) for piece in rect]


def _scanned(walls: Walls, settings: Office, rng: np.random.Generator) -> Cells:
    """Return the cells: as drawn by an architect, or with the marks of a scan."""
    placed, rooms = walls.placed, walls.placed.rooms
    scanned = chance(settings.rough_chance, rng)
    if scanned:
        scan.roughen(rooms, rng.uniform(0.0, settings.rough_max), rng)
    cells = scan.outlined(rooms, np.zeros(rooms.shape, np.bool_), depth=int(rng.integers(1, 4)))
    draw_walls(cells, walls)
    if chance(settings.faded_chance, rng):
        scan.forget_walls(cells, rng.random(), rng)
    for _ in range(int(rng.poisson(2.0)) if scanned else 0):
        scan.cast_through_window(placed, cells, (0.3, 2.0), rng)
    return cells
