"""Section II.C: virtual doors between two convex corners, or from one to the closest boundary."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated, Any, ClassVar, NamedTuple

import numpy as np
import scipy
from numpy.typing import NDArray

from vdoor.config import Within
from vdoor.errors import MapError
from vdoor.frame import Frame
from vdoor.grid import FREE
from vdoor.method.boundary import BoundaryPath
from vdoor.method.corners import Corners, gaps_m
from vdoor.method.curvature import EPSILON
from vdoor.method.simplify import SimplifiedGrid
from vdoor.raster.lines import lines_between
from vdoor.record import Record, Spec
from vdoor.topology import KINDS

Floats = NDArray[np.float64]
Ints = NDArray[np.int32]
Mask = NDArray[np.bool_]

VERDICTS = ("proposed", "blocked", "same wall", "no gap", "duplicate", "too narrow")
PROPOSED = VERDICTS.index("proposed")
MOST_PAIRS = 2_000_000
"""Pairs of corners that are looked at: of maps of homes and halls, each corner is in 1 to 7."""


class VirtualDoors(Record):
    """Segments between obstacle cells that may be doors; `verdict` is why some are rejected."""

    topic: ClassVar[str] = "doors"

    start: Annotated[NDArray[np.int32], Spec("cell", "door 2")]
    """The obstacle cell of the convex corner."""
    end: Annotated[NDArray[np.int32], Spec("column", "door 2", unit="cells")]
    """The obstacle cell of the other corner, or of the closest boundary."""
    kind: Annotated[NDArray[np.uint8], Spec("code", "door", words=KINDS)]
    verdict: Annotated[NDArray[np.uint8], Spec("code", "door", words=VERDICTS)]
    corner_start: Annotated[NDArray[np.int32], Spec("column", "door", of="corners.sample")]
    corner_end: Annotated[NDArray[np.int32], Spec("column", "door", of="corners.sample", or_none=True)]
    """The other corner, -1 if the door ends at a boundary without a corner."""
    length_m: Annotated[NDArray[np.float64], Spec("column", "door", unit="m", tolerance=1e-9)]
    """Distance between the end cells' centres, to which the paper's 1.2 m applies."""
    width_m: Annotated[NDArray[np.float64], Spec("column", "door", unit="m", tolerance=1e-9)]
    """Width of the free gap between the end cells."""
    tilt_rad: Annotated[NDArray[np.float64], Spec("column", "door", unit="rad", tolerance=1e-9)]
    """Angle to the nearer axis of the grid, 0 to pi/4."""
    line_cell: Annotated[NDArray[np.int32], Spec("cell", "line 2")]
    """The free cells of proposed doors, 8-connected, door after door."""
    line_door: Annotated[NDArray[np.int32], Spec("column", "line", of="doors.start")]
    frame: Frame


@dataclass(frozen=True, kw_only=True)
class ProposeDoors:
    """Join convex corners close to each other, and the remaining ones to the closest boundary."""

    max_length_m: Annotated[float, Within(0, 20)] = 1.2
    """Longest door, between the centres of its end cells."""
    pair_detour: Annotated[float, Within(0, 100)] = 1.5
    """A door between two corners of one contour requires a path between them longer than this times the door."""
    single_detour: Annotated[float, Within(0, 100)] = 3.0
    """The same factor for a door between a corner and a boundary."""

    def __call__(self, simplified: SimplifiedGrid, path: BoundaryPath, corners: Corners) -> VirtualDoors:
        """Pairs first, then single corners, each sorted; crossing doors are kept, of equal ones only the first."""
        free = simplified.cells == FREE
        convex = np.flatnonzero(corners.convex).astype(np.int32)
        pairs = self._pairs(free, path, corners, convex)
        paired = np.unique(pairs.corners[pairs.verdict == PROPOSED])
        single = self._singles(free, path, corners, np.setdiff1d(convex, paired))
        found = pairs.followed_by(single)
        return measured(free, found, path.frame)

    def _pairs(self, free: Mask, path: BoundaryPath, corners: Corners, convex: Ints) -> DoorCandidates:
        """All pairs of convex corners within reach, with their verdicts."""
        both = pairs_within(corners, convex, self._reach(path))
        start, end = corners.cell[both[:, 0]], corners.cell[both[:, 1]]
        verdict = np.full(len(both), PROPOSED, np.uint8)
        clear, _, _ = lines_between(free, start, end)
        verdict[~clear] = VERDICTS.index("blocked")
        same = same_wall(path, corners.sample[both[:, 0]], corners.sample[both[:, 1]], self.pair_detour)
        verdict[same] = VERDICTS.index("same wall")
        verdict[np.abs(end - start).max(axis=1, initial=0) <= 1] = VERDICTS.index("no gap")
        return DoorCandidates(start, end, np.zeros(len(both), np.uint8), verdict, both)

    def _singles(self, free: Mask, path: BoundaryPath, corners: Corners, alone: Ints) -> DoorCandidates:
        """Each corner with its closest visible boundary cell (all at a tie) or, if none is visible, the closest hidden.

        The boundary next to the corner is its own wall and does not count.
        """
        corner, sample, squared = self._boundaries(path, corners, alone)
        start, end = corners.cell[corner], path.cell[sample]
        clear, _, _ = lines_between(free, start, end)
        nearest = np.full((2, len(corners.cell)), np.iinfo(np.int64).max)
        for rank, seen in enumerate((~clear, clear)):
            np.minimum.at(nearest[rank], corner[seen], squared[seen])
        has_clear = nearest[1, corner] < np.iinfo(np.int64).max
        chosen = np.where(clear, squared == nearest[1, corner], ~has_clear & (squared == nearest[0, corner]))
        verdict = np.where(clear, PROPOSED, VERDICTS.index("blocked")).astype(np.uint8)[chosen]
        both = np.stack([corner, np.full_like(corner, -1)], axis=1)[chosen]
        return DoorCandidates(
            start[chosen], end[chosen], np.full(len(verdict), KINDS.index("single"), np.uint8), verdict, both
        )

    def _boundaries(self, path: BoundaryPath, corners: Corners, alone: Ints) -> tuple[Ints, Ints, NDArray[np.int64]]:
        """Corners `alone`, each with all boundary samples within reach, and their squared distances in cells.

        One sample per cell, sorted by corner and cell. A cell is left out if any of its samples is on the corner's own
        wall.
        """
        tree, boundary = scipy.spatial.cKDTree(corners.cell[alone]), scipy.spatial.cKDTree(path.cell)
        if not len(alone):
            return alone, alone, alone.astype(np.int64)
        near = tree.sparse_distance_matrix(boundary, self._reach(path), output_type="ndarray")
        corner, sample = alone[near["i"]], near["j"].astype(np.int32)
        start, end = corners.cell[corner], path.cell[sample]
        own = same_wall(path, corners.sample[corner], sample, self.single_detour)
        own |= np.abs(end - start).max(axis=1) <= 1
        # one entry per cell; samples on the own wall come first, so that one of them excludes its cell
        cell = end[:, 0].astype(np.int64) * (path.frame.width + 2) + end[:, 1]  # columns -1 to width
        order = np.lexsort((~own, cell, corner))
        key = np.stack([corner[order], cell[order]])
        leads = np.append(True, (key[:, 1:] != key[:, :-1]).any(axis=0))
        kept = order[leads & ~own[order]]
        span = (end[kept] - start[kept]).astype(np.int64)
        return corner[kept], sample[kept], (span * span).sum(axis=1)

    def _reach(self, path: BoundaryPath) -> float:
        """The length of the longest door in cells."""
        return self.max_length_m / path.frame.resolution_m + EPSILON


def same_wall(path: BoundaryPath, one: Ints, other: Ints, detour: float) -> Mask:
    """Whether the path between two samples (k,) is so short that the segment between them only runs along one wall."""
    length_m = np.hypot(*(path.cell[other] - path.cell[one]).T) * path.frame.resolution_m
    common = path.contour[one] == path.contour[other]
    return np.asarray(common & (gaps_m(path, one, other) <= detour * length_m + EPSILON))


class DoorCandidates(NamedTuple):
    """The columns of virtual doors, before these are measured."""

    start: Ints
    end: Ints
    kind: NDArray[np.uint8]
    verdict: NDArray[np.uint8]
    corners: Ints

    def followed_by(self, other: DoorCandidates) -> DoorCandidates:
        """The rows of both, this one's first."""
        columns: Iterator[tuple[Any, Any]] = zip(self, other, strict=True)
        return DoorCandidates(*map(np.concatenate, columns))


def measured(free: Mask, found: DoorCandidates, frame: Frame) -> VirtualDoors:
    """The record of the virtual doors, with measures, duplicates marked, and the cells of the proposed ones."""
    verdict = without_duplicates(found)
    proposed = np.flatnonzero(verdict == PROPOSED)
    _, line_cell, owner = lines_between(free, found.start[proposed], found.end[proposed])
    length_m, width_m, tilt_rad = measures(found.start, found.end, frame.resolution_m)
    return VirtualDoors(
        start=found.start,
        end=found.end,
        kind=found.kind,
        verdict=verdict,
        corner_start=found.corners[:, 0],
        corner_end=found.corners[:, 1],
        length_m=length_m,
        width_m=width_m,
        tilt_rad=tilt_rad,
        line_cell=line_cell,
        line_door=proposed[owner].astype(np.int32),
        frame=frame,
    )


def pairs_within(corners: Corners, among: Ints, reach: float) -> Ints:
    """Pairs (k, 2) of the corners `among` at most `reach` cells apart, the lower first, sorted.

    Raises MapError for more than `MOST_PAIRS`.
    """
    if not len(among):
        return np.zeros((0, 2), np.int32)
    tree = scipy.spatial.cKDTree(corners.cell[among])
    found = (int(tree.count_neighbors(tree, reach)) - len(among)) // 2
    if found > MOST_PAIRS:
        raise MapError(
            f"doors: wanted at most {MOST_PAIRS} pairs of corners within reach of each other, found {found}; the map "
            f"is noise, or its cells are larger than it says (--resolution)"
        )
    near = tree.query_pairs(reach, output_type="ndarray")
    both = among[np.sort(near, axis=1).astype(np.intp)].reshape(-1, 2)
    return np.asarray(both[np.lexsort((both[:, 1], both[:, 0]))])


def without_duplicates(found: DoorCandidates) -> NDArray[np.uint8]:
    """The verdicts (k,), with all but the first of proposed segments with equal ends changed to duplicate."""
    proposed = np.flatnonzero(found.verdict == PROPOSED)
    start, end = found.start[proposed], found.end[proposed]
    swap = (start[:, 0] > end[:, 0]) | ((start[:, 0] == end[:, 0]) & (start[:, 1] > end[:, 1]))
    ends = np.where(swap[:, None], np.hstack([end, start]), np.hstack([start, end]))
    _, first = np.unique(ends, axis=0, return_index=True)
    verdict = found.verdict.copy()
    verdict[np.delete(proposed, first)] = VERDICTS.index("duplicate")
    return verdict


def measures(start: Ints, end: Ints, cell_m: float) -> tuple[Floats, Floats, Floats]:
    """Length between the centres in m, free gap in m, and angle to the nearer axis in rad, of segments (k,)."""
    span = np.abs(end - start)
    long, short = span.max(axis=1), span.min(axis=1)
    length = np.hypot(long, short)
    # a segment leaves its end cell after half a cell along the longer axis
    gap = length * np.maximum(1 - 1 / np.maximum(long, 1), 0)
    return length * cell_m, gap * cell_m, np.arctan2(short, long)
