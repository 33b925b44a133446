"""The final topological map: the rooms that remain when the removed doors are opened."""

from __future__ import annotations

from typing import Annotated, ClassVar

import numpy as np
from numpy.typing import NDArray

from vdoor.record import Frame, Record, Spec
from vdoor.stages.doors import KINDS


class TopologicalMap(Record):
    """Rooms as nodes, doors as edges, at the input's resolution. Room ids are 1, 2, ... and labels carry them."""

    topic: ClassVar[str] = "map"

    labels: Annotated[NDArray[np.int32], Spec("labels", "height width")]
    """Room of every free cell that can be reached from a room; 0 elsewhere."""
    centre: Annotated[NDArray[np.int32], Spec("cell", "room 2")]
    """The room's own cell nearest to its mean."""
    area_m2: Annotated[NDArray[np.float64], Spec("column", "room", unit="m2", tolerance=1e-9)]
    edge: Annotated[NDArray[np.int32], Spec("column", "door")]
    """Edge of the initial map, -1 for a passage too narrow for the working resolution."""
    start_m: Annotated[NDArray[np.float64], Spec("column", "door 2", unit="m", tolerance=1e-9)]
    end_m: Annotated[NDArray[np.float64], Spec("column", "door 2", unit="m", tolerance=1e-9)]
    """End points as x, y in the map frame."""
    kind: Annotated[NDArray[np.uint8], Spec("code", "door", words=KINDS)]
    length_m: Annotated[NDArray[np.float64], Spec("column", "door", unit="m", tolerance=1e-9)]
    width_m: Annotated[NDArray[np.float64], Spec("column", "door", unit="m", tolerance=1e-9)]
    tilt_rad: Annotated[NDArray[np.float64], Spec("column", "door", unit="rad", tolerance=1e-9)]
    room_a: Annotated[NDArray[np.int32], Spec("column", "door")]
    room_b: Annotated[NDArray[np.int32], Spec("column", "door")]
    """The two rooms it joins, a < b; a door that borders more has one row per pair."""
    feature_room: Annotated[NDArray[np.int32], Spec("column", "feature")]
    feature_corner: Annotated[NDArray[np.int32], Spec("column", "feature")]
    feature_convex: Annotated[NDArray[np.bool_], Spec("column", "feature")]
    vertex_m: Annotated[NDArray[np.float64], Spec("column", "vertex 2", unit="m", tolerance=1e-9)]
    """Polygons with holes as x, y in the map frame; each ring closed by its first vertex."""
    vertex_room: Annotated[NDArray[np.int32], Spec("column", "vertex")]
    vertex_ring: Annotated[NDArray[np.int32], Spec("column", "vertex")]
    """Ring within the room: 0 is the outer one, then its holes."""
    frame: Frame
