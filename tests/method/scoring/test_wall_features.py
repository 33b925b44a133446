"""The cells around a door's ends, read row by row, give what a filter of the whole map gives."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import ndimage

from vdoor.method.scoring.wall_features import shares_at


@pytest.mark.parametrize("window", [3, 5, 9])
@pytest.mark.parametrize("edge", [False, True])
@pytest.mark.parametrize("shape", [(300, 40), (2, 7), (1, 1)])
def test_shares_are_those_of_a_filter_of_the_whole_map(window: int, edge: bool, shape: tuple[int, int]) -> None:
    mask = np.random.default_rng(4).random(shape) < 0.4
    row, col = np.meshgrid(np.arange(-1, shape[0] + 1), np.arange(-1, shape[1] + 1), indexing="ij")
    point = np.stack([row.ravel(), col.ravel()], axis=1)
    filtered = ndimage.uniform_filter(mask.astype(np.float64), window, mode="nearest" if edge else "constant")
    wanted = np.pad(filtered, 1, constant_values=0.25)
    found = shares_at(mask, point, window, outside=0.25, edge=edge)
    assert found.tobytes() == wanted.ravel().tobytes()
