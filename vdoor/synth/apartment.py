"""From settings and a random generator to an apartment: its walls, and what a robot sees of them.

Homes and offices are laid on the map's cells and scanned there. Apartments are scanned on the canvas itself, before it
is reduced to the map's cells: so the same generator state gives the same apartment at any cell size.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import scipy

from vdoor.frame import Frame
from vdoor.grid import FREE, OCCUPIED, UNKNOWN, OccupancyGrid
from vdoor.synth.apartment_plan import BESIDE_DOOR_M, Plan, draw_plan, furnish
from vdoor.synth.canvas import FINE_M, LATTICE_M, Canvas, Cells, Placed, Rect, nearest, snap
from vdoor.synth.layout import Face, faces
from vdoor.synth.settings import Apartment, chance
from vdoor.synth.truth import SyntheticMap, in_reach, true_door

BUMP_M = LATTICE_M
SEEN_M = 0.1
"""How far into a wall a robot's map shows it occupied."""
RAY_M = 0.1
RAY_APART_M = 0.25
"""Rays leave this much of wall between their middles: a hole shows at 5 cm and never at 20 cm."""
APART_M = 0.3
"""Blots and the rays of different rooms keep this distance, so that they join nothing at any cell size."""


@dataclass(frozen=True, eq=False)
class Sheet(Canvas):
    """A canvas, and the state of each of its cells: free ones without a room are out of reach."""

    cells: Cells

    def mark(self, rect: Rect, state: int, room: int = 0) -> None:
        """Set state and room of the cells within a rectangle."""
        self.paint(rect, room)
        self.cells[self.window(rect)] = state


def draw_apartment(settings: Apartment, rng: np.random.Generator) -> SyntheticMap:
    """Return one apartment; the same generator state gives the same one at any cell size, turned or furnished or not.

    Raises `SettingError` if the rooms do not fit.
    """
    for_plan, for_furniture, for_walls, for_outside = rng.spawn(4)
    plan = draw_plan(settings, for_plan)
    sheet = _drawn(plan)
    for rect in furnish(plan, settings, for_furniture) + _rough_walls(plan, settings, for_walls):
        sheet.mark(rect, OCCUPIED)
    _hide_inside_walls(sheet)
    _cast_rays(sheet, plan, settings, for_outside)
    _speckle(sheet, plan, settings, for_outside)

    frame, _ = sheet.turned(math.radians(settings.rotation_deg))
    final = _reduced(_upright(sheet, frame), round(settings.cell_m / FINE_M))
    placed = Placed(in_reach(final.rooms, final.cells == FREE), frame, settings.cell_m)
    doors = [
        true_door(door.gap, placed.map_from_plan(np.sort(door.gap.ends, axis=0)), door.rooms) for door in plan.doors
    ]
    return SyntheticMap(OccupancyGrid.from_array(final.cells, settings.cell_m), placed.rooms, tuple(doors), settings)


def _drawn(plan: Plan) -> Sheet:
    """Return a sheet with the rooms' floors free, and doors halved between them."""
    width, height = (round(side / FINE_M) for side in plan.size_m)  # `Canvas.blank` rounds up, here that is not exact
    sheet = Sheet(np.zeros((height, width), np.int32), np.full((height, width), UNKNOWN, np.int8))
    for number, room in enumerate(plan.rooms, start=1):
        sheet.paint(room, number)
    for door in plan.doors:
        sheet.open(door.gap.rect, door.gap.ends, door.rooms[::-1])
    sheet.cells[sheet.window(plan.shell)] = OCCUPIED
    sheet.cells[sheet.rooms > 0] = FREE
    return sheet


def _faces(plan: Plan) -> list[Face]:
    """Return the faces of all rooms."""
    return [face for number, floor in enumerate(plan.rooms, start=1) for face in faces(number, floor)]


def _rough_walls(plan: Plan, settings: Apartment, rng: np.random.Generator) -> list[Rect]:
    """Return noise and juts on the walls, none near a door."""
    walls = _faces(plan)
    bumps = []
    for wall in walls:
        low, length = wall.floor.low[wall.along], wall.floor.sides[wall.along]
        noisy = np.flatnonzero(rng.random(round(length / BUMP_M)) < settings.wall_noise)
        bumps += [wall.strip(low + k * BUMP_M, BUMP_M, -BUMP_M) for k in noisy.tolist()]
    for _ in range(rng.poisson(settings.juts_per_room * len(plan.rooms))):
        wall = walls[rng.integers(len(walls))]
        length = float(rng.integers(1, 4)) * LATTICE_M
        low, slack = wall.floor.low[wall.along], wall.floor.sides[wall.along] - length
        bumps.append(wall.strip(snap(low + rng.uniform(0.0, slack)), length, -BUMP_M))
    zones = [door.gap.clear(settings.door_clear_m, BESIDE_DOOR_M) for door in plan.doors]
    return [bump for bump in bumps if not any(bump.overlaps(zone) for zone in zones)]


def _hide_inside_walls(sheet: Sheet) -> None:
    """Make occupied cells unknown that lie deeper in a wall, or in furniture, than a robot's map shows."""
    reach = 2 * round(SEEN_M / FINE_M) + 1
    near_free = scipy.ndimage.maximum_filter((sheet.cells == FREE).astype(np.uint8), size=reach) > 0
    sheet.cells[(sheet.cells == OCCUPIED) & ~near_free] = UNKNOWN


def _cast_rays(sheet: Sheet, plan: Plan, settings: Apartment, rng: np.random.Generator) -> None:
    """Free what a scanner saw through windows in the outer walls; it counts as part of the room it stood in."""
    outer = [
        wall
        for wall in _faces(plan)
        if math.isclose(wall.at_m, (plan.inside.low, plan.inside.high)[wall.sign > 0][wall.axis])
    ]
    for k in rng.permutation(len(outer))[: rng.poisson(settings.windows)].tolist():  # at most one window a wall
        wall = outer[k]
        side = wall.floor.sides[wall.along]
        half = min(rng.uniform(0.6, 1.2), side - 0.6) / 2
        middle = wall.floor.low[wall.along] + rng.uniform(0.3 + half, side - 0.3 - half)
        eye = middle + rng.uniform(-0.2, 0.2)
        away = min(rng.uniform(1.0, 2.5), wall.floor.sides[wall.axis])
        for at in np.arange(middle - half, middle + half, RAY_APART_M):
            step = np.array([away, at - eye]) / math.hypot(away, at - eye)
            _cast_ray(sheet, wall, at, step, rng.uniform(0.4, 1.5 * settings.margin_m + 0.4))


def _cast_ray(
    sheet: Sheet, wall: Face, at: float, step: np.ndarray[tuple[int], np.dtype[np.float64]], length_m: float
) -> None:
    """Free one ray from the wall's face outwards, until it comes near what another room's rays freed."""
    number = wall.room
    for gone in np.arange(RAY_M / 2, length_m, FINE_M):
        across, along = wall.at_m + wall.sign * step[0] * gone, at + step[1] * gone
        point = (across, along) if wall.axis == 0 else (along, across)
        # Far enough out of the wall; within it, the rooms on either side of a corner are near by nature.
        around = sheet.rooms[sheet.window(Rect(point, point).grown(APART_M, APART_M))]
        if step[0] * gone > APART_M and ((around > 0) & (around != number)).any():
            return
        sheet.mark(Rect(point, point).grown(RAY_M / 2, RAY_M / 2), FREE, number)


def _speckle(sheet: Sheet, plan: Plan, settings: Apartment, rng: np.random.Generator) -> None:
    """Add blots, free or occupied, to what is unknown outside, away from everything free."""
    for _ in range(rng.poisson(settings.speckles)):
        low = [snap(rng.uniform(0.0, plan.size_m[k] - 0.2)) for k in (0, 1)]
        sides = [float(rng.integers(1, 5)) * LATTICE_M for _ in range(2)]
        state = FREE if chance(0.5, rng) else OCCUPIED  # as often as not
        blot = Rect((low[0], low[1]), (low[0] + sides[0], low[1] + sides[1]))
        near = sheet.cells[sheet.window(blot.grown(APART_M, APART_M))]
        if not plan.shell.grown(APART_M, APART_M).overlaps(blot) and not (near == FREE).any():
            sheet.mark(blot, state)


def _upright(sheet: Sheet, frame: Frame) -> Sheet:
    """Return the sheet as an upright raster of the map frame, by the nearest cell; beyond its edges all is unknown."""
    if frame.yaw_rad == 0:
        return sheet
    height, width = sheet.rooms.shape
    cos, sin = abs(math.cos(frame.yaw_rad)), abs(math.sin(frame.yaw_rad))
    upright = Frame(math.ceil(height * cos + width * sin), math.ceil(width * cos + height * sin), FINE_M)
    # `Canvas.placed` does the same for homes and offices, but sums in another order. Turned by 45 degrees, a row of an
    # apartment's cells lies halfway between two others: there the last bit decides, and maps would change.
    centres = upright.world_from_cell(np.indices((upright.height, upright.width)).reshape(2, -1).T)
    row, col = frame.cell_from_world(centres).T.reshape(2, upright.height, upright.width)
    return Sheet(nearest(sheet.rooms, row, col), nearest(sheet.cells, row, col, beyond=UNKNOWN))


def _reduced(sheet: Sheet, factor: int) -> Sheet:
    """Return blocks of `factor` cells as one: occupied if any cell is, else free if any is, else unknown.

    Blocks are counted from the lower left corner. A free block has the room of its middle, or of any cell if the
    middle has none.
    """
    missing = [-length % factor for length in sheet.cells.shape]
    pad = ((missing[0], 0), (0, missing[1]))
    cells = np.pad(sheet.cells, pad, constant_values=UNKNOWN)
    shape = cells.shape[0] // factor, factor, cells.shape[1] // factor, factor
    blocks, labels = cells.reshape(shape), np.pad(sheet.rooms, pad).reshape(shape)
    occupied = (blocks == OCCUPIED).any(axis=(1, 3))
    free = (blocks == FREE).any(axis=(1, 3)) & ~occupied
    middle = labels[:, factor // 2, :, factor // 2]
    rooms = np.where(free, np.where(middle > 0, middle, labels.max(axis=(1, 3))), 0)
    return Sheet(rooms.astype(np.int32), np.where(occupied, OCCUPIED, np.where(free, FREE, UNKNOWN)).astype(np.int8))
