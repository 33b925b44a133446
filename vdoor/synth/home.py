"""From settings and a random generator to a home as a robot vacuum maps it: its furniture, and what the robot sees."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from vdoor.synth import furniture, scan
from vdoor.synth.canvas import Cells, Placed, Rect, Shape, box
from vdoor.synth.drawn_walls import Walls, draw_walls
from vdoor.synth.home_plan import draw_home_plan
from vdoor.synth.layout import Drawn, Gap, Layout, Opened, SlantingGap, drawn, laid_on_map
from vdoor.synth.settings import Dwelling, Home, chance, log_uniform
from vdoor.synth.truth import SyntheticMap, with_truth
from vdoor.synth.wall_style import drawn_style, planned

AROUND_M = 4.0
"""As far as rays may go beyond the plan."""
JAGGED_CHANCE = 0.4


def draw_home(settings: Home, rng: np.random.Generator) -> SyntheticMap:
    """Return one home; the same generator state gives the same plan with other furniture or artefacts."""
    for_plan, for_doors, for_furniture, for_place, for_scan, for_style, for_walls = rng.spawn(7)
    style = drawn_style(settings, for_style)
    built = planned(settings, style)
    plan = drawn(draw_home_plan(built, for_plan))
    furnish(plan, settings, for_doors, for_furniture)
    placed = laid_on_map(plan.canvas, settings, AROUND_M, for_place)
    walls = Walls(style, for_walls, plan, placed, built.wall_max_m)
    return with_truth(_scanned(walls, settings, for_scan), placed, plan.opened, settings)


def furnish(
    plan: Drawn, settings: Dwelling, for_doors: np.random.Generator, for_furniture: np.random.Generator
) -> None:
    """Put furniture on the canvas of a plan, and leaves and what flanks doors beside these."""
    standing = _beside_doors(plan.opened, settings, for_doors) + _furniture(plan.layout, settings, for_furniture)
    furniture.keep_passable(plan, standing)


def _beside_doors(opened: Sequence[Opened], settings: Dwelling, rng: np.random.Generator) -> list[tuple[Rect, Shape]]:
    """Return leaves and what flanks doors, each with the place by its door."""
    found: list[tuple[Rect, Shape]] = []
    for gap in (door.gap for door in opened if not isinstance(door.gap, SlantingGap)):
        if gap.leaf and chance(settings.leaf_chance, rng):
            found.append((gap.rect, furniture.leaf(gap, rng)))
        if chance(settings.niche_chance, rng):
            found += [(gap.rect, shape) for shape in furniture.niche(gap, rng)]
    return found


def _furniture(layout: Layout, settings: Dwelling, rng: np.random.Generator) -> list[tuple[Rect, Shape]]:
    """Return shafts, and what stands in all rooms unless furniture is off, each with its floor."""
    clear_m = (settings.wall_piece_clear_m, settings.clutter_clear_m)
    wide, close = ([gap.clear(away_m, 0.05) for gap in layout.gaps] for away_m in clear_m)
    floors = [floor for floor in layout.floors if min(floor.sides) > furniture.PASSAGE_M]
    found: list[tuple[Rect, Shape]] = []
    for k in rng.integers(len(floors), size=rng.poisson(settings.shafts)).tolist():
        found += [(floors[k], box(rect)) for rect in furniture.shaft(floors[k], rng)]
    lively = log_uniform(settings.clutter_min_per_m2, settings.clutter_max_per_m2, rng)
    if settings.furniture:
        for floor in floors:
            found += [(floor, shape) for shape in _large(floor, settings, rng) if furniture.clear_of(shape, wide)]
            found += [(floor, shape) for shape in _small(floor, lively, rng) if furniture.clear_of(shape, close)]
    return [(floor, shape) for floor, shape in found if furniture.clear_of(shape, close)]


def _large(floor: Rect, settings: Dwelling, rng: np.random.Generator) -> list[Shape]:
    """Return cupboards, beds and sofas of one room, and boxes that stand free."""
    pieces = [
        box(rect)
        for _ in range(rng.poisson(min(settings.wall_pieces_per_m2 * floor.area, 6.0)))
        for rect in furniture.against_wall(floor, (0.3, 2.0), (0.1, 1.0), rng, jagged_chance=JAGGED_CHANCE)
    ]
    free = [
        furniture.free_standing(floor, (0.2, 1.1), rng, turned_chance=0.4)
        for _ in range(rng.poisson(min(settings.free_pieces_per_m2 * floor.area, 2.5)))
    ]
    return pieces + [piece for piece in free if piece is not None]


def _small(floor: Rect, clutter_per_m2: float, rng: np.random.Generator) -> list[Shape]:
    """Return clutter, and legs of tables and chairs."""
    found = [furniture.clutter(floor, rng) for _ in range(rng.poisson(clutter_per_m2 * floor.area))]
    for _ in range(rng.poisson(clutter_per_m2 * floor.area / 5)):
        table = furniture.free_standing(floor, (0.3, 1.4), rng, turned_chance=0.4)
        if table is not None:
            found += furniture.legs(table, rng.uniform(0.04, 0.1))
    return found


def _scanned(walls: Walls, settings: Home, rng: np.random.Generator) -> Cells:
    """Return the cells as the robot shows them; the rooms lose what it did not see, and gain what rays freed."""
    plan, placed, rooms = walls.plan, walls.placed, walls.placed.rooms
    doors = placed.cells_from_plan(np.array([door.gap.rect.middle for door in plan.opened]).reshape(-1, 2))
    unseen = np.zeros(rooms.shape, np.bool_)
    for _ in range(int(rng.integers(1, 4)) if chance(settings.corners_chance, rng) else 0):
        unseen |= scan.leave_corners(rooms, doors, 0.12, rng)
    if chance(settings.rough_chance, rng):
        scan.roughen(rooms, rng.uniform(0.0, settings.rough_max), rng)
    cells = scan.outlined(rooms, unseen, depth=2 if chance(0.15, rng) else 1)  # one in seven
    draw_walls(cells, walls)
    scan.forget_walls(cells, rng.uniform(0.0, settings.unknown_max) * chance(0.6, rng), rng)
    if chance(settings.holes_chance, rng):
        scan.pierce(rooms, cells, int(rng.integers(1, 5)), rng)
    for gap in plan.shut:
        _cast_through_door(gap, placed, cells, rng)
    for _ in range(rng.poisson(settings.windows)):
        scan.cast_through_window(placed, cells, (0.3, 3.5), rng)
    for _ in range(int(rng.integers(1, 9)) if chance(settings.pockets_chance, rng) else 0):
        scan.draw_pockets(rooms, cells, settings.cell_m, rng)
    scan.speckle(rooms, cells, int(rng.poisson(settings.specks)), rng)
    return cells


def _cast_through_door(gap: Gap, placed: Placed, cells: Cells, rng: np.random.Generator) -> None:
    """Show what is seen of a room that was not visited, through its door; now and then the door was shut."""
    if chance(0.4, rng):
        return
    away = rng.uniform(0.4, 1.5)
    for sign in (-1, 1):
        ends = placed.cells_from_plan(np.array([gap.before(sign, away), gap.rect.middle]))
        row, col = np.rint(ends[0]).astype(int)
        if placed.rooms[row, col]:
            angle = math.atan2(*(ends[1] - ends[0]))
            half = math.atan(0.4 * gap.width_m / away)
            reach = (away + rng.uniform(0.5, 3.0)) / placed.cell_m
            scan.cast(placed.rooms, cells, scan.Fan((float(row), float(col)), angle, half, reach), rng)
