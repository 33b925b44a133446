"""From a space and rooms to a path that covers them: one visit to each part of a room, in turn."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated

import numpy as np
import shapely
from numpy.typing import NDArray

from vdoor.config import Within
from vdoor.navigate.coverage.floor import Part, floor_of, room_parts
from vdoor.navigate.coverage.net import Net
from vdoor.navigate.coverage.path import Path
from vdoor.navigate.coverage.pieces import Piece, lanes, wall_passes
from vdoor.navigate.coverage.polish import Polish
from vdoor.navigate.coverage.sweep import Tool
from vdoor.navigate.coverage.tour import tour_of
from vdoor.navigate.coverage.visits import Parts, Round, Visit
from vdoor.navigate.space import Space

Mask = NDArray[np.bool_]
Ints = NDArray[np.int32]
Floats = NDArray[np.float64]


LEVELS=(.125,.25,.5,1)
@dataclass(frozen=True, kw_only=True)
class CoverFloor:
    """Plan a path whose tool sweeps the floor."""

    tool_m: Annotated[float, Within(0.01, 10)] = 0.30
    """Width of the tool."""
    trade: Annotated[float, Within(0, 1)] = 0.12
    """How much area may stay uncovered for a length saved, as a share of what the tool sweeps on that length; the dial
    between coverage and length."""
    leave: Annotated[float, Within(0, 1)] = 0.02
    bend_m: Annotated[float, Within(0, 10)] = 0.2
    """What a bend of the path costs, as a length."""

    def __call__(self, space: Space, labels: Ints, *, reached: Mask, start: Floats, end: Floats | None) -> Covered:
        """Cover the cells with a label (h, w), from the allowed cells `reached` (h, w).

        `start` and `end` are row, col (2,), among these; without an end the path may end anywhere. Rooms are visited
        one after the other.
        """
        resolution_m = space.frame.resolution_m
        reach = self.tool_m / 2 / resolution_m
        tool = Tool(reach, space.blocked, reach > space.radius_m / resolution_m)
        wanted = tool.reachable(reached) & (labels > 0)
        floor = floor_of(space, reached)
        parts = room_parts(floor, labels)
        tour = Parts.of(floor, [part.floor for part in parts], np.stack([start, start if end is None else end]))
        round_ = tour.round(range(len(parts)), ends=end is not None)
        site = Site(floor, tool, wanted, labels)
        path = _driven(site, parts, round_)
        for share in LEVELS:
            path = Polish(floor=floor, tool=tool, wanted=wanted, trade=self.trade*share, bend=self.bend_m / resolution_m, leave=self.leave)(path)
        return Covered(path, [parts[visit.part].room for visit in round_.visits], wanted, tool)


@dataclass(frozen=True, eq=False)
class Covered:
    """A path that covers rooms."""

    path: Path
    room: Sequence[int]
    """The room of each visit."""
    wanted: Mask
    """The cells that the tool could sweep in the rooms wanted (h, w)."""
    tool: Tool


@dataclass(frozen=True, eq=False)
class Site:
    """What is to be swept, and from where."""

    floor: shapely.MultiPolygon
    tool: Tool
    wanted: Mask
    labels: Ints

    def pieces(self, part: Part) -> list[Piece]:
        """Passes along the walls of a part of a room, and lanes over what these leave uncovered."""
        box = self._box(part)
        width = 2 * self.tool.reach
        passes = wall_passes(part.floor, self.floor.boundary, width)
        swept = np.zeros(self.wanted.size, np.bool_)
        for piece in passes:
            swept[self.tool.swept(piece.point[:-1], piece.point[1:]).cell] = True
        uncovered = self.wanted[box] & (self.labels[box] == part.room) & ~swept.reshape(self.wanted.shape)[box]
        corner = np.array([side.start for side in box], np.float64)
        local = shapely.transform(part.floor, lambda at: at - corner)
        between = [Piece(piece.kind, piece.point + corner) for piece in lanes(uncovered, local, width)]
        return passes + between

    def _box(self, part: Part) -> tuple[slice, slice]:
        """The cells around a part that the tool can sweep from it."""
        low_row, low_col, high_row, high_col = part.floor.bounds
        more = self.tool.reach + 1
        height, width = self.wanted.shape
        return (
            slice(max(int(low_row - more), 0), min(int(high_row + more) + 1, height)),
            slice(max(int(low_col - more), 0), min(int(high_col + more) + 1, width)),
        )


def _driven(site: Site, parts: Sequence[Part], round_: Round) -> Path:
    """The path over all visits, not yet polished."""
    stretches = []
    for number, visit in enumerate(round_.visits):
        stretches.append(Path.along(visit.way, "way", number))
        stretches += _visited(site.pieces(parts[visit.part]), parts[visit.part], visit, number)
    if len(round_.home):
        stretches.append(Path.along(round_.home, "way", len(round_.visits) - 1))
    return Path.joined(stretches)


def _visited(pieces: Sequence[Piece], part: Part, visit: Visit, number: int) -> list[Path]:
    """The stretches of a path that drives all pieces of a part."""
    ends = np.concatenate([piece.point[[0, -1]] for piece in pieces] + [visit.way[-1:]])
    if visit.leave is not None:
        ends = np.concatenate([ends, visit.leave[None]])
    piece = np.arange(2 * len(pieces)).reshape(-1, 2)
    straight = piece[[own.kind == "lane" for own in pieces]]
    net = Net.over(part.floor, ends, straight)
    reached = piece[np.isfinite(net.distance[2 * len(pieces), piece[:, 0]])]
    tour = tour_of(net.distance, reached, 2 * len(pieces), len(ends) - 1 if visit.leave is not None else None)
    stretches = []
    for here, enter in zip(tour.leave[:-1].tolist(), tour.enter[1:].tolist(), strict=True):
        stretches.append(Path.along(net.way(here, enter), "way", number))
        if enter < 2 * len(pieces):
            own = pieces[enter // 2]
            stretches.append(Path.along(own.point if enter % 2 == 0 else own.point[::-1], own.kind, number))
    return stretches
