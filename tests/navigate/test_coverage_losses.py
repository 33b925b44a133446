"""What changes to a path lose, found by rows, against cells counted one by one."""

from __future__ import annotations

import numpy as np
import pytest

from vdoor.navigate.coverage.losses import Losses, Segments
from vdoor.navigate.coverage.sweep import Tool


@pytest.mark.parametrize("fine", [1, 2])
def test_a_change_loses_the_cells_that_only_segments_sweep_that_go(fine: int) -> None:
    rng = np.random.default_rng(3)
    shape, point = (40, 50), rng.uniform((-2, -2), (42, 52), (60, 2))
    blocked = rng.random(shape) < 0.1
    tool = Tool.on(blocked, fine, reach=2.6, radius=3.0)
    counts = np.where(tool.blocked, 0, rng.integers(0, 5, tool.blocked.shape)).astype(np.int32).reshape(-1)

    def times(places: np.ndarray[tuple[int, int], np.dtype[np.float64]]) -> np.ndarray[tuple[int], np.dtype[np.int32]]:
        cell = tool.swept(places[:-1], places[1:]).cell
        return np.bincount(cell, minlength=counts.size).astype(np.int32)

    first = rng.integers(0, 55, 30)
    gone = rng.integers(2, 5, 30)
    middle = rng.uniform((0, 0), (40, 50), (30, 2))
    rows = [np.flatnonzero(gone > number) for number in range(4)]
    goes = [Segments(own, point[first[own] + n], point[first[own] + n + 1]) for n, own in enumerate(rows)]
    every = np.arange(30)
    comes = [Segments(every, point[first], middle), Segments(every, middle, point[first + gone])]
    found = Losses(tool, 30, goes, comes).lost(times(point), counts)
    before = counts[times(point) > 0].sum()
    for change in range(30):
        ends = [point[: first[change] + 1], middle[change : change + 1], point[first[change] + gone[change] :]]
        assert found[change] == before - counts[times(np.concatenate(ends)) > 0].sum()
