"""What a robot's map adds to a floor plan: rough walls, rays through windows, speckle, and nothing behind walls."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy import ndimage

from vdoor.grid import FREE, OCCUPIED, UNKNOWN
from vdoor.synth.canvas import FINE_M, LATTICE_M, Axis, Rect, snap, square_to
from vdoor.synth.furnish import BESIDE_DOOR_M
from vdoor.synth.plan import Plan
from vdoor.synth.settings import Apartment
from vdoor.synth.sheet import Sheet

BUMP_M = LATTICE_M
SEEN_M = 0.1
"""How far into a wall a robot's map shows it occupied."""
RAY_M = 0.1
RAY_APART_M = 0.25
"""Rays leave this much of wall between their middles: a hole shows at 5 cm and never at 20 cm."""
APART_M = 0.3
"""Blots and the rays of different rooms keep this distance, so that they join nothing at any cell size."""


@dataclass(frozen=True)
class Face:
    """One of the four walls of a room as seen from inside: at `at_m` on `axis`, outside is on the side of `sign`."""

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

    def bump(self, start_m: float, length_m: float) -> Rect:
        """Return a strip of wall face, 5 cm deep, grown into the room."""
        ends = sorted((self.at_m, self.at_m - self.sign * BUMP_M))
        return self.floor.spanning(self.axis, *ends).spanning(self.along, start_m, start_m + length_m)


def faces(plan: Plan) -> list[Face]:
    """All four faces of all rooms."""
    axes: tuple[Axis, Axis] = (0, 1)
    return [Face(k, floor, axis, sign) for k, floor in enumerate(plan.rooms) for axis in axes for sign in (-1, 1)]


def rough_walls(plan: Plan, settings: Apartment, rng: np.random.Generator) -> list[Rect]:
    """Return noise and juts on the walls, none near a door."""
    walls = faces(plan)
    bumps = []
    for wall in walls:
        low, length = wall.floor.low[wall.along], wall.floor.sides[wall.along]
        noisy = np.flatnonzero(rng.random(round(length / BUMP_M)) < settings.wall_noise)
        bumps += [wall.bump(low + k * BUMP_M, BUMP_M) for k in noisy.tolist()]
    for _ in range(rng.poisson(settings.juts_per_room * len(plan.rooms))):
        wall = walls[rng.integers(len(walls))]
        length = float(rng.integers(1, 4)) * LATTICE_M
        low, slack = wall.floor.low[wall.along], wall.floor.sides[wall.along] - length
        bumps.append(wall.bump(snap(low + rng.uniform(0.0, slack)), length))
    zones = [door.clear(settings.door_clear_m, BESIDE_DOOR_M) for door in plan.doors]
    return [bump for bump in bumps if not any(bump.overlaps(zone) for zone in zones)]


def hide_what_walls_hide(sheet: Sheet) -> None:
    """Make occupied cells unknown that lie deeper in a wall, or in furniture, than a robot's map shows."""
    reach = 2 * round(SEEN_M / FINE_M) + 1
    near_free = ndimage.maximum_filter((sheet.cells == FREE).astype(np.uint8), size=reach) > 0
    sheet.cells[(sheet.cells == OCCUPIED) & ~near_free] = UNKNOWN


def cast_rays(sheet: Sheet, plan: Plan, settings: Apartment, rng: np.random.Generator) -> None:
    """Free what a scanner saw through windows in the outer walls; it counts as part of the room it stood in."""
    outer = [
        wall
        for wall in faces(plan)
        if math.isclose(wall.at_m, (plan.inside.low, plan.inside.high)[wall.sign > 0][wall.axis])
    ]
    for k in rng.permutation(len(outer))[: rng.poisson(settings.windows)].tolist():  # at most one window a wall
        wall = outer[k]
        side = wall.floor.sides[wall.along]
        half = min(rng.uniform(0.6, 1.2), side - 0.6) / 2
        middle = wall.floor.low[wall.along] + rng.uniform(0.3 + half, side - 0.3 - half)
        eye = middle + rng.uniform(-0.2, 0.2)
        away = min(rng.uniform(1.0, 2.5), wall.floor.sides[wall.axis])
        for at in np.arange(middle - half, middle + half, RAY_APART_M):
            step = np.array([away, at - eye]) / math.hypot(away, at - eye)
            _cast(sheet, wall, at, step, rng.uniform(0.4, 1.5 * settings.margin_m + 0.4))


def _cast(
    sheet: Sheet, wall: Face, at: float, step: np.ndarray[tuple[int], np.dtype[np.float64]], length_m: float
) -> None:
    """Free one ray from the wall's face outwards, until it comes near what another room's rays freed."""
    number = wall.room + 1
    for gone in np.arange(RAY_M / 2, length_m, FINE_M):
        across, along = wall.at_m + wall.sign * step[0] * gone, at + step[1] * gone
        point = (across, along) if wall.axis == 0 else (along, across)
        # Far enough out of the wall; within it, the rooms on either side of a corner are near by nature.
        around = sheet.rooms[sheet.window(Rect(point, point).grown(APART_M, APART_M))]
        if step[0] * gone > APART_M and ((around > 0) & (around != number)).any():
            return
        sheet.paint(Rect(point, point).grown(RAY_M / 2, RAY_M / 2), FREE, number)


def speckle(sheet: Sheet, plan: Plan, settings: Apartment, rng: np.random.Generator) -> None:
    """Add blots, free or occupied, to what is unknown outside, away from everything free."""
    for _ in range(rng.poisson(settings.speckles)):
        low = [snap(rng.uniform(0.0, plan.sheet.high[k] - 0.2)) for k in (0, 1)]
        sides = [float(rng.integers(1, 5)) * LATTICE_M for _ in range(2)]
        state = FREE if rng.random() < 0.5 else OCCUPIED  # noqa: PLR2004  # as often as not
        blot = Rect((low[0], low[1]), (low[0] + sides[0], low[1] + sides[1]))
        near = sheet.cells[sheet.window(blot.grown(APART_M, APART_M))]
        if not plan.shell.grown(APART_M, APART_M).overlaps(blot) and not (near == FREE).any():
            sheet.paint(blot, state)
