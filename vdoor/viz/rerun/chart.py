"""Charts drawn as pictures: their axis is the chart's own, whatever timeline is selected."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
import rerun as rr
import rerun.blueprint as rrb
from numpy.typing import NDArray

from vdoor.viz.marks.kinds import Chart, Curve
from vdoor.viz.marks.plots import ends, limits
from vdoor.viz.rerun import style
from vdoor.viz.rerun.scene import Scene

WIDTH, HEIGHT = 900.0, 360.0
"""Size of a chart in the units of its view."""
TICKS = 6
FAR = 20.0
"""Points are drawn up to that many heights of a chart above it: lines to them leave the view at their own slope."""
Floats = NDArray[np.float64]


def view_of_chart(entity: str, name: str) -> rrb.Spatial2DView:
    """A view of a chart; its name says what the axes and colours are, since text in it would cover other text."""
    bounds = rrb.VisualBounds2D(x_range=[-70.0, WIDTH + 30.0], y_range=[-30.0, HEIGHT + 60.0])
    return rrb.Spatial2DView(origin=entity, name=name, visual_bounds=bounds)


def draw_chart(scene: Scene, entity: str, chart: Chart) -> None:
    """Draw axes with numbers, levels and curves. It is there at all times: a later one takes its place."""
    _draw_axes(scene, entity, chart)
    for height, colour, meaning in chart.levels:
        across = placed(chart, np.array(ends(chart)), np.full(2, height))
        line = rr.LineStrips2D([across], colors=colour, radii=-0.8, labels=[meaning], show_labels=False, draw_order=2.0)
        scene.keep(f"{entity}/levels/{meaning.partition(',')[0].partition(' ')[0]}", line)
    for order, curve in enumerate(chart.curves, start=3):
        scene.keep(f"{entity}/curves/{curve.name}", _curve(chart, curve, float(order)))


def placed(chart: Chart, x: Floats, y: Floats) -> Floats:
    """Points (k, 2) of a chart in the units of its view, x right and y down; what is above the axis is out of view."""
    (left, right), (low, high) = ends(chart), limits(chart)
    across = (np.asarray(x, np.float64) - left) / max(right - left, 1e-12) * WIDTH
    down = (high - np.clip(y, low, high + FAR * (high - low))) / max(high - low, 1e-12) * HEIGHT
    return np.stack([across, down], axis=1)


def _curve(chart: Chart, curve: Curve, order: float) -> rr.Points2D | rr.LineStrips2D:
    points = placed(chart, curve.x, curve.y)
    if curve.dotted:
        return rr.Points2D(points, colors=curve.colour, radii=-2.5, draw_order=order)
    parts = np.split(points, np.flatnonzero(np.isnan(points).any(axis=1)))
    lines = [part[~np.isnan(part).any(axis=1)] for part in parts]
    return rr.LineStrips2D([line for line in lines if len(line) > 1], colors=curve.colour, radii=-1.0, draw_order=order)


def _draw_axes(scene: Scene, entity: str, chart: Chart) -> None:
    """Draw lines across at round numbers, and the numbers of both axes."""
    (left, right), (low, high) = ends(chart), limits(chart)
    across = np.array([*ticks(low, high)])
    along = np.array([*ticks(left, right)])
    lines = [placed(chart, np.array([left, right]), np.full(2, height)) for height in across]
    scene.keep(f"{entity}/axes/lines", rr.LineStrips2D(lines, colors=style.BETWEEN, radii=-0.3, draw_order=0.0))
    at_y = placed(chart, np.full(len(across), left), across) - [28.0, 0.0]
    at_x = placed(chart, along, np.full(len(along), low)) - [0.0, -14.0]
    texts = [f"{number:g}" for number in [*across.tolist(), *along.tolist()]]
    numbers = rr.Points2D(
        np.concatenate([at_y, at_x]), labels=texts, show_labels=True, colors=style.UNKNOWN, radii=-0.5
    )
    scene.keep(f"{entity}/axes/numbers", numbers)


def ticks(low: float, high: float) -> Iterator[float]:
    """A few round numbers between two."""
    rough = (high - low) / TICKS
    power = 10.0 ** math.floor(math.log10(max(rough, 1e-12)))
    step = next(part * power for part in (1, 2, 5, 10) if part * power >= rough)
    for number in range(math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9) + 1):
        yield round(number * step, 9)
