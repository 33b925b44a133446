"""The columns of a finished map, and the map made of them; reading a result needs no more of the method than this."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from vdoor.frame import Frame
from vdoor.raster.polygons import centres, polygons
from vdoor.raster.runs import runs_of
from vdoor.topology import TopologicalMap

Floats = NDArray[np.float64]
Ints = NDArray[np.int32]


class Doors(NamedTuple):
    """The door columns of the map."""

    edge: Ints
    start_m: Floats
    end_m: Floats
    kind: NDArray[np.uint8]
    length_m: Floats
    width_m: Floats
    tilt_rad: Floats
    room_a: Ints
    room_b: Ints

    def followed_by(self, other: Doors) -> Doors:
        """The rows of both, this one's first."""
        columns: Iterator[tuple[Any, Any]] = zip(self, other, strict=True)
        return Doors(*map(np.concatenate, columns))


class Features(NamedTuple):
    """The corner columns of the map."""

    room: Ints
    corner: Ints
    convex: NDArray[np.bool_]
    point_m: Floats

    @classmethod
    def none(cls) -> Features:
        """The columns of a map without corners."""
        rows = np.zeros(0, np.int32)
        return cls(rows, rows, np.zeros(0, np.bool_), np.zeros((0, 2)))


def map_of(
    labels: Ints, frame: Frame, doors: Doors, features: Features, names: Mapping[int, str] | None = None
) -> TopologicalMap:
    """The topological map of room ids (h, w), which need not be consecutive; `names` by id, for rooms that have one."""
    runs = runs_of(labels)
    ids = np.unique(runs.label)
    ranked = runs.labelled(np.searchsorted(ids, runs.label).astype(np.int32) + 1)
    vertex, vertex_room, vertex_ring = polygons(runs)
    cells = ranked.cells(len(ids))
    all_names = tuple((names or {}).get(room, "") for room in ids.tolist())
    return TopologicalMap(
        labels=labels,
        centre=centres(ranked, len(ids)),
        area_m2=cells.astype(np.float64) * frame.resolution_m**2,
        name=all_names if any(all_names) else (),
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
