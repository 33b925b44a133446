"""The floor that is swept as the robot drives."""

from __future__ import annotations

import numpy as np

from vdoor.explain.coverage import described
from vdoor.navigate.cover_floor import Coverage
from vdoor.viz.rerun import style
from vdoor.viz.rerun.routes import CM_PER_M, DRIVE, draw_driving
from vdoor.viz.rerun.scene import Scene, classes

FRAMES, MOST_CELLS = 60, 60_000_000
"""Number of pictures of the floor along the way, and largest number of their cells."""


def draw_coverage(scene: Scene, coverage: Coverage) -> None:
    """Draw the robot on its way, and the floor that it has swept so far."""
    _draw_floor(scene, coverage)
    draw_driving(scene, "coverage", coverage.frame, coverage.point_m, radius_m=coverage.radius_m)
    scene.log_text(described(coverage))


def _draw_floor(scene: Scene, coverage: Coverage) -> None:
    """Colour the swept cells in pictures along the timeline of the robot, as pictures and the report do."""
    total_m = coverage.length_m
    last = len(coverage.along_m) - 1
    when_m = coverage.along_m[np.clip(coverage.swept, 0, last)]  # damaged records may hold anything
    scene.keep("coverage/floor", classes({0: ("not swept", style.CLEAR), 1: ("swept", style.SWEPT)}))
    frames = min(FRAMES, max(MOST_CELLS // coverage.swept.size, 1))
    for at_m in np.linspace(0, total_m, frames + 1):
        scene.at(**{DRIVE: round(at_m * CM_PER_M)})
        swept = (coverage.swept > 0) & (when_m <= at_m)
        scene.raster("coverage/floor", swept.astype(np.uint8), order=165.0, opacity=0.6)
