"""Shapes of labelled regions: their central cells, and polygons with holes."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from vdoor.raster.contours import CRACK_START, Contours, follow
from vdoor.raster.runs import Runs, parts_of_runs

Ints = NDArray[np.int32]


def centres(runs: Runs, count: int) -> Ints:
    """The cell (count, 2) of each label 1 to `count` that is nearest to the mean of its cells; the first at a tie."""
    mean = runs.means(count)
    centre = np.rint(mean).astype(np.int32)
    own = runs.at(np.ravel_multi_index(tuple(centre.T), runs.shape))
    elsewhere = np.flatnonzero(own != np.arange(1, count + 1))
    order, end = np.argsort(runs.label, kind="stable"), np.cumsum(np.bincount(runs.label, minlength=count + 1))
    for region in elsewhere.tolist():
        some = order[end[region] : end[region + 1]]
        begin, last = runs.begin[some, None], (runs.begin + runs.length)[some, None] - 1
        col = np.clip(np.floor(mean[region, 1]) + np.arange(2), begin, last)  # the nearest cell of a run is one of two
        row = np.repeat(runs.row[some], 2)
        best = np.argmin((row - mean[region, 0]) ** 2 + (col.ravel() - mean[region, 1]) ** 2)
        centre[region] = row[best], col.ravel()[best]
    return centre


def polygons(runs: Runs) -> tuple[Ints, Ints, Ints]:
    """Rings around all labels: vertices (k, 2) in cell edges, label (k,) and ring (k,) of each vertex.

    The rings of a label are numbered from 0: the outer ring of its largest 4-connected part, the holes in it, then the
    outer ring of the next part, and so on. Outer rings run one way and holes the other; each ends with its first
    vertex.
    """
    part, contours = runs, follow(runs, cross_corners=True)
    bends, corner = _bends(contours)
    if _in_parts(contours, runs, np.column_stack([contours.contour[bends], corner])):
        part = parts_of_runs(runs)
        contours = follow(part, cross_corners=True)
        bends, corner = _bends(contours)
    at = np.ravel_multi_index(tuple(contours.cell[contours.first].T), runs.shape)
    owner, own_part = runs.at(at), part.at(at)
    size = part.cells(part.most)[own_part - 1] if part is not runs else np.zeros(len(owner), np.int64)
    order = np.lexsort((np.arange(len(owner)), ~contours.outer, own_part, -size, owner))
    begin = np.searchsorted(owner[order], owner[order], "left")
    ring = np.empty(len(order), np.int32)
    ring[order] = np.arange(len(order)) - begin

    # repeat the first vertex of each ring at its end, and sort the rings by label
    of = contours.contour[bends]
    first = np.searchsorted(of, np.arange(len(owner)))
    index = np.concatenate([np.arange(len(of)), first])
    contour = np.concatenate([of, np.arange(len(owner))])
    rank = np.empty(len(owner), np.intp)
    rank[order] = np.arange(len(owner))
    sort = np.argsort(rank[contour], kind="stable")
    return corner[index[sort]].astype(np.int32), owner[contour[sort]].astype(np.int32), ring[contour[sort]]


def _bends(contours: Contours) -> tuple[NDArray[np.intp], Ints]:
    """The states (n,) at which a ring has a vertex, and these vertices (n, 2) in cell edges."""
    before = np.arange(-1, len(contours.turn) - 1)
    before[contours.first] = contours.first + contours.length - 1
    bends = np.flatnonzero(contours.turn[before] != 0)
    return bends, contours.cell[bends] + CRACK_START[contours.heading[bends]]


def _in_parts(contours: Contours, runs: Runs, vertex: NDArray[np.integer]) -> bool:
    """Whether a label has several outer rings, or one that touches itself where two of its parts meet at a corner.

    `vertex` (n, 3) are the vertices of all rings, each with the number of its ring.
    """
    owner = runs.at(np.ravel_multi_index(tuple(contours.cell[contours.first[contours.outer]].T), runs.shape))
    return len(np.unique(owner)) < len(owner) or len(np.unique(vertex, axis=0)) < len(vertex)
