"""Section II.C: virtual doors, wherever a corner faces another one or a wall nearby."""

from __future__ import annotations

from typing import Annotated, ClassVar

import numpy as np
from numpy.typing import NDArray

from vdoor.record import Frame, Record, Spec

KINDS = ("pair", "single", "passage")
VERDICTS = ("proposed", "blocked", "same wall", "no gap", "duplicate")


class VirtualDoors(Record):
    """Segments between obstacle cells that may be doors; the rejected ones say why."""

    topic: ClassVar[str] = "doors"

    start: Annotated[NDArray[np.int32], Spec("cell", "door 2")]
    """The convex corner's obstacle cell."""
    end: Annotated[NDArray[np.int32], Spec("column", "door 2", unit="cells")]
    """The other corner's, or the closest boundary's."""
    kind: Annotated[NDArray[np.uint8], Spec("code", "door", words=KINDS)]
    verdict: Annotated[NDArray[np.uint8], Spec("code", "door", words=VERDICTS)]
    corner_start: Annotated[NDArray[np.int32], Spec("column", "door")]
    corner_end: Annotated[NDArray[np.int32], Spec("column", "door")]
    """The other corner, -1 where the door ends on a plain boundary."""
    length_m: Annotated[NDArray[np.float64], Spec("column", "door", unit="m", tolerance=1e-9)]
    """Between the end cells' centres; what the paper's 1.2 m limits."""
    width_m: Annotated[NDArray[np.float64], Spec("column", "door", unit="m", tolerance=1e-9)]
    """The free gap between the end cells."""
    tilt_rad: Annotated[NDArray[np.float64], Spec("column", "door", unit="rad", tolerance=1e-9)]
    """Angle to the nearer of the grid's axes, 0 to pi/4."""
    line_cell: Annotated[NDArray[np.int32], Spec("cell", "line 2")]
    """The free cells that proposed doors lie on, 8-connected, door after door."""
    line_door: Annotated[NDArray[np.int32], Spec("column", "line")]
    frame: Frame
