"""The occupancy grid: what every map format is read into and every stage starts from."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated, ClassVar

import numpy as np
from numpy.typing import NDArray

from vdoor.record import Frame, Record, Spec

UNKNOWN, FREE, OCCUPIED = -1, 0, 100
# Nav2's defaults for trinary maps, on the message's scale of 0 to 100.
FREE_TO, OCCUPIED_FROM = 19, 65


@dataclass(frozen=True)
class Source:
    """Where a map came from: the files' own bytes, and how they were read, so that a recording can read them again."""

    files: tuple[tuple[str, bytes], ...] = ()
    options: dict[str, float | int | str] = field(default_factory=dict)


class OccupancyGrid(Record):
    """An occupancy grid map as read: row 0 is the top of the image."""

    topic: ClassVar[str] = "input"

    cells: Annotated[NDArray[np.int8], Spec("occupancy", "height width")]
    frame: Frame
    source: Source = Source()

    @classmethod
    def from_array(
        cls,
        cells: NDArray[np.int8],
        resolution_m: float,
        *,
        x_m: float = 0.0,
        y_m: float = 0.0,
        yaw_rad: float = 0.0,
        source: Source | None = None,
    ) -> OccupancyGrid:
        """A grid of `cells` (h, w) int8 with -1 unknown, 0 free to 100 occupied."""
        frame = Frame(cells.shape[0], cells.shape[1], resolution_m, x_m, y_m, yaw_rad)
        return cls(cells=np.ascontiguousarray(cells), frame=frame, source=source or Source())

    @property
    def free(self) -> NDArray[np.bool_]:
        """Cells that are free by Nav2's default threshold (h, w)."""
        return self.cells.view(np.uint8) <= FREE_TO  # unknown, -1, is 255 here

    @property
    def occupied(self) -> NDArray[np.bool_]:
        """Cells that are occupied by Nav2's default threshold (h, w)."""
        return self.cells >= OCCUPIED_FROM
