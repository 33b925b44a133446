"""Sweeps as one picture: one row per setting, one column per panel. Equal sweeps give equal bytes."""

from __future__ import annotations

import io
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from vdoor.experiments.sweep import Point, by_setting
from vdoor.viz.panels import (
    NOTE,
    PANELS,
    Axis,
    Line,
    Panel,
    Series,
    axis_of,
    label_of,
    limits,
    maps_of,
    series_of,
)
from vdoor.viz.rerun.style import Colour

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure, SubFigure

PANEL_IN = (3.5, 2.4)
"""Width and height of a panel in inches."""
NOTE_IN = 0.35
OWN: Colour = (110, 114, 122)
FAILED: Colour = (214, 30, 50)
FAILED_ABOVE = 0.06
"""Height of the text with the number of failed maps, on the panel's axis."""
TICKS = 6
MOST_WORDS = 4
"""With more words below an axis, they are rotated."""


DOTS_PER_INCH = 100
STYLE: dict[str, Any] = {
    "font.family": "DejaVu Sans",  # comes with matplotlib, so independent of the machine's fonts
    "font.size": 9,
    "axes.titlesize": 9,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.linewidth": 0.6,
    "legend.fontsize": 8,
    "legend.frameon": False,
}


def sweep_png(points: Sequence[Point]) -> bytes:
    """The charts as a PNG."""
    sweeps = by_setting(points)
    shared = [limits(panel, sweeps.values()) if panel.alike else None for panel in PANELS]
    with drawing(PANEL_IN[0] * len(PANELS), PANEL_IN[1] * len(sweeps) + NOTE_IN) as figure:
        figure.suptitle(NOTE.format(maps=maps_of(points)), fontsize=8, x=0.01, horizontalalignment="left")
        rows = figure.subfigures(len(sweeps), 1, squeeze=False)[:, 0]
        for number, (row, own) in enumerate(zip(rows, sweeps.values(), strict=True)):
            draw_sweep(row, own, shared, first=not number)
        return to_png(figure)


def draw_sweep(
    row: SubFigure, points: Sequence[Point], shared: Sequence[tuple[float, float] | None], *, first: bool
) -> None:
    """Draw all panels of one sweep side by side; only the first sweep of a picture has legends."""
    axis = axis_of(points)
    setting = points[0].setting
    title = f"{setting.meaning} Preset: {axis.texts[axis.own]}"
    row.suptitle(title, fontsize=9, fontweight="bold", x=0.01, horizontalalignment="left")
    for axes, panel, ends in zip(row.subplots(1, len(PANELS)), PANELS, shared, strict=True):
        draw_panel(axes, panel, points, axis)
        axes.set_ylim(ends or limits(panel, [points]))
        axes.set_xlabel(label_of(setting))
        axes.set_title(panel.title, loc="left")
        if first and len(panel.lines) > 1:
            axes.legend()


def draw_panel(axes: Axes, panel: Panel, points: Sequence[Point], axis: Axis) -> None:
    """Draw one panel of one sweep."""
    axes.axvline(axis.places[axis.own], color=rgb(OWN), linewidth=1.0, linestyle=":")
    axes.axhline(0.0, color="0.6", linewidth=0.6)
    for behind, line in enumerate(reversed(panel.lines)):
        draw_line(axes, line, series_of(points, line, panel), axis, behind=behind)
    if panel.most is not None:
        draw_failed(axes, points, axis)
    axes.set_ylabel(panel.unit)
    axes.grid(axis="y", color="0.92", linewidth=0.6)
    axes.set_axisbelow(True)
    if axis.numeric:
        axes.locator_params(axis="x", nbins=TICKS)
    else:
        axes.set_xticks(axis.places, axis.texts, rotation=30 if len(axis.texts) > MOST_WORDS else 0)
        axes.set_xlim(-0.5, len(axis.places) - 0.5)


def draw_line(axes: Axes, line: Line, series: Series, axis: Axis, *, behind: int) -> None:
    """Draw one figure: a line over numbers, points over words.

    `behind` is the number of lines drawn over it: it is wider by that much, to stay visible.
    """
    colour, size = rgb(line.colour), 1.3 + 0.7 * behind
    axes.plot(
        axis.places,
        series.mean,
        linestyle="-" if axis.numeric else "none",
        marker="o",
        markersize=1.3 + size,
        color=colour,
        linewidth=size,
        label=line.name,
        zorder=3 - 0.1 * behind,
    )
    if not line.band:
        return
    if axis.numeric:
        axes.fill_between(axis.places, series.low, series.high, color=colour, alpha=0.15, linewidth=0)
    else:
        axes.vlines(axis.places, series.low, series.high, color=colour, alpha=0.3, linewidth=5)


def draw_failed(axes: Axes, points: Sequence[Point], axis: Axis) -> None:
    """Draw a cross and a count where maps failed."""
    for place, point in zip(axis.places, points, strict=True):
        if point.failed:
            axes.plot(place, 0.0, "x", color=rgb(FAILED), clip_on=False, zorder=5)
            text = f"{len(point.failed)} failed"
            axes.annotate(
                text, (place, FAILED_ABOVE), color=rgb(FAILED), fontsize=7, rotation=90, ha="center", va="bottom"
            )


def rgb(colour: Sequence[int]) -> tuple[float, float, float]:
    """A colour as matplotlib takes it, without its opacity."""
    red, green, blue = (part / 255 for part in colour[:3])
    return red, green, blue


@contextmanager
def drawing(width_in: float, height_in: float) -> Iterator[Figure]:
    """An empty picture; within the block the style is fixed, whatever the user's own matplotlib settings are."""
    from matplotlib import style  # noqa: PLC0415
    from matplotlib.backends.backend_agg import FigureCanvasAgg  # noqa: PLC0415
    from matplotlib.figure import Figure  # noqa: PLC0415

    with style.context(["default", STYLE]):
        figure = Figure(figsize=(width_in, height_in), dpi=DOTS_PER_INCH, layout="constrained")
        FigureCanvasAgg(figure)
        yield figure


def to_png(figure: Figure) -> bytes:
    """The picture as a PNG of 256 colours, without metadata on program and date."""
    from PIL import Image  # noqa: PLC0415

    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", metadata={"Software": None})
    image = Image.open(buffer).convert("RGB").quantize(256, dither=Image.Dither.NONE)
    small = io.BytesIO()
    image.save(small, format="png", optimize=True)
    return small.getvalue()
