"""Ways through places that are too narrow for the robot asked about, where the map has no wider one."""

from __future__ import annotations

import numpy as np
import scipy
from numpy.typing import NDArray

from vdoor.navigate.roadmap_floor import Floor, cell_of

Point = tuple[float, float]
Ints = NDArray[np.int64]
Floats = NDArray[np.float64]

STEEP = 3
"""Below the clearance asked for a step costs (asked / its clearance) ** STEEP, so that ways keep to the middle."""


def narrow_ways(floor: Floor, part: NDArray[np.intp], stuck: list[Point]) -> list[list[Point]]:
    """The cheapest ways that join the parts of a room's floor, as many as it takes: their ends and bends, as row, col.

    `part` (h, w) is the part of each allowed cell, -1 for others. `stuck` are further places, each a part of its own:
    doors in which the robot does not fit, and the room's middle. No way leads to those that lie in what is blocked.
    """
    steps, number = floor.within.graph(floor.own)
    stuck = [place for place in stuck if number[cell_of(place)] >= 0]
    steps = _weighted(floor, steps)
    cells = np.argwhere(number >= 0)
    known = part[tuple(cells.T)]
    if not stuck and (known < 0).all():
        return []
    at_cell = {int(number[cell_of(place)]): place for place in reversed(stuck)}
    first = int(part.max(initial=-1)) + 1
    for more, node in enumerate(at_cell):
        known[node] = first + more
    spent, before, source = scipy.sparse.csgraph.dijkstra(
        steps, directed=False, indices=np.flatnonzero(known >= 0), min_only=True, return_predecessors=True
    )
    reached = np.where(source >= 0, known[np.maximum(source, 0)], -1)  # -9999 where there is none
    ways = []
    for joint in _joints(steps, spent, reached):
        one, other = (_trace(before, node) for node in joint)
        ends = [[at_cell[trace[-1]]] if trace[-1] in at_cell else [] for trace in (one, other)]
        path = np.array([*ends[0], *cells[one[::-1] + other].tolist(), *ends[1]], np.float64)
        moves = np.append(True, np.diff(path, axis=0).any(axis=1))
        ways.append(straightened(floor, path[moves]))
    twice = [place for place in stuck if place not in at_cell.values()]
    return ways + [[place, at_cell[int(number[cell_of(place)])]] for place in twice]


def _weighted(floor: Floor, steps: scipy.sparse.csr_array) -> scipy.sparse.csr_array:
    """The steps with costs for lengths: more where they come near to what is blocked."""
    asked = floor.clear.radius_m / floor.frame.resolution_m
    weight = np.maximum(asked / np.maximum(floor.clearance[floor.own], 0.5), 1.0) ** STEEP
    pairs = steps.tocoo()
    pairs.data = pairs.data * (weight[pairs.row] + weight[pairs.col]) / 2
    return pairs.tocsr()


def _joints(steps: scipy.sparse.csr_array, spent: Floats, part: NDArray[np.intp]) -> list[tuple[int, int]]:
    """Pairs of neighbouring cells in which ways from two parts meet, so that all parts are joined at the least cost."""
    pairs = steps.tocoo()
    cost = spent[pairs.row] + pairs.data + spent[pairs.col]
    meet = np.flatnonzero((part[pairs.row] < part[pairs.col]) & (part[pairs.row] >= 0))
    meet = meet[np.argsort(cost[meet], kind="stable")]
    joined: list[tuple[int, int]] = []
    group = np.arange(int(part.max(initial=-1)) + 1)
    for at in meet.tolist():
        one, other = int(pairs.row[at]), int(pairs.col[at])
        into, of = group[part[one]], group[part[other]]
        if into != of:
            joined.append((one, other))
            group[group == of] = into
    return joined


def _trace(before: NDArray[np.int32], node: int) -> list[int]:
    trace = [node]
    while before[trace[-1]] >= 0:
        trace.append(int(before[trace[-1]]))
    return trace


def straightened(floor: Floor, path: Floats) -> list[Point]:
    """The bends of a path (k, 2), its ends included, with few straight pieces between them.

    No piece comes nearer to walls than what it replaces, below the clearance asked for.
    """
    bends, ahead = [0], [len(path) - 1]
    while ahead:
        begin, end = bends[-1], ahead[-1]
        if end == begin + 1 or _straight(floor, path[begin : end + 1]):
            bends.append(ahead.pop())
        else:
            ahead.append(_farthest(path, begin, end))
    return [(float(row), float(col)) for row, col in path[bends]]


def _straight(floor: Floor, path: Floats) -> bool:
    """Whether the straight line between a path's ends stays in the room and comes no nearer to walls."""
    ends = path[[0, -1]]
    inside = floor.stays(ends[:1], ends[1:])[0]
    return bool(inside and floor.clearance_m(ends) >= floor.clearance_m(path) - 1e-9)


def _farthest(path: Floats, begin: int, end: int) -> int:
    """The point between two others that is farthest from the straight line through them."""
    along, between = path[end] - path[begin], path[begin + 1 : end] - path[begin]
    return begin + 1 + int(np.argmax(np.abs(between[:, 0] * along[1] - between[:, 1] * along[0])))
