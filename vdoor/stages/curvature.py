"""Section II.B, eq. 1 to 5: adaptive curvature at each sample."""

from __future__ import annotations

from typing import Annotated, ClassVar

import numpy as np
from numpy.typing import NDArray

from vdoor.record import Frame, Record, Spec


class Curvature(Record):
    """How sharply the path bends at each sample of the boundary path."""

    topic: ClassVar[str] = "curvature"

    cell: Annotated[NDArray[np.int32], Spec("cell", "sample 2")]
    k_forward: Annotated[NDArray[np.int32], Spec("column", "sample")]
    """K_f, eq. 1."""
    k_backward: Annotated[NDArray[np.int32], Spec("column", "sample")]
    """K_b, eq. 2."""
    forward: Annotated[NDArray[np.int32], Spec("column", "sample 2", unit="half cells")]
    """f as (row, col), eq. 3."""
    backward: Annotated[NDArray[np.int32], Spec("column", "sample 2", unit="half cells")]
    """b as (row, col), eq. 4."""
    angle_rad: Annotated[NDArray[np.float64], Spec("column", "sample", unit="rad", tolerance=1e-9)]
    """Between f and b: pi on a straight wall, 0 at the tip of a thin one."""
    rho_per_deg: Annotated[NDArray[np.float64], Spec("column", "sample", unit="1/deg", tolerance=1e-9)]
    """Eq. 5: the angle's inverse, infinite at a tip."""
    frame: Frame
