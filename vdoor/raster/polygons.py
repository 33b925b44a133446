"""Shapes of labelled regions: their central cells, and polygons with holes."""

from __future__ import annotations

import numpy as np
import scipy
from numpy.typing import NDArray

from vdoor.raster.contours import CRACK_START, Contours, follow
from vdoor.raster.labels import parts_of
from vdoor.raster.runs import runs_of

Ints = NDArray[np.int32]


def centres(label: Ints, count: int) -> Ints:
    """The cell (count, 2) of each label 1 to `count` that is nearest to the mean of its cells; the first at a tie."""
    mean = runs_of(label).means(count)
    centre = np.rint(mean).astype(np.int32)
    elsewhere = label[centre[:, 0], centre[:, 1]] != np.arange(1, count + 1)
    boxes = scipy.ndimage.find_objects(label, max_label=count) if elsewhere.any() else []
    for region in np.flatnonzero(elsewhere):
        box = boxes[region]
        own = np.argwhere(label[box] == region + 1) + [side.start for side in box]
        centre[region] = own[np.argmin(((own - mean[region]) ** 2).sum(axis=1))]
    return centre


def polygons(label: Ints) -> tuple[Ints, Ints, Ints]:
    """Rings around all labels: vertices (k, 2) in cell edges, label (k,) and ring (k,) of each vertex.

    The rings of a label are numbered from 0: the outer ring of its largest 4-connected part, the holes in it, then the
    outer ring of the next part, and so on. Outer rings run one way and holes the other; each ends with its first
    vertex.
    """
    part, contours = label, follow(label, cross_corners=True)
    bends, corner = _bends(contours)
    if _in_parts(contours, label, np.column_stack([contours.contour[bends], corner])):
        part = parts_of(label)
        contours = follow(part, cross_corners=True)
        bends, corner = _bends(contours)
    at = contours.cell[contours.first].T
    owner, own_part = label[*at], part[*at]
    size = np.bincount(part.ravel())[own_part] if part is not label else np.zeros(len(owner), np.intp)
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


def _in_parts(contours: Contours, label: Ints, vertex: NDArray[np.integer]) -> bool:
    """Whether a label has several outer rings, or one that touches itself where two of its parts meet at a corner.

    `vertex` (n, 3) are the vertices of all rings, each with the number of its ring.
    """
    owner = label[*contours.cell[contours.first[contours.outer]].T]
    return len(np.unique(owner)) < len(owner) or len(np.unique(vertex, axis=0)) < len(vertex)
