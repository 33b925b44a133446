"""The curvature plot drawn as a picture, to be visible on every timeline: angle over samples."""

from __future__ import annotations

import math

import numpy as np
import rerun as rr
from numpy.typing import NDArray

from vdoor.method.corners import Candidates
from vdoor.viz.rerun import style
from vdoor.viz.rerun.scene import Scene

WIDTH, HEIGHT = 900.0, 300.0
"""Size of the plot in the units of its view."""
MARKS_DEG = (0, 45, 90, 135, 180)


def place(sample: NDArray[np.generic], angle_deg: NDArray[np.float64], samples: int) -> NDArray[np.float64]:
    """Points (k, 2) of the plot, x right and y down."""
    right = np.asarray(sample, np.float64) * (WIDTH / max(samples - 1, 1))
    return np.stack([right, HEIGHT * (1 - np.asarray(angle_deg) / 180)], axis=1)


def draw_curve(scene: Scene, shown: NDArray[np.int64], angle_deg: NDArray[np.float64], *, samples: int) -> None:
    """Draw the angle at the samples shown, the scale, and a mark at the walker."""
    line = place(shown, angle_deg, samples)
    scene.log("curve/angle", rr.LineStrips2D([line], colors=style.DOOR, radii=0.8, draw_order=2.0))
    scene.columns("curve/walker", "sample", shown, rr.Points2D.columns(positions=line))
    scene.keep("curve/walker", rr.Points2D.from_fields(colors=style.WALKER, radii=5.0, draw_order=5.0))
    rows = [HEIGHT * (1 - mark / 180) for mark in MARKS_DEG]
    grid = [[(0.0, row), (WIDTH, row)] for row in rows]
    scene.keep("curve/scale/lines", rr.LineStrips2D(grid, colors=style.BETWEEN, radii=0.3, draw_order=0.0))
    names = rr.Points2D(
        [(-14.0, row) for row in rows],
        labels=[f"{mark}" for mark in MARKS_DEG],
        show_labels=True,
        colors=style.UNKNOWN,
        radii=1.0,
    )
    scene.keep("curve/scale/degrees", names)


def draw_threshold(scene: Scene, candidates: Candidates, limit_deg: float, *, samples: int) -> None:
    """Draw the threshold, and the candidates below it by convexity."""
    row = HEIGHT * (1 - limit_deg / 180)
    line = [[(0.0, row), (WIDTH, row)]]
    scene.log("curve/threshold", rr.LineStrips2D(line, colors=style.THRESHOLD, radii=1.0, draw_order=3.0))
    label = rr.Points2D(
        [(WIDTH + 20, row)], labels=[f"{limit_deg:g}"], show_labels=True, colors=style.THRESHOLD, radii=1.0
    )
    scene.log("curve/threshold/degrees", label)
    points = place(candidates.sample, candidates.angle_rad * (180 / math.pi), samples)
    for kind, own, colour in (
        ("convex", candidates.convex, style.CONVEX),
        ("concave", ~candidates.convex, style.CONCAVE),
    ):
        scene.log(f"curve/{kind}", rr.Points2D(points[own], colors=colour, radii=3.0, draw_order=4.0))
