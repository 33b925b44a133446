"""Spaces: free space that is wide enough for a robot, the gaps between spaces, and the obstacles that separate them.

No robot fits through a gap, so gaps count as closed. Pieces of obstacles with gaps between them are a wall if they
separate two spaces, and furniture if a way leads around them. Removing furniture and closing gaps therefore connects no
spaces that were separate.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vdoor.method.space_numbers import SpaceNumbers
from vdoor.raster.morphology import (
    covered,
    in_bands,
    labelled,
    opened,
    room_for,
    square,
    steps_to_middle,
    with_neighbours,
)
from vdoor.raster.runs import Runs, beside, parts_of_mask, runs_of

Ints = NDArray[np.int32]
Mask = NDArray[np.bool_]
Box = tuple[slice, ...]

BESIDE = 2
"""Margin, in cells beyond a gap's width, within which narrow places beside an obstacle count as part of it."""
AROUND_GAP = 2
"""Margin, in cells, within which the sides of a narrow place must be connected for it to be a nook, not a gap."""
SHORTEST_DASH = 2
"""Smallest length of a dash in cells; anything shorter is a speck."""


@dataclass(frozen=True, eq=False)
class Spaces:
    """Where a robot fits, and where it does not."""

    runs: Runs
    """The number of the space that each free cell belongs to; none in narrow places."""
    gap: Mask
    """Free cells (h, w) between two spaces, or between two sides of one: closed for the robot."""
    narrow: Mask
    """Free cells (h, w) that the robot cannot cover: gaps and nooks."""

    @classmethod
    def of(cls, free: Mask, wide: int) -> Spaces:
        """The spaces of a robot that does not fit through `wide` cells.

        The robot is round, so that the direction of walls does not matter. For walls along the grid a square robot is
        used to find further gaps, as it does not reach into their ends.
        """
        element = disc(wide + 1)
        room = room_for(free, element)
        numbers = SpaceNumbers.of(room, element)
        gap = numbers.gap()
        narrow = in_bands(lambda some: reached_from_two_sides(some, element), room, 2 * len(element))
        narrow |= ~numbers.mask
        narrow &= free
        gap |= between_sides(narrow, numbers)
        gap |= between_sides(free & ~opened(free, square(wide + 1)), numbers)
        runs = runs_of(numbers.mask & ~gap)
        narrow = free & ~numbers.mask
        narrow |= gap
        return cls(runs.labelled(numbers.at(runs.first)), gap, narrow)


def furniture(free: Mask, loose: Mask, *, gap: int, around: int, least: float) -> Mask:
    """The cells of `loose` (h, w) that may be removed: all but those of walls.

    Loose pieces with only narrow places between them, for a robot that does not fit through `gap` cells, form a group.
    A group is a wall if it separates two spaces: there is no way from one to the other or, beside one of its pieces,
    none within `around` cells. Spaces of fewer than `least` cells do not count.
    """
    spaces = Spaces.of(free, gap)
    pieces, narrow, group = (parts_of_mask(mask, 2) for mask in (loose, spaces.narrow, loose | spaces.narrow))
    large = np.append(False, spaces.runs.cells(spaces.runs.most) >= least)
    walls: set[int] = set()
    found: dict[int, set[int]] = {}
    # A piece without narrow places or other obstacles beside it is surrounded by one space, so it is no wall.
    unsure = np.flatnonzero(with_neighbours(spaces.narrow | ~(free | loose)) & loose)
    group_of, boxes = group.at(pieces.first_cells(pieces.most)), pieces.boxes(pieces.most)
    for number in np.unique(pieces.at(unsure)).tolist():
        own, box = int(group_of[number - 1]), as_box(boxes[number - 1])
        if own in walls:
            continue
        near = grown(box, max(around, gap + BESIDE), free.shape)
        obstacle = pieces.inside(near).image() == number
        close = narrow.inside(near).image() * inside(grown(box, gap + BESIDE, free.shape), near)
        at = with_neighbours(obstacle | np.isin(close, np.setdiff1d(close[with_neighbours(obstacle)], 0)))
        label = spaces.runs.inside(near).image()
        spaces_beside = found.setdefault(own, set())
        spaces_beside.update(space for space in np.setdiff1d(label[at], 0).tolist() if large[space])
        part = labelled(label > 0)
        sides = np.bincount(part.ravel())[np.setdiff1d(part[at], 0)]
        if len(spaces_beside) > 1 or (sides >= least).sum() > 1:
            walls.add(own)
    wall = np.zeros(group.most + 1, np.bool_)
    wall[list(walls)] = True
    return loose & ~group.chosen(wall).mask()


def in_line(free: Mask, *, wide: int, thick: int, least: int) -> Mask:
    """The free cells (h, w) in gaps at most `wide` cells wide between two dashes of a wall along the grid.

    Dashes are at most `thick` cells thick, and one of the two is at least `least` cells long.
    """
    reach = 2 * thick + 2 * least + 2 * wide
    return in_bands(lambda some: _in_line(some, wide=wide, thick=thick, least=least), free, reach)


def _in_line(free: Mask, *, wide: int, thick: int, least: int) -> Mask:
    found = np.zeros_like(free)
    for turn in (np.asarray, np.transpose):
        thin = ~free & ~opened(~free, turn(square(thick + 1)[:, :1]))
        dash, long = (opened(thin, turn(square(length)[:1])) for length in (SHORTEST_DASH, least))
        gap = free & ~opened(~dash, turn(square(wide + 1)[:1]))
        found |= gap & covered(long, turn(square(2 * wide + 1)[:1]))
    return found


def disc(side: int) -> Mask:
    """The cells of a square of `side` cells whose centres are within its inscribed circle."""
    away = np.arange(side) - (side - 1) / 2
    return np.asarray(np.hypot(away[:, None], away) <= side / 2)


def reached_from_two_sides(room: Mask, element: Mask) -> Mask:
    """The cells (h, w) covered by elements from both ends of a gap, and neighbours covered from different ends.

    A round robot at either end reaches into a gap that it does not fit through. The elements that cover such a cell
    have their centres in two separate ranges of directions; and no element covers both of two such neighbours.
    """
    down, right = len(element) - 1 - 2 * np.indices(element.shape)  # half cells from a cell to the element's centre
    aside = element & (np.hypot(down, right) > 2)  # noqa: PLR2004  # more than a cell from the centre
    reached = covered(room, element)
    cell = np.flatnonzero(reached & ~covered(room, element & ~aside))
    direction = np.rint(np.arctan2(down, right) / (np.pi / 4)).astype(int) % 8
    seen = np.zeros(len(cell), np.uint8)
    for step, way in zip(steps_to_middle(aside, room.shape[1]).tolist(), direction[aside], strict=True):
        centre = room.reshape(-1).take(cell + step, mode="clip").view(np.uint8)
        seen |= centre << np.uint8(way)
    found = np.zeros_like(room)
    found.reshape(-1)[cell[TWO_RANGES[seen]]] = True
    for first, second in ((np.s_[:-1], np.s_[1:]), (np.s_[:, :-1], np.s_[:, 1:])):
        pair = np.zeros_like(element)
        pair[first] = element[first] & element[second]
        meet = reached[first] & reached[second]
        meet &= ~covered(room, pair)[first]
        found[first] |= meet
        found[second] |= meet
    return found


def ranges_of(bits: int) -> int:
    """The number of ranges of set bits in a byte that is closed to a ring."""
    return sum(bits >> way & 1 and not bits >> (way - 1) % 8 & 1 for way in range(8))


TWO_RANGES = np.array([ranges_of(bits) > 1 for bits in range(256)])


def between_sides(narrow: Mask, numbers: SpaceNumbers) -> Mask:
    """The pieces (h, w) of narrow places between two spaces, or between two sides of one.

    Sides of a space are those that are not connected near the piece.
    """
    pieces = parts_of_mask(narrow, 2)
    space = numbers.mask & ~narrow
    ring = space & with_neighbours(narrow)
    cell = np.flatnonzero(ring)
    piece, at = beside(pieces, cell)
    of_spaces, of_sides = (
        counts(piece, own[at], pieces.most + 1) for own in (numbers.at(cell), parts_of_mask(ring).at(cell))
    )
    gap = of_spaces > 1
    unsure = (of_sides > 1) & ~gap
    boxes = pieces.chosen(unsure).boxes(pieces.most)
    for number in np.flatnonzero(unsure).tolist():
        near = grown(as_box(boxes[number - 1]), AROUND_GAP, narrow.shape)
        part = labelled(space[near])
        gap[number] = len(np.setdiff1d(part[with_neighbours(pieces.inside(near).image() == number)], 0)) > 1
    return pieces.chosen(gap).mask()


def counts(piece: Ints, other: Ints, count: int) -> NDArray[np.intp]:
    """The number (count,) of different values of `other` (k,) with each piece (k,)."""
    most = int(other.max(initial=0)) + 1
    return np.bincount(np.unique(piece.astype(np.int64) * most + other) // most, minlength=count)


def as_box(sides: NDArray[np.int64]) -> Box:
    """A bounding box (4,) as slices."""
    top, left, bottom, right = sides.tolist()
    return slice(top, bottom), slice(left, right)


def grown(box: Box, margin: int, shape: tuple[int, ...]) -> Box:
    """A box grown by a margin, clipped to the grid."""
    return tuple(
        slice(max(side.start - margin, 0), min(side.stop + margin, length))
        for side, length in zip(box, shape, strict=True)
    )


def inside(box: Box, near: Box) -> Mask:
    """Which cells of the window `near` are in a box within it."""
    found = np.zeros([side.stop - side.start for side in near], np.bool_)
    found[tuple(slice(b.start - n.start, b.stop - n.start) for b, n in zip(box, near, strict=True))] = True
    return found
