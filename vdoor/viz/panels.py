"""What is drawn of a sweep, whatever draws it: panels of lines over the swept value."""

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
"""Share of an axis left beyond the lines."""


class Line(NamedTuple):
    """One figure."""

    name: str
    figure: str
    colour: Colour
    band: bool = False
    """Its spread over the maps is drawn as well."""


class Panel(NamedTuple):
    """Lines that share an axis."""

    title: str
    unit: str
    lines: tuple[Line, ...]
    most: float | None = None
    """Where the axis ends; None: where the lines do."""
    alike: bool = True
    """All sweeps have the same axis, so that they can be compared by eye."""


PANELS = (
    Panel(
        "Doors right",
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
    Panel("Cost", "of the choice", (Line("cost", "cost", DARK, band=True),), alike=False),
)
"""Cost is not alike in all sweeps: its own weights are among what is swept."""
NOTE = (
    "Lines: mean of {maps}; bands: one standard deviation to either side; upright line: the preset's own value; "
    "matched / virtual: of all doors together"
)


class Series(NamedTuple):
    """A line's numbers, one for each value; nan where there is none."""

    mean: Numbers
    low: Numbers
    high: Numbers
    """A standard deviation below and above, within what the axis has."""


class Axis(NamedTuple):
    """Where the values of a setting stand."""

    places: Numbers
    numeric: bool
    """The places are the values; else they are 0, 1, ... and the values are words."""
    texts: tuple[str, ...]
    own: int
    """Which of them is the preset's own."""


def axis_of(points: Sequence[Point]) -> Axis:
    """Places of the points' values."""
    values: list[Any] = [point.value for point in points]
    numeric = all(isinstance(value, int | float) and not isinstance(value, bool) for value in values)
    places = np.array(values if numeric else range(len(values)), np.float64)
    own = next(number for number, point in enumerate(points) if point.own)
    return Axis(places, numeric, tuple(map(value_text, values)), own)


def series_of(points: Sequence[Point], line: Line, panel: Panel) -> Series:
    """The numbers of one line; of matched / virtual, which is one number of all maps together, the band is none."""
    if line.figure == "accuracy":
        mean = np.array([point.figures.get(line.figure, np.nan) for point in points])
        return Series(mean, mean, mean)
    spreads = np.array([spread(point.maps, line.figure) for point in points])
    mean, deviation = spreads.T
    low, high = mean - deviation, mean + deviation
    return Series(mean, low, high) if panel.most is None else Series(mean, low.clip(0.0), high.clip(None, panel.most))


def limits(panel: Panel, sweeps: Iterable[Sequence[Point]]) -> tuple[float, float]:
    """Where a panel's axis begins and ends, with 0 on it and a little to spare."""
    series = [series_of(points, line, panel) for points in sweeps for line in panel.lines]
    numbers = np.concatenate([np.concatenate([one.low, one.high]) for one in series] or [np.zeros(1)])
    numbers = numbers[np.isfinite(numbers)]
    low, high = min(0.0, numbers.min(initial=0.0)), max(numbers.max(initial=0.0), panel.most or 0.0)
    spare = SPARE * (high - low) or 1.0
    return (low - spare if low else 0.0), high + spare


def label_of(setting: Setting) -> str:
    """What stands at the axis of values."""
    return f"{setting.name} ({setting.unit})" if setting.unit else setting.name


def maps_of(points: Sequence[Point]) -> str:
    """How many maps."""
    count = len(points[0].maps)
    return f"{count} maps" if count > 1 else "the map"
