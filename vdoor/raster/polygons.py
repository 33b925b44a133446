"""Shapes of labelled regions: their central cells, and polygons with holes."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from vdoor.raster.contours import CRACK_START, follow
from vdoor.raster.runs import runs_of

Ints = NDArray[np.int32]


def centres(label: Ints, count: int) -> Ints:
    """The cell (count, 2) of each label 1 to `count` that is nearest to the mean of its cells; the first at a tie."""
    mean = runs_of(label).means(count)
    centre = np.rint(mean).astype(np.int32)
    elsewhere = label[centre[:, 0], centre[:, 1]] != np.arange(1, count + 1)
    boxes = ndimage.find_objects(label, max_label=count) if elsewhere.any() else []
    for region in np.flatnonzero(elsewhere):
        box = boxes[region]
        own = np.argwhere(label[box] == region + 1) + [side.start for side in box]
        centre[region] = own[np.argmin(((own - mean[region]) ** 2).sum(axis=1))]
    return centre


def polygons(label: Ints) -> tuple[Ints, Ints, Ints]:
    """Rings around all labels: vertices (k, 2) in cell edges, label (k,) and ring (k,) of each (0 = outer, then holes).

    Each ring ends with its first vertex.
    """
    contours = follow(label, cross_corners=True)
    before = np.arange(-1, len(contours.turn) - 1)
    before[contours.first] = contours.first + contours.length - 1
    bends = np.flatnonzero(contours.turn[before] != 0)
    corner = contours.cell[bends] + CRACK_START[contours.heading[bends]]
    owner = label[contours.cell[contours.first, 0], contours.cell[contours.first, 1]]
    order = np.lexsort((np.arange(len(owner)), ~contours.outer, owner))
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
