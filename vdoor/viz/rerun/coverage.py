"""The floor that is swept as the robot drives."""

from __future__ import annotations

import colorsys

import numpy as np

from vdoor.explain.coverage import described
from vdoor.navigate.cover_floor import Coverage
from vdoor.viz.rerun import style
from vdoor.viz.rerun.routes import CM_PER_M, DRIVE, draw_driving
from vdoor.viz.rerun.scene import Scene, classes

HUES = 200
"""Number of colours from the first swept cells to the last."""
FRAMES, MOST_CELLS = 60, 60_000_000
"""Number of pictures of the floor along the way, and largest number of their cells."""


def draw_coverage(scene: Scene, coverage: Coverage) -> None:
    """Draw the robot on its way, and the floor in colours from the first swept cells to the last."""
    _draw_floor(scene, coverage)
    draw_driving(scene, "coverage", coverage.frame, coverage.point_m, radius_m=coverage.radius_m)
    scene.log_text(described(coverage))


def _draw_floor(scene: Scene, coverage: Coverage) -> None:
    """Colour the swept cells by when they are swept, in pictures along the timeline of the robot."""
    total_m = coverage.length_m
    last = len(coverage.along_m) - 1
    when_m = coverage.along_m[np.clip(coverage.swept, 0, last)]  # damaged records may hold anything
    shade = np.where(coverage.swept > 0, 1 + (when_m / max(total_m, 1e-9) * (HUES - 1)).astype(np.int64), 0)
    scene.keep("coverage/floor", classes(_shades()))
    frames = min(FRAMES, max(MOST_CELLS // coverage.swept.size, 1))
    for at_m in np.linspace(0, total_m, frames + 1):
        scene.at(**{DRIVE: round(at_m * CM_PER_M)})
        scene.raster("coverage/floor", np.where(when_m <= at_m, shade, 0).astype(np.uint8), order=165.0, opacity=0.6)


def _shades() -> dict[int, tuple[str, tuple[int, int, int, int]]]:
    """Colours from blue over green to red, and none for cells that are not swept yet."""
    found = {0: ("not swept", style.CLEAR)}
    for number in range(HUES):
        red, green, blue = colorsys.hsv_to_rgb(0.66 * (1 - number / (HUES - 1)), 0.6, 0.95)
        found[number + 1] = (
            f"{number / (HUES - 1):.0%}",
            (round(red * 255), round(green * 255), round(blue * 255), 255),
        )
    return found
