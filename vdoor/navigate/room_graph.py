"""The steps of the robot within a part of the map, and distances over them that add up exactly."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from functools import cached_property
from typing import NamedTuple

import numpy as np
import scipy
from numpy.typing import NDArray

from vdoor.frame import Frame
from vdoor.navigate.space import Space

Ints = NDArray[np.int32]
Mask = NDArray[np.bool_]
Cell = tuple[int, int]
Box = tuple[slice, ...]

STRAIGHT, DIAGONAL = 408, 577
"""Lengths of steps, whole so that sums do not depend on their order; 577 / 408 is the root of 2 within 2e-6."""
FAR = np.iinfo(np.int32).max // 2
"""The distance to a cell that cannot be reached; a step can be added to it."""
NEIGHBOURS = tuple((row, col) for row in (-1, 0, 1) for col in (-1, 0, 1) if row or col)


class Step(NamedTuple):
    """A step to a neighbour, in a flat array."""

    by: int
    length: int
    diagonal: bool
    corner: int
    """How far on the corner is that a diagonal step passes."""


NO_STEP = Step(0, 1, diagonal=False, corner=0)


@dataclasses.dataclass(frozen=True, eq=False)
class RoomGraph:
    """Some allowed cells, such as those of a room and of the portals around it, and the steps between them."""

    corner: Cell
    """Row, col, in the map, of the upper left cell of `node`."""
    node: Ints
    """The number of each cell (h, w) of a part of the map, -1 for cells that do not belong to the graph."""
    steps: scipy.sparse.csr_array
    crossing: Mask
    """The corners of cells that keep the clearance (h - 1, w - 1)."""

    @classmethod
    def of_room(cls, space: Space, labels: Ints, room: int, box: Box, portals: Sequence[Cell]) -> RoomGraph:
        """The graph of a room that lies in a box of the map; portals may lie one cell outside of the room."""
        rows, cols = (slice(max(side.start - 1, 0), side.stop + 1) for side in box)
        cells = space.allowed[rows, cols] & (labels[rows, cols] == room)
        for row, col in portals:
            cells[row - rows.start, col - cols.start] = True
        return cls.of(space, (rows, cols), cells)

    @classmethod
    def of(cls, space: Space, box: Box, cells: Mask) -> RoomGraph:
        """The graph of allowed cells (h, w) in a box of the map."""
        part = cropped(space, *box)
        steps, node = part.graph(cells)
        diagonal = steps.data > 1.2 * space.frame.resolution_m  # between 1 and the root of 2
        steps.data = np.where(diagonal, float(DIAGONAL), float(STRAIGHT))
        return cls((box[0].start, box[1].start), node, steps, part.crossing)

    def number(self, cell: Cell) -> int:
        """The node of a cell of the map; -1 if it is not in the graph."""
        row, col = cell[0] - self.corner[0], cell[1] - self.corner[1]
        inside = 0 <= row < self.node.shape[0] and 0 <= col < self.node.shape[1]
        return int(self.node[row, col]) if inside else -1

    def distances(self, source: Cell, *, limit: float = np.inf) -> Ints:
        """The distance (n,) of each node from a cell, `FAR` beyond the limit."""
        found = scipy.sparse.csgraph.dijkstra(self.steps, indices=np.array(self.number(source)), limit=limit)
        return np.where(np.isfinite(found), found, float(FAR)).astype(np.int32)

    def way(self, start: Cell, distance: Ints) -> list[Cell]:
        """The ends and bends of a shortest way from a cell to the source of some distances.

        Of several next cells the one straight ahead is taken, or the first in reading order: the way depends on the
        distances alone.
        """
        far, (node, _, width) = distance.data, self._flat
        at = self._place(start)
        left, ahead, turns = far[node[at]], NO_STEP, []
        while left:
            step = self._nearer(at, left, ahead, far)
            if step is not ahead:
                turns.append(at)
            at, left, ahead = at + step.by, left - step.length, step
        return [self._cell(place, width) for place in (*(turns or [at]), *([at] if turns else []))]

    def _nearer(self, at: int, left: int, ahead: Step, far: memoryview) -> Step:
        """The next step of a way at a place from where `left` is left."""
        node, corner, _ = self._flat
        for step in (ahead, *self._steps):
            to = node[at + step.by]
            if to >= 0 and far[to] + step.length == left and (not step.diagonal or corner[at + step.corner]):
                return step
        raise AssertionError("a cell at a distance has a neighbour nearer by a step")

    def _place(self, cell: Cell) -> int:
        """Where a cell is in `_flat`."""
        return (cell[0] - self.corner[0] + 1) * self._flat[2] + cell[1] - self.corner[1] + 1

    def _cell(self, place: int, width: int) -> Cell:
        return place // width + self.corner[0] - 1, place % width + self.corner[1] - 1

    @cached_property
    def _flat(self) -> tuple[memoryview, memoryview, int]:
        """Nodes and corners with a margin of one cell, flat, and the width: fast to read one by one."""
        height, width = self.node.shape
        corner = np.zeros((height + 2, width + 2), np.bool_)
        corner[1:height, 1:width] = self.crossing
        node = np.pad(self.node, 1, constant_values=-1)
        return node.reshape(-1).data, corner.reshape(-1).data, width + 2

    @cached_property
    def _steps(self) -> list[Step]:
        """The steps to the eight neighbours, in reading order."""
        width = self._flat[2]
        return [
            Step(
                down * width + right,
                DIAGONAL if down and right else STRAIGHT,
                bool(down and right),
                min(down, 0) * width + min(right, 0),
            )
            for down, right in NEIGHBOURS
        ]


def beeline(start: Cell, goal: Cell) -> int:
    """The least length over cells between two cells."""
    low, high = sorted((abs(start[0] - goal[0]), abs(start[1] - goal[1])))
    return low * DIAGONAL + (high - low) * STRAIGHT


def local_way(space: Space, start: Cell, goal: Cell, most: int) -> list[Cell] | None:
    """The ends and bends of a shortest way of at most that length between two allowed cells; None if there is none.

    It is searched among the cells that a way of that length can pass, which are few if it is almost straight.
    """
    pad = (most - beeline(start, goal)) // (2 * (DIAGONAL - STRAIGHT)) + 1  # aside, where steps lose least
    box = tuple(
        slice(max(min(ends) - pad, 0), min(max(ends) + pad + 1, side))
        for *ends, side in zip(start, goal, space.allowed.shape, strict=True)
    )
    detour = _beelines(start, box) + _beelines(goal, box)
    graph = RoomGraph.of(space, box, space.allowed[box] & (detour <= most))
    distance = graph.distances(goal, limit=most)
    return graph.way(start, distance) if distance[graph.number(start)] < FAR else None


def _beelines(cell: Cell, box: Box) -> Ints:
    """The least lengths (h, w) over cells between one cell and those of a box."""
    rows, cols = (np.abs(np.arange(side.start, side.stop) - at) for at, side in zip(cell, box, strict=True))
    low, high = np.minimum(rows[:, None], cols), np.maximum(rows[:, None], cols)
    return np.asarray(low * (DIAGONAL - STRAIGHT) + high * STRAIGHT, np.int32)


def cropped(space: Space, rows: slice, cols: slice) -> Space:
    """A part of a space, with its own frame; what is allowed in it depends on the cells around it as well."""
    frame = space.frame
    height, width = space.allowed[rows, cols].shape
    x_m, y_m = frame.world_from_cell(np.array([[rows.start + height - 0.5, cols.start - 0.5]]))[0].tolist()
    return Space(
        Frame(height, width, frame.resolution_m, x_m, y_m, frame.yaw_rad),
        space.blocked[rows, cols],
        space.radius_m,
        space.allowed[rows, cols],
        space.crossing[rows.start : rows.start + height - 1, cols.start : cols.start + width - 1],
    )
