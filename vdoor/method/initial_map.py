"""The initial topological map: the free space divided by all virtual doors (end of section II.C)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, ClassVar

import numpy as np
from numpy.typing import NDArray

from vdoor.config import Within
from vdoor.frame import Frame
from vdoor.grid import FREE
from vdoor.method.arrangement import Pieces, borders, cut
from vdoor.method.boundary import BoundaryPath
from vdoor.method.corners import Corners
from vdoor.method.doors import PROPOSED, VirtualDoors
from vdoor.method.scoring.score import LIKELY, DoorScores
from vdoor.method.simplify import REASONS, SimplifiedGrid
from vdoor.raster.polygons import centres, polygons
from vdoor.record import Record, Spec
from vdoor.topology import KINDS

Floats = NDArray[np.float64]
Ints = NDArray[np.int32]
Mask = NDArray[np.bool_]


IDLE = ("parts nothing", "not in the input")
"""Why a proposed door is not an edge: it borders fewer than two regions of the simplified grid, or of the input."""


class InitialMap(Record):
    """Regions as nodes and virtual doors as edges, before the search; their ids start at 0.

    Free cells are divided into pieces: regions between the doors, and atoms, groups of door cells that are on the same
    set of doors and therefore open together. Piece p has label p + 1 in `piece`; the regions come first.
    """

    topic: ClassVar[str] = "initial_map"

    piece: Annotated[NDArray[np.int32], Spec("labels", "height width")]
    centre: Annotated[NDArray[np.int32], Spec("cell", "region 2")]
    """The cell of the region nearest to the mean of its cells."""
    area_m2: Annotated[NDArray[np.float64], Spec("column", "region", unit="m2", tolerance=1e-9)]
    start: Annotated[NDArray[np.int32], Spec("cell", "edge 2")]
    end: Annotated[NDArray[np.int32], Spec("column", "edge 2", unit="cells")]
    door: Annotated[NDArray[np.int32], Spec("column", "edge", of="doors.start")]
    """Row in `VirtualDoors`; doors that border fewer than two regions are not edges (see `idle_door`)."""
    kind: Annotated[NDArray[np.uint8], Spec("code", "edge", words=KINDS)]
    length_m: Annotated[NDArray[np.float64], Spec("column", "edge", unit="m", tolerance=1e-9)]
    width_m: Annotated[NDArray[np.float64], Spec("column", "edge", unit="m", tolerance=1e-9)]
    tilt_rad: Annotated[NDArray[np.float64], Spec("column", "edge", unit="rad", tolerance=1e-9)]
    idle_door: Annotated[NDArray[np.int32], Spec("column", "idle", of="doors.start")]
    """Proposed doors that are not edges; see `idle_reason`."""
    idle_reason: Annotated[tuple[str, ...], Spec("text", "idle")] = ()
    """One of `IDLE` per idle door; empty if only the simplified grid is checked (paper)."""
    border_edge: Annotated[NDArray[np.int32], Spec("column", "border", of="initial_map.door")]
    border_region: Annotated[NDArray[np.int32], Spec("column", "border", of="initial_map.area_m2")]
    """The regions that each edge borders, sorted."""
    atom_area_m2: Annotated[NDArray[np.float64], Spec("column", "atom", unit="m2", tolerance=1e-9)]
    cover_atom: Annotated[NDArray[np.int32], Spec("column", "cover", of="initial_map.atom_area_m2")]
    cover_edge: Annotated[NDArray[np.int32], Spec("column", "cover", of="initial_map.door")]
    """The edges that must all be removed to open each atom, sorted."""
    touch_a: Annotated[NDArray[np.int32], Spec("column", "touch")]
    touch_b: Annotated[NDArray[np.int32], Spec("column", "touch")]
    """4-adjacent pieces, a < b, sorted; b is always an atom."""
    feature_region: Annotated[NDArray[np.int32], Spec("column", "feature")]
    feature_corner: Annotated[NDArray[np.int32], Spec("column", "feature")]
    """The corners on the boundary of each region, sorted."""
    feature_convex: Annotated[NDArray[np.bool_], Spec("column", "feature")]
    feature_cell: Annotated[NDArray[np.int32], Spec("cell", "feature 2")]
    """The corner's obstacle cell."""
    vertex: Annotated[NDArray[np.int32], Spec("column", "vertex 2", unit="cell edges")]
    """Polygons with holes: (row, col) is the upper left corner of that cell; each ring ends with its first vertex."""
    vertex_region: Annotated[NDArray[np.int32], Spec("column", "vertex")]
    vertex_ring: Annotated[NDArray[np.int32], Spec("column", "vertex")]
    """Ring number within the region: 0 for the outer one, then the holes."""
    frame: Frame


@dataclass(frozen=True, kw_only=True)
class DivideRooms:
    """Cut the free space along all proposed doors, and track exactly which cells open when a door is removed."""

    feature_samples: Annotated[int, Within(0, 1_000)] = 2
    """A corner belongs to the regions that the walker is in, from this many samples before to as many after it."""
    in_input: bool = False
    """Leave out doors that lead only to where obstacles were removed; false: the final map drops them (paper)."""

    def __call__(
        self,
        simplified: SimplifiedGrid,
        path: BoundaryPath,
        corners: Corners,
        doors: VirtualDoors,
        scores: DoorScores | None = None,
    ) -> InitialMap:
        """The initial map, with 4-connected regions, without unlikely doors and those that border fewer than two."""
        free = simplified.cells == FREE
        proposed = np.flatnonzero(doors.verdict == PROPOSED).astype(np.int32)
        if scores is not None:
            proposed = scores.door[scores.judgement == LIKELY]
        idle = self._idle(cut(free, doors, proposed), len(proposed))
        edges, left_out = proposed[~idle], proposed[~idle][:0]
        if self.in_input:
            # Without scores, longer doors are dropped first.
            worth = -doors.length_m if scores is None else np.zeros(len(doors.verdict))
            if scores is not None:
                worth[scores.door] = scores.log_odds
            edges = edges[separating_in_input(free, as_read(simplified), doors, edges, worth[edges])]
            left_out = np.setdiff1d(proposed[~idle], edges)
        pieces = cut(free, doors, edges)
        border = borders(pieces, len(edges))
        area_m2 = pieces.cells.astype(np.float64) * simplified.frame.resolution_m**2
        feature = self._features(pieces, path, corners)
        vertex, vertex_region, vertex_ring = polygons(pieces.region)
        return InitialMap(
            piece=pieces.image(),
            centre=centres(pieces.region, pieces.regions),
            area_m2=area_m2[: pieces.regions],
            start=doors.start[edges],
            end=doors.end[edges],
            door=edges,
            kind=doors.kind[edges],
            length_m=doors.length_m[edges],
            width_m=doors.width_m[edges],
            tilt_rad=doors.tilt_rad[edges],
            idle_door=np.concatenate([proposed[idle], left_out]),
            idle_reason=tuple(np.repeat(IDLE, [idle.sum(), len(left_out)]).tolist()) if self.in_input else (),
            border_edge=border[:, 0],
            border_region=border[:, 1],
            atom_area_m2=area_m2[pieces.regions :],
            cover_atom=pieces.cover[:, 0],
            cover_edge=pieces.cover[:, 1],
            touch_a=pieces.touch[:, 0],
            touch_b=pieces.touch[:, 1],
            feature_region=feature[:, 0],
            feature_corner=feature[:, 1],
            feature_convex=corners.convex[feature[:, 1]],
            feature_cell=corners.cell[feature[:, 1]],
            vertex=vertex,
            vertex_region=vertex_region - 1,
            vertex_ring=vertex_ring,
            frame=simplified.frame,
        )

    def _idle(self, pieces: Pieces, edges: int) -> Mask:
        """Which edges (k,) border fewer than two regions, also counting those beyond crossing and touching doors."""
        return np.bincount(borders(pieces, edges)[:, 0], minlength=edges) < 2  # noqa: PLR2004  # two sides

    def _features(self, pieces: Pieces, path: BoundaryPath, corners: Corners) -> Ints:
        """Rows (k, 2) of each region and the corners on its boundary, sorted."""
        found = []
        count = np.diff(np.append(path.first, len(path.cell)))
        for ahead in range(-self.feature_samples, self.feature_samples + 1):
            contour = path.contour[corners.sample]
            local = corners.sample - path.first[contour] + ahead
            cell = path.free_cell[path.first[contour] + local % count[contour]]
            label = pieces.at(np.ravel_multi_index(tuple(cell.T), pieces.region.shape))
            inside = (label > 0) & (label <= pieces.regions)
            found.append(np.stack([label[inside] - 1, np.flatnonzero(inside)], axis=1))
        return np.unique(np.concatenate(found).astype(np.int32), axis=0)


def as_read(simplified: SimplifiedGrid) -> Mask:
    """The cells (h, w) that are as in the input, or are a sill, which joins rooms that the input shows."""
    return np.asarray((simplified.reason == 0) | (simplified.reason == REASONS.index("sill")))


def separating_in_input(free: Mask, as_read: Mask, doors: VirtualDoors, edges: Ints, worth: Floats) -> Mask:
    """Which edges (k,) separate two regions in the input as well, that is, in the free cells that are `as_read`.

    Of each region, only its largest part in the input counts, which becomes the room of the final map. Edges that do
    not separate are dropped one by one in each place, that of least `worth` (k,) first, as this merges two regions.
    """
    kept = np.ones(len(edges), np.bool_)
    seen = free & as_read
    while kept.any():
        rows = np.flatnonzero(kept)
        both, own = cut(free, doors, edges[rows]), cut(seen, doors, edges[rows])
        region = main_parts(both, own)
        border = borders(own, len(rows))
        border = np.unique(np.stack([border[:, 0], region[border[:, 1]]], axis=1)[region[border[:, 1]] >= 0], axis=0)
        poor = np.bincount(border[:, 0], minlength=len(rows)) < 2  # noqa: PLR2004  # two sides
        if not poor.any():
            break
        beside = borders(both, len(rows))
        beside = beside[poor[beside[:, 0]]]
        least = np.full(both.regions, np.inf)
        np.minimum.at(least, beside[:, 1], worth[rows[beside[:, 0]]])
        gone = beside[worth[rows[beside[:, 0]]] <= least[beside[:, 1]], 0]
        kept[rows[gone if len(gone) else np.flatnonzero(poor)]] = False
    return kept


def main_parts(both: Pieces, own: Pieces) -> Ints:
    """For each region (regions,) of `own`, the region of `both` whose largest part it is; -1 for smaller parts."""
    region = both.at(own.region.first_cells(own.regions)) - 1
    order = np.lexsort((np.arange(own.regions), -own.cells[: own.regions], region))
    leads = np.append(True, region[order][1:] != region[order][:-1])[: len(order)]
    found = np.full(own.regions, -1, np.int32)
    found[order[leads]] = region[order[leads]]
    return found
