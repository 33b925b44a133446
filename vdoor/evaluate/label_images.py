"""Label images: which labels count as rooms, rooms drawn as blobs, and labels flooding the cells beside them."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from vdoor.errors import VdoorError

MIN_ROOM_M2 = 0.25
"""Rooms of this area or less are ignored: 100 cells of 5 cm."""
MOST_ROOMS = 5_000
"""Rooms are compared each with each; more are noise."""
WHITE_FROM = 251
"""From this grey on a cell belongs to a room drawn as a blob."""

Labels = NDArray[np.int32]


def rooms_of(labels: NDArray[Any], resolution_m: float) -> Labels:
    """Rooms 1, 2, ... in the order of their labels (h, w), without those too small to be one; 0 stays no room.

    Raises `VdoorError` where more are left than can be compared.
    """
    values, place, cells = np.unique(labels, return_inverse=True, return_counts=True)
    # Rounded: 0.25 m2 are 100 cells of 5 cm, not 99.99999999999999.
    counts = (values != 0) & (cells > round(MIN_ROOM_M2 / resolution_m**2, 6))
    rooms = int(counts.sum())
    if rooms > MOST_ROOMS:
        raise VdoorError(f"labels: wanted at most {MOST_ROOMS} rooms, found {rooms}")
    numbers = np.where(counts, np.cumsum(counts), 0).astype(np.int32)
    return numbers[place].reshape(labels.shape)


def labels_of_blobs(greys: NDArray[np.uint8]) -> Labels:
    """Labels (h, w) of rooms drawn white and parted by darker lines; diagonal neighbours are one room."""
    labels, _ = ndimage.label(greys >= WHITE_FROM, structure=np.ones((3, 3)))
    return np.asarray(labels, np.int32)


def flooded(labels: Labels, free: NDArray[np.bool_], steps: int) -> Labels:
    """Labels (h, w) after free cells without one took a neighbour's (of four), `steps` times over.

    Of labels that arrive together the largest wins.
    """
    spread = np.pad(labels, 1)
    width = spread.shape[1]
    flat = spread.ravel()
    empty = np.flatnonzero(np.pad(free, 1) & (spread == 0))
    for _ in range(steps):
        arriving = np.max([flat[empty + step] for step in (-width, -1, 1, width)], axis=0, initial=0)
        flat[empty] = arriving
        empty = empty[arriving == 0]
    return spread[1:-1, 1:-1]
