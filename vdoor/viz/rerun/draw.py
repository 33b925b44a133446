"""Drawings of each record: one function per record, and the table of them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import rerun as rr

from vdoor.baselines import CriticalLines, ErodedSpace, GrownRooms, Skeleton
from vdoor.editing.apply import Edits
from vdoor.grid import OccupancyGrid
from vdoor.method.boundary import BoundaryPath
from vdoor.method.corners import Candidates, Corners
from vdoor.method.curvature import Curvature
from vdoor.method.doors import PROPOSED, VERDICTS, VirtualDoors
from vdoor.method.initial_map import InitialMap
from vdoor.method.scoring.score import DoorScores
from vdoor.method.search.certificate import Certificate
from vdoor.method.search.generation import Generation
from vdoor.method.simplify import REASONS, SimplifiedGrid
from vdoor.navigate.cover_floor import Coverage
from vdoor.navigate.find_route import Route
from vdoor.record import RASTERS, Record, specs, tables
from vdoor.topology import TopologicalMap
from vdoor.viz.rerun import style
from vdoor.viz.rerun.baselines import draw_critical_lines, draw_eroded, draw_grown, draw_skeleton
from vdoor.viz.rerun.coverage import draw_coverage
from vdoor.viz.rerun.curve import draw_curve, draw_threshold
from vdoor.viz.rerun.graphs import draw_edits, draw_generation, draw_initial, draw_map
from vdoor.viz.rerun.restrictions import restrictions
from vdoor.viz.rerun.routes import draw_route
from vdoor.viz.rerun.scene import Scene, classes, pixels, strips, table
from vdoor.viz.rerun.scores import draw_certificate, draw_scores

MOST_PLACES = 20_000
"""Maximum number of samples at which the walker is drawn."""
UNKNOWN, FREE, BETWEEN, OCCUPIED = 0, 1, 2, 3
"""A reduced raster keeps the highest code, so walls win."""
CELL_CLASSES = {
    UNKNOWN: ("unknown", style.UNKNOWN),
    FREE: ("free", style.FREE),
    BETWEEN: ("between", style.BETWEEN),
    OCCUPIED: ("occupied", style.OCCUPIED),
}
HEADING_PX = np.array([(1, 0), (0, -1), (-1, 0), (0, 1)])


def draw_input(scene: Scene, grid: OccupancyGrid) -> None:
    """Draw the input map."""
    scene.remembered[grid.topic] = grid.frame
    scene.keep("input/map", classes(CELL_CLASSES))
    scene.raster("input/map", cell_classes(grid))
    draw_restrictions(scene, grid)


def draw_restrictions(scene: Scene, grid: OccupancyGrid) -> None:
    """Draw virtual walls and no-go areas from the map's file, if any, over the input map."""
    drawn = [
        (pixels(grid.frame.cell_from_world(np.array(line))), colour, name)
        for name, colour, own in restrictions(grid)
        for line in own
    ]
    if drawn:
        lines, colours, labels = zip(*drawn, strict=True)
        strips_of = rr.LineStrips2D(lines, colors=colours, labels=labels, show_labels=False, radii=0.3, draw_order=5.0)
        scene.log("input/map", strips_of)


def draw_simplified(scene: Scene, grid: SimplifiedGrid) -> None:
    """Draw the working grid, and the changed cells as a separate layer."""
    scene.remembered[grid.topic] = grid
    scene.keep("map/simplified", classes(CELL_CLASSES))
    scene.keep(
        "map/removed",
        classes({code: (word, style.OF_REASON.get(word, style.CLEAR)) for code, word in enumerate(REASONS)}),
    )
    scene.raster("map/simplified", cell_classes(grid))
    scene.raster("map/removed", grid.reason, order=1.0)
    counts = [np.count_nonzero(grid.reason == code) for code in range(len(REASONS))]
    scene.log_text(", ".join(f"{count} cells {name}" for name, count in zip(REASONS, counts, strict=True) if count))


def draw_path(scene: Scene, path: BoundaryPath) -> None:
    """Draw the boundary path, and the walker along the timeline `sample`."""
    scene.remembered[path.topic] = path
    ends = np.append(path.first[1:], len(path.half))
    rings = [
        np.vstack([path.half[a:b], path.half[a : a + 1]])[:, ::-1] / 2 for a, b in zip(path.first, ends, strict=True)
    ]
    scene.log("map/path", rr.LineStrips2D(rings, colors=style.BOUNDARY, radii=0.08, draw_order=10.0))
    shown = walked(scene, path)
    at = pixels(path.free_cell[shown])
    scene.columns("map/walker", "sample", shown, rr.Points2D.columns(positions=at))
    scene.keep("map/walker", rr.Points2D.from_fields(colors=style.WALKER, radii=0.35, draw_order=40.0))
    heading = HEADING_PX[path.heading[shown]]
    scene.columns("map/heading", "sample", shown, rr.Arrows2D.columns(origins=at, vectors=heading))
    scene.keep("map/heading", rr.Arrows2D.from_fields(colors=style.WALKER, radii=0.12, draw_order=41.0))


def draw_curvature(scene: Scene, curvature: Curvature) -> None:
    """Draw the angle along the path, and f and b at the walker."""
    scene.remembered[curvature.topic] = curvature
    path = scene.remembered["path"]
    angle_deg = np.degrees(curvature.angle_rad)
    shown = walked(scene, path)
    draw_curve(scene, shown, angle_deg[shown], samples=len(angle_deg))
    scene.columns("plots/curvature/angle_deg", "sample", shown, rr.Scalars.columns(scalars=angle_deg[shown]))
    scene.keep("plots/curvature/angle_deg", rr.SeriesLines(colors=style.DOOR, names="angle between f and b, degrees"))
    origins = np.repeat(path.half[shown][:, ::-1] / 2, 2, axis=0)
    vectors = np.stack([curvature.forward[shown], curvature.backward[shown]], axis=1).reshape(-1, 2)[:, ::-1] / 2
    scene.columns(
        "map/vectors",
        "sample",
        shown,
        rr.Arrows2D.columns(origins=origins, vectors=vectors).partition(np.full(len(shown), 2)),
    )
    both = rr.Arrows2D.from_fields(colors=[style.FORWARD, style.BACKWARD], radii=0.1, draw_order=42.0)
    scene.keep("map/vectors", both)


def draw_candidates(scene: Scene, candidates: Candidates) -> None:
    """Draw candidates by convexity, and the threshold in the plot."""
    angle_deg = np.degrees(candidates.angle_rad)
    limit_deg = scene.remembered["threshold_deg"]
    samples = len(scene.remembered["path"].cell)
    draw_threshold(scene, candidates, limit_deg, samples=samples)
    ends = np.array([0, max(samples - 1, 1)])
    scene.columns("plots/curvature/threshold", "sample", ends, rr.Scalars.columns(scalars=[limit_deg, limit_deg]))
    scene.keep("plots/curvature/threshold", rr.SeriesLines(colors=style.THRESHOLD, names=f"threshold {limit_deg:g}"))
    for kind, convex, colour in (("convex", True, style.CONVEX), ("concave", False, style.CONCAVE)):
        own = candidates.convex == convex
        points = rr.Points2D(pixels(candidates.cell[own]), colors=colour, radii=0.22, draw_order=20.0)
        scene.log(f"map/candidates/{kind}", points)
        if own.any():
            scene.columns(
                f"plots/curvature/{kind}", "sample", candidates.sample[own], rr.Scalars.columns(scalars=angle_deg[own])
            )
            marks = rr.SeriesPoints(colors=colour, markers="circle", names=f"{kind} candidates", marker_sizes=3)
            scene.keep(f"plots/curvature/{kind}", marks)


def draw_corners(scene: Scene, corners: Corners) -> None:
    """Draw corners on the map, and as a table with one row per corner."""
    scene.remembered[corners.topic] = corners
    for kind, convex, colour in (("convex", True, style.CONVEX), ("concave", False, style.CONCAVE)):
        own = corners.convex == convex
        place = corners.quarter[own] / 4 - 0.5
        labels = [f"corner {index}" for index in np.flatnonzero(own)]
        points = rr.Points2D(
            pixels(place), colors=colour, radii=0.45, labels=labels, show_labels=False, draw_order=30.0
        )
        scene.log(f"map/corners/{kind}", points)
    table(scene, corners, "corner")


def draw_doors(scene: Scene, doors: VirtualDoors) -> None:
    """Draw proposed doors, and rejected ones in one layer per reason."""
    scene.remembered[doors.topic] = doors
    for code, verdict in enumerate(VERDICTS):
        own = np.flatnonzero(doors.verdict == code)
        proposed = code == PROPOSED
        labels = [f"door {row}, {doors.width_m[row]:.2f} m" if proposed else f"door {row}: {verdict}" for row in own]
        scene.log(
            "map/doors/proposed" if proposed else f"map/doors/rejected/{verdict.replace(' ', '_')}",
            rr.LineStrips2D(
                strips(doors.start[own], doors.end[own]),
                colors=style.DOOR if proposed else style.REJECTED[verdict],
                radii=0.14 if proposed else 0.07,
                labels=labels,
                show_labels=False,
                draw_order=26.0 if proposed else 24.0,
            ),
        )
    counts = np.bincount(doors.verdict, minlength=len(VERDICTS))
    scene.log_text(", ".join(f"{count} {name}" for name, count in zip(VERDICTS, counts, strict=True)))
    table(scene, doors, "door")


def draw_any(scene: Scene, record: Record) -> None:
    """Draw any record: rasters as pictures, rows that lie in cells as dots, tables as rows."""
    for name, (spec, _) in specs(type(record)).items():
        place, values = f"other/{record.topic}/{name}", np.asarray(getattr(record, name))
        if spec.kind in RASTERS:
            scene.raster(place, values.astype(np.uint16))
        elif spec.kind == "cell":
            scene.log(place, rr.Points2D(pixels(values), colors=style.CONVEX, radii=0.3, draw_order=20.0))
    for name in tables(type(record)):
        table(scene, record, name)


def cell_classes(grid: OccupancyGrid | SimplifiedGrid) -> np.ndarray[Any, np.dtype[np.uint8]]:
    """Class of each cell (h, w)."""
    by_value = np.full(256, BETWEEN, np.uint8)
    by_value[128:] = UNKNOWN
    by_value[:20] = FREE
    by_value[65:128] = OCCUPIED
    return by_value[grid.cells.view(np.uint8)]


def walked(scene: Scene, path: BoundaryPath) -> np.ndarray[Any, np.dtype[np.int64]]:
    """Samples at which the walker is drawn: all, or every k-th if there are too many."""
    every = -(-len(path.cell) // MOST_PLACES)
    if every > 1:
        scene.log_text(f"one in {every} of {len(path.cell)} samples is drawn along the timeline `sample`")
    return np.arange(0, len(path.cell), max(every, 1))


DRAW: dict[type[Record], Callable[[Scene, Any], None]] = {
    OccupancyGrid: draw_input,
    SimplifiedGrid: draw_simplified,
    Skeleton: draw_skeleton,
    CriticalLines: draw_critical_lines,
    ErodedSpace: draw_eroded,
    GrownRooms: draw_grown,
    BoundaryPath: draw_path,
    Curvature: draw_curvature,
    Candidates: draw_candidates,
    Corners: draw_corners,
    VirtualDoors: draw_doors,
    DoorScores: draw_scores,
    InitialMap: draw_initial,
    Generation: draw_generation,
    Certificate: draw_certificate,
    Edits: draw_edits,
    Route: draw_route,
    Coverage: draw_coverage,
    TopologicalMap: draw_map,
}
