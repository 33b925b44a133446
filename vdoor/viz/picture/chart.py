"""A chart, drawn into a box of a sheet."""

from __future__ import annotations

from typing import Any

from vdoor.viz.marks.kinds import Chart
from vdoor.viz.marks.plots import ends, limits
from vdoor.viz.picture.layout import Box
from vdoor.viz.picture.sheet import FONT, LINE_PX, POINTS_PER_PX, Entry, Sheet, hex_of, lines_of

LEFT_PX, RIGHT_PX, BOTTOM_PX = 62.0, 12.0, 44.0
"""Room for the numbers and names of the axes."""
DOTTED: dict[str, Any] = {"marker": "o", "linestyle": "none", "markeredgewidth": 0, "markersize": 3, "clip_on": False}
LINE = 1.6
"""Width of curves in points."""
DENSE = 6
"""Curves of more points than that to a pixel are drawn thin: they would run together."""
SMALL = 11 * POINTS_PER_PX


def draw_chart(sheet: Sheet, box: Box, chart: Chart) -> None:
    """Draw the legend, the axes, the levels and the curves."""
    across = box.width - LEFT_PX - RIGHT_PX
    key = entries(chart)
    head = lines_of(key, across) * LINE_PX + 4
    sheet.legend(key, box.left + LEFT_PX, box.top, across)
    inner = Box(box.left + LEFT_PX, box.top + head, across, max(box.height - head - BOTTOM_PX, 20.0))
    axes = sheet.axes(inner)
    for order, (curve, wide) in enumerate(zip(chart.curves, widths(chart, across), strict=True), start=3):
        look = DOTTED if curve.dotted else {"linewidth": wide}
        axes.plot(curve.x, curve.y, color=hex_of(curve.colour), zorder=order, **look)
    for height, colour, _ in chart.levels:
        axes.axhline(height, color=hex_of(colour), linewidth=1.2, linestyle="--", zorder=3 + len(chart.curves))
    axes.set(xlim=ends(chart), ylim=limits(chart))
    axes.set_xlabel(chart.x_label, fontsize=SMALL, fontfamily=FONT)
    axes.set_ylabel(chart.y_label, fontsize=SMALL, fontfamily=FONT)
    axes.tick_params(labelsize=SMALL, labelfontfamily=FONT, width=0.6, length=3)
    axes.grid(axis="y", color="0.9", linewidth=0.6)
    axes.set_axisbelow(True)
    axes.spines[["top", "right"]].set_visible(False)


def widths(chart: Chart, across: float) -> list[float]:
    """Widths of the curves: those below others are wider, so that where they run together all are seen."""
    above = [sum(not later.dotted for later in chart.curves[at + 1 :]) for at in range(len(chart.curves))]
    dense = max((len(curve.x) for curve in chart.curves), default=0) > DENSE * across
    return [LINE / 3 if dense else LINE + 1.6 * count for count in above]


def entries(chart: Chart) -> list[Entry]:
    """The legend of a chart."""
    found = [Entry("o" if curve.dotted else "-", curve.colour, curve.meaning, 4.0) for curve in chart.curves]
    return [*found, *(Entry("--", colour, meaning, 2.0) for _, colour, meaning in chart.levels)]
