"""The floor of a map as polygons: everywhere the robot's centre may be, as a whole and room by room.

Points are row, col in cells, also as the two coordinates of a polygon. Paths along walls and lanes between them are
not bound to cell centres, which saves turns on slanted walls and leaves less uncovered beside them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import scipy
import shapely
import shapely.affinity
from numpy.typing import NDArray

from vdoor.navigate.coverage.path import norms
from vdoor.navigate.space import Space, grown
from vdoor.raster.polygons import polygons
from vdoor.raster.runs import parts_of_mask

Mask = NDArray[np.bool_]
Ints = NDArray[np.int32]
Floats = NDArray[np.float64]

ARC = 16
"""Straight pieces in a quarter of a circle around a corner."""
SLACK_M = 0.002
"""By how much the boundary of the floor may lie further inside, so that it has fewer vertices."""
SHALLOW = 0.1
"""Corners into which the robot comes no deeper are filled, in cells: those between the steps of a slanted wall."""
NEAR = 2.0
"""A place is moved so far onto a larger part of the floor, in cells."""
SNAP = 1e-3
"""How much larger the floor is when it is asked whether a path stays inside, in cells: points on its boundary do."""


@dataclass(frozen=True, eq=False)
class Part:
    """A connected part of a room's floor."""

    room: int
    floor: shapely.Polygon


def floor_of(space: Space, centres: Mask) -> shapely.MultiPolygon:
    """Where the robot's centre may be, around the allowed cells `centres` (h, w): every point keeps the clearance."""
    radius, slack = (length_m / space.frame.resolution_m for length_m in (space.radius_m, SLACK_M))
    free = grown(centres, radius + 2) & ~space.blocked
    outer = shapely.union_all([_filled(part, radius) for part in outlines(free)])
    inside = outer.buffer(-radius - inset_of(space), quad_segs=ARC).simplify(slack / 2)
    kept = [part for part in parts_of(inside) if _holds_any(part, centres)]
    return shapely.MultiPolygon(kept)


def inset_of(space: Space) -> float:
    """How much farther from everything than the radius the boundary of a floor is on average, in cells."""
    within = math.cos(math.pi / (4 * ARC))  # how near the chords of an arc come to its centre
    return ((space.radius_m + SLACK_M / 2) / within - space.radius_m) / space.frame.resolution_m


def nearest_on(floor: shapely.MultiPolygon, point: Floats) -> Floats:
    """The nearest place on the floor (2,), on the largest of its parts that is near enough.

    An allowed cell may lie just outside, or on a part of its own that is cut off by a place where the robot barely
    fits.
    """
    parts = shapely.get_parts(floor)
    apart = shapely.distance(parts, shapely.Point(point))
    near = np.flatnonzero(apart <= max(NEAR, float(apart.min())))
    part = parts[near[int(np.argmax(shapely.area(parts[near])))]]
    inside = shapely.intersects_xy(part, *point)
    return point if inside else shapely.get_coordinates(shapely.shortest_line(part, shapely.Point(point)))[0]


def _filled(free: shapely.Polygon, radius: float) -> shapely.Polygon:
    """Free cells without the shallow corners that a robot of a radius touches on both sides but hardly enters."""
    shell, *holes = (_without_corners(shapely.get_coordinates(ring)[:-1], radius) for ring in shapely.get_rings(free))
    return shapely.Polygon(shell, holes)


def _without_corners(vertex: Floats, radius: float) -> Floats:
    """A ring (k, 2) with free cells to one side, without shallow corners, of two in a row without the first."""
    before, after = np.roll(vertex, 1, axis=0), np.roll(vertex, -1, axis=0)
    one, other = vertex - before, after - vertex
    hollow = one[:, 0] * other[:, 1] < one[:, 1] * other[:, 0]
    half = norms(after - before) / 2
    depth = radius - np.sqrt(np.maximum(radius**2 - half**2, 0))
    shallow = hollow & (depth <= SHALLOW)
    return vertex[~(shallow & ~np.roll(shallow, 1))]


def _holds_any(part: shapely.Polygon, centres: Mask) -> bool:
    low_row, low_col, high_row, high_col = part.bounds
    rows = np.arange(max(math.ceil(low_row), 0), min(math.floor(high_row), centres.shape[0] - 1) + 1)
    cols = np.arange(max(math.ceil(low_col), 0), min(math.floor(high_col), centres.shape[1] - 1) + 1)
    found = np.argwhere(centres[np.ix_(rows, cols)])
    if not len(found):
        return False
    return bool(shapely.intersects_xy(part, rows[found[:, 0]], cols[found[:, 1]]).any())


def outlines(cells: Mask) -> list[shapely.Polygon]:
    """The outlines of the connected parts of `cells` (h, w), along cell edges."""
    parts = parts_of_mask(cells)
    if not parts.most:
        return []
    vertex, owner, ring = polygons(parts)
    ends = np.flatnonzero((np.diff(owner) != 0) | (np.diff(ring) != 0)) + 1
    rings = np.split(vertex - 0.5, ends)
    outer = np.flatnonzero(ring[np.append(0, ends)] == 0)
    return [shapely.Polygon(shell, holes) for shell, *holes in (rings[a:b] for a, b in _spans(outer, len(rings)))]


def _spans(first: NDArray[np.intp], count: int) -> list[tuple[int, int]]:
    return list(zip(first.tolist(), [*first[1:].tolist(), count], strict=True))


def enlarged(shape: shapely.Geometry, distance: float) -> shapely.Geometry:
    """A shape grown by a distance, with its corners, ready to be asked often."""
    larger: shapely.Geometry = shapely.buffer(shape, distance, join_style="mitre")
    shapely.prepare(larger)
    return larger


def parts_of(shape: shapely.Geometry) -> list[shapely.Polygon]:
    """The polygons of a shape, without points and lines."""
    return [part for part in shapely.get_parts(shape) if isinstance(part, shapely.Polygon) and part.area > 0]


def room_parts(floor: shapely.MultiPolygon, labels: Ints) -> list[Part]:
    """The connected parts of each room's floor, by room; `labels` (h, w) as in the topological map."""
    found = []
    for room, box in enumerate(scipy.ndimage.find_objects(labels), start=1):
        if box is None:
            continue
        corner = np.array([box[0].start, box[1].start], np.float64)
        own = shapely.affinity.translate(shapely.union_all(outlines(labels[box] == room)), *corner)
        near = shapely.clip_by_rect(floor, box[0].start - 1, box[1].start - 1, box[0].stop, box[1].stop)
        inside = shapely.intersection(near, own)
        found += [Part(room, part) for part in parts_of(inside)]
    return found
