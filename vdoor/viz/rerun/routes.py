"""The robot that drives along a path on a timeline of its own."""

from __future__ import annotations

import numpy as np
import rerun as rr
from numpy.typing import NDArray

from vdoor.explain.routes import described
from vdoor.frame import Frame
from vdoor.navigate.find_route import Route
from vdoor.viz.rerun import style
from vdoor.viz.rerun.scene import Scene, pixels

Floats = NDArray[np.float64]

DRIVE = "drive"
"""The timeline on which robots drive: how far they have come, in centimetres."""
CM_PER_M = 100
STEP_M = 0.05
MOST_PLACES = 20_000
"""The robot is drawn at no more places than that."""
LONGEST_M = 1e9


def draw_route(scene: Scene, route: Route) -> None:
    """Draw the driving robot, and log the route in words."""
    if route.found:
        draw_driving(scene, "route", route.frame, route.point_m, radius_m=route.radius_m)
    scene.log_text(described(route))


def draw_driving(scene: Scene, entity: str, frame: Frame, point_m: Floats, *, radius_m: float) -> None:
    """Draw a robot that drives along a path through points (k, 2), x, y, on the timeline `drive`."""
    along_m = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(point_m, axis=0).T))])
    if not along_m[-1] < LONGEST_M:  # a damaged recording can hold any number
        return
    count = int(np.clip(along_m[-1] / STEP_M, 1, MOST_PLACES))
    at_m = np.unique(np.concatenate([np.linspace(0, along_m[-1], count + 1), along_m]))
    x_m, y_m = (np.interp(at_m, along_m, point_m[:, axis]) for axis in (0, 1))
    place = _pixels(frame, np.stack([x_m, y_m], axis=1))
    moments = np.rint(at_m * CM_PER_M).astype(np.int64)
    scene.columns(f"{entity}/robot", DRIVE, moments, rr.Points2D.columns(positions=place))
    radius = radius_m / frame.resolution_m
    scene.keep(f"{entity}/robot", rr.Points2D.from_fields(colors=style.ROBOT, radii=radius, draw_order=250.0))


def _pixels(frame: Frame, point_m: Floats) -> Floats:
    return pixels(frame.cell_from_world(point_m))
