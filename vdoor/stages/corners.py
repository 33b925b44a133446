"""Section II.B, eq. 6: candidate corner features, and those of locally greatest curvature."""

from __future__ import annotations

from typing import Annotated, ClassVar

import numpy as np
from numpy.typing import NDArray

from vdoor.record import Frame, Record, Spec


class Candidates(Record):
    """Samples that bend more than the threshold."""

    topic: ClassVar[str] = "candidates"

    cell: Annotated[NDArray[np.int32], Spec("cell", "candidate 2")]
    sample: Annotated[NDArray[np.int32], Spec("column", "candidate")]
    angle_rad: Annotated[NDArray[np.float64], Spec("column", "candidate", unit="rad", tolerance=1e-9)]
    convex: Annotated[NDArray[np.bool_], Spec("column", "candidate")]
    frame: Frame


class Corners(Record):
    """Candidates of locally greatest curvature, in the order of the path."""

    topic: ClassVar[str] = "corners"

    cell: Annotated[NDArray[np.int32], Spec("cell", "corner 2")]
    sample: Annotated[NDArray[np.int32], Spec("column", "corner")]
    quarter: Annotated[NDArray[np.int32], Spec("column", "corner 2", unit="quarter cells")]
    """Middle of the plateau of greatest curvature: (4 row + 2, 4 col + 2) is the centre of a cell."""
    angle_rad: Annotated[NDArray[np.float64], Spec("column", "corner", unit="rad", tolerance=1e-9)]
    convex: Annotated[NDArray[np.bool_], Spec("column", "corner")]
    frame: Frame
