"""What lies nearest to a point, and how far virtual doors reach."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vdoor.history import History
from vdoor.method.doors import ProposeDoors
from vdoor.method.wide_doors import ProposeWideDoors

Point = tuple[float, float]


def nearest(run: History, point_m: Point, places: NDArray[Any], count: int) -> list[tuple[int, float]]:
    """The `count` nearest of places (k, 2) in working cells: index and metres away, the first one at a tie."""
    away_m = np.hypot(*(run.simplified.frame.world_from_cell(places) - point_m).T).round(9)
    order = np.argsort(away_m, kind="stable")[:count]
    return [(int(index), float(away_m[index])) for index in order]


def point_of(run: History, place: NDArray[Any]) -> Point:
    """A place as row, col of working cells in metres."""
    x_m, y_m = run.simplified.frame.world_from_cell(place)[0].tolist()
    return x_m, y_m


@dataclass(frozen=True)
class Reach:
    """The limits of one kind of virtual doors."""

    max_length_m: float
    detour: float | None
    """The path between the ends must be so many times longer than the door; None where it is not asked."""
    least_width_m: float = 0.0
    """Narrower gaps are no doors."""


def reach(settings: ProposeDoors | ProposeWideDoors, kind: str) -> Reach:
    """The limits of pairs, singles or extensions."""
    if isinstance(settings, ProposeDoors):
        return Reach(settings.max_length_m, settings.pair_detour if kind == "pair" else settings.single_detour)
    return {
        "pair": Reach(settings.pair_m, settings.pair_detour, settings.least_m),
        "single": Reach(settings.single_m, settings.single_detour, settings.least_m),
        "extension": Reach(settings.extension_m, None, settings.least_m),
    }[kind]


def longest_m(settings: ProposeDoors | ProposeWideDoors) -> float:
    """The longest door of any kind."""
    if isinstance(settings, ProposeDoors):
        return settings.max_length_m
    return max(settings.pair_m, settings.single_m, settings.extension_m)
