"""Ways between points of a floor: straight lines that stay inside it, joined to a net with shortest ways."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy
import shapely
from numpy.typing import NDArray

from vdoor.navigate.coverage.floor import SNAP, enlarged
from vdoor.navigate.coverage.path import norms

Ints = NDArray[np.intp]
Floats = NDArray[np.float64]

NEAREST = 8
"""Each point is joined to so many of its nearest, besides its neighbours in a triangulation."""
SHORTEST = 1e-6
"""Length of a line between two points at the same place, in cells: zero would mean no line."""


@dataclass(frozen=True, eq=False)
class Net:
    """Shortest ways between some points, over each other and over the corners of the floor."""

    point: Floats
    """Row, col of the places of the points, each once, and then the corners (k, 2)."""
    node: Ints
    """The node (n,) of each point."""
    distance: Floats
    """Length of the way between two of the points (n, n), in cells; infinite without one."""
    before: NDArray[np.int32]
    """The node before each node on the way from each of the places; negative for none."""

    @classmethod
    def over(cls, floor: shapely.Polygon | shapely.MultiPolygon, points: Floats, lines: Ints | None = None) -> Net:
        """The net of points (k, 2) inside `floor`; `lines` (n, 2) between points are known to stay inside."""
        corners, sides = _corners(floor)
        node, of = _different(np.concatenate([points, corners]))
        of, sides = of[: len(points)], of[len(points) + sides]
        places = int(of.max()) + 1
        sure = [sides, *([] if lines is None else [of[lines]])]
        inside = enlarged(floor, SNAP)
        tried = _pairs(node, places)
        seen = tried[shapely.covers(inside, shapely.linestrings(node[tried]))]
        pair = np.unique(np.sort(np.concatenate([*sure, seen]), axis=1), axis=0)
        pair = np.concatenate([pair, _bridges(node, pair, inside)])
        length = np.maximum(norms(node[pair[:, 0]] - node[pair[:, 1]]), SHORTEST)
        graph = scipy.sparse.coo_array((length, (pair[:, 0], pair[:, 1])), shape=(len(node), len(node))).tocsr()
        distance, before = scipy.sparse.csgraph.dijkstra(
            graph, directed=False, indices=np.arange(places), return_predecessors=True
        )
        return cls(node, of, distance[np.ix_(of, of)], before)

    def way(self, start: int, end: int) -> Floats:
        """Row, col of the nodes on the way from one point to another, both included."""
        first, nodes = self.node[start], [int(self.node[end])]
        while nodes[-1] != first:
            nodes.append(int(self.before[first, nodes[-1]]))
        return self.point[nodes[::-1]]


def _different(point: Floats) -> tuple[Floats, Ints]:
    """The different points in their order, and which of them each is."""
    _, first, of = np.unique(point, axis=0, return_index=True, return_inverse=True)
    order = np.argsort(first)
    rank = np.empty_like(order)
    rank[order] = np.arange(len(order))
    return point[first[order]], rank[of]


def _corners(floor: shapely.Geometry) -> tuple[Floats, Ints]:
    """The vertices of a floor (k, 2), and its sides as pairs of them."""
    rings = [shapely.get_coordinates(ring)[:-1] for ring in shapely.get_rings(shapely.get_parts(floor))]
    first = np.cumsum([0, *map(len, rings)])
    sides = [np.stack([i, np.roll(i, -1)], axis=1) for i in map(np.arange, first[:-1], first[1:])]
    return np.concatenate(rings), np.concatenate(sides)


def _pairs(node: Floats, points: int) -> Ints:
    """Pairs of nodes that may see each other: neighbours in a triangulation, and the nearest of each point."""
    tried = [np.zeros((0, 2), np.intp)]
    try:
        corners = scipy.spatial.Delaunay(node).simplices.astype(np.intp)
        tried += [corners[:, [0, 1]], corners[:, [1, 2]], corners[:, [0, 2]]]
    except scipy.spatial.QhullError:
        pass  # too few nodes, or all in one line: the nearest are enough
    near = scipy.spatial.cKDTree(node[:points]).query(node[:points], k=np.arange(1, min(NEAREST + 1, points) + 1))[1]
    tried.append(np.stack([np.repeat(np.arange(points), near.shape[1]), near.reshape(-1)], axis=1))
    pair = np.unique(np.sort(np.concatenate(tried), axis=1), axis=0)
    return pair[pair[:, 0] < pair[:, 1]]


def _bridges(node: Floats, pair: Ints, inside: shapely.Geometry) -> Ints:
    """Lines that join the parts of the net: each node of a smaller part is tried with the nearest of the others."""
    graph = scipy.sparse.coo_array((np.ones(len(pair)), (pair[:, 0], pair[:, 1])), shape=(len(node), len(node)))
    count, part = scipy.sparse.csgraph.connected_components(graph, directed=False)
    if count == 1:
        return np.zeros((0, 2), np.intp)
    largest = part == np.bincount(part).argmax()
    small, large = np.flatnonzero(~largest), np.flatnonzero(largest)
    near = scipy.spatial.cKDTree(node[large]).query(node[small], k=np.arange(1, min(4 * NEAREST, len(large)) + 1))[1]
    tried = np.stack([np.repeat(small, near.shape[1]), large[near.reshape(-1)]], axis=1)
    return tried[shapely.covers(inside, shapely.linestrings(node[tried]))]
