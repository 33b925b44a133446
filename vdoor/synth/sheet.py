"""The fine raster that an apartment is drawn on, and how it is turned and reduced to the map's own cells."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vdoor.frame import Frame
from vdoor.grid import FREE, OCCUPIED, UNKNOWN
from vdoor.synth.canvas import FINE_M, Rect
from vdoor.synth.plan import Plan


@dataclass(frozen=True, eq=False)
class Sheet:
    """Cells (h, w) int8 as in `OccupancyGrid`, and the room of each free one (h, w) int32; row 0 is the top."""

    cells: NDArray[np.int8]
    rooms: NDArray[np.int32]

    def window(self, rect: Rect) -> tuple[slice, slice]:
        """Rows and columns of the cells within a rectangle, as far as it is on the sheet."""
        height, width = self.cells.shape
        left, right = (min(max(round(x / FINE_M), 0), width) for x in (rect.low[0], rect.high[0]))
        bottom, top = (min(max(round(y / FINE_M), 0), height) for y in (rect.low[1], rect.high[1]))
        return slice(height - top, height - bottom), slice(left, right)

    def paint(self, rect: Rect, state: int, room: int = 0) -> None:
        """Set the cells within a rectangle."""
        window = self.window(rect)
        self.cells[window], self.rooms[window] = state, room


def draw_walls(plan: Plan) -> Sheet:
    """Return a sheet with the rooms' floors free, labelled from 1 in the plan's order, doors halved between them."""
    width, height = (round(side / FINE_M) for side in plan.sheet.sides)
    sheet = Sheet(np.full((height, width), UNKNOWN, dtype=np.int8), np.zeros((height, width), dtype=np.int32))
    sheet.paint(plan.shell, OCCUPIED)
    for number, room in enumerate(plan.rooms, start=1):
        sheet.paint(room, FREE, number)
    for door in plan.doors:
        low, middle, high = (point[door.axis] for point in (door.gap.low, door.gap.middle, door.gap.high))
        sheet.paint(door.gap.spanning(door.axis, low, middle), FREE, door.rooms[0] + 1)
        sheet.paint(door.gap.spanning(door.axis, middle, high), FREE, door.rooms[1] + 1)
    return sheet


def turned_frame(sheet: Sheet, yaw_rad: float) -> Frame:
    """Return where the sheet lies in the map frame once it is turned and pushed into the first quadrant."""
    height, width = sheet.cells.shape
    flat = Frame(height, width, FINE_M, 0.0, 0.0, yaw_rad)
    corners = np.array([(-0.5, -0.5), (-0.5, width - 0.5), (height - 0.5, -0.5), (height - 0.5, width - 0.5)])
    low = flat.world_from_cell(corners).min(axis=0)
    return Frame(height, width, FINE_M, -float(low[0]), -float(low[1]), yaw_rad)


def turned(sheet: Sheet, frame: Frame) -> Sheet:
    """Return the sheet as an upright raster of the map frame, by the nearest cell; beyond its edges all is unknown."""
    if frame.yaw_rad == 0:
        return sheet
    height, width = sheet.cells.shape
    cos, sin = abs(math.cos(frame.yaw_rad)), abs(math.sin(frame.yaw_rad))
    upright = Frame(math.ceil(height * cos + width * sin), math.ceil(width * cos + height * sin), FINE_M)
    centres = upright.world_from_cell(np.indices((upright.height, upright.width)).reshape(2, -1).T)
    row, col = np.rint(frame.cell_from_world(centres)).astype(np.intp).T.reshape(2, upright.height, upright.width)
    known = (row >= 0) & (row < height) & (col >= 0) & (col < width)
    row, col = np.where(known, row, 0), np.where(known, col, 0)
    return Sheet(
        np.where(known, sheet.cells[row, col], UNKNOWN).astype(np.int8),
        np.where(known, sheet.rooms[row, col], 0).astype(np.int32),
    )


def reduced(sheet: Sheet, factor: int) -> Sheet:
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
    return Sheet(np.where(occupied, OCCUPIED, np.where(free, FREE, UNKNOWN)).astype(np.int8), rooms.astype(np.int32))
