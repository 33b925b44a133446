"""Spaces: free space that is wide enough for a robot, the gaps between spaces, and the obstacles that separate them.

No robot fits through a gap, so gaps count as closed. Pieces of obstacles with gaps between them are a wall if they
separate two spaces, and furniture if a way leads around them. Removing furniture and closing gaps therefore connects no
spaces that were separate.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vdoor.raster.morphology import components_of, counted, covered, greatest, labelled, opened, room_for, square

Ints = NDArray[np.int32]
Mask = NDArray[np.bool_]
Box = tuple[slice, ...]

AROUND = tuple((down, right) for down in range(3) for right in range(3) if (down, right) != (1, 1))
BESIDE = 2
"""Margin, in cells beyond a gap's width, within which narrow places beside an obstacle count as part of it."""
AROUND_GAP = 2
"""Margin, in cells, within which the sides of a narrow place must be connected for it to be a nook, not a gap."""
SHORTEST_DASH = 2
"""Smallest length of a dash in cells; anything shorter is a speck."""


@dataclass(frozen=True, eq=False)
class Spaces:
    """Where a robot fits, and where it does not; all (h, w)."""

    label: Ints
    """Number of the space that each free cell belongs to; 0 in narrow places."""
    gap: Mask
    """Free cells between two spaces, or between two sides of one: closed for the robot."""
    narrow: Mask
    """Free cells that the robot cannot cover: gaps and nooks."""

    @classmethod
    def of(cls, free: Mask, wide: int) -> Spaces:
        """The spaces of a robot that does not fit through `wide` cells.

        The robot is round, so that the direction of walls does not matter. For walls along the grid a square robot is
        used to find further gaps, as it does not reach into their ends.
        """
        element = disc(wide + 1)
        room = room_for(free, element)
        centre, count = counted(room)
        label = greatest(centre, element, count)
        lowest = count + 1 - greatest((count + 1 - centre) * room, element, count)
        gap = (label > 0) & (label != lowest)  # covered by robots in two spaces
        label[gap] = 0
        gap |= beside_other(label)
        narrow = free & ((label == 0) | reached_from_two_sides(room, element))
        gap |= between_sides(narrow, label)
        gap |= between_sides(free & ~opened(free, square(wide + 1)), label)
        narrow = free & (label == 0)
        label[gap] = 0
        return cls(label, gap, narrow | gap)


def furniture(free: Mask, loose: Mask, *, gap: int, around: int, least: float) -> Mask:
    """The cells of `loose` (h, w) that may be removed: all but those of walls.

    Loose pieces with only narrow places between them, for a robot that does not fit through `gap` cells, form a group.
    A group is a wall if it separates two spaces: there is no way from one to the other or, beside one of its pieces,
    none within `around` cells. Spaces of fewer than `least` cells do not count.
    """
    spaces = Spaces.of(free, gap)
    pieces = components_of(loose, 2)
    piece, narrow, group = pieces.label, labelled(spaces.narrow, 2), labelled(loose | spaces.narrow, 2)
    large = np.bincount(spaces.label.ravel()) >= least
    walls: set[int] = set()
    beside: dict[int, set[int]] = {}
    # A piece without narrow places or other obstacles beside it is surrounded by one space, so it is no wall.
    for number in np.unique(piece[with_neighbours(spaces.narrow | ~(free | loose)) & loose]).tolist():
        box = pieces.box(number)
        near = grown(box, max(around, gap + BESIDE), free.shape)
        obstacle = piece[near] == number
        own = int(group[near][obstacle][0])
        if own in walls:
            continue
        close = narrow[near] * inside(grown(box, gap + BESIDE, free.shape), near)
        at = with_neighbours(obstacle | np.isin(close, np.setdiff1d(close[with_neighbours(obstacle)], 0)))
        label = spaces.label[near]
        found = beside.setdefault(own, set())
        found.update(space for space in np.setdiff1d(label[at], 0).tolist() if large[space])
        part = labelled(label > 0)
        sides = np.bincount(part.ravel())[np.setdiff1d(part[at], 0)]
        if len(found) > 1 or (sides >= least).sum() > 1:
            walls.add(own)
    wall = np.zeros(int(group.max(initial=0)) + 1, np.bool_)
    wall[list(walls)] = True
    goes = loose.copy()
    goes[loose] = ~wall[group[loose]]
    return goes


def in_line(free: Mask, *, wide: int, thick: int, least: int) -> Mask:
    """The free cells (h, w) in gaps at most `wide` cells wide between two dashes of a wall along the grid.

    Dashes are at most `thick` cells thick, and one of the two is at least `least` cells long.
    """
    found = []
    for turned in (free, np.ascontiguousarray(free.T)):
        thin = ~turned & ~opened(~turned, square(thick + 1)[:, :1])
        dash, long = (opened(thin, square(length)[:1]) for length in (SHORTEST_DASH, least))
        gap = turned & ~opened(~dash, square(wide + 1)[:1])
        found.append(gap & beside_in_row(long, wide))
    return np.asarray(found[0] | found[1].T)


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
    direction = np.rint(np.arctan2(down, right) / (np.pi / 4)).astype(int) % 8
    aside = element & (np.hypot(down, right) > 2)  # noqa: PLR2004  # more than a cell from the centre
    found = starts_twice([covered(room, aside & (direction == way)) for way in range(8)])
    found &= ~covered(room, element & ~aside)
    reached = covered(room, element)
    for first, second in ((np.s_[:-1], np.s_[1:]), (np.s_[:, :-1], np.s_[:, 1:])):
        pair = np.zeros_like(element)
        pair[first] = element[first] & element[second]
        meet = (reached[first] & reached[second]) & ~covered(room, pair)[first]
        found[first] |= meet
        found[second] |= meet
    return np.asarray(found)


def starts_twice(seen: list[Mask]) -> Mask:
    """Where two or more ranges of set masks begin, in a list that is closed to a ring."""
    once, twice = np.zeros_like(seen[0]), np.zeros_like(seen[0])
    for number, mask in enumerate(seen):
        begins = mask & ~seen[number - 1]
        twice |= once & begins
        once |= begins
    return twice


def beside_other(label: Ints) -> Mask:
    """The labelled cells with a 4-neighbour of another label."""
    found = np.zeros(label.shape, np.bool_)
    for one, other in ((np.s_[1:], np.s_[:-1]), (np.s_[:, 1:], np.s_[:, :-1])):
        differs = (label[one] != label[other]) & (label[one] > 0) & (label[other] > 0)
        found[one] |= differs
        found[other] |= differs
    return found


def between_sides(narrow: Mask, label: Ints) -> Mask:
    """The pieces (h, w) of narrow places between two spaces, or between two sides of one.

    Sides of a space are those that are not connected near the piece.
    """
    pieces = components_of(narrow, 2)
    piece, count = pieces.label, pieces.count + 1
    space = label * ~narrow
    side = labelled((space > 0) & with_neighbours(narrow))
    of_spaces, of_sides = (np.bincount(pairs_beside(piece, other)[:, 0], minlength=count) for other in (space, side))
    gap = of_spaces > 1
    for number in np.flatnonzero((of_sides > 1) & ~gap).tolist():
        near = grown(pieces.box(number), AROUND_GAP, narrow.shape)
        part = labelled(space[near] > 0)
        gap[number] = len(np.setdiff1d(part[with_neighbours(piece[near] == number)], 0)) > 1
    found = np.zeros_like(narrow)
    found[narrow] = gap[piece[narrow]]
    return found


def with_neighbours(mask: Mask) -> Mask:
    """The cells of a mask (h, w) and their eight neighbours."""
    tall = mask.copy()
    tall[1:] |= mask[:-1]
    tall[:-1] |= mask[1:]
    found = tall.copy()
    found[:, 1:] |= tall[:, :-1]
    found[:, :-1] |= tall[:, 1:]
    return found


def beside_in_row(mask: Mask, reach: int) -> Mask:
    """The cells of a mask (h, w), and those at most `reach` cells to the left or right of them."""
    padded = np.pad(mask, ((0, 0), (reach, reach)))
    return np.asarray(
        np.logical_or.reduce([padded[:, begin : begin + mask.shape[1]] for begin in range(2 * reach + 1)])
    )


def pairs_beside(one: Ints, other: Ints) -> Ints:
    """The pairs (k, 2) of labels in two images (h, w) that are 8-neighbours, sorted."""
    row, col = np.nonzero(one)
    padded = np.pad(other, 1)
    near = np.stack([padded[row + down, col + right] for down, right in AROUND])
    own = np.broadcast_to(one[row, col], near.shape)[near > 0]
    count = int(other.max(initial=0)) + 1
    key = np.unique(own.astype(np.int64) * count + near[near > 0])
    return np.stack([key // count, key % count], axis=1).astype(np.int32)


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
