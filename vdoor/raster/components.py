"""Connected components of a graph, and the pieces that the contacts between rooms form."""

from __future__ import annotations

import numpy as np
import scipy
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int32]


def components(links: NDArray[np.intp], count: int) -> NDArray[np.intp]:
    """Component (count,) of each node, given links (2, k) between nodes.

    Components are numbered in the order of their first nodes.
    """
    if not count:
        return np.zeros(0, np.intp)
    graph = scipy.sparse.coo_array((np.ones(links.shape[1], np.bool_), (links[0], links[1])), shape=(count, count))
    found, label = scipy.sparse.csgraph.connected_components(graph, directed=False)
    first = np.empty(found, np.intp)
    first[label[::-1]] = np.arange(count)[::-1]
    number = np.empty(found, np.intp)
    number[np.argsort(first)] = np.arange(found)
    return number[label]


def contacts(labels: Ints) -> tuple[Floats, Ints]:
    """Cell sides where two rooms touch: their midpoints (k, 2) as row, col, and the two rooms (k, 2), lower first."""
    places, pairs = [], []
    for step in ((0, 1), (1, 0)):
        one = labels[: labels.shape[0] - step[0], : labels.shape[1] - step[1]]
        other = labels[step[0] :, step[1] :]
        row, col = np.nonzero((one != other) & (one > 0) & (other > 0))
        places.append(np.stack([row, col], axis=1) + np.array(step) / 2)
        pairs.append(np.sort(np.stack([one[row, col], other[row, col]], axis=1), axis=1))
    return np.concatenate(places), np.concatenate(pairs)


def contact_pieces(place: Floats, pair: Ints, gap: float) -> NDArray[np.intp]:
    """Connected piece (k,) of each contact, numbered from 0: the same two rooms, steps of at most `gap` cells."""
    if not len(place):
        return np.zeros(0, np.intp)
    near = scipy.spatial.cKDTree(place).query_pairs(gap, output_type="ndarray")
    near = near[(pair[near[:, 0]] == pair[near[:, 1]]).all(axis=1)]
    return components(near.T, len(place))
