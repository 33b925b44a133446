"""Section II.B: the boundary, walked by the left-hand path and sampled."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, ClassVar

import numpy as np
from numpy.typing import NDArray

from vdoor.config import Within
from vdoor.frame import Frame
from vdoor.grid import FREE
from vdoor.method.simplify import SimplifiedGrid
from vdoor.raster.contours import STEP, Contours, follow
from vdoor.record import Record, Spec

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

HEADINGS = ("east", "north", "west", "south")


class BoundaryPath(Record):
    """Closed cycles around the free space with the wall on the left, one per contour, samples in walking order.

    Positions in half cells are exact: the centre of cell (row, col) is (2 row + 1, 2 col + 1).
    """

    topic: ClassVar[str] = "path"

    cell: Annotated[NDArray[np.int32], Spec("cell", "sample 2")]
    """The obstacle cell at the walker's left hand."""
    free_cell: Annotated[NDArray[np.int32], Spec("column", "sample 2")]
    """The free cell the walker stands on."""
    half: Annotated[NDArray[np.int32], Spec("column", "sample 2", unit="half cells")]
    """The sample's own position: the obstacle cell's centre, or the middle of the crack beside it."""
    heading: Annotated[NDArray[np.uint8], Spec("code", "sample", words=HEADINGS)]
    turned_left: Annotated[NDArray[np.bool_], Spec("column", "sample")]
    """The walker turned left around this obstacle cell."""
    contour: Annotated[NDArray[np.int32], Spec("column", "sample", of="path.first")]
    arc_m: Annotated[NDArray[np.float64], Spec("column", "sample", unit="m", tolerance=1e-9)]
    """Length of the path from the contour's first sample."""
    first: Annotated[NDArray[np.int32], Spec("column", "contour", of="path.cell")]
    """The contour's first sample."""
    length_m: Annotated[NDArray[np.float64], Spec("column", "contour", unit="m", tolerance=1e-9)]
    outer: Annotated[NDArray[np.bool_], Spec("column", "contour")]
    """The contour runs around the free space, not around an island in it."""
    on_cracks: Annotated[int, Spec("count")]
    """1 where samples are crack middles, 0 where they are obstacle cells (paper)."""
    frame: Frame


@dataclass(frozen=True, kw_only=True)
class TraceBoundary:
    """Walk the boundary with the wall on the left and sample it."""

    cracks_below_m: Annotated[float, Within(0, 10)] = 0.1
    """Cells smaller than this are sampled at the middles of cracks, others at obstacle cells (paper)."""

    def __call__(self, simplified: SimplifiedGrid) -> BoundaryPath:
        """One closed cycle per contour, the outer boundary and every island."""
        contours = follow(simplified.cells == FREE)
        on_cracks = simplified.frame.resolution_m < self.cracks_below_m
        wall = contours.cell + STEP[(contours.heading + 1) % 4]
        start = np.zeros(len(wall), np.bool_)
        start[contours.first] = True
        keep = start | on_cracks
        if not on_cracks:
            before = np.roll(wall, 1, axis=0)
            before[contours.first] = wall[contours.first + contours.length - 1]
            keep = (wall != before).any(axis=1)
            alone = np.bincount(contours.contour[keep], minlength=len(contours.first)) == 0
            keep[contours.first[alone]] = True
        sample = sample_of_crack(keep, contours)

        contour = contours.contour[keep]
        count = np.bincount(contour, minlength=len(contours.first))
        first = (np.cumsum(count) - count).astype(np.int32)
        half = 2 * wall[keep] + 1
        if on_cracks:
            half -= STEP[(contours.heading[keep] + 1) % 4]
        turned_left = np.zeros(len(half), np.bool_)
        # Both cracks beside a corner belong to it, so that the mark mirrors with the map.
        after = np.arange(1, len(wall) + 1)
        after[contours.first + contours.length - 1] = contours.first
        for side in (np.arange(len(wall)), after):
            turned_left[sample[side[contours.turn > 0]]] = True
        arc_m, length_m = arc_lengths(half, first, simplified.frame.resolution_m)
        return BoundaryPath(
            cell=wall[keep],
            free_cell=contours.cell[keep],
            half=half,
            heading=contours.heading[keep].astype(np.uint8),
            turned_left=turned_left,
            contour=contour,
            arc_m=arc_m,
            first=first,
            length_m=length_m,
            outer=contours.outer,
            on_cracks=int(on_cracks),
            frame=simplified.frame,
        )


def sample_of_crack(keep: NDArray[np.bool_], contours: Contours) -> NDArray[np.intp]:
    """Which sample each crack belongs to: the last one kept at or before it on its contour, cyclically."""
    sample = np.cumsum(keep) - 1
    last = sample[contours.first + contours.length - 1]
    begin = sample[contours.first] + ~keep[contours.first]
    return np.where(sample < begin[contours.contour], last[contours.contour], sample)


def arc_lengths(half: NDArray[np.int32], first: NDArray[np.int32], cell_m: float) -> tuple[Floats, Floats]:
    """Path length in metres from each contour's first sample (n,), and of each whole contour (contours,).

    Straight and slanting steps are counted as whole numbers and turned into metres last, so that a length does not
    depend on where its contour happens to begin.
    """
    straight, slant, contour_straight, contour_slant = step_counts(half, first)
    to_m = cell_m / 2
    arc_m = to_m * (straight + math.sqrt(2) * slant)
    return arc_m, to_m * (contour_straight + math.sqrt(2) * contour_slant)


def step_counts(half: NDArray[np.int32], first: NDArray[np.int32]) -> tuple[Ints, Ints, Ints, Ints]:
    """Half cells gone straight and gone slanting before each sample of its contour, and around each whole contour."""
    after = np.arange(1, len(half) + 1)
    after[np.append(first[1:], len(half)) - 1] = first
    step = np.abs(half[after] - half)
    slant = step.min(axis=1).astype(np.int64)
    straight = step.max(axis=1) - slant
    contour = np.repeat(np.arange(len(first)), np.diff(np.append(first, len(half))))
    ends = np.append(first[1:], len(half))
    before_straight, before_slant = (np.append(0, np.cumsum(part)) for part in (straight, slant))
    return (
        before_straight[:-1] - before_straight[first][contour],
        before_slant[:-1] - before_slant[first][contour],
        before_straight[ends] - before_straight[first],
        before_slant[ends] - before_slant[first],
    )
