"""From a space and rooms to a path that covers them: one visit to each part of a room, in turn."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import scipy
import shapely
from numpy.typing import NDArray

from vdoor.navigate.coverage.floor import Part, floor_of, inset_of, nearest_on, room_parts
from vdoor.navigate.coverage.net import Net
from vdoor.navigate.coverage.path import Path
from vdoor.navigate.coverage.pieces import Piece, Rest, lanes, wall_passes
from vdoor.navigate.coverage.polish import Polish
from vdoor.navigate.coverage.sweep import Tool, finer, inside_rings
from vdoor.navigate.coverage.tour import tour_of
from vdoor.navigate.coverage.visits import Parts, Round, Visit
from vdoor.navigate.space import Space
from vdoor.raster.components import contacts

Mask = NDArray[np.bool_]
Ints = NDArray[np.int32]
Floats = NDArray[np.float64]
Box = tuple[slice, slice]

LARGEST_CELL_M = 0.03
"""It is counted on cells of at most this size what is swept; larger ones of the map are divided."""
LEAST_AREA, LEAST_BY_LEAVE = 0.15, 7.5
"""A smaller uncovered place gets no lane, in squares of the tool's width; less if less may stay uncovered: so many
times that share."""
NARROW = 0.55
"""The whole trade counts where at least this share of the floor lies beside walls, and less of it in more open floor:
what is left uncovered there is no sliver between legs that would take a detour."""
SMALL_ISLAND = 6.0
"""What stands free is swept all around if the way around it is at most so long, in widths of the tool."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Task:
    """What is to be swept, from where, and what it may cost."""

    space: Space
    labels: Ints
    """The units that are visited one after the other, rooms as a rule: numbers of cells (h, w), 0 for none."""
    rooms: Sequence[int]
    """The units to be swept, in order if `ordered`."""
    ordered: bool
    start: Floats
    """Row, col (2,) of an allowed cell."""
    end: Floats | None
    """Row, col (2,) of an allowed cell, None if the path may end anywhere."""
    reach: float
    """Half of the tool's width, in cells."""
    trade: float
    """See `Polish`, as the next two."""
    bend: float
    leave: float


@dataclass(frozen=True, eq=False)
class Covered:
    """A path that covers rooms."""

    path: Path
    room: Sequence[int]
    """The room of each visit, in order."""
    wanted: Mask
    """The cells of the tool's raster that it could sweep in the rooms (h, w)."""
    tool: Tool


def cover(task: Task) -> Covered:
    """A path that covers what can be reached from its start."""
    space = task.space
    floor = floor_of(space, space.parts == space.parts[tuple(task.start.astype(np.intp))])
    radius = space.radius_m / space.frame.resolution_m
    tool = Tool.on(space.blocked, _fine(space), reach=task.reach, radius=radius)
    wanted = _reachable(tool, floor, inset_of(space)) & finer(np.isin(task.labels, task.rooms), tool.fine)
    site = Site(floor, tool, wanted, task.labels, min(LEAST_AREA, LEAST_BY_LEAVE * task.leave))
    parts = room_parts(site.floor, task.labels)
    chosen = [number for room in task.rooms for number, part in enumerate(parts) if part.room == room]
    if not chosen:
        return Covered(Path.along(task.start[None], "way", 0), [], wanted, tool)
    ends = np.stack([nearest_on(site.floor, at) for at in (task.start, task.start if task.end is None else task.end)])
    ways = Parts.of(site.floor, [part.floor for part in parts], ends)
    tour = ways.round(chosen, ends=task.end is not None, ordered=task.ordered)
    polish = Polish(
        floor=floor,
        tool=tool,
        wanted=wanted,
        kept=site.thresholds | _beside_small_islands(tool, floor),
        trade=task.trade * min(1.0, _beside_walls(floor, tool) / NARROW),
        bend=task.bend,
        leave=task.leave,
    )
    path = polish(_driven(site, parts, tour))
    return Covered(path, [parts[visit.part].room for visit in tour.visits], wanted, tool)


def _beside_walls(floor: shapely.MultiPolygon, tool: Tool) -> float:
    """About the share of a floor within the tool's width of its border; over 1 where passages are narrower."""
    return float(floor.length / floor.area * 2 * tool.reach) if floor.area > 0 else 1.0


def _fine(space: Space) -> int:
    """How many cells of the raster lie along a cell of the map."""
    return max(1, math.ceil(space.frame.resolution_m / LARGEST_CELL_M))


def _reachable(tool: Tool, floor: shapely.MultiPolygon, inset: float) -> Mask:
    """The cells of the raster (h, w) that the tool reaches from where its centre keeps the clearance."""
    rings = [shapely.get_coordinates(ring) for ring in shapely.get_rings(shapely.get_parts(floor))]
    start, end = (np.concatenate([ring[own] for ring in rings]) for own in (slice(None, -1), slice(1, None)))
    return replace(tool, reach=tool.reach + inset).reachable(start, end)


def _beside_small_islands(tool: Tool, floor: shapely.MultiPolygon) -> Mask:
    """The cells of the raster (h, w) beside table legs and the like, within what the tool's centre goes around."""
    islands = [ring for part in floor.geoms for ring in part.interiors if ring.length <= SMALL_ISLAND * 2 * tool.reach]
    rings = [tool.on_raster(shapely.get_coordinates(ring)) for ring in islands] or [np.zeros((1, 2))]
    start, end = (np.concatenate([ring[own] for ring in rings]) for own in (slice(None, -1), slice(1, None)))
    return inside_rings(start, end, tool.blocked.shape)


@dataclass(frozen=True, eq=False)
class Site:
    """A floor, a tool, and what is to be swept."""

    floor: shapely.MultiPolygon
    tool: Tool
    wanted: Mask
    labels: Ints
    least_area: float
    """Smaller uncovered places get no lane, in squares of the tool's width."""

    @cached_property
    def boundary(self) -> shapely.Geometry:
        """The lines along walls and islands."""
        return self.floor.boundary

    @cached_property
    def thresholds(self) -> Mask:
        """The cells of the raster (h, w) where two rooms touch, with their neighbours."""
        beside, _ = contacts(self.labels)  # the middles of sides between cells
        found = np.zeros(self.labels.shape, np.bool_)
        for cell in (np.floor(beside), np.ceil(beside)):
            found[tuple(cell.astype(np.intp).T)] = True
        near = scipy.ndimage.binary_dilation(found)
        return finer(near, self.tool.fine)

    def pieces(self, part: Part) -> list[Piece]:
        """Passes along the walls of a part of a room, and lanes over what these leave uncovered."""
        width = 2 * self.tool.reach
        passes = wall_passes(part.floor, self.boundary, width)
        swept = np.zeros(self.wanted.size, np.bool_)
        for piece in passes:
            swept[self.tool.swept(piece.point[:-1], piece.point[1:]).cell] = True
        box, raster = self._box(part)
        own = finer(self.labels[box] == part.room, self.tool.fine)
        uncovered = self.wanted[raster] & own & ~swept.reshape(self.wanted.shape)[raster]
        at = self.tool.on_map(np.argwhere(uncovered) + [side.start for side in raster])
        rest = Rest(
            uncovered=uncovered,
            thresholds=self.thresholds[raster],
            at=at,
            side=1 / self.tool.fine,
            least_area=self.least_area,
        )
        return passes + lanes(rest, part.floor, width)

    def _box(self, part: Part) -> tuple[Box, Box]:
        """The cells around a part that the tool can sweep from it, of the map and of the raster."""
        low_row, low_col, high_row, high_col = part.floor.bounds
        more = self.tool.reach + 1
        height, width = self.labels.shape
        rows = slice(max(int(low_row - more), 0), min(int(high_row + more) + 1, height))
        cols = slice(max(int(low_col - more), 0), min(int(high_col + more) + 1, width))
        fine = self.tool.fine
        return (rows, cols), (_times(rows, fine), _times(cols, fine))


def _times(side: slice, fine: int) -> slice:
    return slice(side.start * fine, side.stop * fine)


def _driven(site: Site, parts: Sequence[Part], tour: Round) -> Path:
    """The path over all visits, not yet polished."""
    stretches = []
    for number, visit in enumerate(tour.visits):
        stretches.append(Path.along(visit.way, "way", number))
        part = parts[visit.part]
        stretches += _visited(site.pieces(part), part, visit, number)
    if len(tour.home):
        stretches.append(Path.along(tour.home, "way", len(tour.visits) - 1))
    return Path.joined(stretches)


def _visited(pieces: Sequence[Piece], part: Part, visit: Visit, number: int) -> list[Path]:
    """The stretches of a path that drives all pieces of a part."""
    count = 2 * len(pieces)
    leave = [] if visit.leave is None else [visit.leave[None]]
    ends = np.concatenate([piece.point[[0, -1]] for piece in pieces] + [visit.way[-1:], *leave])
    piece = np.arange(count).reshape(-1, 2)
    straight = np.array([own.kind == "lane" for own in pieces], np.bool_)
    net = Net.over(part.floor, ends, piece[straight])
    near = piece[np.isfinite(net.distance[count, piece[:, 0]])]
    tour = tour_of(net.distance, near, count, count + 1 if leave else None)
    stretches = []
    for here, enter in zip(tour.leave[:-1].tolist(), tour.enter[1:].tolist(), strict=True):
        stretches.append(Path.along(net.way(here, enter), "way", number))
        if enter < count:
            own = pieces[enter // 2]
            stretches.append(Path.along(own.point if enter % 2 == 0 else own.point[::-1], own.kind, number))
    return stretches
