"""How good a path is: what it sweeps, how long and how winding it is, and how near it comes to anything."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vdoor.navigate.coverage.path import Path, norms
from vdoor.navigate.coverage.sweep import Swept, Tool
from vdoor.navigate.sight import least_clearance
from vdoor.navigate.space import Space
from vdoor.raster.runs import consecutive

Mask = NDArray[np.bool_]
Ints = NDArray[np.intp]
Labels = NDArray[np.int32]
Floats = NDArray[np.float64]

TURN_RAD = np.radians(10.0)
"""A smaller change of heading is driven without slowing down and is no turn."""


@dataclass(frozen=True, kw_only=True)
class Measures:
    """Figures of a path that covers a floor."""

    covered: float
    """Share of the cells within the tool's reach of where the robot can be."""
    length_m: float
    excess: float
    """Length over what a path without overlap would need: the swept area over the tool's width."""
    swept_twice: float
    """Share of the swept cells that are swept again after the tool has been elsewhere."""
    turns: int
    """Changes of heading by more than 10 degrees."""
    turns_per_m2: float
    rotation_rad: float
    """Sum of all changes of heading."""
    clearance_m: float
    """Least distance from the path to the edge of a cell that must not be touched."""
    room_changes: int
    """How often the path goes from one room into another, and stays there for longer than the tool is wide."""


@dataclass(frozen=True, kw_only=True)
class Motion:
    """How fast the robot moves."""

    speed_m_s: float = 0.3
    turn_rad_s: float = 1.5

    def times_s(self, path: Path, resolution_m: float) -> Floats:
        """When the robot is at each point (k,): straight at its speed, and on the spot at each turn."""
        lengths_m = norms(np.diff(path.point, axis=0)) * resolution_m
        bends = path.bends_rad()
        turning = np.concatenate([[0.0], np.where(bends > TURN_RAD, bends, 0.0)]) / self.turn_rad_s
        return np.concatenate([[0.0], np.cumsum(turning[: len(lengths_m)] + lengths_m / self.speed_m_s)])


def measured(path: Path, tool: Tool, wanted: Mask, labels: Labels, space: Space) -> Measures:
    """The figures of a path for a tool; `wanted` are the cells of its raster to be swept, `labels` the map's rooms."""
    resolution_m = space.frame.resolution_m
    width = 2 * tool.reach
    swept = tool.swept(path.point[:-1], path.point[1:])
    times = np.bincount(swept.cell, minlength=wanted.size)
    own = wanted & (times.reshape(wanted.shape) > 0)
    area_m2 = np.count_nonzero(own) * (resolution_m / tool.fine) ** 2
    length_m = path.length * resolution_m
    bends_rad = path.bends_rad()
    turns = int(np.count_nonzero(bends_rad > TURN_RAD))
    again = _again(path, swept, wanted.size, width)
    return Measures(
        covered=_share(np.count_nonzero(own), np.count_nonzero(wanted)),
        length_m=length_m,
        excess=_share(length_m * width * resolution_m, area_m2),
        swept_twice=_share(np.count_nonzero(again & own.reshape(-1)), np.count_nonzero(own)),
        turns=turns,
        turns_per_m2=_share(turns, area_m2),
        rotation_rad=float(bends_rad.sum()),
        clearance_m=least_clearance(space, path.point),
        room_changes=len(rooms_passed(path, labels, width)) - 1,
    )


def _share(part: float | np.integer, whole: float | np.integer) -> float:
    return float(part) / float(whole) if whole else 0.0


def _again(path: Path, swept: Swept, cells: int, width: float) -> Mask:
    """The cells (h w,) that are swept again after the path has gone on by more than the tool's width."""
    gone = np.concatenate([[0.0], np.cumsum(norms(np.diff(path.point, axis=0)))])
    order = np.lexsort((swept.segment, swept.cell))
    segment, cell = swept.segment[order], swept.cell[order]
    later = (cell[1:] == cell[:-1]) & (gone[segment[1:]] - gone[segment[:-1] + 1] > width)
    again = np.zeros(cells, np.bool_)
    again[cell[1:][later]] = True
    return again


def rooms_passed(path: Path, labels: Labels, least: float) -> list[int]:
    """The rooms that a path passes, in order, without stays shorter than `least` cells, and cells without a room.

    The path is looked at once a cell.
    """
    steps = np.maximum(np.ceil(norms(np.diff(path.point, axis=0))), 1).astype(np.intp)
    segment = np.repeat(np.arange(len(steps)), steps)
    share = (consecutive(np.zeros_like(steps), steps) + 0.5) / steps[segment]
    at = path.point[segment] + share[:, None] * (path.point[segment + 1] - path.point[segment])
    room = labels[tuple(np.rint(at).astype(np.intp).T)]
    for enough in (1, least):  # first without gaps, so that a stay is not cut in two by one
        first = np.flatnonzero(np.concatenate([[True], room[1:] != room[:-1]])[: len(room)])
        length = np.diff(np.append(first, len(room)))
        kept = (room[first] > 0) & (length >= enough)
        room = np.repeat(room[first][kept], length[kept])
    return [int(number) for number in room[np.concatenate([[True], room[1:] != room[:-1]])[: len(room)]]]
