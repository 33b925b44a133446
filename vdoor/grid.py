"""The occupancy grid: the result of reading any map format and the input of the pipeline."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated, ClassVar

import numpy as np
from numpy.typing import NDArray

from vdoor.frame import Frame
from vdoor.record import Record, Spec

UNKNOWN, FREE, OCCUPIED = -1, 0, 100
# Nav2's defaults for trinary maps, on the message's scale of 0 to 100.
FREE_TO, OCCUPIED_FROM = 19, 65


@dataclass(frozen=True)
class Source:
    """Where a map came from: the bytes of its files and the options used, so that a recording can read it again."""

    files: tuple[tuple[str, bytes], ...] = ()
    options: dict[str, float | int | str] = field(default_factory=dict)


Point = tuple[float, float]
Line = tuple[Point, ...]


@dataclass(frozen=True, kw_only=True)
class Segment:
    """A room as segmented by the robot maker's own software."""

    label: int
    """The segment's number in the label image."""
    id: str
    name: str
    """Not necessarily unique: a home may have two halls."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Annotations:
    """What a map file contains besides the cells; points are x, y in metres in the map frame."""

    own_origin_cm: Point
    """The map frame's origin in the robot's own frame, whose y axis points down, in centimetres."""
    robot_m: Point | None = None
    charger_m: Point | None = None
    virtual_walls_m: tuple[Line, ...] = ()
    no_go_areas_m: tuple[Line, ...] = ()
    no_mop_areas_m: tuple[Line, ...] = ()
    """Areas as their vertices; the first is not repeated."""
    segments: tuple[Segment, ...] = ()
    labels: NDArray[np.int32] | None = None
    """Segment of each free cell (h, w), 0 = none; None if the file has no segments."""

    @property
    def places_m(self) -> tuple[Point, ...]:
        """Positions for the robot in order of preference: its own, then its charger's."""
        return tuple(place for place in (self.robot_m, self.charger_m) if place is not None)


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
        """A grid of `cells` (h, w) int8: -1 unknown, 0 free to 100 occupied."""
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
