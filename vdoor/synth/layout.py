"""Plans of any shape: floors, solids, and gaps in walls. Floors that touch are one room; gaps part rooms.

Also the walls between floors, and doors in them.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import NDArray

from vdoor.synth.canvas import AXES, FINE_M, HAIR_M, Axis, Canvas, Placed, Rect, fine, square_to
from vdoor.synth.settings import Dwelling, Office, chance


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
    """A gap between two rooms, and their numbers on the canvas: that on the lower side first."""

    gap: Gap
    rooms: tuple[int, int]


@dataclass(frozen=True)
class Drawn:
    """A layout on its canvas: gaps that part two rooms, and those that stay shut since behind them there is none."""

    layout: Layout
    floor: Canvas
    """With nothing on its floors; 0 is wall."""
    canvas: Canvas
    """With all that stands on them."""
    opened: tuple[Opened, ...]
    shut: tuple[Gap, ...]


def drawn(layout: Layout) -> Drawn:
    """Return the layout with its rooms numbered from 1, and those gaps opened that part two of them."""
    floor = Canvas.blank(layout.size_m)
    for pieces, room in ((layout.floors, 1), (layout.solids, 0), (layout.pits, 1)):
        for rect in pieces:
            floor.paint(rect, room)
    floor.rooms[:], _ = scipy.ndimage.label(floor.rooms)
    # All sides are read before any gap is opened: a gap may end in the jamb of another one.
    sides = [(floor.at(gap.before(-1, FINE_M / 2)), floor.at(gap.before(1, FINE_M / 2))) for gap in layout.gaps]
    opened, shut = [], []
    for gap, (a, b) in zip(layout.gaps, sides, strict=True):
        if a and b and a != b:
            floor.open(gap.rect, gap.ends, (b, a))
            opened.append(Opened(gap, (a, b)))
        elif bool(a) != bool(b):
            shut.append(gap)
    return Drawn(layout, floor, Canvas(floor.rooms.copy()), tuple(opened), tuple(shut))


def laid_on_map(canvas: Canvas, settings: Dwelling | Office, margin_m: float, rng: np.random.Generator) -> Placed:
    """Return a canvas on the map's cells: straight, or turned by up to 6 degrees, two in five of those up to 45."""
    most = 45.0 if chance(0.4, rng) else 6.0
    turned = rng.uniform(-most, most) if chance(settings.rotated_chance, rng) else 0.0
    return canvas.placed(math.radians(turned), settings.cell_m, margin_m, (rng.random(), rng.random()))


def walls_between(a: Rect, b: Rect, thickest_m: float, needs_m: float) -> Iterator[Gap]:
    """Yield the wall between two floors as one wide gap, if they are neighbours along at least `needs_m`."""
    for axis in AXES:
        along = square_to(axis)
        low, high = max(a.low[along], b.low[along]), min(a.high[along], b.high[along])
        if high - low < needs_m - HAIR_M:
            continue
        for lower, upper in ((a, b), (b, a)):
            sides = lower.high[axis], upper.low[axis]
            if HAIR_M < sides[1] - sides[0] <= thickest_m + HAIR_M:
                yield Gap(lower.spanning(axis, *sides).spanning(along, low, high), axis)


def placed_door(
    wall: Gap,
    width_m: float,
    rng: np.random.Generator,
    *,
    jamb_m: tuple[float, float],
    corner: float,
    snapped: Callable[[float], float] = fine,
) -> Gap:
    """Return a door in a wall: with chance `corner` within `jamb_m` (least, most) of one of its ends.

    `snapped` moves lengths onto a raster.
    """
    slack = max(wall.rect.sides[wall.along] - 2 * jamb_m[0] - width_m, 0.0)
    offset = rng.uniform(0.0, slack)
    if chance(corner, rng):
        offset = min(rng.uniform(0.0, jamb_m[1] - jamb_m[0]), slack)
        offset = offset if chance(0.5, rng) else slack - offset  # either end
    low = snapped(wall.rect.low[wall.along] + jamb_m[0] + offset)
    return Gap(wall.rect.spanning(wall.along, low, snapped(low + snapped(width_m))), wall.axis)


class Groups:
    """Which of `count` rooms the doors join so far."""

    def __init__(self, count: int, pairs: Iterable[tuple[int, int]] = ()) -> None:
        self._group = list(range(count))
        for a, b in pairs:
            self.join(a, b)

    def apart(self, a: int, b: int) -> bool:
        """Whether no doors lead from one of two rooms to the other."""
        return self._group[a] != self._group[b]

    def join(self, a: int, b: int) -> None:
        """Put a door between two rooms."""
        old, new = self._group[a], self._group[b]
        self._group = [new if group == old else group for group in self._group]

    def all_joined(self, rooms: Iterable[int]) -> bool:
        """Whether doors lead from each of some rooms to all others."""
        return len({self._group[room] for room in rooms}) <= 1


@dataclass(frozen=True)
class Face:
    """One of the four walls around a floor, from inside: at `at_m` on `axis`, the wall is on the side of `sign`."""

    room: int
    floor: Rect
    axis: Axis
    sign: int

    @property
    def along(self) -> Axis:
        """The axis on which the wall runs."""
        return square_to(self.axis)

    @property
    def at_m(self) -> float:
        """Where the face is on `axis`."""
        return (self.floor.low, self.floor.high)[self.sign > 0][self.axis]

    def strip(self, start_m: float, length_m: float, depth_m: float) -> Rect:
        """Return part of the wall behind the face, or of the floor before it if the depth is negative."""
        ends = sorted((self.at_m, self.at_m + self.sign * depth_m))
        return self.floor.spanning(self.axis, *ends).spanning(self.along, start_m, start_m + length_m)


def faces(room: int, floor: Rect) -> list[Face]:
    """All four faces of a room's floor."""
    return [Face(room, floor, axis, sign) for axis in AXES for sign in (-1, 1)]
