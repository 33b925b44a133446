"""Which found door is which true one, and the figures that follow."""

from __future__ import annotations

from dataclasses import astuple, dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from vdoor.evaluate.door_places import Doors

TOLERANCES_M = (0.5, 1.0)
"""How far apart two doors may be and still be one."""
EXCUSED_M = 1.0
"""How far a found door may be from one to be ignored and still be excused."""
NARROW_M = 1.2
"""Doors up to this width are narrow."""

Rows = NDArray[np.intp]


@dataclass(frozen=True, kw_only=True)
class Tally:
    """Numbers of doors, to be added over maps."""

    hits: int = 0
    missed: int = 0
    false: int = 0
    narrow_hits: int = 0
    narrow_missed: int = 0

    def __add__(self, other: Tally) -> Tally:
        """Both together."""
        hits, missed, false, narrow_hits, narrow_missed = map(sum, zip(astuple(self), astuple(other), strict=True))
        return Tally(hits=hits, missed=missed, false=false, narrow_hits=narrow_hits, narrow_missed=narrow_missed)

    @property
    def precision(self) -> float:
        """Share of the found doors that are true; where none was found 1 if there is none, else 0."""
        found = self.hits + self.false
        return self.hits / found if found else float(not self.missed)

    @property
    def recall(self) -> float:
        """Share of the true doors that were found; 1 where there is none."""
        return _share(self.hits, self.missed)

    @property
    def narrow_recall(self) -> float:
        """Recall of the narrow doors."""
        return _share(self.narrow_hits, self.narrow_missed)

    @property
    def f1(self) -> float:
        """Harmonic mean of precision and recall."""
        both = self.precision + self.recall
        return 2 * self.precision * self.recall / both if both else 0.0


@dataclass(frozen=True, kw_only=True, eq=False)
class DoorMatch:
    """Rows of the true and of the found doors, by what became of them."""

    hit_true: Rows
    hit_found: Rows
    """One pair a row."""
    missed: Rows
    """True doors nobody found."""
    false: Rows
    """Found doors that are none."""
    excused: Rows
    """Found doors that are none, at a place where nobody is sure."""
    tally: Tally


def match_doors(true: Doors, found: Doors, tolerance_m: float, *, unsure: Doors | None = None) -> DoorMatch:
    """True and found doors paired one to one within the tolerance; each unsure door excuses one false door."""
    hit_true, hit_found = nearest_pairs(true.centre_m, found.centre_m, tolerance_m)
    missed = np.setdiff1d(np.arange(len(true)), hit_true)
    false = np.setdiff1d(np.arange(len(found)), hit_found)
    excused = false[:0]
    if unsure is not None:
        _, rows = nearest_pairs(unsure.centre_m, found.centre_m[false], EXCUSED_M)
        excused, false = false[rows], np.delete(false, rows)
    narrow = true.width_m <= NARROW_M
    tally = Tally(
        hits=len(hit_true),
        missed=len(missed),
        false=len(false),
        narrow_hits=int(narrow[hit_true].sum()),
        narrow_missed=int(narrow[missed].sum()),
    )
    return DoorMatch(
        hit_true=hit_true,
        hit_found=hit_found,
        missed=missed,
        false=false,
        excused=excused,
        tally=tally,
    )


def nearest_pairs(one_m: NDArray[np.float64], other_m: NDArray[np.float64], limit_m: float) -> tuple[Rows, Rows]:
    """Rows of places (k, 2) and (l, 2) paired one to one within the limit: most pairs, then least distance in all."""
    apart_m = np.hypot(*(one_m[:, None] - other_m[None]).transpose(2, 0, 1))
    near = apart_m <= limit_m
    # One pair more is worth more than all distances together.
    out_of_reach_m = limit_m * (min(apart_m.shape) + 1)
    one, other = linear_sum_assignment(np.where(near, apart_m, out_of_reach_m))
    paired = near[one, other]
    return one[paired], other[paired]


def _share(part: int, rest: int) -> float:
    return part / (part + rest) if part + rest else 1.0
