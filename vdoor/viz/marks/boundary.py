"""Marks of section II.A and II.B: the map, its boundary and the corners."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from vdoor.frame import Frame
from vdoor.grid import FREE_TO, OCCUPIED_FROM, OccupancyGrid
from vdoor.history.records import RunRecords
from vdoor.method.boundary import BoundaryPath
from vdoor.method.simplify import REASONS
from vdoor.viz.marks.kinds import Arrows, Cells, Colour, Dots, Lines, Mark, Places, path_name
from vdoor.viz.rerun import style
from vdoor.viz.rerun.restrictions import restrictions

UNKNOWN, FREE, BETWEEN, OCCUPIED = range(4)
"""Codes of the states of cells; of several in one pixel the highest is seen, so walls win."""
STATES: dict[int, tuple[Colour, str]] = {
    UNKNOWN: (style.UNKNOWN, "unknown"),
    FREE: (style.FREE, "free"),
    BETWEEN: (style.BETWEEN, "neither free nor occupied"),
    OCCUPIED: (style.OCCUPIED, "occupied"),
}
BINS: tuple[tuple[float, float, Colour], ...] = (
    (155.0, 181.0, (105, 140, 200)),
    (120.0, 155.0, (238, 178, 60)),
    (90.0, 120.0, (232, 120, 40)),
    (60.0, 90.0, (200, 48, 28)),
    (0.0, 60.0, (120, 0, 40)),
)
"""From and to an angle in degrees, and the colour of samples between, the sharpest last."""
BECAME = {
    "unreachable": "unreachable, now unknown",
    "jut": "jut: a bump on a wall, now free",
    "notch": "notch: a dent in a wall, now occupied",
    "island": "island: as small as furniture, now free",
    "thin unknown": "thin line of unknown cells, now free",
    "slit": "slit: too narrow for the robot, closed",
    "sill": "sill: unseen floor of a doorway, now free",
}
"""What has become of cells that were changed, by reason."""
ARROWS = 60
"""About that many arrows along the boundary, whatever its length."""
ARROW_CELLS = 1 / 40
"""Length of an arrow, as a share of the map's longer side."""


def states(cells: NDArray[np.int8]) -> NDArray[np.uint8]:
    """The state of each cell (h, w)."""
    by_value = np.full(256, BETWEEN, np.uint8)
    by_value[128:] = UNKNOWN
    by_value[: FREE_TO + 1] = FREE
    by_value[OCCUPIED_FROM:128] = OCCUPIED
    return by_value[cells.view(np.uint8)]


def input_map(run: RunRecords) -> Iterator[Mark]:
    """The map as it was read, with the walls and areas that the robot is forbidden."""
    grid = run.input
    yield Cells(name="cells", frame=grid.frame, codes=states(grid.cells), colours=STATES)
    yield from _restricted(grid)


def _restricted(grid: OccupancyGrid) -> Iterator[Mark]:
    for word, colour, lines in restrictions(grid):
        strips = [grid.frame.cell_from_world(np.array(line)) for line in lines]
        if strips:
            tips = [word] * len(strips)
            yield Lines(
                name=path_name(word), frame=grid.frame, strips=strips, colour=colour, meaning=word, tips=tips, wide_px=3
            )


def ground(run: RunRecords) -> Iterator[Mark]:
    """The working grid, on which later stages are drawn."""
    grid = run.simplified
    yield Cells(name="cells", frame=grid.frame, codes=states(grid.cells), colours=STATES)


def simplified(run: RunRecords) -> Iterator[Mark]:
    """The working grid, and the cells that differ from the input, by reason."""
    yield from ground(run)
    reason = run.simplified.reason
    count = np.bincount(reason.ravel(), minlength=len(REASONS)).tolist()
    colours = {
        code: (style.OF_REASON[word], f"{BECAME[word]} ({count[code]} cells)")
        for code, word in enumerate(REASONS)
        if code
    }
    yield Cells(name="changed", frame=run.simplified.frame, codes=reason, colours=colours)


def boundary(run: RunRecords) -> Iterator[Mark]:
    """The boundary that is walked, without what belongs to single samples."""
    path = run.path
    yield Lines(
        name="rings", frame=path.frame, strips=rings(path), colour=style.BOUNDARY, meaning="boundary", wide_px=2
    )


def walk(run: RunRecords) -> Iterator[Mark]:
    """The boundary, and which way it is walked."""
    path = run.path
    yield from boundary(run)
    long = max(path.frame.height, path.frame.width) * ARROW_CELLS
    chord = _chords(path, max(round(long / 2), 1))
    chord_cells = np.hypot(*chord.T)
    every = max(len(path.cell) // ARROWS, 1)
    # The straightest place of each stretch: at a turn an arrow would point through a wall.
    shown = [at + int(chord_cells[at : at + every].argmax()) for at in range(0, len(path.cell), every)]
    by = chord[shown] / np.maximum(chord_cells[shown, None], 1.0) * long
    at = path.half[shown] / 2 - 0.5
    yield Arrows(
        name="direction",
        frame=path.frame,
        cell=at - by / 2,
        vector=by,
        colour=style.WALKER,
        meaning="direction of the walk, wall on the left",
    )


def _chords(path: BoundaryPath, samples: int) -> NDArray[np.float64]:
    """Vectors (k, 2) in cells from so many samples before each to as many behind it, along its ring."""
    split = np.split(path.half / 2, path.first[1:])
    return np.concatenate([np.roll(ring, -samples, axis=0) - np.roll(ring, samples, axis=0) for ring in split])


def rings(path: BoundaryPath) -> list[Places]:
    """The contours (k, 2) in cells, each closed."""
    places = path.half / 2 - 0.5
    return [np.concatenate([ring, ring[:1]]) for ring in np.split(places, path.first[1:]) if len(ring)]


def curvature(run: RunRecords) -> Iterator[Mark]:
    """Samples of the boundary by their angle, the sharpest on top."""
    path, angle_deg = run.path, np.degrees(run.curvature.angle_rad)
    places = path.half / 2 - 0.5
    for low, high, colour in BINS:
        own = (angle_deg >= low) & (angle_deg < high)
        meaning = f"{low:g}° to {min(high, 180):g}° ({own.sum()})"
        yield Dots(
            name=f"from_{low:g}",
            frame=path.frame,
            cell=places[own],
            colour=colour,
            meaning=f"nearly straight, {meaning}" if high > 180 else meaning,  # noqa: PLR2004  # degrees
            wide_px=3.5 if high > 180 else 5,  # noqa: PLR2004
        )


def candidates(run: RunRecords) -> Iterator[Mark]:
    """Candidates by convexity."""
    found = run.candidates
    yield from _by_side(found.frame, found.cell, found.convex, "candidate", found.angle_rad, wide_px=5.0)


def corners(run: RunRecords) -> Iterator[Mark]:
    """Corners by convexity."""
    found = run.corners
    yield from _by_side(found.frame, found.quarter / 4 - 0.5, found.convex, "corner", found.angle_rad, wide_px=9.0)


def _by_side(
    frame: Frame, place: Places, convex: NDArray[np.bool_], word: str, angle_rad: NDArray[np.float64], *, wide_px: float
) -> Iterator[Mark]:
    """Dots for concave and for convex bends."""
    for name, own, colour in (("concave", ~convex, style.CONCAVE), ("convex", convex, style.CONVEX)):
        rows = np.flatnonzero(own)
        tips = [
            f"{word} {row}: {name}, {angle:.0f}°" for row, angle in zip(rows, np.degrees(angle_rad[own]), strict=True)
        ]
        yield Dots(
            name=name,
            frame=frame,
            cell=place[own],
            colour=colour,
            meaning=f"{name} {word} ({len(rows)})",
            tips=tips,
            wide_px=wide_px,
        )
