"""The initial topological map: what the virtual doors divide the free space into (end of section II.C)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, ClassVar

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from vdoor.config import Within
from vdoor.grid import FREE
from vdoor.record import Frame, Record, Spec
from vdoor.stages.contours import CRACK_START, follow
from vdoor.stages.corners import Corners
from vdoor.stages.doors import KINDS, PROPOSED, VirtualDoors
from vdoor.stages.runs import runs_of
from vdoor.stages.simplify import SimplifiedGrid
from vdoor.stages.trace import BoundaryPath

Ints = NDArray[np.int32]
Mask = NDArray[np.bool_]


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
    feature_cell: Annotated[NDArray[np.int32], Spec("cell", "feature 2")]
    """The corner's obstacle cell."""
    vertex: Annotated[NDArray[np.int32], Spec("column", "vertex 2", unit="cell edges")]
    """Polygons with holes: (row, col) is the upper left corner of that cell; each ring closed by its first vertex."""
    vertex_region: Annotated[NDArray[np.int32], Spec("column", "vertex")]
    vertex_ring: Annotated[NDArray[np.int32], Spec("column", "vertex")]
    """Ring within the region: 0 is the outer one, then its holes."""
    frame: Frame


@dataclass(frozen=True, kw_only=True)
class DivideRooms:
    """Cut the free space along all proposed doors and keep exact books of what opens when a door is removed."""

    feature_samples: Annotated[int, Within(0, 1_000)] = 2
    """A corner belongs to the regions the walker stands in up to so many samples before and after it."""

    def __call__(
        self, simplified: SimplifiedGrid, path: BoundaryPath, corners: Corners, doors: VirtualDoors
    ) -> InitialMap:
        """Regions are 4-connected; doors that border fewer than two regions are left out."""
        free = simplified.cells == FREE
        proposed = np.flatnonzero(doors.verdict == PROPOSED).astype(np.int32)
        idle = self._idle(cut(free, doors, proposed), len(proposed))
        edges = proposed[~idle]
        pieces = cut(free, doors, edges)
        border = borders(pieces, len(edges))
        area_m2 = pieces.cells.astype(np.float64) * simplified.frame.resolution_m**2
        feature = self._features(pieces, path, corners)
        vertex, vertex_region, vertex_ring = polygons(np.where(pieces.label <= pieces.regions, pieces.label, 0))
        return InitialMap(
            piece=pieces.label,
            centre=centres(pieces.label, pieces.regions),
            area_m2=area_m2[: pieces.regions],
            start=doors.start[edges],
            end=doors.end[edges],
            door=edges,
            kind=doors.kind[edges],
            length_m=doors.length_m[edges],
            width_m=doors.width_m[edges],
            tilt_rad=doors.tilt_rad[edges],
            idle_door=proposed[idle],
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
        """Edges (k,) with fewer than two regions around them, crossing and touching doors looked through."""
        return np.bincount(borders(pieces, edges)[:, 0], minlength=edges) < 2  # noqa: PLR2004  # two sides

    def _features(self, pieces: Pieces, path: BoundaryPath, corners: Corners) -> Ints:
        """Rows (k, 2) of region and corner, sorted."""
        found = []
        count = np.diff(np.append(path.first, len(path.cell)))
        for ahead in range(-self.feature_samples, self.feature_samples + 1):
            contour = path.contour[corners.sample]
            local = corners.sample - path.first[contour] + ahead
            cell = path.free_cell[path.first[contour] + local % count[contour]]
            label = pieces.label[cell[:, 0], cell[:, 1]]
            inside = (label > 0) & (label <= pieces.regions)
            found.append(np.stack([label[inside] - 1, np.flatnonzero(inside)], axis=1))
        return np.unique(np.concatenate(found).astype(np.int32), axis=0)


@dataclass(frozen=True)
class Pieces:
    """The free space cut along doors, which are numbered 0 to k - 1 here."""

    label: Ints
    """(h, w) piece + 1, 0 where not free; regions first, then atoms."""
    regions: int
    cells: NDArray[np.int64]
    """(pieces,) how many cells each has."""
    cover: Ints
    """(m, 2) atom, door: which doors the atom lies on, sorted."""
    touch: Ints
    """(t, 2) pieces a < b with 4-adjacent cells, sorted."""


def cut(free: Mask, doors: VirtualDoors, chosen: Ints) -> Pieces:
    """Cut the free space along the chosen doors (rows of `doors`)."""
    number = np.full(len(doors.verdict), -1, np.int32)
    number[chosen] = np.arange(len(chosen), dtype=np.int32)
    on = number[doors.line_door] >= 0
    flat = doors.line_cell[on, 0].astype(np.int64) * free.shape[1] + doors.line_cell[on, 1]
    cell, atom_of_cell, cover = atoms(flat, number[doors.line_door[on]], free.shape[1])

    region_space = free.copy()
    region_space.reshape(-1)[cell] = False
    label, regions = ndimage.label(region_space)
    label.reshape(-1)[cell] = regions + 1 + atom_of_cell
    # Adjacency is asked of the door cells only: regions never touch each other.
    padded = np.pad(label, 1)
    row, col = np.divmod(cell, free.shape[1])
    pairs = [
        np.stack([label.reshape(-1)[cell], padded[row + 1 + down, col + 1 + right]], axis=1)
        for down, right in ((0, 1), (1, 0), (0, -1), (-1, 0))
    ]
    touch = np.sort(np.concatenate(pairs), axis=1)
    touch = np.unique(touch[(touch[:, 0] > 0) & (touch[:, 0] != touch[:, 1])], axis=0) - 1
    piece: Ints = label.astype(np.int32, copy=False)
    cells = runs_of(piece).cells(regions + int(atom_of_cell.max(initial=-1)) + 1)
    return Pieces(piece, regions, cells, cover, touch.astype(np.int32))


def atoms(flat: NDArray[np.int64], door: Ints, width: int) -> tuple[NDArray[np.int64], NDArray[np.intp], Ints]:
    """Door cells (k,) as sorted flat indices, the atom of each, and rows (m, 2) of atom and door, sorted.

    An atom is a 4-connected group of cells that lie on the same set of doors.
    """
    order = np.lexsort((door, flat))
    flat, door = flat[order], door[order]
    cell, begin, count = np.unique(flat, return_index=True, return_counts=True)
    deepest = count.max(initial=1)
    sets = np.full((len(cell), deepest), -1, np.int32)
    sets[np.repeat(np.arange(len(cell)), count), np.arange(len(flat)) - np.repeat(begin, count)] = door
    _, same_set = np.unique(sets, axis=0, return_inverse=True)
    links = []
    for step in (1, width):
        beside = np.searchsorted(cell, cell + step)
        beside[beside == len(cell)] = 0
        linked = (cell[beside] == cell + step) & (same_set[beside] == same_set) if len(cell) else np.zeros(0, np.bool_)
        linked &= (step != 1) | (cell % width != width - 1)
        links.append(np.stack([np.flatnonzero(linked), beside[linked]]))
    atom = components(np.concatenate(links, axis=1), len(cell))
    cover = np.unique(np.stack([np.repeat(atom, count), door], axis=1), axis=0)
    return cell, atom, cover.astype(np.int32)


def components(links: NDArray[np.intp], count: int) -> NDArray[np.intp]:
    """Component (count,) of each node under links (2, k), numbered by their first member."""
    if not count:
        return np.zeros(0, np.intp)
    graph = coo_array((np.ones(links.shape[1], np.bool_), (links[0], links[1])), shape=(count, count))
    _, label = connected_components(graph, directed=False)
    _, first, inverse = np.unique(label, return_index=True, return_inverse=True)
    return np.argsort(np.argsort(first))[inverse]


def borders(pieces: Pieces, doors: int) -> Ints:
    """Rows (k, 2) of door and region it borders, sorted.

    A door borders the regions its own atoms touch. Where those are fewer than two, a door beside or across it takes
    their place on one side, and the regions behind that one count as well.
    """
    to_atom = pieces.touch[pieces.touch[:, 0] < pieces.regions]
    own = _join(pieces.cover, to_atom[:, ::-1] - np.array([pieces.regions, 0], np.int32))
    short = np.bincount(own[:, 0], minlength=doors) < 2  # noqa: PLR2004  # two sides
    if not short.any():
        return own
    between = pieces.touch[pieces.touch[:, 0] >= pieces.regions] - pieces.regions
    cluster = components(between.T.astype(np.intp), len(pieces.cells) - pieces.regions)
    behind = np.stack([cluster[to_atom[:, 1] - pieces.regions], to_atom[:, 0]], axis=1)
    of_cluster = np.stack([pieces.cover[:, 1], cluster[pieces.cover[:, 0]]], axis=1)[short[pieces.cover[:, 1]]]
    wide = _join(np.unique(of_cluster, axis=0)[:, ::-1], np.unique(behind, axis=0))
    return np.unique(np.concatenate([own, wide]), axis=0).astype(np.int32)


def _join(key_left: NDArray[np.integer], key_right: NDArray[np.integer]) -> Ints:
    """Rows (left, right), unique and sorted, of two relations (key, left) and (key, right)."""
    right = key_right[np.argsort(key_right[:, 0], kind="stable")]
    begin = np.searchsorted(right[:, 0], key_left[:, 0], "left")
    count = np.searchsorted(right[:, 0], key_left[:, 0], "right") - begin
    row = np.arange(count.sum()) - np.repeat(np.cumsum(count) - count, count) + np.repeat(begin, count)
    rows = np.stack([np.repeat(key_left[:, 1], count), right[row, 1]], axis=1)
    return np.unique(rows, axis=0).astype(np.int32)


def centres(label: Ints, count: int) -> Ints:
    """The cell (count, 2) of each label 1 to `count` that lies nearest to the label's mean, the first one at a tie."""
    mean = runs_of(label).means(count)
    centre = np.rint(mean).astype(np.int32)
    elsewhere = label[centre[:, 0], centre[:, 1]] != np.arange(1, count + 1)
    boxes = ndimage.find_objects(label, max_label=count) if elsewhere.any() else []
    for region in np.flatnonzero(elsewhere):
        box = boxes[region]
        own = np.argwhere(label[box] == region + 1) + [side.start for side in box]
        centre[region] = own[np.argmin(((own - mean[region]) ** 2).sum(axis=1))]
    return centre


def polygons(label: Ints) -> tuple[Ints, Ints, Ints]:
    """Rings around every label: vertices (k, 2) in cell edges, their label, their ring (0 = outer, then holes)."""
    contours = follow(label, cross_corners=True)
    before = np.arange(-1, len(contours.turn) - 1)
    before[contours.first] = contours.first + contours.length - 1
    bends = np.flatnonzero(contours.turn[before] != 0)
    corner = contours.cell[bends] + CRACK_START[contours.heading[bends]]
    owner = label[contours.cell[contours.first, 0], contours.cell[contours.first, 1]]
    order = np.lexsort((np.arange(len(owner)), ~contours.outer, owner))
    begin = np.searchsorted(owner[order], owner[order], "left")
    ring = np.empty(len(order), np.int32)
    ring[order] = np.arange(len(order)) - begin

    # close each ring by repeating its first vertex, rings sorted by label
    of = contours.contour[bends]
    first = np.searchsorted(of, np.arange(len(owner)))
    index = np.concatenate([np.arange(len(of)), first])
    contour = np.concatenate([of, np.arange(len(owner))])
    rank = np.empty(len(owner), np.intp)
    rank[order] = np.arange(len(owner))
    sort = np.argsort(rank[contour], kind="stable")
    return corner[index[sort]].astype(np.int32), owner[contour[sort]].astype(np.int32), ring[contour[sort]]
