"""A path for the tool, with what each of its segments is for."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Ints = NDArray[np.intp]
Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]

KINDS = ("way", "wall", "lane")
"""What a segment is for: to get somewhere, along a wall or an island, or to sweep what lies between."""
SAME_PLACE = 1e-6


@dataclass(frozen=True, eq=False)
class Path:
    """A polyline; everything about a segment stands at the point where it ends."""

    point: Floats
    """Row, col (k, 2)."""
    kind: NDArray[np.uint8]
    """What the segment that ends here is for (k,), an index into `KINDS`."""
    visit: Ints
    """The visit to a part of a room during which it is driven (k,)."""

    @classmethod
    def joined(cls, stretches: list[Path]) -> Path:
        """One path out of stretches that follow each other; points at the same place become one."""
        point = np.concatenate([stretch.point for stretch in stretches])
        kept = np.concatenate([[True], norms(np.diff(point, axis=0)) > SAME_PLACE])
        kind = np.concatenate([stretch.kind for stretch in stretches])
        visit = np.concatenate([stretch.visit for stretch in stretches])
        return cls(point[kept], kind[kept], visit[kept])

    @classmethod
    def along(cls, point: Floats, kind: str, visit: int) -> Path:
        """A stretch of one kind."""
        return cls(point, np.full(len(point), KINDS.index(kind), np.uint8), np.full(len(point), visit, np.intp))

    @property
    def length(self) -> float:
        """Its length in cells."""
        return float(norms(np.diff(self.point, axis=0)).sum())

    def bends_rad(self) -> Floats:
        """The change of heading (k - 2,) at each inner point, 0 to pi."""
        return bends_rad(self.point[:-2], self.point[1:-1], self.point[2:])


def norms(vector: Floats) -> Floats:
    """The lengths (k,) of vectors (k, 2)."""
    return np.asarray(np.sqrt((vector**2).sum(axis=1)))


def bends_rad(before: Floats, at: Floats, after: Floats) -> Floats:
    """The change of heading (k,) on the ways over `at`, 0 to pi; 0 where two points are at the same place."""
    one, other = at - before, after - at
    return np.asarray(np.abs(np.arctan2(one[:, 0] * other[:, 1] - one[:, 1] * other[:, 0], (one * other).sum(axis=1))))
