"""Charts of a sweep, independent of the drawing library: panels of lines over the swept value."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from vdoor.experiments.steps import Setting
from vdoor.experiments.sweep import Point, spread
from vdoor.experiments.sweep_report import value_text
from vdoor.viz.rerun.style import Colour

DARK: Colour = (38, 40, 46)
BLUE: Colour = (36, 92, 230)
GREEN: Colour = (20, 150, 70)
ORANGE: Colour = (224, 120, 20)
PURPLE: Colour = (150, 40, 190)
Numbers = NDArray[np.float64]
SPARE = 0.05
"""Margin of an axis beyond its lines, as a fraction."""


class Line(NamedTuple):
    """One line of a panel: one figure over the swept value."""

    name: str
    figure: str
    colour: Colour
    band: bool = False
    """Whether its spread over the maps is drawn as well."""


class Panel(NamedTuple):
    """Lines that share an axis."""

    title: str
    unit: str
    lines: tuple[Line, ...]
    most: float | None = None
    """Upper end of the axis; None to fit the lines."""
    alike: bool = True
    """Whether all sweeps have the same axis, so that they can be compared by eye."""


PANELS = (
    Panel(
        "Door detection",
        "share",
        (
            Line("precision", "door_precision", ORANGE),
            Line("recall", "door_recall", GREEN),
            Line("matched / virtual", "accuracy", PURPLE),
            Line("F1", "door_f1", BLUE, band=True),
        ),
        most=1.0,
    ),
    Panel(
        "Found minus true",
        "per map",
        (Line("rooms", "rooms_excess", GREEN, band=True), Line("doors", "doors_excess", BLUE, band=True)),
    ),
    Panel(
        "Corners, proposed doors",
        "per map",
        (Line("corners", "corners", ORANGE, band=True), Line("proposed doors", "proposed", BLUE, band=True)),
    ),
    Panel("Cost", "of the kept doors", (Line("cost", "cost", DARK, band=True),), alike=False),
)
"""The cost has its own axis in each sweep, as its weights may be swept."""
NOTE = (
    "Lines: mean of {maps}; bands: plus and minus one standard deviation; vertical line: value of the preset; "
    "matched / virtual: over the doors of all maps"
)


class Series(NamedTuple):
    """Numbers of a line, one per swept value; nan if unknown."""

    mean: Numbers
    low: Numbers
    high: Numbers
    """One standard deviation below and above, within the axis."""


class Axis(NamedTuple):
    """Positions of a setting's values on the axis."""

    places: Numbers
    numeric: bool
    """Whether the positions are the values; otherwise they are 0, 1, ... and the values are words."""
    texts: tuple[str, ...]
    own: int
    """Index of the preset's own value."""


def axis_of(points: Sequence[Point]) -> Axis:
    """Axis of the points' values."""
    values: list[Any] = [point.value for point in points]
    numeric = all(isinstance(value, int | float) and not isinstance(value, bool) for value in values)
    places = np.array(values if numeric else range(len(values)), np.float64)
    own = next(number for number, point in enumerate(points) if point.own)
    return Axis(places, numeric, tuple(map(value_text, values)), own)


def series_of(points: Sequence[Point], line: Line, panel: Panel) -> Series:
    """Numbers of one line; matched / virtual is one number for all maps together, so its band is empty."""
    if line.figure == "accuracy":
        mean = np.array([point.figures.get(line.figure, np.nan) for point in points])
        return Series(mean, mean, mean)
    spreads = np.array([spread(point.maps, line.figure) for point in points])
    mean, deviation = spreads.T
    low, high = mean - deviation, mean + deviation
    return Series(mean, low, high) if panel.most is None else Series(mean, low.clip(0.0), high.clip(None, panel.most))


def limits(panel: Panel, sweeps: Iterable[Sequence[Point]]) -> tuple[float, float]:
    """Lower and upper end of a panel's axis, including 0 and a margin."""
    series = [series_of(points, line, panel) for points in sweeps for line in panel.lines]
    numbers = np.concatenate([np.concatenate([one.low, one.high]) for one in series] or [np.zeros(1)])
    numbers = numbers[np.isfinite(numbers)]
    low, high = min(0.0, numbers.min(initial=0.0)), max(numbers.max(initial=0.0), panel.most or 0.0)
    spare = SPARE * (high - low) or 1.0
    return (low - spare if low else 0.0), high + spare


def label_of(setting: Setting) -> str:
    """Label of the axis of values."""
    return f"{setting.name} ({setting.unit})" if setting.unit else setting.name


def maps_of(points: Sequence[Point]) -> str:
    """Number of maps as text."""
    count = len(points[0].maps)
    return f"{count} maps" if count > 1 else "the map"
