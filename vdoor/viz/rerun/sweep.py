"""Charts of sweeps, drawn as pictures with axes, as Rerun's own plots only run over time."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import rerun as rr
import rerun.blueprint as rrb
from numpy.typing import NDArray

from vdoor import __version__
from vdoor.emit import RunInfo
from vdoor.experiments.steps import Setting
from vdoor.experiments.sweep import Point, by_setting
from vdoor.experiments.sweep_report import COUNTS, SHARES, STAGES, row
from vdoor.viz.panels import (
    NOTE,
    PANELS,
    Axis,
    Line,
    Numbers,
    Panel,
    Series,
    axis_of,
    label_of,
    limits,
    maps_of,
    series_of,
)
from vdoor.viz.rerun import style
from vdoor.viz.rerun.scene import Scene, classes
from vdoor.viz.rerun.sink import whole_recording

WIDTH, HEIGHT = 480, 280
"""Size of a chart in pixels of its picture, without margins."""
ROOM = (60, 25, 25, 75)
"""Margins of a chart: left, right, above, below."""
LABEL_UP = 12.0
"""Upward shift of labels beside a line, as the viewer writes labels below their position."""
PAPER: style.Colour = (16, 17, 20)
INK: style.Colour = (214, 216, 220)
FAINT: style.Colour = (48, 51, 56)
OWN: style.Colour = (170, 174, 182)
FAILED: style.Colour = (240, 80, 90)
"""Dark colours, as the viewer draws labels on dark plates."""
LIGHTER = 0.45
"""Fraction by which line colours are lightened on the dark ground."""
BAND_OPACITY = 0.12
WORD_PX = 16
"""Half the width of a band over a word."""
MOST_TICKS = 6
OVERVIEW = "Overview"


class Chart:
    """One panel of one sweep, with the mapping from numbers to pixels, x right and y down."""

    def __init__(self, points: Sequence[Point], panel: Panel, ends: tuple[float, float]) -> None:
        self.points, self.panel, self.ends = points, panel, ends
        self.axis: Axis = axis_of(points)
        low, high = self.axis.places.min(), self.axis.places.max()
        spare = 0.03 * (high - low) if self.axis.numeric and high > low else 0.5
        self.across = float(low - spare), float(high + spare)

    def x(self, places: Numbers | float) -> Numbers:
        """Pixel columns of positions on the axis of values."""
        low, high = self.across
        return np.asarray((np.asarray(places) - low) / (high - low) * WIDTH)

    def y(self, numbers: Numbers | float) -> Numbers:
        """Pixel rows of numbers."""
        low, high = self.ends
        return np.asarray((high - np.asarray(numbers)) / (high - low) * HEIGHT)

    def band(self, series: Series) -> NDArray[np.bool_]:
        """Mask (HEIGHT, WIDTH) of the pixels in a series' band; over words, only near each word."""
        columns, rows = np.arange(WIDTH) + 0.5, np.arange(HEIGHT)[:, None] + 0.5
        places = self.x(self.axis.places)
        ends = [self.y(side) for side in (series.high, series.low)]
        if self.axis.numeric:
            covered = (columns >= places[0]) & (columns <= places[-1])
            top, bottom = (np.interp(columns, places, end) for end in ends)
        else:
            nearest = np.abs(columns[:, None] - places).argmin(axis=1)
            covered = np.abs(columns - places[nearest]) <= WORD_PX
            top, bottom = (end[nearest] for end in ends)
        return np.asarray(covered & (rows >= top) & (rows <= bottom))  # both are false for nan


def save_sweeps(path: Path, points: Sequence[Point]) -> None:
    """Write a Rerun recording with one tab per setting; `VdoorError` if it cannot be written."""
    sweeps = by_setting(points)
    with whole_recording(path, _identity(points), blueprint(list(sweeps))) as scene:
        scene.begin(0, "sweep")
        for number, own in enumerate(sweeps.values()):
            for place, panel in enumerate(PANELS):
                ends = limits(panel, sweeps.values() if panel.alike else [own])
                draw_chart(scene, f"sweep/{number}/{place}", Chart(own, panel, ends))
            scene.keep(f"sweep/{number}/table", rr.TextDocument(markdown(own), media_type="text/markdown"))


def blueprint(settings: Sequence[Setting]) -> rrb.Blueprint:
    """Tabs with the first panel of all sweeps side by side, then each sweep with all its panels and figures."""
    first = PANELS[0]
    overview = [_view(number, 0, f"{first.title} over {label_of(setting)}") for number, setting in enumerate(settings)]
    tabs: list[rrb.Container] = [rrb.Grid(*overview, name=OVERVIEW)]
    for number, setting in enumerate(settings):
        charts = [_view(number, place, f"{panel.title}, {panel.unit}") for place, panel in enumerate(PANELS)]
        table = rrb.TextDocumentView(origin=f"sweep/{number}/table", name="Figures")
        grid = rrb.Grid(*charts, grid_columns=2)
        tabs.append(rrb.Horizontal(grid, table, column_shares=[5, 3], name=setting.name))
    return rrb.Blueprint(
        rrb.Tabs(*tabs),
        rrb.BlueprintPanel(state="collapsed"),
        rrb.SelectionPanel(state="collapsed"),
        rrb.TimePanel(state="collapsed", timeline="step", play_state="paused"),
        auto_views=False,
        auto_layout=False,
    )


def draw_chart(scene: Scene, entity: str, chart: Chart) -> None:
    """Draw axes, the preset's own value, bands and lines."""
    draw_axes(scene, entity, chart)
    for number, line in enumerate(chart.panel.lines):
        draw_line(scene, f"{entity}/{line.figure}", chart, line, order=10.0 + number)
    names = [(line.name, light(line.colour)) for line in chart.panel.lines]
    if chart.panel.most is not None and any(point.failed for point in chart.points):
        draw_failed(scene, f"{entity}/failed", chart)
        names.append(("maps failed", FAILED))
    draw_legend(scene, f"{entity}/legend", names)


def draw_axes(scene: Scene, entity: str, chart: Chart) -> None:
    """Draw lines at round numbers, their labels, the labels of the values and the preset's own value."""
    axis = chart.axis
    levels = ticks(*chart.ends)
    across = [[[0.0, y], [WIDTH, y]] for y in chart.y(levels)]
    scene.log(f"{entity}/axes/levels", rr.LineStrips2D(across, colors=FAINT, radii=0.5, draw_order=1.0))
    numbers = [(-24.0, y - LABEL_UP) for y in chart.y(levels)]
    _words(scene, f"{entity}/axes/numbers", numbers, [f"{level:g}" for level in levels])
    places = ticks(*chart.across) if axis.numeric else axis.places
    texts = [f"{place:g}" for place in places] if axis.numeric else list(axis.texts)
    _words(scene, f"{entity}/axes/values", [(x, HEIGHT + 2.0) for x in chart.x(places)], texts)
    own = float(chart.x(axis.places[axis.own]))
    line = rr.LineStrips2D([[[own, 0.0], [own, HEIGHT]]], colors=OWN, radii=0.8, draw_order=2.0)
    scene.log(f"{entity}/axes/own", line)
    _words(scene, f"{entity}/axes/preset", [(own, -LABEL_UP - 10.0)], [f"preset: {axis.texts[axis.own]}"])


def draw_line(scene: Scene, entity: str, chart: Chart, line: Line, *, order: float) -> None:
    """Draw one figure with its band: a line over numbers, points over words; each point has a label with its value."""
    series = series_of(chart.points, line, chart.panel)
    if line.band:
        scene.keep(f"{entity}/band", classes({0: ("", style.CLEAR), 1: (line.name, light(line.colour))}))
        mask = chart.band(series).astype(np.uint8)
        scene.log(f"{entity}/band", rr.SegmentationImage(mask, opacity=BAND_OPACITY, draw_order=3.0))
    spots = np.stack([chart.x(chart.axis.places), chart.y(series.mean)], axis=1)
    known = np.isfinite(series.mean)
    colour = light(line.colour)
    if chart.axis.numeric:
        pieces = np.split(spots, np.flatnonzero(~known))
        strips = [piece[np.isfinite(piece[:, 1])] for piece in pieces]
        scene.log(entity, rr.LineStrips2D(strips, colors=colour, radii=1.0, draw_order=order))
    labels = [f"{line.name} {mean:.4g} at {text}" for mean, text in zip(series.mean, chart.axis.texts, strict=True)]
    labels = [label for label, is_known in zip(labels, known, strict=True) if is_known]
    dots = rr.Points2D(spots[known], colors=colour, radii=2.6, labels=labels, show_labels=False, draw_order=order)
    scene.log(f"{entity}/points", dots)


def draw_failed(scene: Scene, entity: str, chart: Chart) -> None:
    """Draw a point where maps failed, with a label for their number."""
    failed = np.array([len(point.failed) for point in chart.points])
    places = chart.x(chart.axis.places[failed > 0])
    spots = np.stack([places, np.full(len(places), float(chart.y(0.0)))], axis=1)
    labels = [f"{count} maps failed" for count in failed[failed > 0]]
    dots = rr.Points2D(spots, colors=FAILED, radii=4.0, labels=labels, show_labels=False, draw_order=30.0)
    scene.log(entity, dots)


def draw_legend(scene: Scene, entity: str, names: Sequence[tuple[str, style.Colour]]) -> None:
    """Draw names in their colours below the chart."""
    step = WIDTH / len(names)
    spots = [(step * (number + 0.5), HEIGHT + 36.0) for number in range(len(names))]
    texts, colours = zip(*names, strict=True)
    scene.log(entity, rr.Points2D(spots, colors=colours, radii=3.0, labels=texts, show_labels=True, draw_order=40.0))


def ticks(low: float, high: float) -> Numbers:
    """Round numbers between two, in at most six steps: multiples of 1, 2 or 5 times a power of ten."""
    rough = (high - low) / MOST_TICKS
    power = 10.0 ** np.floor(np.log10(rough))
    step = next(size * power for size in (1, 2, 5, 10) if size * power >= rough)
    return np.asarray(np.arange(np.ceil(low / step), np.floor(high / step) + 1) * step + 0.0)  # no -0


def light(colour: style.Colour) -> style.Colour:
    """A colour lightened for a dark ground."""
    red, green, blue = (round(part + LIGHTER * (255 - part)) for part in colour)
    return red, green, blue


def markdown(points: Sequence[Point]) -> str:
    """Table of one sweep and notes on its charts, as Markdown."""
    heads = ["value", *SHARES, *COUNTS, "accuracy", *STAGES, "cost", "failed"]
    rows = [f"| {' | '.join(cells)} |" for cells in (heads, ["---"] * len(heads), *map(row, points))]
    setting = points[0].setting
    return f"# {label_of(setting)}\n\n{setting.meaning}\n\n{NOTE.format(maps=maps_of(points))}.\n\n" + "\n".join(rows)


def _words(scene: Scene, entity: str, spots: Sequence[tuple[float, float]], texts: Sequence[str]) -> None:
    """Draw texts at points of the picture."""
    scene.log(entity, rr.Points2D(spots, colors=INK, radii=0.0, labels=texts, show_labels=True, draw_order=5.0))


def _view(sweep: int, panel: int, name: str) -> rrb.Spatial2DView:
    left, right, above, below = ROOM
    bounds = rrb.VisualBounds2D(x_range=(-left, WIDTH + right), y_range=(-above, HEIGHT + below))
    return rrb.Spatial2DView(origin=f"sweep/{sweep}/{panel}", name=name, background=PAPER, visual_bounds=bounds)


def _identity(points: Sequence[Point]) -> RunInfo:
    """Information that the recording's id is derived from; equal sweeps have equal ids."""
    figures = {f"{point.setting.name}={point.value}": point.maps for point in points}
    return RunInfo(version=__version__, preset="sweep", seed=0, settings=figures)
