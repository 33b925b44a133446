"""Section II.B: the boundary, walked by the left-hand path and sampled."""

from __future__ import annotations

from typing import Annotated, ClassVar

import numpy as np
from numpy.typing import NDArray

from vdoor.record import Frame, Record, Spec

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
    contour: Annotated[NDArray[np.int32], Spec("column", "sample")]
    arc_m: Annotated[NDArray[np.float64], Spec("column", "sample", unit="m", tolerance=1e-9)]
    """Length of the path from the contour's first sample."""
    first: Annotated[NDArray[np.int32], Spec("column", "contour")]
    """The contour's first sample."""
    length_m: Annotated[NDArray[np.float64], Spec("column", "contour", unit="m", tolerance=1e-9)]
    outer: Annotated[NDArray[np.bool_], Spec("column", "contour")]
    """The contour runs around the free space, not around an island in it."""
    on_cracks: Annotated[int, Spec("count")]
    """1 where samples are crack middles, 0 where they are obstacle cells (paper)."""
    frame: Frame
