"""Halls of an office floor: what corridors run into, what parts them, and walls in them that part nothing."""

from __future__ import annotations

from vdoor.synth.canvas import Axis, Rect, fine, square_to
from vdoor.synth.layout import Gap
from vdoor.synth.office_sketch import Sketch

BLOCK_M, BLOCK_GAP_M = (0.1, 0.8), (0.45, 1.8)
"""Thickness of what parts a hall, and the openings left in it."""
SCREEN_NEEDS_M, AWAY_M = 4.0, 1.2
"""Least side of rooms with screens in them, and how far these stay away from walls that they do not touch."""


def end_hall(sketch: Sketch, column: Rect, mains: list[Rect], mouth: float) -> None:
    """Add a hall that the main corridors run into, in all their width."""
    sketch.halls.append(column)
    for main in mains:
        rect = Rect((mouth, main.low[1]), (fine(mouth + sketch.wall_m), main.high[1]))
        sketch.open_mouth(rect, 0)


def open_hall(sketch: Sketch, hall: Rect, mains: tuple[Rect, Rect]) -> None:
    """Add a hall that takes in the main corridor below or above, or both; people part it where that goes on."""
    wall = sketch.wall_m
    for main in mains[: 1 + sketch.chance(0.4)] if sketch.chance(0.5) else mains[1:]:
        hall = hall.spanning(1, min(hall.low[1], main.low[1]), max(hall.high[1], main.high[1]))
        for x, beyond_m in ((fine(hall.low[0] - wall), -1.0), (hall.high[0], 1.0)):
            mouth = Rect((x, main.low[1]), (fine(x + wall), main.high[1]))
            if main.low[0] < mouth.middle[0] + beyond_m < main.high[0]:
                sketch.solids.append(mouth)
                sketch.open_mouth(mouth, 0)
    sketch.corridors.append(hall)


def divide_hall(sketch: Sketch, hall: Rect) -> None:
    """Part a hall by a row of blocks with openings between them, through all of which one can walk."""
    rng = sketch.rng
    along: Axis = 0 if hall.sides[0] < hall.sides[1] else 1
    across = square_to(along)
    at = fine(hall.low[across] + hall.sides[across] * rng.uniform(0.3, 0.7))
    row = hall.spanning(across, at, fine(at + rng.uniform(*BLOCK_M)))
    count = int(rng.integers(1, 6))
    share = hall.sides[along] / count
    if share < BLOCK_GAP_M[1] + 0.5:
        return
    sketch.solids.append(row)
    for k in range(count):
        width = fine(rng.uniform(*BLOCK_GAP_M))
        low = fine(row.low[along] + k * share + rng.uniform(0.1, share - width - 0.1))
        sketch.gaps.append(Gap(row, across).in_wall(low, width, leaf=False))


def put_screens(sketch: Sketch) -> None:
    """Put walls into large rooms that part nothing: most of the way past their ends is open."""
    for floor in sketch.rooms + sketch.halls + sketch.corridors:
        if min(floor.sides) > SCREEN_NEEDS_M and sketch.chance(sketch.settings.screen_chance):
            screen = _screen(floor, sketch)
            near = [gap.clear(1.0, 0.1) for gap in sketch.gaps] + [solid.grown(0.6, 0.6) for solid in sketch.solids]
            if not any(screen.overlaps(rect) for rect in near):
                sketch.solids.append(screen)


def _screen(floor: Rect, sketch: Sketch) -> Rect:
    """Return a short thin wall on a floor, free or from one of its walls on."""
    rng = sketch.rng
    along: Axis = 0 if sketch.chance(0.5) else 1
    across = square_to(along)
    length = fine(rng.uniform(0.6, min(3.0, 0.4 * floor.sides[along])))
    beside_m = 0.0 if sketch.chance(0.4) else AWAY_M
    low = fine(rng.uniform(floor.low[along] + beside_m, floor.high[along] - beside_m - length))
    if not beside_m:
        low = floor.low[along] if sketch.chance(0.5) else fine(floor.high[along] - length)
    at = fine(rng.uniform(floor.low[across] + AWAY_M, floor.high[across] - AWAY_M - 0.2))
    return floor.spanning(along, low, fine(low + length)).spanning(across, at, fine(at + rng.uniform(0.05, 0.25)))
