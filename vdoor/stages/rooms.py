"""The initial topological map: what the virtual doors divide the free space into (end of section II.C)."""

from __future__ import annotations

from typing import Annotated, ClassVar

import numpy as np
from numpy.typing import NDArray

from vdoor.record import Frame, Record, Spec
from vdoor.stages.doors import KINDS


class InitialMap(Record):
    """Rooms as nodes and virtual doors as edges, before the search; ids of regions and doors start at 0 here.

    Free cells fall into pieces: regions between the doors, and atoms, groups of door cells that lie on the same set
    of doors and so open together. Piece p has label p + 1 in `piece`; the regions come first.
    """

    topic: ClassVar[str] = "initial_map"

    piece: Annotated[NDArray[np.int32], Spec("labels", "height width")]
    centre: Annotated[NDArray[np.int32], Spec("cell", "region 2")]
    """The region's own cell nearest to its mean."""
    area_m2: Annotated[NDArray[np.float64], Spec("column", "region", unit="m2", tolerance=1e-9)]
    start: Annotated[NDArray[np.int32], Spec("cell", "edge 2")]
    end: Annotated[NDArray[np.int32], Spec("column", "edge 2", unit="cells")]
    door: Annotated[NDArray[np.int32], Spec("column", "edge")]
    """Row in `VirtualDoors`; doors that border fewer than two regions are no edges (see `idle_door`)."""
    kind: Annotated[NDArray[np.uint8], Spec("code", "edge", words=KINDS)]
    length_m: Annotated[NDArray[np.float64], Spec("column", "edge", unit="m", tolerance=1e-9)]
    width_m: Annotated[NDArray[np.float64], Spec("column", "edge", unit="m", tolerance=1e-9)]
    tilt_rad: Annotated[NDArray[np.float64], Spec("column", "edge", unit="rad", tolerance=1e-9)]
    idle_door: Annotated[NDArray[np.int32], Spec("column", "idle")]
    """Proposed doors dropped because they border fewer than two regions."""
    border_edge: Annotated[NDArray[np.int32], Spec("column", "border")]
    border_region: Annotated[NDArray[np.int32], Spec("column", "border")]
    """Which regions each edge borders, sorted."""
    atom_area_m2: Annotated[NDArray[np.float64], Spec("column", "atom", unit="m2", tolerance=1e-9)]
    cover_atom: Annotated[NDArray[np.int32], Spec("column", "cover")]
    cover_edge: Annotated[NDArray[np.int32], Spec("column", "cover")]
    """Which edges must all be removed to open each atom, sorted."""
    touch_a: Annotated[NDArray[np.int32], Spec("column", "touch")]
    touch_b: Annotated[NDArray[np.int32], Spec("column", "touch")]
    """4-adjacent pieces, a < b, sorted; b is always an atom."""
    feature_region: Annotated[NDArray[np.int32], Spec("column", "feature")]
    feature_corner: Annotated[NDArray[np.int32], Spec("column", "feature")]
    """Which corners form the boundary of each region, sorted."""
    feature_convex: Annotated[NDArray[np.bool_], Spec("column", "feature")]
    vertex: Annotated[NDArray[np.int32], Spec("column", "vertex 2", unit="cell edges")]
    """Polygons with holes: (row, col) is the upper left corner of that cell; each ring closed by its first vertex."""
    vertex_region: Annotated[NDArray[np.int32], Spec("column", "vertex")]
    vertex_ring: Annotated[NDArray[np.int32], Spec("column", "vertex")]
    """Ring within the region: 0 is the outer one, then its holes."""
    frame: Frame
