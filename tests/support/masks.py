"""Small masks of all kinds: random ones of several shapes, an empty one, a full one, and one that is no C array."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Mask = NDArray[np.bool_]


def masks() -> list[Mask]:
    """Masks (h, w), two dozen, the same at every call."""
    rng = np.random.default_rng(3)
    shapes = [(1, 1), (1, 9), (9, 1), (17, 23), (40, 31)]
    found = [rng.random(shape) < share for shape in shapes for share in (0.3, 0.6, 0.9)]
    return [*found, np.zeros((4, 5), np.bool_), np.ones((4, 5), np.bool_), found[-1].T]
