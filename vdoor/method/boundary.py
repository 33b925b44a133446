"""Section II.B: the boundary, walked along the left-hand path and sampled."""

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
    """Closed cycles along the boundary with the wall on the left, one per contour, samples in walking order.

    Positions in half cells are exact: the centre of cell (row, col) is (2 row + 1, 2 col + 1).
    """

    topic: ClassVar[str] = "path"

    cell: Annotated[NDArray[np.int32], Spec("cell", "sample 2")]
    """The obstacle cell on the walker's left."""
    free_cell: Annotated[NDArray[np.int32], Spec("column", "sample 2")]
    """The free cell that the walker is on."""
    half: Annotated[NDArray[np.int32], Spec("column", "sample 2", unit="half cells")]
    """The position of the sample: the obstacle cell's centre, or the middle of the crack beside it."""
    heading: Annotated[NDArray[np.uint8], Spec("code", "sample", words=HEADINGS)]
    turned_left: Annotated[NDArray[np.bool_], Spec("column", "sample")]
    """Whether the walker turned left around this obstacle cell."""
    contour: Annotated[NDArray[np.int32], Spec("column", "sample", of="path.first")]
    arc_m: Annotated[NDArray[np.float64], Spec("column", "sample", unit="m", tolerance=1e-9)]
    """Path length from the contour's first sample."""
    first: Annotated[NDArray[np.int32], Spec("column", "contour", of="path.cell")]
    """The contour's first sample."""
    length_m: Annotated[NDArray[np.float64], Spec("column", "contour", unit="m", tolerance=1e-9)]
    outer: Annotated[NDArray[np.bool_], Spec("column", "contour")]
    """Whether the contour runs around the free space, not around an island in it."""
    on_cracks: Annotated[int, Spec("count")]
    """1 if samples are crack middles, 0 if they are obstacle cells (paper)."""
    frame: Frame


@dataclass(frozen=True, kw_only=True)
class TraceBoundary:
    """Walk the boundary with the wall on the left and sample it."""

    cracks_below_m: Annotated[float, Within(0, 10)] = 0.1
    """For cells smaller than this, samples are crack middles; for others, obstacle cells (paper). A crack is the side
    between a free cell and an obstacle cell."""

    def __call__(self, simplified: SimplifiedGrid) -> BoundaryPath:
        """One closed cycle per contour: outer boundaries and islands."""
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
        # Both cracks beside a corner are marked, so that the marks mirror with the map.
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
    """The sample that each crack belongs to: the last one kept at or before it on its contour, cyclically."""
    sample = np.cumsum(keep) - 1
    last = sample[contours.first + contours.length - 1]
    begin = sample[contours.first] + ~keep[contours.first]
    return np.where(sample < begin[contours.contour], last[contours.contour], sample)


def arc_lengths(half: NDArray[np.int32], first: NDArray[np.int32], cell_m: float) -> tuple[Floats, Floats]:
    """Path length in metres from the contour's first sample to each sample (n,), and of each contour (contours,).

    Straight and diagonal steps are counted as integers and converted to metres last, so that lengths do not depend on
    where a contour begins.
    """
    straight, slant, contour_straight, contour_slant = step_counts(half, first)
    to_m = cell_m / 2
    arc_m = to_m * (straight + math.sqrt(2) * slant)
    return arc_m, to_m * (contour_straight + math.sqrt(2) * contour_slant)


def step_counts(half: NDArray[np.int32], first: NDArray[np.int32]) -> tuple[Ints, Ints, Ints, Ints]:
    """Straight and diagonal steps, in half cells, before each sample (n,) of its contour, and of each whole contour."""
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
