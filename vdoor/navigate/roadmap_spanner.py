"""Few straight ways between the nodes of a roadmap that are nearly as short as all of them."""

from __future__ import annotations

import heapq
import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import scipy
from numpy.typing import NDArray

Ints = NDArray[np.int64]
Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]


class Ways(NamedTuple):
    """Straight ways between nodes."""

    ends: Ints
    """The two nodes (k, 2) of each, the lower first."""
    length: Floats
    """Lengths (k,) in cells."""


def straight_ways(points: Floats, most: float, sees: Callable[[Ints, Ints], Mask]) -> Ways:
    """The ways between nodes (n, 2) up to a length; `sees` says of pairs (k,) of them whether one sees the other."""
    ends = scipy.spatial.cKDTree(points).query_pairs(most, output_type="ndarray").astype(np.int64)
    ends = ends[np.lexsort(ends.T[::-1])]
    ends = ends[sees(ends[:, 0], ends[:, 1])]
    return Ways(ends, np.hypot(*(points[ends[:, 0]] - points[ends[:, 1]]).T))


class Net:
    """Ways between nodes that are added one after the other."""

    def __init__(self) -> None:
        self._near: dict[int, list[tuple[int, float]]] = {}

    def add(self, one: int, other: int, length: float) -> None:
        """Add a way, which can be gone both ways."""
        self._near.setdefault(one, []).append((other, length))
        self._near.setdefault(other, []).append((one, length))

    def within(self, start: int, end: int, most: float) -> bool:
        """Whether a path between two nodes is at most so long."""
        least, queue = {start: 0.0}, [(0.0, start)]
        while queue:
            length, node = heapq.heappop(queue)
            if node == end:
                return True
            if length > least[node]:
                continue
            for after, step in self._near.get(node, ()):
                there = length + step
                if there <= most and there < least.get(after, math.inf):
                    least[after] = there
                    heapq.heappush(queue, (there, after))
        return False


def spanner(ways: Ways, stretch: float) -> Ways:
    """Some of the ways, by which each of the others can be gone with at most `stretch` times its length.

    Greedy: a way is taken if those taken before, which are shorter, do not do.
    """
    net, taken = Net(), np.zeros(len(ways.length), np.bool_)
    for at in np.argsort(ways.length, kind="stable").tolist():
        (one, other), length = ways.ends[at].tolist(), float(ways.length[at])
        if not net.within(one, other, stretch * length):
            net.add(one, other, length)
            taken[at] = True
    return Ways(ways.ends[taken], ways.length[taken])
