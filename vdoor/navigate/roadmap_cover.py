"""Where the nodes of a roadmap stand in a room: every place that keeps the clearance sees one of them nearby."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from vdoor.navigate.roadmap_floor import Floor, Spots
from vdoor.navigate.roadmap_spanner import Net, Ways, straight_ways

Ints = NDArray[np.int64]
Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]

Point = tuple[float, float]

REACH_M = 1.5
"""Every place sees a node that is at most so far away."""
AROUND = 1.1
"""A corner gets a node if the known ways around it are longer than the one by that node, by more than this factor."""


@dataclass(eq=False)
class Cover:
    """Nodes of a room, and which of them each cell sees; grows a node at a time."""

    floor: Floor
    points: list[Point] = field(default_factory=list)
    """The nodes as row, col of the floor; halves where they stand in a door."""
    eyes: list[Point] = field(default_factory=list)
    """Where each node looks from: itself, or just within the room where it stands in a door."""
    apart: Floats = field(init=False)
    """The distance in cells from each cell (h, w) to the nearest node that it sees; infinite if it sees none."""
    owner: Ints = field(init=False)
    """That node (h, w); -1 if there is none."""

    def __post_init__(self) -> None:
        """Begin with no cell seen."""
        self.apart = np.full(self.floor.allowed.shape, np.inf)
        self.owner = np.full(self.floor.allowed.shape, -1, np.int64)

    @property
    def reach(self) -> float:
        """`REACH_M` in cells."""
        return REACH_M / self.floor.frame.resolution_m

    def add(self, point: Point, eye: Point | None = None) -> None:
        """Add a node, which looks from `eye` if that is another place."""
        self.points.append(point)
        self.eyes.append(eye or point)
        cells = self._near(point)
        apart = np.hypot(*(cells - point).T)
        nearer = apart < self.apart[tuple(cells.T)]
        cells, apart = cells[nearer], apart[nearer]
        own = self.spots.of(np.full(len(cells), len(self.points) - 1))
        seen = self.floor.sees(own, Spots.at_cells(cells))
        cells = cells[seen]
        self.apart[tuple(cells.T)] = apart[seen]
        self.owner[tuple(cells.T)] = len(self.points) - 1

    def _near(self, point: tuple[float, float]) -> Ints:
        """The allowed cells (k, 2) within reach of a point."""
        low = [max(math.ceil(at - self.reach), 0) for at in point]
        high = [max(math.floor(at + self.reach) + 1, 0) for at in point]
        cells = np.argwhere(self.floor.allowed[low[0] : high[0], low[1] : high[1]]) + low
        found: Ints = cells[np.hypot(*(cells - point).T) <= self.reach]
        return found

    def fill(self) -> None:
        """Add nodes until every allowed cell sees one: each time at the unseen cell farthest from walls."""
        depth = np.where(self.floor.allowed, self.floor.clearance, -1.0)
        depth[self.owner >= 0] = -1.0
        while (best := int(np.argmax(depth))) >= 0 and depth.flat[best] >= 0:
            row, col = divmod(best, depth.shape[1])
            self.add((row, col))
            depth[self.owner >= 0] = -1.0

    def add_farthest(self) -> None:
        """Add a second node at the cell farthest from the only one, if that sees any other."""
        far = np.where(self.owner == 0, self.apart, 0.0)
        row, col = divmod(int(np.argmax(far)), far.shape[1])
        if far[row, col] > 0:
            self.add((row, col))

    @property
    def spots(self) -> Spots:
        """All nodes."""
        return Spots(np.array(self.points, np.float64), np.array(self.eyes, np.float64))

    def ways(self) -> Ways:
        """The straight ways between nodes that see each other, up to twice the reach."""
        spots = self.spots
        return straight_ways(
            spots.point, 2 * self.reach + 2, lambda one, other: self.floor.sees(spots.of(one), spots.of(other))
        )

    def join(self) -> None:
        """Add nodes around corners: where cells of two nodes touch and no way between these is nearly as short."""
        net = Net()
        for (one, other), length in zip(*(part.tolist() for part in self.ways()), strict=True):
            net.add(one, other, length)
        for one, other, corner, length in self._borders():
            if not net.within(one, other, AROUND * length):
                chain = [one, *self._around(one, other, corner), other]
                for ends in pairwise(chain):
                    net.add(*ends, math.dist(*(self.points[end] for end in ends)))

    def _around(self, one: int, other: int, corner: list[Point]) -> list[int]:
        """New nodes between two: the first of two touching cells if that one does, else both."""
        cells = np.array([*corner, *corner], np.intp)
        ends = self.spots.of(np.array([one, one, other, other]))
        from_one, from_other = self.floor.sees(ends, Spots.at_cells(cells)).reshape(2, 2)
        sole = np.flatnonzero(from_one & from_other)
        for cell in [corner[sole[0]]] if len(sole) else corner:
            self.add(cell)
        return list(range(len(self.points) - (1 if len(sole) else 2), len(self.points)))

    def _borders(self) -> list[tuple[int, int, list[Point], float]]:
        """Pairs of nodes whose cells touch: the two, the cells to pass from one to the other, and the length that way.

        The shortest way of each pair, in the order of their lengths.
        """
        steps, number = self.floor.clear.graph(self.floor.allowed)
        pairs = steps.tocoo()
        cells = np.argwhere(number >= 0)
        owner, apart = self.owner[tuple(cells.T)], self.apart[tuple(cells.T)]
        one, other = owner[pairs.row], owner[pairs.col]
        length = apart[pairs.row] + pairs.data / self.floor.frame.resolution_m + apart[pairs.col]
        kept = np.flatnonzero((one < other) & (one >= 0))
        kept = kept[np.argsort(length[kept], kind="stable")]
        _, first = np.unique(np.stack([one[kept], other[kept]], axis=1), axis=0, return_index=True)
        found = []
        for at in kept[np.sort(first)].tolist():
            corner = [(float(row), float(col)) for row, col in cells[[pairs.row[at], pairs.col[at]]]]
            found.append((int(one[at]), int(other[at]), corner, float(length[at])))
        return found
