"""The final map put together: all that follows from the label image, beside its doors, corner features and names."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from vdoor.record import Frame
from vdoor.stages.final_doors import Doors
from vdoor.stages.polygons import centres, polygons
from vdoor.stages.runs import runs_of
from vdoor.topology import TopologicalMap

Floats = NDArray[np.float64]
Ints = NDArray[np.int32]


class Features(NamedTuple):
    """The corner feature columns of the map."""

    room: Ints
    corner: Ints
    convex: NDArray[np.bool_]
    point_m: Floats

    @classmethod
    def none(cls) -> Features:
        """Of a map that knows none."""
        rows = np.zeros(0, np.int32)
        return cls(rows, rows, np.zeros(0, np.bool_), np.zeros((0, 2)))


def map_of(
    labels: Ints, frame: Frame, doors: Doors, features: Features, names: Mapping[int, str] | None = None
) -> TopologicalMap:
    """The map of rooms (h, w) by their ids, whatever these are; `names` by id, of those rooms that have one."""
    ids, rank = ranked(labels)
    vertex, vertex_room, vertex_ring = polygons(labels)
    cells = runs_of(rank).cells(len(ids))
    called = tuple((names or {}).get(room, "") for room in ids.tolist())
    return TopologicalMap(
        labels=labels,
        centre=centres(rank, len(ids)),
        area_m2=cells.astype(np.float64) * frame.resolution_m**2,
        name=called if any(called) else (),
        **doors._asdict(),
        feature_room=features.room,
        feature_corner=features.corner,
        feature_convex=features.convex,
        feature_m=features.point_m,
        vertex_m=frame.world_from_cell(vertex - 0.5),
        vertex_room=vertex_room,
        vertex_ring=vertex_ring,
        frame=frame,
    )


def ranked(labels: Ints) -> tuple[Ints, Ints]:
    """The labels there are but 0, rising; and each cell's place (h, w) among them, from 1 on, 0 where it has none."""
    ids = np.unique(runs_of(labels).label)
    if len(ids) == ids.max(initial=0):
        return ids, labels
    return ids, np.searchsorted(np.append(0, ids), labels).astype(np.int32)
