"""Walls as drawings and sparse scans show them: outlines with nothing inside, pieces with gaps, grey edges."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import NDArray

from vdoor.grid import FREE, OCCUPIED, UNKNOWN
from vdoor.synth.canvas import FINE_M, Canvas, Cells, Placed, Rect, Rooms
from vdoor.synth.layout import Drawn, Face, faces
from vdoor.synth.scan import EIGHT, Mask
from vdoor.synth.settings import chance
from vdoor.synth.wall_style import PIECE_M, THIN_M, Gaps, Grey, Hollow, Style

CORNER_M = 0.2
"""Left whole where walls end or turn, so that two gaps never make one about a corner."""
JAMB_M = 0.15
"""Left whole beside doors, so that they stay as wide as they are."""
DEEPEST_M = 0.6
"""No wall between two rooms is thicker."""
FACE_M = 0.3
"""Scans show no more of a wall's face than this."""
SHUT, UNKNOWN_FACE, FREE_FACE, THROUGH = range(4)
"""No gap; one in a face only, which shows unknown or free cells; one through which the other side is seen."""
AROUND_ROOM_M = 0.3
"""How much of the walls around a room counts as its own."""
HAIR = 1e-6
HIDDEN_M = 0.7
"""Outlines of hollow walls are drawn behind what stands against them, up to this far."""


@dataclass(frozen=True, eq=False)
class Walls:
    """How a map's walls are to be drawn, and what is known of them."""

    style: Style
    rng: np.random.Generator
    """Of their own: no other draw depends on how they are drawn."""
    plan: Drawn
    placed: Placed
    thickest_m: float
    """Of the walls between rooms."""


def draw_walls(cells: Cells, walls: Walls) -> None:
    """Draw anew, in their style, walls that are solid: what has a room stays free, what becomes free has none."""
    style = walls.style
    if not (style.hollow or style.gaps or style.grey):
        return
    part = _part(walls)
    hollow = _hollowed(cells, walls, style.hollow, part) if style.hollow else np.zeros(cells.shape, np.bool_)
    if style.grey:
        _grey_edges(cells, walls, style.grey, part & ~hollow)
    if style.gaps:
        _interrupted(cells, walls, style.gaps, part)


def _part(walls: Walls) -> Mask:
    """Return the cells whose walls are drawn so."""
    if walls.style.part == "inner":
        return _between_floors(walls)
    whole = np.ones(walls.placed.rooms.shape, np.bool_)
    return whole if walls.style.part == "all" else _around_some_rooms(walls)


def _around_some_rooms(walls: Walls) -> Mask:
    """Return the cells on and around a third to four fifths of the floors, one at least."""
    floors = walls.plan.layout.floors
    share = walls.rng.uniform(0.33, 0.8)
    chosen = walls.rng.permutation(len(floors))[: max(1, round(share * len(floors)))].tolist()
    taken = walls.plan.floor.empty()
    for floor in (floors[k] for k in chosen):
        taken.paint(floor.grown(AROUND_ROOM_M, AROUND_ROOM_M), 1)
    return np.asarray(walls.placed.on_map(taken.rooms) > 0)


def _between_floors(walls: Walls) -> Mask:
    """Return the cells of walls that have a floor on either side: what a closing of the floors fills."""
    floor = walls.plan.floor.rooms > 0
    size = 2 * math.ceil(walls.thickest_m / 2 / FINE_M) + 1
    closed = scipy.ndimage.minimum_filter(scipy.ndimage.maximum_filter(floor, size), size)
    return np.asarray(walls.placed.on_map(closed & ~floor))


def _hollowed(cells: Cells, walls: Walls, hollow: Hollow, part: Mask) -> Mask:
    """Draw walls as outlines, and return all cells of those walls."""
    rooms, cell_m = walls.placed.rooms, walls.placed.cell_m
    floor = walls.plan.floor.rooms > 0
    band = scipy.ndimage.maximum_filter(floor, 2 * round(hollow.thick_m / FINE_M) + 1) & ~floor
    seen = scipy.ndimage.distance_transform_edt(rooms == 0) * cell_m <= hollow.thick_m + HIDDEN_M
    those = part & seen & walls.placed.on_map(band) & (rooms == 0)
    inside = scipy.ndimage.binary_erosion(those, EIGHT, iterations=hollow.outline)
    cells[those] = OCCUPIED
    cells[inside] = hollow.fill
    return np.asarray(those)


def _interrupted(cells: Cells, walls: Walls, style: Gaps, part: Mask) -> None:
    """Open gaps in walls: one sees through where there is room to see on either side."""
    rooms = walls.placed.rooms
    raster = _gap_raster(walls.plan, style, walls.placed.cell_m, walls.rng)
    gaps = np.where(part & (rooms == 0), walls.placed.on_map(raster), SHUT)
    occupied = cells == OCCUPIED
    cells[occupied & (gaps != SHUT)] = UNKNOWN
    cells[(occupied & (gaps == FREE_FACE)) | _joining(gaps == THROUGH, rooms)] = FREE


def _joining(gaps: Mask, rooms: Rooms) -> Mask:
    """Return those gaps which two rooms border."""
    part, count = scipy.ndimage.label(gaps, EIGHT)
    sides = (np.s_[1:], np.s_[:-1]), (np.s_[:, 1:], np.s_[:, :-1])
    met = np.concatenate(
        [
            np.stack([part[a], rooms[b]], axis=-1)[gaps[a] & (rooms[b] > 0)]
            for p, q in sides
            for a, b in ((p, q), (q, p))
        ]
    )
    bordered = np.bincount(np.unique(met, axis=0)[:, 0], minlength=count + 1)
    return np.asarray(bordered[part] >= 2)  # noqa: PLR2004


def _grey_edges(cells: Cells, walls: Walls, grey: Grey, part: Mask) -> None:
    """Make edges of walls unknown where ink covers too little of a cell: there is always a core that it covers most."""
    size = round(grey.blur_cells * walls.placed.cell_m / FINE_M)
    ink = scipy.ndimage.uniform_filter((walls.plan.canvas.rooms == 0).astype(np.float32), max(size, 2), mode="nearest")
    covered = walls.placed.on_map(ink)
    core = (covered >= grey.below) | (covered >= scipy.ndimage.maximum_filter(covered, size=3) - HAIR)
    core |= _ridge(covered) & (_beside_doors(walls) if grey.dotted else True)
    edge = part & (cells == OCCUPIED) & ~core
    behind = scipy.ndimage.binary_dilation(edge, EIGHT) & part & (walls.placed.rooms == 0) & (cells == UNKNOWN) & core
    cells[edge] = UNKNOWN
    cells[behind] = OCCUPIED


def _ridge(covered: NDArray[np.float32]) -> Mask:
    """Return cells covered no less than both neighbours in a row or a column, and more than is near on either side.

    Along a face all cells are covered alike: its end is no ridge, and the middle of a wall two cells thick is one.
    """
    found = np.zeros(covered.shape, np.bool_)
    for axis in (0, 1):
        before, after = (scipy.ndimage.minimum_filter1d(covered, 3, axis, origin=side) for side in (1, -1))
        most = scipy.ndimage.maximum_filter1d(covered, 3, axis)
        found |= (covered >= most - HAIR) & (covered > np.maximum(before, after) + HAIR)
    return found


def _beside_doors(walls: Walls) -> Mask:
    """Return the cells in and around doors: jambs are never dotted."""
    taken = walls.plan.floor.empty()
    away_m = JAMB_M + walls.placed.cell_m
    for gap in walls.plan.layout.gaps:
        taken.paint(gap.rect.grown(away_m, away_m), 1)
    return np.asarray(walls.placed.on_map(taken.rooms) > 0)


def _gap_raster(plan: Drawn, gaps: Gaps, cell_m: float, rng: np.random.Generator) -> NDArray[np.uint8]:
    """Return on the fine raster which cells are SHUT, and which kind of gap the others are in.

    Each gap lies in a wall, square to it, and no other one is near it on the same face.
    """
    layout, floor = plan.layout, plan.floor
    found = floor.empty()
    doors = [gap.rect.grown(JAMB_M + cell_m, JAMB_M + cell_m) for gap in layout.gaps]
    shown = FREE_FACE if gaps.face == FREE else UNKNOWN_FACE
    for room, rect in enumerate((*layout.floors, *layout.pits)):
        near = [door for door in doors if door.overlaps(rect.grown(DEEPEST_M, DEEPEST_M))]
        for face in faces(room, rect):
            for start_m, width_m in _along(face, gaps, cell_m, rng):
                through = THROUGH if chance(gaps.free_share, rng) else UNKNOWN_FACE
                hole = _hole(face, floor, start_m, width_m)
                if hole is None or any(door.overlaps(hole[0]) for door in near):
                    continue
                beside = hole[0].spanning(face.along, start_m - CORNER_M, start_m + width_m + CORNER_M)
                if not found.rooms[found.window(beside)].any():
                    found.paint(hole[0], through if hole[1] else shown)
    return found.rooms.astype(np.uint8)


def _along(face: Face, gaps: Gaps, cell_m: float, rng: np.random.Generator) -> Iterator[tuple[float, float]]:
    """Yield start and width of gaps along a face, with pieces of wall of about one length between them."""
    low, high = face.floor.low[face.along], face.floor.high[face.along]
    at = low + max(rng.uniform(0.0, gaps.piece_m), CORNER_M)
    while True:
        width = int(rng.integers(1, gaps.cells_max + 1)) * cell_m
        if at + width > high - CORNER_M:
            return
        yield at, width
        at += width + float(np.clip(gaps.piece_m * rng.uniform(0.6, 1.4), *PIECE_M))


def _hole(face: Face, floor: Canvas, start_m: float, width_m: float) -> tuple[Rect, bool] | None:
    """Return what a gap takes of the wall behind a face, and whether that is all of it, up to another floor.

    Nothing where the wall ends or turns. A thin wall is left to the upper one of its two sides' floors, or gaps from
    both sides would meet.
    """
    beside = (start_m - CORNER_M, start_m, start_m + width_m, start_m + width_m + CORNER_M)
    if any(floor.at(face.strip(at_m, 0.0, FINE_M).middle) for at_m in beside):
        return None
    depth_m = wall_thickness(face, floor, start_m + width_m / 2)
    if depth_m <= THIN_M + FINE_M / 2:
        return (face.strip(start_m, width_m, depth_m), True) if face.sign < 0 and depth_m else None
    return face.strip(start_m, width_m, min(depth_m / 2, FACE_M)), False


def wall_thickness(face: Face, floor: Canvas, at_m: float) -> float:
    """Return how far it is from a face to the next floor behind it, or 0.6 m where none is near."""
    for k in range(round(DEEPEST_M / FINE_M)):
        point = face.strip(at_m, 0.0, (2 * k + 1) * FINE_M).middle
        if floor.at(point):
            return k * FINE_M
    return DEEPEST_M
