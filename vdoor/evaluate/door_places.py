"""Doors as places: contacts between the rooms of a label image, or segments that somebody marked.

Places are metres right and down from the image's upper left corner, ends are cells (row, col).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import ConvexHull, QhullError, cKDTree

from vdoor.evaluate.label_images import Labels, flooded
from vdoor.raster.labels import contacts

FLOOD_M = 0.30
"""How far rooms flood free cells without label before they touch."""
GAP_M = 0.30
"""Contacts of the same two rooms closer than this are one door."""
MIN_WIDTH_M = 0.25
"""Contacts narrower than this are no doors."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Doors:
    """Doors, one row each."""

    centre_m: NDArray[np.float64]
    """Right and down (k, 2)."""
    width_m: NDArray[np.float64]
    ends: NDArray[np.float64]
    """Both ends (k, 2, 2) as row, col; whole numbers are cell centres."""

    def __len__(self) -> int:
        return len(self.width_m)

    def __getitem__(self, rows: NDArray[np.intp] | NDArray[np.bool_]) -> Doors:
        """Some of the doors."""
        return Doors(centre_m=self.centre_m[rows], width_m=self.width_m[rows], ends=self.ends[rows])

    @property
    def centre(self) -> NDArray[np.float64]:
        """Middle of each door's ends (k, 2) as row, col."""
        return (self.ends[:, 0] + self.ends[:, 1]) / 2


def marked_doors(ends: NDArray[np.float64], resolution_m: float, widths_m: NDArray[np.float64] | None = None) -> Doors:
    """Doors from segments (k, 2, 2) as row, col; as wide as the segments are long where no widths are given."""
    ends = ends.reshape(-1, 2, 2)
    lengths_m = np.hypot(*(ends[:, 1] - ends[:, 0]).T) * resolution_m
    centre_m = (ends.sum(axis=1)[:, ::-1] + 1) / 2 * resolution_m
    return Doors(centre_m=centre_m, width_m=lengths_m if widths_m is None else widths_m, ends=ends)


def contact_doors(labels: Labels, free: NDArray[np.bool_], resolution_m: float) -> Doors:
    """Doors between the rooms of a label image, from where they touch after flooding the free cells beside them.

    A door is a connected piece of the border of two rooms, its place the mean of the cell edges it consists of, its
    width their largest extent and a cell.
    """
    places, rooms = contacts(flooded(labels, free, round(FLOOD_M / resolution_m)))
    doors, piece = _pieces(places, rooms, GAP_M / resolution_m)
    cells = np.bincount(piece, minlength=doors)
    mean = np.stack([np.bincount(piece, along, minlength=doors) / cells for along in places.T], axis=1)
    borders = np.split(places[np.argsort(piece, kind="stable")], np.cumsum(cells)[:-1]) if doors else []
    ends = np.array([_farthest(border) for border in borders]).reshape(-1, 2, 2)
    width_m = (np.hypot(*(ends[:, 1] - ends[:, 0]).T) + 1) * resolution_m
    found = Doors(centre_m=(mean[:, ::-1] + 0.5) * resolution_m, width_m=width_m, ends=ends)
    return found[width_m >= MIN_WIDTH_M]


def _pieces(places: NDArray[np.float64], rooms: NDArray[np.int32], gap: float) -> tuple[int, NDArray[np.int32]]:
    """How many pieces the contacts form, and the piece of each: same two rooms, steps of at most `gap` cells."""
    if not len(places):
        return 0, np.zeros(0, np.int32)
    near = cKDTree(places).query_pairs(gap, output_type="ndarray")
    near = near[(rooms[near[:, 0]] == rooms[near[:, 1]]).all(axis=1)]
    links = coo_array((np.ones(len(near)), (near[:, 0], near[:, 1])), shape=(len(places), len(places)))
    pieces, piece = connected_components(links, directed=False)
    return int(pieces), piece


def _farthest(places: NDArray[np.float64]) -> NDArray[np.float64]:
    """The two of the places (k, 2) that are farthest apart (2, 2)."""
    try:
        outer = places[ConvexHull(places).vertices]
    except QhullError:  # all on one line
        return places[np.lexsort(places.T)[[0, -1]]]
    apart = np.hypot(*(outer[:, None] - outer[None]).transpose(2, 0, 1))
    return outer[list(np.unravel_index(apart.argmax(), apart.shape))]
