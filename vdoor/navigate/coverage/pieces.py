"""What a room's path is put together from: passes along its walls and around its islands, and lanes in between."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import scipy
import shapely
from numpy.typing import NDArray

from vdoor.navigate.coverage.path import norms

Mask = NDArray[np.bool_]
Floats = NDArray[np.float64]

PASS_LENGTH = 3.5
"""Length of the pieces into which a pass along the walls is cut, in widths of the tool: the tour may leave a wall
between two pieces and return later."""
LANE_COST = 2.0
"""What a further lane costs, in widths of the tool, when the direction of lanes is chosen: two turns and a way."""
GAP = 1.5
"""Lanes are interrupted where so many widths of the tool along them are swept already."""
SHORTENED = 0.4
"""How much a lane is shorter than what it has to sweep, at each end, in widths of the tool."""
ON_BOUNDARY = 1e-6
"""Rounding errors of points on a boundary, in cells."""
SAME_DIRECTION_RAD = math.radians(2)
"""Directions of walls that differ less from the map's axes count as the axes'."""


@dataclass(frozen=True, eq=False)
class Piece:
    """A piece of a path, to be driven in either direction."""

    kind: str
    """wall or lane."""
    point: Floats
    """Row, col of its vertices (k, 2), at least two."""


def wall_passes(part: shapely.Polygon, boundary: shapely.Geometry, width: float) -> list[Piece]:
    """Passes along the lines of the whole floor's `boundary` that lie in one part: none along cuts at doors."""
    inside = part.buffer(ON_BOUNDARY)
    along = shapely.intersection(shapely.clip_by_rect(boundary, *inside.bounds), inside)
    lines = [line for line in shapely.get_parts(shapely.line_merge(along)) if line.length > 2 * ON_BOUNDARY]
    return [Piece("wall", cut) for line in lines for cut in _cut(shapely.get_coordinates(line), width)]


def _cut(point: Floats, width: float) -> list[Floats]:
    """A line cut at vertices into pieces of about equal lengths; a ring into four at least, so it is met anywhere."""
    gone = np.concatenate([[0], np.cumsum(norms(np.diff(point, axis=0)))])
    count = max(4 if (point[0] == point[-1]).all() else 1, round(gone[-1] / (PASS_LENGTH * width)))
    inner = np.searchsorted(gone, np.linspace(0, gone[-1], count + 1)[1:-1])
    at = np.unique([0, *inner.tolist(), len(point) - 1])
    return [point[a : b + 1] for a, b in pairwise(at.tolist())]


@dataclass(frozen=True, kw_only=True, eq=False)
class Rest:
    """What passes along walls leave uncovered, on a raster."""

    uncovered: Mask
    """Cells to be swept (h, w)."""
    thresholds: Mask
    """Cells where rooms touch (h, w)."""
    at: Floats
    """Row, col on the map of each uncovered cell (n, 2)."""
    side: float
    """Of a cell of the raster, in cells of the map."""
    least_area: float
    """A smaller patch gets no lane, nor does a stretch of a lane over less, in squares of the tool's width."""


def lanes(rest: Rest, part: shapely.Polygon, width: float) -> list[Piece]:
    """Lanes that sweep the uncovered cells of a part, for each connected patch in the cheapest direction.

    A patch at a threshold is swept however small, since it goes on in the next room.
    """
    uncovered, side = rest.uncovered, rest.side
    least = rest.least_area * (width / side) ** 2
    patch, count = scipy.ndimage.label(uncovered, np.ones((3, 3)))
    own = patch[uncovered]
    cell = rest.at[np.argsort(own, kind="stable")]
    ends = np.cumsum(np.bincount(own, minlength=count + 1))
    at_door = np.bincount(patch[uncovered & rest.thresholds], minlength=count + 1)[1:] > 0
    turned = _directions_rad(part, width)
    found = []
    for (first, last), sure in zip(pairwise(ends.tolist()), at_door.tolist(), strict=True):
        if sure or last - first >= least:
            tried = [_lanes(cell[first:last], rest, rad, width) for rad in turned]
            found += list(tried[int(np.argmin([_cost(lines, width) for lines in tried]))])
    inside = (shapely.intersection(shapely.LineString(line), part) for line in found)
    return [Piece("lane", _ends(lane)) for line in inside for lane in shapely.get_parts(line) if not lane.is_empty]


def _ends(line: shapely.Geometry) -> Floats:
    """The two ends of a lane, equal for one that is a point."""
    return shapely.get_coordinates(line)[[0, -1]]


def _directions_rad(part: shapely.Polygon, width: float) -> list[float]:
    """Directions of lanes: the map's axes, and those of the walls where they differ."""
    side = np.diff(shapely.get_coordinates(part.exterior.simplify(width / 2)), axis=0)
    angle_rad, length = np.arctan2(side[:, 1], side[:, 0]), norms(side)
    walls_rad = float(np.angle((length * np.exp(4j * angle_rad)).sum())) / 4  # -45 to 45 degrees
    turned = [] if abs(walls_rad) < SAME_DIRECTION_RAD else [walls_rad, walls_rad + math.pi / 2]
    return [0.0, math.pi / 2, *turned]


def _cost(lines: Floats, width: float) -> float:
    """The length of lanes and what is between them; after an odd number the robot has to come back."""
    length = norms(lines[:, 1] - lines[:, 0])
    return float(length.sum() + LANE_COST * width * len(lines) + len(lines) % 2 * length.sum() / max(len(lines), 1))


def _lanes(cell: Floats, rest: Rest, direction_rad: float, width: float) -> Floats:
    """Lanes (k, 2, 2) in one direction, as far apart as the tool is wide or closer, over the cells of one patch."""
    axes = np.array(
        [[math.cos(direction_rad), math.sin(direction_rad)], [-math.sin(direction_rad), math.cos(direction_rad)]]
    )
    along, across = axes @ cell.T
    low, high = across.min() - rest.side / 2, across.max() + rest.side / 2
    count = max(1, math.ceil((high - low) / width - 1e-6))
    apart = (high - low) / count
    lane = np.minimum(((across - low) / apart).astype(np.intp), count - 1)
    order = np.lexsort((along, lane))
    along, lane = along[order], lane[order]
    ends = np.flatnonzero((np.diff(lane) != 0) | (np.diff(along) > GAP * width))
    first, last = np.concatenate([[0], ends + 1]), np.concatenate([ends, [len(lane) - 1]])
    enough = ((last - first + 1) * rest.side**2 >= rest.least_area * width**2) | (len(first) == 1)
    first, last = first[enough], last[enough]
    shorter = np.minimum(SHORTENED * width, (along[last] - along[first]) / 2)
    middle = low + (lane[first] + 0.5) * apart
    ends_at = [np.stack([along[first] + shorter, middle]), np.stack([along[last] - shorter, middle])]
    return np.stack([(axes.T @ end).T for end in ends_at], axis=1)
