"""A plan of any shape: floors, solids and gaps in walls. What its floors connect is a room; gaps part rooms."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from vdoor.synth.canvas import FINE_M, Axis, Canvas, Rect, Shape, fine, square_to

HAIR_M = 1e-6


@dataclass(frozen=True)
class Gap:
    """A door or an opening through a wall."""

    rect: Rect
    axis: Axis
    """Along which one walks through it."""
    leaf: bool = True
    """It is a door, not an opening that nothing could close."""
    unsure: bool = False

    @property
    def along(self) -> Axis:
        """The axis on which the wall runs."""
        return square_to(self.axis)

    @property
    def ends(self) -> NDArray[np.float64]:
        """Where it meets the jambs (2, 2), in the middle of the wall; the upper side lies to the left of this line."""
        points = np.array([self.rect.middle, self.rect.middle])
        points[:, self.along] = self.rect.low[self.along], self.rect.high[self.along]
        return points[::-1] if self.axis == 0 else points  # walking along x, the upper side is on the right

    @property
    def width_m(self) -> float:
        """From jamb to jamb."""
        return float(np.hypot(*(self.ends[1] - self.ends[0])))

    def before(self, sign: int, away_m: float) -> tuple[float, float]:
        """Return the point `away_m` before its middle, on the lower side for -1, on the upper one for 1."""
        point = list(self.rect.middle)
        point[self.axis] = (self.rect.high if sign > 0 else self.rect.low)[self.axis] + sign * away_m
        return point[0], point[1]

    def clear(self, depth_m: float, beside_m: float = 0.0) -> Rect:
        """Return the gap with the space `depth_m` before both sides of it, and `beside_m` more of the wall."""
        return self.rect.grown(*((depth_m, beside_m) if self.axis == 0 else (beside_m, depth_m)))

    def in_wall(self, low_m: float, width_m: float, *, leaf: bool = True, unsure: bool = False) -> Gap:
        """Return a gap in the wall that this one takes all of."""
        return Gap(self.rect.spanning(self.along, low_m, fine(low_m + width_m)), self.axis, leaf=leaf, unsure=unsure)


@dataclass(frozen=True)
class SlantingGap(Gap):
    """A door between the ends of two walls that do not lie in line; `rect` is what it opens."""

    line: tuple[tuple[float, float], tuple[float, float]] = ((0.0, 0.0), (0.0, 0.0))

    @property
    def ends(self) -> NDArray[np.float64]:
        """See `Gap.ends`."""
        return np.array(self.line)

    def before(self, sign: int, away_m: float) -> tuple[float, float]:
        """Return a point before its middle, well out of `rect` on either side."""
        start, end = self.ends
        x, y = (end - start) / self.width_m * (away_m + 0.45)
        middle = (start + end) / 2
        return float(middle[0] - sign * y), float(middle[1] + sign * x)


@dataclass(frozen=True)
class Layout:
    """Floors are open, solids stand on them; all in metres, x right, y up, from (0, 0) to `size_m`."""

    floors: tuple[Rect, ...]
    gaps: tuple[Gap, ...]
    size_m: tuple[float, float]
    solids: tuple[Rect, ...] = ()
    pits: tuple[Rect, ...] = ()
    """Floors that solids are opened for again: rooms within rooms."""


@dataclass(frozen=True)
class Opened:
    """A gap between two rooms, and their numbers on the canvas: the lower side first."""

    gap: Gap
    rooms: tuple[int, int]


@dataclass(frozen=True)
class Drawn:
    """A layout on its canvas: gaps that part two rooms, and those that stay shut since behind them there is none."""

    canvas: Canvas
    opened: tuple[Opened, ...]
    shut: tuple[Gap, ...]


def drawn(layout: Layout) -> Drawn:
    """Return the layout with its rooms numbered from 1, and those gaps opened that part two of them."""
    canvas = Canvas.blank(layout.size_m)
    for pieces, room in ((layout.floors, 1), (layout.solids, 0), (layout.pits, 1)):
        for rect in pieces:
            canvas.paint(rect, room)
    canvas.rooms[:], _ = ndimage.label(canvas.rooms)
    # All sides are read before any gap is opened: a gap may end in the jamb of another one.
    sides = [(canvas.at(gap.before(-1, FINE_M / 2)), canvas.at(gap.before(1, FINE_M / 2))) for gap in layout.gaps]
    opened, shut = [], []
    for gap, (a, b) in zip(layout.gaps, sides, strict=True):
        if a and b and a != b:
            canvas.open(gap.rect, gap.ends, (b, a))
            opened.append(Opened(gap, (a, b)))
        elif bool(a) != bool(b):
            shut.append(gap)
    return Drawn(canvas, tuple(opened), tuple(shut))


def walls_between(a: Rect, b: Rect, thickest_m: float, needs_m: float) -> Iterator[Gap]:
    """Yield the wall between two floors as one wide gap, if they are neighbours along at least `needs_m`."""
    for axis, along in ((0, 1), (1, 0)):
        low, high = max(a.low[along], b.low[along]), min(a.high[along], b.high[along])
        if high - low < needs_m - HAIR_M:
            continue
        for lower, upper in ((a, b), (b, a)):
            faces = lower.high[axis], upper.low[axis]
            if HAIR_M < faces[1] - faces[0] <= thickest_m + HAIR_M:
                yield Gap(lower.spanning(axis, *faces).spanning(along, low, high), axis)  # type: ignore[arg-type]  # 0, 1


def placed_door(
    wall: Gap, width_m: float, rng: np.random.Generator, *, jamb_m: tuple[float, float], corner: float
) -> Gap:
    """Return a door in a wall: with chance `corner` within `jamb_m` (least, most) of one of its ends."""
    slack = wall.rect.sides[wall.along] - 2 * jamb_m[0] - width_m
    offset = rng.uniform(0.0, max(slack, 0.0))
    if rng.random() < corner:
        offset = min(rng.uniform(0.0, jamb_m[1] - jamb_m[0]), max(slack, 0.0))
        offset = offset if rng.random() < 0.5 else max(slack, 0.0) - offset  # noqa: PLR2004  # either end
    return wall.in_wall(fine(wall.rect.low[wall.along] + jamb_m[0] + offset), fine(width_m))


def connected(count: int, pairs: Sequence[tuple[int, int]]) -> list[int]:
    """Return the group of each of `count` things that the pairs join, groups named by one of their members."""
    group = list(range(count))
    for a, b in pairs:
        old, new = group[a], group[b]
        if old != new:
            group = [new if g == old else g for g in group]
    return group


def keep_passable(plan: Drawn, things: Sequence[tuple[Rect, Shape]]) -> None:
    """Block the canvas with things (each with the floor it stands on), but no floor's where that cuts a door off."""
    canvas, opened = plan.canvas, plan.opened
    bare = canvas.rooms.copy()
    banned: set[Rect] = set()
    for _ in range(4):
        canvas.rooms[:] = bare
        for floor, shape in things:
            if floor not in banned:
                canvas.block(shape)
        part, _ = ndimage.label(canvas.rooms[::2, ::2])
        small = Canvas(part.astype(np.int32))
        met = [_parts_before(small, door.gap) for door in opened]
        counts = np.bincount([part for parts in met for part in parts], minlength=2)
        counts[0] = 0
        main = int(counts.argmax())
        cut = [door.gap for door, parts in zip(opened, met, strict=True) if parts != (main, main)]
        more = {floor for floor, _ in things if any(floor.overlaps(gap.clear(0.3)) for gap in cut)} - banned
        if not more:
            return
        banned |= more


def _parts_before(half: Canvas, gap: Gap) -> tuple[int, int]:
    """Return what is 20 cm before both sides of a gap, on a canvas of half the resolution."""
    below, above = (tuple(x / 2 for x in gap.before(sign, 0.2)) for sign in (-1, 1))
    return half.at((below[0], below[1])), half.at((above[0], above[1]))
