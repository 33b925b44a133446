"""Section III, eq. 7: which virtual doors to remove. One record a generation, whatever the optimiser."""

from __future__ import annotations

from typing import Annotated, ClassVar

import numpy as np
from numpy.typing import NDArray

from vdoor.record import Record, Spec


class Generation(Record):
    """The population after one generation; bit 1 = edge removed (as printed)."""

    topic: ClassVar[str] = "generation"

    number: Annotated[int, Spec("count")]
    evaluations: Annotated[int, Spec("count")]
    """Strings evaluated so far."""
    best_cost: Annotated[float, Spec("number", tolerance=1e-9)]
    mean_cost: Annotated[float, Spec("number", tolerance=1e-9)]
    worst_cost: Annotated[float, Spec("number", tolerance=1e-9)]
    small_rooms: Annotated[int, Spec("count")]
    """NumSmallNode of the best string."""
    area_sd_m2: Annotated[float, Spec("number", unit="m2", tolerance=1e-9)]
    """AreaSD of the best string."""
    tilt_sd_deg: Annotated[float, Spec("number", unit="deg", tolerance=1e-9)]
    """DegSD of the best string."""
    removed: Annotated[NDArray[np.bool_], Spec("bits", "edge")]
    """The best string, one bit per edge of the initial map."""
