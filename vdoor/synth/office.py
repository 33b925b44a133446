"""From settings and a random generator to a floor of an office building."""

from __future__ import annotations

import numpy as np

from vdoor.synth import furniture, scan
from vdoor.synth.canvas import Cells, Rect, Shape, box, disc, turned_box
from vdoor.synth.drawn_walls import Walls, draw_walls
from vdoor.synth.furniture import keep_passable
from vdoor.synth.layout import Layout, drawn, laid
from vdoor.synth.office_plan import draw_office_plan
from vdoor.synth.settings import Office
from vdoor.synth.truth import SyntheticMap, with_truth
from vdoor.synth.wall_style import drawn_style, planned

AROUND_M = 2.0
CLEAR_M = 0.7
"""Left free by furniture before both sides of a door."""


def draw_office(settings: Office, rng: np.random.Generator) -> SyntheticMap:
    """Return one floor; the same generator state gives the same plan, furnished or not."""
    for_plan, for_furniture, for_place, for_scan, for_style, for_walls = rng.spawn(6)
    style = drawn_style(settings, for_style)
    built = planned(settings, style)
    plan = drawn(draw_office_plan(built, for_plan))
    if settings.furniture and for_furniture.random() < settings.furnished_chance:
        keep_passable(plan, _furniture(plan.layout, for_furniture))
    placed = laid(plan.canvas, settings, AROUND_M, for_place)
    walls = Walls(style, for_walls, plan, placed, built.wall_max_m)
    return with_truth(_scanned(walls, settings, for_scan), placed, plan.opened, settings)


def _scanned(walls: Walls, settings: Office, rng: np.random.Generator) -> Cells:
    """Return the cells: as drawn by an architect, or with the marks of a scan."""
    placed, rooms = walls.placed, walls.placed.rooms
    scanned = rng.random() < settings.rough_chance
    if scanned:
        scan.roughen(rooms, rng.uniform(0.0, settings.rough_max), rng)
    cells = scan.outlined(rooms, np.zeros(rooms.shape, np.bool_), depth=int(rng.integers(1, 4)))
    draw_walls(cells, walls)
    if rng.random() < settings.faded_chance:
        scan.forget_walls(cells, rng.random(), rng)
    for _ in range(int(rng.poisson(2.0)) if scanned else 0):
        scan.look_outside(placed, cells, (0.3, 2.0), rng)
    return cells


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


def _bins(floor: Rect, chance: float, rng: np.random.Generator) -> list[Shape]:
    """Return a bin near the wall of some rooms."""
    if rng.random() >= chance:
        return []
    rect = furniture.against_wall(floor, (0.4, 0.4), (0.4, 0.4), rng)
    return [disc(piece.middle, 0.2) for piece in rect]
