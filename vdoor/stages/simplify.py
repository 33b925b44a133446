"""Section II.A: the grid without what the robot cannot reach and without juts."""

from __future__ import annotations

from typing import Annotated, ClassVar

import numpy as np
from numpy.typing import NDArray

from vdoor.record import Frame, Record, Spec

REASONS = ("as it was", "unreachable", "jut", "notch", "island")


class SimplifiedGrid(Record):
    """The grid at the working resolution: free is one 4-connected component, all that it does not touch is unknown."""

    topic: ClassVar[str] = "simplified"

    cells: Annotated[NDArray[np.int8], Spec("occupancy", "height width")]
    reason: Annotated[NDArray[np.uint8], Spec("codes", "height width", words=REASONS)]
    """Why a cell is not what resampling made it."""
    factor: Annotated[int, Spec("count")]
    """Input cells along one side of a working cell."""
    frame: Frame
