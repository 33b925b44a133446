"""The fine raster that maps are drawn on, the shapes drawn on it, and how it is laid on a map's cells.

Shapes are in metres, x right, y up, from the canvas's lower left corner.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from vdoor.frame import Frame

FINE_M = 0.025
"""Side of a cell of the raster that everything is drawn on."""
LATTICE_M = 0.05
"""Walls, doors and furniture of apartments begin and end on multiples of this, so that 5 cm cells show them exactly."""
Axis = Literal[0, 1]
"""x or y."""
AXES: tuple[Axis, Axis] = (0, 1)
Rooms = NDArray[np.int32]
"""Number of the room of each cell (h, w), 0 for none."""
Cells = NDArray[np.int8]
"""State of each cell (h, w) as in `OccupancyGrid`."""
Shape = NDArray[np.float64]
"""Corners (k, 2) as x, y of a convex polygon, counter-clockwise."""
HAIR_M = 1e-6
"""Less than this is nothing."""


def fine(value_m: float) -> float:
    """Return the nearest multiple of `FINE_M`."""
    return round(value_m / FINE_M) * FINE_M


def snap(value_m: float) -> float:
    """Return the nearest multiple of `LATTICE_M`."""
    return round(value_m / LATTICE_M) / round(1 / LATTICE_M)


def lattice_range(low_m: float, high_m: float) -> range:
    """Return which multiples of `LATTICE_M` lie between the two, both included."""
    return range(math.ceil(low_m / LATTICE_M - 1e-6), math.floor(high_m / LATTICE_M + 1e-6) + 1)


def square_to(axis: Axis) -> Axis:
    """Return the axis at a right angle to this one."""
    return 1 if axis == 0 else 0


@dataclass(frozen=True)
class Rect:
    """An upright rectangle; `low` and `high` are (x, y) of its lower left and upper right corners."""

    low: tuple[float, float]
    high: tuple[float, float]

    @classmethod
    def between(cls, one: tuple[float, float], two: tuple[float, float]) -> Rect:
        """Return the rectangle with these two points as opposite corners."""
        return cls((min(one[0], two[0]), min(one[1], two[1])), (max(one[0], two[0]), max(one[1], two[1])))

    @property
    def sides(self) -> tuple[float, float]:
        """Width and height."""
        return self.high[0] - self.low[0], self.high[1] - self.low[1]

    @property
    def area(self) -> float:
        """Width times height."""
        return math.prod(self.sides)

    @property
    def middle(self) -> tuple[float, float]:
        """Its centre."""
        return (self.low[0] + self.high[0]) / 2, (self.low[1] + self.high[1]) / 2

    def grown(self, x_m: float, y_m: float) -> Rect:
        """Return a rectangle with `x_m` more to the left and right, `y_m` more below and above."""
        return Rect((self.low[0] - x_m, self.low[1] - y_m), (self.high[0] + x_m, self.high[1] + y_m))

    def spanning(self, axis: Axis, low: float, high: float) -> Rect:
        """Return the rectangle with its extent along `axis` replaced."""
        if axis == 0:
            return Rect((low, self.low[1]), (high, self.high[1]))
        return Rect((self.low[0], low), (self.high[0], high))

    def overlaps(self, other: Rect) -> bool:
        """Whether the two have area in common (less than a hair is none)."""
        return all(self.low[k] < other.high[k] - HAIR_M and other.low[k] < self.high[k] - HAIR_M for k in (0, 1))

    def holds(self, other: Rect) -> bool:
        """Whether `other` lies inside."""
        return all(self.low[k] < other.low[k] + HAIR_M and other.high[k] < self.high[k] + HAIR_M for k in (0, 1))


def turned_box(middle: tuple[float, float], sides: tuple[float, float], angle_rad: float = 0.0) -> Shape:
    """Return a rectangle about `middle`, turned."""
    corners = np.array([(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)]) * sides
    cos, sin = math.cos(angle_rad), math.sin(angle_rad)
    return np.asarray(corners @ np.array([(cos, sin), (-sin, cos)]) + middle)


def box(rect: Rect) -> Shape:
    """Return an upright rectangle as a shape."""
    return turned_box(rect.middle, rect.sides)


def around(shape: Shape) -> Rect:
    """Return the upright rectangle around a shape."""
    low, high = shape.min(axis=0), shape.max(axis=0)
    return Rect((low[0], low[1]), (high[0], high[1]))


def disc(middle: tuple[float, float], radius_m: float) -> Shape:
    """Return a regular polygon of twelve corners."""
    angle = np.arange(12) * math.pi / 6
    return np.asarray(np.stack([np.cos(angle), np.sin(angle)], axis=1) * radius_m + middle)


@dataclass(frozen=True, eq=False)
class Canvas:
    """A raster of fine cells with the room that each belongs to, 0 where one cannot go; row 0 is the top."""

    rooms: Rooms

    @classmethod
    def blank(cls, size_m: tuple[float, float]) -> Canvas:
        """Return a canvas of that width and height, all solid."""
        width, height = (math.ceil(side / FINE_M) for side in size_m)
        return cls(np.zeros((height, width), np.int32))

    def empty(self) -> Canvas:
        """Return another canvas of this size, all solid."""
        return Canvas(np.zeros_like(self.rooms))

    def window(self, rect: Rect) -> tuple[slice, slice]:
        """Rows and columns of the cells within a rectangle, as far as it is on the canvas."""
        height, width = self.rooms.shape
        left, right = (min(max(round(x / FINE_M), 0), width) for x in (rect.low[0], rect.high[0]))
        bottom, top = (min(max(round(y / FINE_M), 0), height) for y in (rect.low[1], rect.high[1]))
        return slice(height - top, height - bottom), slice(left, right)

    def paint(self, rect: Rect, room: int) -> None:
        """Give the cells within a rectangle to a room."""
        self.rooms[self.window(rect)] = room

    def open(self, rect: Rect, line: NDArray[np.float64], rooms: tuple[int, int]) -> None:
        """Give the cells of a rectangle to the rooms on the left and on the right of a line (2, 2) through it."""
        rows, cols = self.window(rect)
        x, y = self._centres(rows, cols)
        (x0, y0), (x1, y1) = line.tolist()
        left = (x1 - x0) * (y - y0) >= (y1 - y0) * (x - x0)
        self.rooms[rows, cols] = np.where(left, *rooms)

    def block(self, shape: Shape) -> None:
        """Make the cells solid whose centres lie within a convex polygon."""
        rows, cols = self.window(around(shape).grown(FINE_M, FINE_M))
        x, y = self._centres(rows, cols)
        inside = np.ones((y.size, x.size), np.bool_)
        for (x0, y0), (x1, y1) in zip(shape.tolist(), np.roll(shape, -1, axis=0).tolist(), strict=True):
            inside &= (x1 - x0) * (y - y0) >= (y1 - y0) * (x - x0)
        self.rooms[rows, cols][inside] = 0

    def _centres(self, rows: slice, cols: slice) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return x (1, w) and y (h, 1) of the middles of the cells of a window."""
        x = (np.arange(cols.start, cols.stop) + 0.5) * FINE_M
        y = (self.rooms.shape[0] - np.arange(rows.start, rows.stop) - 0.5) * FINE_M
        return x[np.newaxis], y[:, np.newaxis]

    def at(self, point: tuple[float, float]) -> int:
        """Room at a point, 0 beyond the edges."""
        row, col = self.rooms.shape[0] - 1 - math.floor(point[1] / FINE_M), math.floor(point[0] / FINE_M)
        inside = 0 <= row < self.rooms.shape[0] and 0 <= col < self.rooms.shape[1]
        return int(self.rooms[row, col]) if inside else 0

    def placed(self, yaw_rad: float, cell_m: float, margin_m: float, phase: tuple[float, float]) -> Placed:
        """Return the canvas turned and laid on cells of `cell_m`: each has the room of its middle.

        Around it are `margin_m` and up to a cell more, by `phase` (two shares of a cell); the origin is (0, 0).
        """
        source, (wide_m, high_m) = self.turned(yaw_rad, (margin_m + phase[0] * cell_m, margin_m + phase[1] * cell_m))
        rows, cols = (math.ceil((side_m + 2 * margin_m) / cell_m) + 1 for side_m in (high_m, wide_m))
        target = Frame(rows, cols, cell_m)
        return Placed(_sampled(self.rooms, source, target), source, cell_m)

    def turned(self, yaw_rad: float, low_m: tuple[float, float] = (0.0, 0.0)) -> tuple[Frame, tuple[float, float]]:
        """Return where the turned canvas lies with its lowest x and y at `low_m`, and how wide and high it is then."""
        height, width = self.rooms.shape
        corners = np.array([(-0.5, -0.5), (-0.5, width - 0.5), (height - 0.5, -0.5), (height - 0.5, width - 0.5)])
        points = Frame(height, width, FINE_M, yaw_rad=yaw_rad).world_from_cell(corners)
        (left, bottom), (right, top) = points.min(axis=0).tolist(), points.max(axis=0).tolist()
        frame = Frame(height, width, FINE_M, low_m[0] - left, low_m[1] - bottom, yaw_rad)
        return frame, (right - left, top - bottom)


@dataclass(eq=False)
class Placed:
    """A canvas on the map's cells: the rooms of these, and where the canvas lies on the map."""

    rooms: Rooms
    canvas: Frame
    cell_m: float

    @property
    def frame(self) -> Frame:
        """The map's own frame."""
        return Frame(self.rooms.shape[0], self.rooms.shape[1], self.cell_m)

    def on_map(self, raster: NDArray[Any]) -> NDArray[Any]:
        """Another raster of the canvas's shape on the map's cells (h, w), 0 beyond it."""
        return _sampled(raster, self.canvas, self.frame)

    def map_from_plan(self, points_m: NDArray[np.float64]) -> NDArray[np.float64]:
        """Map coordinates (k, 2) of points of the plan (k, 2), both x, y."""
        flat = Frame(self.canvas.height, self.canvas.width, FINE_M)
        return self.canvas.world_from_cell(flat.cell_from_world(points_m))

    def cells_from_plan(self, points_m: NDArray[np.float64]) -> NDArray[np.float64]:
        """Cells (k, 2) as row, col of points of the plan (k, 2), not rounded."""
        return self.frame.cell_from_world(self.map_from_plan(points_m))


def _sampled(raster: NDArray[Any], source: Frame, target: Frame) -> NDArray[Any]:
    """Return a raster at the middles of another frame's cells, 0 beyond its edges."""
    # The map from cells to cells is affine: three points give all of it, and sums of a column and a row are cheap.
    start, down, right = source.cell_from_world(target.world_from_cell(np.array([(0, 0), (1, 0), (0, 1)])))
    steps = np.arange(target.height)[:, np.newaxis], np.arange(target.width)
    row, col = (start[k] + steps[0] * (down - start)[k] + steps[1] * (right - start)[k] for k in (0, 1))
    return nearest(raster, row, col)


def nearest(raster: NDArray[Any], row: NDArray[np.float64], col: NDArray[np.float64], beyond: int = 0) -> NDArray[Any]:
    """Return a raster's values at places between its cells, and `beyond` outside."""
    row, col = np.rint(row).astype(np.intp), np.rint(col).astype(np.intp)
    height, width = raster.shape
    known = (row >= 0) & (row < height) & (col >= 0) & (col < width)
    at = np.where(known, row * width + col, 0)
    return np.where(known, raster.ravel()[at], beyond).astype(raster.dtype)
