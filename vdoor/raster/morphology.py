"""Morphology and connected components of rasters, by OpenCV: exact, and several times as fast as SciPy's.

An element is a small mask (j, k); where it fits is indexed by its middle cell, (j // 2, k // 2).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

Ints = NDArray[np.int32]
Mask = NDArray[np.bool_]

CROSS = np.array([[0, 1, 0], [1, 1, 1], [0, 1, 0]], np.bool_)
"""A cell and its four neighbours."""
BAND_CELLS = 1 << 22
"""Cells of a raster that are worked on at a time: a mask of so many fits a processor's cache."""
EXACT_CELLS = 2000
"""Distances up to this, in cells, have squares that are found exactly from OpenCV's 24 bits."""


def labelled(mask: Mask, connectivity: int = 1) -> Ints:
    """The connected component (h, w) of each cell, from 1 in reading order; 4-connected (1) or 8-connected (2).

    For small rasters; `parts_of_mask` takes less of large ones.
    """
    return counted(mask, connectivity)[0]


def counted(mask: Mask, connectivity: int = 1) -> tuple[Ints, int]:
    """The same, and the number of components."""
    ways = 4 * connectivity
    count, label = cv2.connectedComponentsWithAlgorithm(bytes_of(mask), ways, cv2.CV_32S, cv2.CCL_SAUF)
    return np.asarray(label, np.int32), count - 1


def bytes_of(mask: Mask) -> NDArray[np.uint8]:
    """A mask as bytes, row by row, without a copy if it lies so."""
    return np.ascontiguousarray(mask).view(np.uint8)


def in_bands(of: Callable[[Mask], Mask], mask: Mask, reach: int) -> Mask:
    """The result (h, w) of a function of a mask, made for some rows at a time, which takes little memory.

    A cell of the result may depend on the rows up to `reach` away only.
    """
    height, width = mask.shape
    rows = max(BAND_CELLS // max(width, 1), 1)
    if rows >= height:
        return of(mask)
    found = np.empty_like(mask)
    for top in range(0, height, rows):
        first = max(top - reach, 0)
        found[top : top + rows] = of(mask[first : top + rows + reach])[top - first :][:rows]
    return found


def room_for(mask: Mask, element: Mask, *, outside: bool = False) -> Mask:
    """Where an element fits into a mask (h, w); cells outside it are set or not, as `outside` says."""
    middle = element.shape[1] // 2, element.shape[0] // 2
    border: dict[str, Any] = {"borderType": cv2.BORDER_CONSTANT, "borderValue": (float(outside),)}
    return np.asarray(cv2.erode(bytes_of(mask), bytes_of(element), anchor=middle, **border)).view(np.bool_)


def covered(room: Mask, element: Mask) -> Mask:
    """The cells (h, w) that an element covers wherever it is placed; `room` is indexed as from `room_for`."""
    if not element.any():
        return np.zeros_like(room)
    middle = (element.shape[1] - 1) // 2, (element.shape[0] - 1) // 2
    border: dict[str, Any] = {"borderType": cv2.BORDER_CONSTANT, "borderValue": (0.0,)}
    return np.asarray(cv2.dilate(bytes_of(room), bytes_of(element[::-1, ::-1]), anchor=middle, **border)).view(np.bool_)


def steps_to_middle(element: Mask, width: int) -> NDArray[np.intp]:
    """The flat steps (k,), in a raster so wide, from each cell of a square element to its middle.

    Elements do not fit so near to the edge that a step beyond it, in the next row, would find one.
    """
    middle = len(element) // 2
    row, column = np.nonzero(element)
    return np.asarray((middle - row) * width + middle - column)


def opened(mask: Mask, element: Mask, *, outside: bool = False) -> Mask:
    """The morphological opening of a mask (h, w) by an element: all cells it covers where it fits."""
    return covered(room_for(mask, element, outside=outside), element)


def eroded(mask: Mask) -> Mask:
    """The cells of a mask (h, w) whose four neighbours are set as well; there are none outside."""
    return room_for(mask, CROSS)


def dilated(mask: Mask) -> Mask:
    """The cells of a mask (h, w) and their four neighbours."""
    return covered(mask, CROSS)


def with_neighbours(mask: Mask) -> Mask:
    """The cells of a mask (h, w) and their eight neighbours."""
    return covered(mask, square(3))


def square(side: int) -> Mask:
    """A square of `side` cells."""
    return np.ones((side, side), np.bool_)


def distances(mask: Mask) -> NDArray[np.float32]:
    """The distance (h, w) in cells of each set cell from the nearest one that is not; see `exact`."""
    return np.asarray(cv2.distanceTransform(bytes_of(mask), cv2.DIST_L2, cv2.DIST_MASK_PRECISE), np.float32)


def exact(distance: NDArray[np.float32]) -> NDArray[np.float64]:
    """Distances up to `EXACT_CELLS` to the last bit, as roots of whole numbers."""
    return np.sqrt(np.rint(np.square(distance, dtype=np.float64)))
