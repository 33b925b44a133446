"""From settings and a random generator to a map with its truth."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from vdoor.frame import Frame
from vdoor.grid import FREE, OCCUPIED, OccupancyGrid
from vdoor.synth.canvas import FINE_M
from vdoor.synth.furnish import furnish
from vdoor.synth.plan import Door, draw_plan
from vdoor.synth.sense import cast_rays, hide_what_walls_hide, rough_walls, speckle
from vdoor.synth.settings import Apartment
from vdoor.synth.sheet import Sheet, draw_walls, reduced, turned, turned_frame
from vdoor.synth.truth import SyntheticMap, TrueDoor


def draw_apartment(settings: Apartment, rng: np.random.Generator) -> SyntheticMap:
    """Return one apartment; the same generator state gives the same one at any cell size, turned or furnished or not.

    Raises `SettingError` if the rooms do not fit.
    """
    for_plan, for_furniture, for_walls, for_outside = rng.spawn(4)
    plan = draw_plan(settings, for_plan)
    sheet = draw_walls(plan)
    for rect in furnish(plan, settings, for_furniture) + rough_walls(plan, settings, for_walls):
        sheet.paint(rect, OCCUPIED)
    hide_what_walls_hide(sheet)
    cast_rays(sheet, plan, settings, for_outside)
    speckle(sheet, plan, settings, for_outside)

    frame = turned_frame(sheet, math.radians(settings.rotation_deg))
    final = reduced(turned(sheet, frame), round(settings.cell_m / FINE_M))
    grid = OccupancyGrid.from_array(final.cells, settings.cell_m)
    return SyntheticMap(grid, _within_reach(final), tuple(_truth(door, frame) for door in plan.doors), settings)


def _within_reach(sheet: Sheet) -> NDArray[np.int32]:
    """Return the rooms without what is not 4-connected to most of them."""
    part, _ = ndimage.label(sheet.cells == FREE)
    main = np.bincount(part[sheet.rooms > 0]).argmax()
    return np.where(part == main, sheet.rooms, 0).astype(np.int32)


def _truth(door: Door, frame: Frame) -> TrueDoor:
    """Return a door of the plan in the map frame and with the labels of its rooms."""
    along = 1 - door.axis
    ends = np.array([door.gap.middle, door.gap.middle])
    ends[:, along] = door.gap.low[along], door.gap.high[along]
    drawn = Frame(frame.height, frame.width, frame.resolution_m)
    start, end = np.round(frame.world_from_cell(drawn.cell_from_world(ends)), 6).tolist()
    a, b = sorted(room + 1 for room in door.rooms)
    return TrueDoor(tuple(start), tuple(end), round(door.gap.sides[along], 6), (a, b))
