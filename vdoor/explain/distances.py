"""Nearest elements to a point, and the length limits of virtual doors."""

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
    """The `count` nearest of places (k, 2) in working cells: index and distance in metres; ties by index."""
    away_m = np.hypot(*(run.simplified.frame.world_from_cell(places) - point_m).T).round(9)
    order = np.argsort(away_m, kind="stable")[:count]
    return [(int(index), float(away_m[index])) for index in order]


def point_of(run: History, place: NDArray[Any]) -> Point:
    """Position in metres of a place given as row, col of working cells."""
    x_m, y_m = run.simplified.frame.world_from_cell(place)[0].tolist()
    return x_m, y_m


@dataclass(frozen=True)
class Reach:
    """Limits of one kind of virtual door."""

    max_length_m: float
    detour: float | None
    """Minimum ratio of the path length between the ends to the length of the door; None if there is no such limit."""
    least_width_m: float = 0.0
    """Minimum width of the free gap."""


def reach(settings: ProposeDoors | ProposeWideDoors, kind: str) -> Reach:
    """Limits of doors of one kind: pair, single or extension."""
    if isinstance(settings, ProposeDoors):
        return Reach(settings.max_length_m, settings.pair_detour if kind == "pair" else settings.single_detour)
    return {
        "pair": Reach(settings.pair_m, settings.pair_detour, settings.least_m),
        "single": Reach(settings.single_m, settings.single_detour, settings.least_m),
        "extension": Reach(settings.extension_m, None, settings.least_m),
    }[kind]


def longest_m(settings: ProposeDoors | ProposeWideDoors) -> float:
    """Maximum length over all kinds of doors."""
    if isinstance(settings, ProposeDoors):
        return settings.max_length_m
    return max(settings.pair_m, settings.single_m, settings.extension_m)
