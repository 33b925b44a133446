"""Charts of stages that are seen along the boundary or along the search, not on the map."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from vdoor.history.records import RunRecords
from vdoor.method.boundary import BoundaryPath
from vdoor.method.corners import Candidates
from vdoor.method.scoring.score import DoorScores
from vdoor.method.search.certificate import Certificate
from vdoor.viz.marks.kinds import Chart, Curve
from vdoor.viz.rerun import style

Floats = NDArray[np.float64]
STRAIGHT_DEG = 180.0
SPARE = 0.05
"""Margin of an axis beyond its curves, as a share."""
TERMS = {
    "small_rooms": ("NumSmallNode: rooms that are too small", style.BEST),
    "area_sd_m2": ("AreaSD: spread of the rooms' areas, m²", style.MEAN),
    "tilt_sd_deg": ("DegSD: tilt of the doors, degrees", style.WORST),
}


def along_m(path: BoundaryPath) -> Floats:
    """How far each sample is along the boundary, contour after contour."""
    before = np.concatenate([[0.0], np.cumsum(path.length_m)[:-1]])
    return np.asarray(path.arc_m + before[path.contour])


def angle_chart(run: RunRecords, limit_deg: float) -> Chart:
    """The angle at each sample, with the threshold of candidates and what is below it."""
    at_m, angle_deg = along_m(run.path), np.degrees(run.curvature.angle_rad)
    first = run.path.first[1:]
    line = Curve("angle", np.insert(at_m, first, np.nan), np.insert(angle_deg, first, np.nan), style.BETWEEN, "angle")
    dots: Sequence[Curve] = ()
    if run.has(Candidates):
        found = run.candidates
        dots = [
            Curve(name, at_m[found.sample[own]], np.degrees(found.angle_rad[own]), colour, f"{name} candidate", True)
            for name, own, colour in (
                ("concave", ~found.convex, style.CONCAVE),
                ("convex", found.convex, style.CONVEX),
            )
        ]
    return Chart(
        name="curvature",
        x_label="along the boundary, m",
        y_label="angle, degrees",
        curves=[line, *dots],
        levels=[(limit_deg, style.THRESHOLD, f"threshold, {limit_deg:g}°")],
        low=0.0,
        high=STRAIGHT_DEG,
    )


def cost_chart(run: RunRecords) -> Chart:
    """Cost of the best, the mean and the worst choice by generation, and the proven bound if there is one."""
    number = run.search.numbers("number")
    curves = [
        Curve(name, number, run.search.numbers(f"{name}_cost"), colour, f"{name} of the generation")
        for name, colour in (("worst", style.WORST), ("mean", style.MEAN), ("best", style.BEST))
    ]
    bound = [run.certificate.lower_bound] if run.has(Certificate) else []
    levels = [(cost, style.BOUND, f"lower bound, {cost:.2f}") for cost in bound]
    what = "cost (energy of scored doors)" if run.has(DoorScores) else "cost (eq. 7)"
    high = _seen_up_to(run.search.numbers("best_cost"), run.search.numbers("mean_cost"), bound)
    return Chart(name="cost", x_label="generation", y_label=what, curves=curves, levels=levels, high=high)


def _seen_up_to(best: Floats, mean: Floats, bound: Sequence[float]) -> float:
    """Upper end of the axis of costs: over the best ones and the least mean, since the worst would leave no height."""
    low, high = min([best.min(), *bound]), max(best.max(), mean.min())
    return float(high + max(high - low, 0.1 * abs(high), 0.1))


def terms_chart(run: RunRecords) -> Chart:
    """The three terms of eq. 7, of the best choice of each generation."""
    number = run.search.numbers("number")
    curves = [
        Curve(name, number, run.search.numbers(name), colour, meaning) for name, (meaning, colour) in TERMS.items()
    ]
    return Chart(name="terms", x_label="generation", y_label="terms of eq. 7", curves=curves, low=0.0)


def ends(chart: Chart) -> tuple[float, float]:
    """From where to where the x axis goes."""
    numbers = np.concatenate([curve.x[np.isfinite(curve.x)] for curve in chart.curves])
    first, last = float(numbers.min(initial=np.inf)), float(numbers.max(initial=-np.inf))
    return (first, last) if first < last else (min(first, 0.0) if len(numbers) else 0.0, max(last, 0.0) + 1.0)


def limits(chart: Chart) -> tuple[float, float]:
    """From where to where the y axis goes: over curves and levels, with a margin where the chart does not say."""
    numbers = np.concatenate(
        [*(curve.y[np.isfinite(curve.y)] for curve in chart.curves), [at for at, *_ in chart.levels]]
    )
    least, most = (-np.inf if chart.low is None else chart.low), (np.inf if chart.high is None else chart.high)
    numbers = numbers.clip(least, most)
    low, high = (float(numbers.min()), float(numbers.max())) if len(numbers) else (0.0, 1.0)
    spare = SPARE * (high - low) or 1.0
    return low - spare if chart.low is None else chart.low, high + spare if chart.high is None else chart.high
