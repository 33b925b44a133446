"""Door positions: contacts between the rooms of a label image, or segments marked by hand.

Centres are in metres right and down from the image's upper left corner, ends in cells (row, col).
"""

from __future__ import annotations

from dataclasses import astuple, dataclass

import numpy as np
import scipy
from numpy.typing import NDArray

from vdoor.evaluate.label_files import Labels, flooded
from vdoor.raster.components import contact_pieces, contacts

FLOOD_M = 0.30
"""How far rooms are grown into unlabelled free cells to find where they touch."""
GAP_M = 0.30
"""Contacts between the same two rooms that are closer than this are one door."""
MIN_WIDTH_M = 0.25
"""Contacts narrower than this are not doors."""


TOLERANCES_M = (0.5, 1.0)
"""Largest distances between a true and a found door for a match."""
EXCUSED_M = 1.0
"""Largest distance between a false door and an unsure one that excuses it."""
NARROW_M = 1.2
"""Doors up to this width count as narrow."""
Rows = NDArray[np.intp]


@dataclass(frozen=True, kw_only=True, eq=False)
class Doors:
    """Doors, one per row."""

    centre_m: NDArray[np.float64]
    """Metres right and down (k, 2)."""
    width_m: NDArray[np.float64]
    ends: NDArray[np.float64]
    """Both ends (k, 2, 2) as row, col; integers are cell centres."""

    def __len__(self) -> int:
        return len(self.width_m)

    def __getitem__(self, rows: NDArray[np.intp] | NDArray[np.bool_]) -> Doors:
        """The doors in the given rows."""
        return Doors(centre_m=self.centre_m[rows], width_m=self.width_m[rows], ends=self.ends[rows])

    @property
    def centre(self) -> NDArray[np.float64]:
        """Midpoint (k, 2) between each door's ends as row, col."""
        return (self.ends[:, 0] + self.ends[:, 1]) / 2


def marked_doors(ends: NDArray[np.float64], resolution_m: float, widths_m: NDArray[np.float64] | None = None) -> Doors:
    """The doors given by segments (k, 2, 2) as row, col; without `widths_m`, their widths are the segments' lengths."""
    ends = ends.reshape(-1, 2, 2)
    lengths_m = np.hypot(*(ends[:, 1] - ends[:, 0]).T) * resolution_m
    centre_m = (ends.sum(axis=1)[:, ::-1] + 1) / 2 * resolution_m
    return Doors(centre_m=centre_m, width_m=lengths_m if widths_m is None else widths_m, ends=ends)


def contact_doors(labels: Labels, free: NDArray[np.bool_], resolution_m: float) -> Doors:
    """The doors between rooms of a label image, where the rooms touch after growing into the free cells beside them.

    A door is a connected piece of the border between two rooms. Its centre is the mean of the piece's cell sides, its
    width their largest extent plus one cell.
    """
    places, rooms = contacts(flooded(labels, free, round(FLOOD_M / resolution_m)))
    piece = contact_pieces(places, rooms, GAP_M / resolution_m)
    doors = int(piece.max(initial=-1)) + 1
    cells = np.bincount(piece, minlength=doors)
    mean = np.stack([np.bincount(piece, along, minlength=doors) / cells for along in places.T], axis=1)
    borders = np.split(places[np.argsort(piece, kind="stable")], np.cumsum(cells)[:-1]) if doors else []
    ends = np.array([_farthest(border) for border in borders]).reshape(-1, 2, 2)
    width_m = (np.hypot(*(ends[:, 1] - ends[:, 0]).T) + 1) * resolution_m
    found = Doors(centre_m=(mean[:, ::-1] + 0.5) * resolution_m, width_m=width_m, ends=ends)
    return found[width_m >= MIN_WIDTH_M]


def _farthest(places: NDArray[np.float64]) -> NDArray[np.float64]:
    """The two (2, 2) of the points (k, 2) that are farthest apart."""
    try:
        outer = places[scipy.spatial.ConvexHull(places).vertices]
    except scipy.spatial.QhullError:  # all on one line
        return places[np.lexsort(places.T)[[0, -1]]]
    apart = np.hypot(*(outer[:, None] - outer[None]).transpose(2, 0, 1))
    return outer[list(np.unravel_index(apart.argmax(), apart.shape))]


@dataclass(frozen=True, kw_only=True)
class Tally:
    """Counts of doors, which can be added up over maps."""

    hits: int = 0
    missed: int = 0
    false: int = 0
    narrow_hits: int = 0
    narrow_missed: int = 0

    def __add__(self, other: Tally) -> Tally:
        """The sum of both."""
        hits, missed, false, narrow_hits, narrow_missed = map(sum, zip(astuple(self), astuple(other), strict=True))
        return Tally(hits=hits, missed=missed, false=false, narrow_hits=narrow_hits, narrow_missed=narrow_missed)

    @property
    def precision(self) -> float:
        """Share of the found doors that are true; if none was found, 1 if there is none, else 0."""
        found = self.hits + self.false
        return self.hits / found if found else float(not self.missed)

    @property
    def recall(self) -> float:
        """Share of the true doors that were found; 1 if there is none."""
        return _share(self.hits, self.missed)

    @property
    def narrow_recall(self) -> float:
        """Recall of the narrow doors; 1 if there is none."""
        return _share(self.narrow_hits, self.narrow_missed)

    @property
    def f1(self) -> float:
        """Harmonic mean of precision and recall."""
        both = self.precision + self.recall
        return 2 * self.precision * self.recall / both if both else 0.0


@dataclass(frozen=True, kw_only=True, eq=False)
class DoorMatch:
    """Rows of the true and the found doors, by outcome."""

    hit_true: Rows
    hit_found: Rows
    """True and found doors that match: row i of one is paired with row i of the other."""
    missed: Rows
    """True doors that were not found."""
    false: Rows
    """Found doors that are not true."""
    excused: Rows
    """Found doors that are not true, near an unsure one."""
    tally: Tally


def match_doors(true: Doors, found: Doors, tolerance_m: float, *, unsure: Doors | None = None) -> DoorMatch:
    """True and found doors matched one to one within the tolerance; each unsure door excuses one false door."""
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


def angles_rad(one: Doors, other: Doors) -> NDArray[np.float64]:
    """The angles (k,) between the doors of each row, 0 to a quarter turn."""
    ways = [np.arctan2(*(doors.ends[:, 1] - doors.ends[:, 0]).T) for doors in (one, other)]
    turned: NDArray[np.float64] = np.abs((ways[0] - ways[1] + np.pi / 2) % np.pi - np.pi / 2)
    return turned


def nearest_pairs(one_m: NDArray[np.float64], other_m: NDArray[np.float64], limit_m: float) -> tuple[Rows, Rows]:
    """Rows of points (k, 2) and (l, 2) paired one to one within the limit: most pairs, then smallest total distance."""
    apart_m = np.hypot(*(one_m[:, None] - other_m[None]).transpose(2, 0, 1))
    near = apart_m <= limit_m
    # One more pair outweighs all distances together.
    out_of_reach_m = limit_m * (min(apart_m.shape) + 1)
    one, other = scipy.optimize.linear_sum_assignment(np.where(near, apart_m, out_of_reach_m))
    paired = near[one, other]
    return one[paired], other[paired]


def _share(part: int, rest: int) -> float:
    return part / (part + rest) if part + rest else 1.0
