"""Which parts of rooms are visited, where each is entered and left, and in which order."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations, pairwise
from typing import NamedTuple

import numpy as np
import scipy
import shapely
from numpy.typing import NDArray

from vdoor.navigate.coverage.net import Net
from vdoor.navigate.order import best_order

Ints = NDArray[np.intp]
Floats = NDArray[np.float64]

TOUCH = 5e-4
"""Parts nearer to each other than this touch, in cells."""


class Crossing(NamedTuple):
    """Where two parts touch: a point on the middle of the contact."""

    one: int
    other: int
    point: tuple[float, float]


class Visit(NamedTuple):
    """A visit to one part of a floor."""

    part: int
    way: Floats
    """Row, col of the way to where it begins (k, 2), which is its last point."""
    leave: Floats | None
    """Row, col (2,) of where it ends; None if it may end anywhere."""


class Round(NamedTuple):
    """All visits of a path."""

    visits: list[Visit]
    home: Floats
    """The way from the last visit to the path's end (k, 2); empty if it ends with the visit."""


@dataclass(frozen=True, eq=False)
class Parts:
    """The parts of a floor, the points where they touch, and the ways between these."""

    net: Net
    """Over the crossings, then a point in each part, then the start and the end."""
    distance: Floats
    """Between the points of the net, inside parts and over crossings, in cells."""
    before: NDArray[np.int32]
    """The point before each point on the way from each point."""
    crossings: int

    @classmethod
    def of(cls, floor: shapely.MultiPolygon, floors: Sequence[shapely.Polygon], ends: Floats) -> Parts:
        """The parts `floors` of a floor, for a path with given `ends` (2, 2), its start first."""
        crossings = crossings_of(floors)
        inner = shapely.get_coordinates([part.representative_point() for part in floors])
        points = np.array([crossing.point for crossing in crossings]).reshape(-1, 2)
        net = Net.over(floor, np.concatenate([points, inner, ends]))
        inside: list[list[int]] = [[len(points) + part] for part in range(len(floors))]
        for number, crossing in enumerate(crossings):
            inside[crossing.one].append(number)
            inside[crossing.other].append(number)
        for number, end in enumerate(map(shapely.Point, ends), start=len(points) + len(floors)):
            inside[int(shapely.distance(floors, end).argmin())].append(number)
        pair = np.array([pair for own in inside for pair in combinations(own, 2)], np.intp)
        length = net.distance[pair[:, 0], pair[:, 1]]
        graph = scipy.sparse.coo_array((length, (pair[:, 0], pair[:, 1])), shape=net.distance.shape).tocsr()
        return cls(net, *scipy.sparse.csgraph.dijkstra(graph, directed=False, return_predecessors=True), len(points))

    def round(self, wanted: Sequence[int], *, ends: bool, ordered: bool = False) -> Round:
        """Visits to the parts `wanted` that can be reached, to the end if it `ends`.

        They are `ordered` already, or come in the order of a short tour.
        """
        start, end = len(self.distance) - 2, len(self.distance) - 1
        anchor = self.crossings + np.array(wanted, np.intp)
        stops = [start, *anchor[np.isfinite(self.distance[start, anchor])].tolist(), *([end] if ends else [])]
        if not ordered:
            between = self.distance[np.ix_(stops, stops)]
            order = best_order(between, start=0, end=len(stops) - 1 if ends else None)
            stops = [stops[place] for place in order.places]
        links = [self._crossed(one, other) for one, other in pairwise(stops)]
        links[0].insert(0, start)
        if ends:
            links[-1].append(end)
        ways = [self._way(link) for link in links]
        leaves = [way[0] for way in ways[1:]] + ([] if ends else [None])
        parts = [stop - self.crossings for stop in stops[1 : len(leaves) + 1]]
        visits = [Visit(part, way, leave) for part, way, leave in zip(parts, ways, leaves, strict=False)]
        return Round(visits, ways[-1] if ends else np.zeros((0, 2)))

    def _crossed(self, start: int, end: int) -> list[int]:
        """The crossings on the way from one point to another."""
        nodes = [end]
        while nodes[-1] != start:
            nodes.append(int(self.before[start, nodes[-1]]))
        return [node for node in nodes[::-1] if node < self.crossings]

    def _way(self, points: Sequence[int]) -> Floats:
        """The way over some points of the net."""
        ways = [self.net.way(one, other) for one, other in pairwise(points)]
        return np.concatenate([self.net.point[self.net.node[points[:1]]], *ways])


def crossings_of(floors: Sequence[shapely.Polygon]) -> list[Crossing]:
    """A crossing for each connected contact of two parts."""
    tree = shapely.STRtree(floors)
    grown = shapely.buffer(floors, TOUCH)
    pairs = tree.query(grown, predicate="intersects").T
    found = []
    for one, other in sorted((int(a), int(b)) for a, b in pairs if a < b):
        contact = shapely.union_all(shapely.get_parts(shapely.intersection(grown[one], floors[other])))
        for piece in shapely.get_parts(contact):
            point = shapely.get_coordinates(piece.representative_point())[0]
            found.append(Crossing(one, other, (float(point[0]), float(point[1]))))
    return found
