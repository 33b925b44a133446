"""Drawings of the records of the baselines."""

from __future__ import annotations

import numpy as np
import rerun as rr

from vdoor.baselines import CriticalLines, ErodedSpace, GrownRooms, Skeleton
from vdoor.baselines.critical_lines import FATES, NARROW
from vdoor.viz.rerun import style
from vdoor.viz.rerun.scene import Scene, classes, pixels, strips


def draw_skeleton(scene: Scene, skeleton: Skeleton) -> None:
    """Draw the skeleton of the free space, each point with its clearance."""
    labels = [f"{clearance_m:.2f} m to the wall" for clearance_m in skeleton.clearance_m]
    points = rr.Points2D(
        pixels(skeleton.cell), colors=style.CONCAVE, radii=0.2, labels=labels, show_labels=False, draw_order=20.0
    )
    scene.log("map/skeleton", points)


def draw_critical_lines(scene: Scene, narrows: CriticalLines) -> None:
    """Draw narrow places with a line from wall to wall, and rejected ones in one layer per reason."""
    for code, fate in enumerate(FATES):
        own = narrows.fate == code
        colour = style.DOOR if code == NARROW else style.REMOVED
        name = fate.replace(" ", "_").replace("-", "_")
        scene.log(f"map/narrows/{name}/place", rr.Points2D(pixels(narrows.cell[own]), colors=colour, radii=0.4))
        lines = rr.LineStrips2D(strips(narrows.start[own], narrows.end[own]), colors=colour, radii=0.1)
        scene.log(f"map/narrows/{name}/across", lines)
    counts = np.bincount(narrows.fate, minlength=len(FATES))
    scene.log_text(", ".join(f"{count} {fate}" for count, fate in zip(counts, FATES, strict=True)))


def draw_eroded(scene: Scene, eroded: ErodedSpace) -> None:
    """Draw the eroded free space, with the cores of rooms in colour."""
    parts = len(eroded.kept)
    grey = (*style.REMOVED, 255)
    colours = {
        part: ("core", style.room(part)) if eroded.kept[part - 1] else ("small", grey) for part in range(1, parts + 1)
    }
    scene.keep("map/eroded", classes({0: ("none", style.CLEAR), **colours}))
    scene.raster("map/eroded", eroded.core.astype(np.uint16), order=1.0, opacity=0.7)
    scene.log_text(f"{np.count_nonzero(eroded.kept)} of {parts} parts are cores of rooms")


def draw_grown(scene: Scene, grown: GrownRooms) -> None:
    """Draw the rooms grown back from the cores."""
    rooms = int(grown.room.max(initial=0))
    colours = {room: (f"room {room}", style.room(room)) for room in range(1, rooms + 1)}
    scene.keep("map/grown", classes({0: ("none", style.CLEAR), **colours}))
    scene.raster("map/grown", grown.room.astype(np.uint16), order=1.0, opacity=0.7)
