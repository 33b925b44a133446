"""Which nodes and doors of the problem lie beside each other, as lists for searches that go from one to the next."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Lists = list[list[int]]


class Adjacency(NamedTuple):
    """Lists by node or by edge; a node is a region or, numbered after these, a bundle of atoms."""

    neighbours: Lists
    """The nodes that touch each node."""
    nodes_of: Lists
    """The nodes that each edge covers."""
    covers: NDArray[np.intp]
    """The edges and the nodes (2, k) that they cover."""
    regions_of: Lists
    """The regions that each edge borders; none if the cost does not count what doors separate."""
    edges_of: Lists
    """The edges that border each node; likewise none."""
    conflicts: Lists
    """The edges in conflict with each edge."""


def grouped(pairs: NDArray[np.integer], count: int) -> Lists:
    """The second of the pairs (2, k) for each of the `count` first ones, ascending."""
    order = np.lexsort((pairs[1], pairs[0]))
    second = pairs[1, order].tolist()
    ends = np.cumsum(np.bincount(pairs[0], minlength=count)).tolist()
    return [second[begin:end] for begin, end in zip([0, *ends], ends, strict=False)]


def both_ways(pairs: NDArray[np.intp]) -> NDArray[np.intp]:
    """The pairs (2, k) and their mirrors (2, 2 k)."""
    return np.concatenate([pairs, pairs[::-1]], axis=1)
