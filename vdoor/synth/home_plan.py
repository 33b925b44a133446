"""The plan of a home: rooms by recursive subdivision, some of them one, joined by doors and openings."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass

import numpy as np

from vdoor.synth.canvas import AXES, Axis, Rect, fine, square_to
from vdoor.synth.layout import Gap, Groups, Layout, SlantingGap, placed_door, walls_between
from vdoor.synth.settings import Dwelling, chance, log_uniform

MARGIN_M = 0.5
CORRIDOR_FROM_M2 = 45.0
CORNER_M, FLUSH_M = (0.05, 0.3), (0.0, 0.05)
OPENING_M = (1.2, 3.0)
OPENING_JAMB_M = 0.1
FORCED = -1.0
"""The rank of a link that comes before all others."""


@dataclass(frozen=True)
class Link:
    """A place in the list of rooms for each of two neighbours, and what may join them."""

    rooms: tuple[int, int]
    wall: Gap
    rank: float


def draw_home_plan(settings: Dwelling, rng: np.random.Generator) -> Layout:
    """Return a plan whose rooms are all joined."""
    area = log_uniform(settings.area_min_m2, settings.area_max_m2, rng)
    long_m = math.sqrt(area * rng.uniform(1.0, settings.aspect_max))
    sides = (long_m, area / long_m) if chance(0.5, rng) else (area / long_m, long_m)  # either way
    inside = Rect((MARGIN_M, MARGIN_M), (fine(MARGIN_M + sides[0]), fine(MARGIN_M + sides[1])))
    rooms, corridor = _rooms(inside, settings, rng)
    bays: list[Rect] = []
    slanting: list[Link] = []
    if chance(settings.jog_chance, rng):
        rooms, bays, slanting = _set_back(rooms, settings, rng)
    taken = {tuple(sorted(link.rooms)) for link in slanting}
    links = slanting + [link for link in _links(rooms, corridor, settings, rng) if link.rooms not in taken]
    kept = _without_outside(len(rooms), links, settings, rng)
    links = [link for link in links if kept.issuperset(link.rooms)]
    gaps, merged = _join(len(rooms), links, settings, rng)
    left_out = _left_out(gaps, merged, settings, rng)
    floors = [rooms[k] for k in sorted(kept - left_out)] + [link.wall.rect for link in merged] + bays
    size = inside.high[0] + MARGIN_M, inside.high[1] + MARGIN_M
    return Layout(tuple(floors), tuple(gap for _, gap in gaps), size)


def _rooms(inside: Rect, settings: Dwelling, rng: np.random.Generator) -> tuple[list[Rect], Rect | None]:
    """Return rooms, and which of them is the corridor."""
    largest = rng.uniform(settings.room_min_m2, settings.room_max_m2)
    parts, corridor = [inside], None
    if inside.area > CORRIDOR_FROM_M2 and chance(settings.corridor_chance, rng):
        parts, corridor = _around_corridor(inside, settings, rng)
    rooms = [room for part in parts for room in _divided(part, largest, settings, rng)]
    return rooms + ([corridor] if corridor else []), corridor


def _around_corridor(inside: Rect, settings: Dwelling, rng: np.random.Generator) -> tuple[list[Rect], Rect | None]:
    """Return what a corridor leaves, and the corridor: through all of the home, or ending before a part of it."""
    along: Axis = 0 if inside.sides[0] >= inside.sides[1] else 1
    across = square_to(along)
    through = chance(0.5, rng)  # as often as not
    pieces = [inside] if through else _halves(inside, along, rng.uniform(0.25, 0.75), settings, rng)
    main = max(pieces, key=lambda piece: piece.area)
    width = rng.uniform(settings.corridor_min_m, settings.corridor_max_m)
    walls = [_thickness(settings, rng) for _ in range(2)]
    low = fine(main.low[across] + rng.uniform(0.3, 0.7) * (main.sides[across] - width))
    high = fine(low + width)
    beside = [
        main.spanning(across, main.low[across], fine(low - walls[0])),
        main.spanning(across, fine(high + walls[1]), main.high[across]),
    ]
    if min(part.sides[across] for part in beside) < settings.room_side_min_m:
        return [inside], None
    return [piece for piece in pieces if piece is not main] + beside, main.spanning(across, low, high)


def _thickness(settings: Dwelling, rng: np.random.Generator) -> float:
    return fine(rng.uniform(settings.wall_min_m, settings.wall_max_m))


def _divided(part: Rect, largest_m2: float, settings: Dwelling, rng: np.random.Generator) -> list[Rect]:
    """Return a part of the home as rooms."""
    if part.area <= largest_m2 * rng.uniform(0.5, 1.0):
        return [part]
    axis: Axis = 0 if part.sides[0] > part.sides[1] * rng.uniform(0.75, 1.33) else 1
    for cut in (axis, square_to(axis)):
        halves = _halves(part, cut, rng.uniform(0.3, 0.7), settings, rng)
        if len(halves) > 1:
            return [room for half in halves for room in _divided(half, largest_m2, settings, rng)]
    return [part]


def _halves(part: Rect, axis: Axis, share: float, settings: Dwelling, rng: np.random.Generator) -> list[Rect]:
    """Return two pieces of a part with a wall between, or the whole if a piece would be too small."""
    wall = _thickness(settings, rng)
    low, high = part.low[axis], part.high[axis]
    at = fine(low + share * (high - low - wall))
    if min(at - low, high - at - wall) < settings.room_side_min_m:
        return [part]
    return [part.spanning(axis, low, at), part.spanning(axis, fine(at + wall), high)]


def _links(rooms: list[Rect], corridor: Rect | None, settings: Dwelling, rng: np.random.Generator) -> list[Link]:
    """Return all walls between neighbours, those of the corridor ranked first."""
    needs = settings.door_max_m + 2 * CORNER_M[0]
    return [
        Link((a, b), wall, rng.random() + (0.0 if corridor in (rooms[a], rooms[b]) else 1.0))
        for a, b in itertools.combinations(range(len(rooms)), 2)
        for wall in walls_between(rooms[a], rooms[b], settings.wall_max_m, needs)
    ]


def _set_back(
    rooms: list[Rect], settings: Dwelling, rng: np.random.Generator
) -> tuple[list[Rect], list[Rect], list[Link]]:
    """Return rooms of which one is set back from its neighbour, the bay this leaves, and the slanting door beside it.

    The door runs from the wall's end across the corner, between the neighbour with its bay and a third room.
    """
    triples = [
        (a, b, c, axis)
        for a, b, c in itertools.permutations(range(len(rooms)), 3)
        for axis in AXES
        if _meet(rooms[a], rooms[b], rooms[c], axis, settings)
    ]
    if not triples:
        return rooms, [], []
    a, b, c, axis = triples[rng.integers(len(triples))]
    smaller, bay, door = _around_corner(rooms[a], rooms[b], rooms[c], axis, rng)
    return [smaller if k == c else room for k, room in enumerate(rooms)], [bay], [Link((a, b), door, FORCED)]


def _around_corner(
    main: Rect, beside: Rect, back: Rect, axis: Axis, rng: np.random.Generator
) -> tuple[Rect, Rect, SlantingGap]:
    """Return the room `back` set back from `main`, the bay before it, and the slanting door from there to `beside`."""
    along = square_to(axis)
    out = 1 if back.low[axis] > main.low[axis] else -1
    up = 1 if beside.low[along] > back.low[along] else -1
    face = (main.high if out > 0 else main.low)[axis]
    end = (back.high if up > 0 else back.low)[along]
    wall = abs((back.low if out > 0 else back.high)[axis] - face)
    between = abs((beside.low if up > 0 else beside.high)[along] - end)
    depth, height = fine(rng.uniform(0.45, 0.8)), fine(rng.uniform(0.45, 0.8))

    def point(away: float, beyond: float) -> tuple[float, float]:
        at = (face + out * away, end + up * beyond)
        return at if axis == 0 else (at[1], at[0])

    length = back.sides[along]
    smaller = Rect.between(point(depth + wall, 0.0), point(wall + back.sides[axis], -length))
    bay = Rect.between(point(0.0, 0.0), point(depth, -length))
    opened = Rect.between(point(0.0, 0.0), point(depth, between + height))
    line = point(wall / 2, between + height), point(depth, between / 2)
    return smaller, bay, SlantingGap(opened, axis, leaf=False, line=line)


def _meet(main: Rect, beside: Rect, back: Rect, axis: Axis, settings: Dwelling) -> bool:
    """Whether `beside` and `back` lie side by side along one wall of `main`, with room for a slanting door between."""
    along = square_to(axis)
    walls = [list(walls_between(main, other, settings.wall_max_m, 1.2)) for other in (beside, back)]
    if not all(len(found) == 1 and found[0].axis == axis for found in walls):
        return False
    same_face = beside.low[axis] == back.low[axis] or beside.high[axis] == back.high[axis]
    return (
        same_face
        and any(wall.axis == along for wall in walls_between(beside, back, settings.wall_max_m, 1.2))
        and main.low[along] <= back.low[along]
        and back.high[along] <= main.high[along]
        and back.sides[axis] >= 0.8 + settings.wall_max_m + settings.room_side_min_m
    )


def _without_outside(count: int, links: list[Link], settings: Dwelling, rng: np.random.Generator) -> set[int]:
    """Return which rooms belong to the home: those left are joined, and never less than two thirds."""
    kept = set(range(count))
    bound = {room for link in links if link.rank == FORCED for room in link.rooms}
    for room in rng.permutation(count).tolist():
        rest = kept - {room}
        pairs = [link.rooms for link in links if rest.issuperset(link.rooms)]
        if chance(settings.outside_chance, rng) and room not in bound and len(rest) >= 2 * count / 3:
            kept = rest if Groups(count, pairs).all_joined(rest) else kept
    return kept


def _join(
    count: int, links: list[Link], settings: Dwelling, rng: np.random.Generator
) -> tuple[list[tuple[tuple[int, int], Gap]], list[Link]]:
    """Return the doors and openings of a random spanning tree and a few more, and the links with no wall at all."""
    open_chance = rng.uniform(settings.open_chance_min, settings.open_chance_max)
    merge_chance = rng.uniform(0.0, settings.merge_chance_max)
    groups = Groups(count)
    gaps: list[tuple[tuple[int, int], Gap]] = []
    merged: list[Link] = []
    for link in sorted(links, key=lambda link: link.rank):
        apart = groups.apart(*link.rooms)
        if not apart and rng.random() >= settings.extra_door_chance:
            continue
        if apart and chance(merge_chance, rng) and link.rank > 0:
            merged.append(link)
        else:
            gaps.append((link.rooms, _gap(link, open_chance, settings, rng)))
        groups.join(*link.rooms)
    return gaps, merged


def _gap(link: Link, open_chance: float, settings: Dwelling, rng: np.random.Generator) -> Gap:
    """Return a door somewhere in a wall, or a wider opening if there is room for one."""
    if isinstance(link.wall, SlantingGap):
        return link.wall
    length = link.wall.rect.sides[link.wall.along]
    widest = min(OPENING_M[1], length - 2 * OPENING_JAMB_M)
    if widest > OPENING_M[0] and chance(open_chance, rng):
        width = fine(rng.uniform(OPENING_M[0], widest))
        low = OPENING_JAMB_M + rng.uniform(0.0, 1.0) * (length - width - 2 * OPENING_JAMB_M)
        unsure = width >= settings.unsure_from_m
        return link.wall.in_wall(fine(link.wall.rect.low[link.wall.along] + low), width, leaf=False, unsure=unsure)
    width = rng.uniform(settings.door_min_m, settings.door_max_m)
    jamb_m = FLUSH_M if chance(settings.flush_chance, rng) else CORNER_M
    return placed_door(link.wall, width, rng, jamb_m=jamb_m, corner=settings.door_corner_chance)


def _left_out(
    gaps: list[tuple[tuple[int, int], Gap]], merged: list[Link], settings: Dwelling, rng: np.random.Generator
) -> set[int]:
    """Return a room with a single door that was not visited, in some homes."""
    uses = [room for rooms, _ in gaps for room in rooms] + [room for link in merged for room in link.rooms * 2]
    leaves = sorted(room for rooms, gap in gaps for room in rooms if uses.count(room) == 1 and gap.leaf)
    if len(leaves) > 1 and chance(settings.left_out_chance, rng):
        return {leaves[rng.integers(len(leaves))]}
    return set()
