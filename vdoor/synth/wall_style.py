"""How the walls of one map are drawn: solid, as outlines, in pieces, or with grey edges."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from typing import Literal, TypeVar

import numpy as np

from vdoor.grid import FREE, UNKNOWN
from vdoor.synth.settings import Home, Office, chance, log_uniform

Part = Literal["all", "inner", "rooms"]
Kind = TypeVar("Kind", Home, Office)

PIECE_M = (0.3, 1.5)
"""Length of what is left of a wall between two gaps."""
THIN_M = 0.2
"""Through gaps in walls up to this thickness one sees the other side."""
HOLLOW_CELLS = 3.5
"""A wall of fewer cells has no room for two outlines and something between."""
BROKEN_CHANCE = 0.4
"""Chance that outlines have gaps of their own."""
DOTTED_CHANCE = 0.35
BLUR_CELLS = (1.0, 2.0)
GREY_BELOW = (0.6, 0.97)


@dataclass(frozen=True)
class Hollow:
    """Walls as outlines, `outline` cells wide, with `fill` inside; outer walls are `thick_m` thick."""

    thick_m: float
    fill: int
    outline: int


@dataclass(frozen=True)
class Gaps:
    """Walls in pieces of about `piece_m`, with gaps of one to `cells_max` cells between."""

    piece_m: float
    cells_max: int
    free_share: float
    """Of the gaps in thin walls this share is free through and through, the others are unknown."""
    face: int
    """What the gaps of thick walls show, each face for itself."""


@dataclass(frozen=True)
class Grey:
    """Walls as a picture shrunk with a blur of `blur_cells` has them: grey where ink covers less than `below`."""

    blur_cells: float
    below: float
    dotted: bool
    """The middle of thin walls is grey as well, apart from its darkest cells."""


@dataclass(frozen=True)
class Style:
    """How the walls are drawn, and which of them: all, those between rooms, or those around some rooms."""

    part: Part = "all"
    hollow: Hollow | None = None
    gaps: Gaps | None = None
    grey: Grey | None = None


def drawn_style(settings: Home | Office, rng: np.random.Generator) -> Style:
    """Return how one map's walls are drawn: mostly solid."""
    for_part, for_hollow, for_gaps, for_grey = rng.spawn(4)
    hollow = _hollow(settings, for_hollow) if chance(settings.hollow_chance, rng) else None
    dashed = chance(settings.dashed_chance, rng)
    antialiased = chance(settings.antialiased_chance, rng)
    part: Part = "all"
    if chance(0.5, for_part):  # either all walls or a part of them
        part = "inner" if chance(0.5, for_part) else "rooms"
    gaps = None
    if dashed:
        gaps = _gaps(math.floor(settings.dash_gap_max_m / settings.cell_m + 1e-6), for_gaps)
    elif hollow and chance(BROKEN_CHANCE, for_gaps):
        gaps = dataclasses.replace(_gaps(2, for_gaps), free_share=0.0, face=hollow.fill)
    return Style(part, hollow, gaps, _grey(for_grey) if antialiased else None)


def planned(settings: Kind, style: Style) -> Kind:
    """Return the settings to plan by: what is drawn hollow has walls that are thick enough for it."""
    if style.hollow is None:
        return settings
    low = min(_thinnest(settings), style.hollow.thick_m)
    return dataclasses.replace(settings, wall_min_m=low, wall_max_m=style.hollow.thick_m)


def _thinnest(settings: Home | Office) -> float:
    return min(max(settings.hollow_wall_min_m, HOLLOW_CELLS * settings.cell_m), settings.hollow_wall_max_m)


def _hollow(settings: Home | Office, rng: np.random.Generator) -> Hollow:
    """Return outlines of one cell, or two in one drawing of four, around what is free or unknown."""
    thick_m = rng.uniform(_thinnest(settings), settings.hollow_wall_max_m)
    fill = FREE if chance(0.6, rng) else UNKNOWN  # unknown inside is common in other maps as well
    return Hollow(thick_m, fill, 2 if chance(0.25, rng) else 1)


def _gaps(cells_most: int, rng: np.random.Generator) -> Gaps:
    """Return pieces of one length, more or less, and gaps of up to three cells, `cells_most` at most."""
    piece_m = log_uniform(PIECE_M[0], PIECE_M[1], rng)
    most = int(rng.integers(1, min(max(cells_most, 1), 3) + 1))
    return Gaps(piece_m, most, float(rng.choice([0.0, 0.5, 0.8, 1.0])), UNKNOWN)


def _grey(rng: np.random.Generator) -> Grey:
    return Grey(rng.uniform(*BLUR_CELLS), rng.uniform(*GREY_BELOW), chance(DOTTED_CHANCE, rng))
