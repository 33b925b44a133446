"""How good a path is: what it sweeps, how long and how winding it is, and how near it comes to anything."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vdoor.frame import Frame
from vdoor.navigate.coverage.path import Path, norms
from vdoor.navigate.coverage.sweep import Tool, consecutive

Mask = NDArray[np.bool_]
Ints = NDArray[np.intp]
Labels = NDArray[np.int32]
Floats = NDArray[np.float64]

TURN_RAD = np.radians(10.0)
"""A smaller change of heading is driven without slowing down and is no turn."""
NEAR = 2.0
"""Cells up to so much farther away than the clearance are looked at for the least one, in cells."""


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
    time_s: float
    """At a constant speed, with a stop at each turn."""
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


def measured(
    path: Path, tool: Tool, wanted: Mask, labels: Labels, frame: Frame, *, radius_m: float, motion: Motion
) -> Measures:
    """The figures of a path for a robot of that radius; `wanted` are the cells to be swept, `labels` their rooms."""
    swept = tool.swept(path.point[:-1], path.point[1:])
    times = np.bincount(swept.cell, minlength=wanted.size)
    own = wanted & (times.reshape(wanted.shape) > 0)
    area_m2 = np.count_nonzero(own) * frame.resolution_m**2
    length_m = path.length * frame.resolution_m
    bends_rad = path.bends_rad()
    turns = int(np.count_nonzero(bends_rad > TURN_RAD))
    times_s = motion.times_s(path, frame.resolution_m)
    return Measures(
        covered=_share(np.count_nonzero(own), np.count_nonzero(wanted)),
        length_m=length_m,
        excess=_share(length_m * 2 * tool.reach * frame.resolution_m, area_m2),
        swept_twice=_share(np.count_nonzero(_again(path, tool) & own.reshape(-1)), np.count_nonzero(own)),
        turns=turns,
        turns_per_m2=_share(turns, area_m2),
        rotation_rad=float(bends_rad.sum()),
        time_s=float(times_s[-1]),
        clearance_m=clearance(path.point, tool.blocked, radius_m / frame.resolution_m) * frame.resolution_m,
        room_changes=len(rooms_passed(path, labels, 2 * tool.reach)) - 1,
    )


def _share(part: float | np.integer, whole: float | np.integer) -> float:
    return float(part) / float(whole) if whole else 0.0


def _again(path: Path, tool: Tool) -> Mask:
    """The cells (h w,) that are swept again after the path has gone on by more than the tool's width."""
    segment, cell = tool.swept(path.point[:-1], path.point[1:])
    gone = np.concatenate([[0.0], np.cumsum(norms(np.diff(path.point, axis=0)))])
    order = np.lexsort((segment, cell))
    segment, cell = segment[order], cell[order]
    later = (cell[1:] == cell[:-1]) & (gone[segment[1:]] - gone[segment[:-1] + 1] > 2 * tool.reach)
    again = np.zeros(tool.blocked.size, np.bool_)
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


def clearance(point: Floats, blocked: Mask, expected: float) -> float:
    """Least distance in cells from a polyline (k, 2) to a blocked cell, taken as a square; all outside is blocked.

    Infinite if nothing is within `expected` and two cells.
    """
    pad = int(np.ceil(expected + NEAR)) + 1
    padded = np.pad(blocked, pad, constant_values=True)
    start, end = point[:-1] + pad, point[1:] + pad
    near = Tool(expected + NEAR, ~padded, hidden=False).swept(start, end)
    square = np.stack(np.divmod(near.cell, padded.shape[1]), axis=1).astype(np.float64)
    a, b = start[near.segment], end[near.segment]
    apart = [_to_square(a, square), _to_square(b, square)]
    apart += [_to_segment(square + corner, a, b) for corner in ((-0.5, -0.5), (-0.5, 0.5), (0.5, -0.5), (0.5, 0.5))]
    return float(np.min(apart)) if len(near.cell) else np.inf


def _to_square(point: Floats, square: Floats) -> Floats:
    return norms(np.maximum(np.abs(point - square) - 0.5, 0))


def _to_segment(point: Floats, start: Floats, end: Floats) -> Floats:
    along = end - start
    share = ((point - start) * along).sum(axis=1) / np.maximum((along**2).sum(axis=1), 1e-12)
    return norms(point - start - np.clip(share, 0, 1)[:, None] * along)
