"""How each record is drawn: its marks, and what a recording has beside them, as walks, charts, graphs and tables."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

import numpy as np
import rerun as rr

from vdoor.baselines import CriticalLines, ErodedSpace, GrownRooms, Skeleton
from vdoor.editing.apply import Edits
from vdoor.grid import OccupancyGrid
from vdoor.method.boundary import BoundaryPath
from vdoor.method.corners import Candidates, Corners
from vdoor.method.curvature import Curvature
from vdoor.method.doors import VERDICTS, VirtualDoors
from vdoor.method.initial_map import InitialMap
from vdoor.method.scoring.score import DoorScores
from vdoor.method.search.certificate import Certificate
from vdoor.method.search.generation import Generation
from vdoor.method.simplify import REASONS, SimplifiedGrid
from vdoor.navigate.cover_floor import Coverage
from vdoor.navigate.find_route import Route
from vdoor.record import Record, tables
from vdoor.topology import TopologicalMap
from vdoor.viz.marks.kinds import Cells, Mark
from vdoor.viz.marks.plots import along_m, angle_chart
from vdoor.viz.marks.table import MARKS, marks_of
from vdoor.viz.rerun import style
from vdoor.viz.rerun.chart import draw_chart, placed
from vdoor.viz.rerun.coverage import draw_coverage
from vdoor.viz.rerun.graphs import draw_final_graph, draw_generation
from vdoor.viz.rerun.marks import draw_marks
from vdoor.viz.rerun.routes import draw_route
from vdoor.viz.rerun.scene import Scene, pixels, table
from vdoor.viz.rerun.scores import draw_certificate, draw_scores

MOST_PLACES = 20_000
"""Maximum number of samples at which the walker is drawn."""
HEADING_PX = np.array([(1, 0), (0, -1), (-1, 0), (0, 1)])
ENTITIES: dict[type[Record], str] = {
    OccupancyGrid: "input/map",
    SimplifiedGrid: "map/simplified",
    BoundaryPath: "map/path",
    Curvature: "map/curvature",
    Candidates: "map/candidates",
    Corners: "map/corners",
    Skeleton: "map/skeleton",
    CriticalLines: "map/narrows",
    ErodedSpace: "map/eroded",
    GrownRooms: "map/grown",
    VirtualDoors: "map/doors",
    DoorScores: "map/scores",
    InitialMap: "map/initial",
    Generation: "map/search",
    Edits: "rooms/edits",
    TopologicalMap: "rooms",
    Route: "route",
    Coverage: "coverage",
}
"""Where the marks of each record go: below `map` in cells of the working grid, elsewhere in those of the input."""
APART = 10.0
"""Draw order from stage to stage: later ones are on top."""
OVER_ROOMS = 230.0
"""Draw order of what the robot must not cross or enter: it holds in the rooms as well."""


def draw_record(scene: Scene, record: Record) -> None:
    """Draw a record: its marks, and what else there is to show of it."""
    scene.remember(record)
    kind = type(record)
    place = ENTITIES.get(kind, f"other/{record.topic}")
    order = APART * ([*ENTITIES].index(kind) if kind in ENTITIES else len(ENTITIES))
    ground, marks = _parted(marks_of(scene.run, kind)) if kind is OccupancyGrid else ([], marks_of(scene.run, kind))
    draw_marks(scene, place, ground, order=order)
    draw_marks(scene, place, marks, order=OVER_ROOMS if ground else order)
    if kind in BESIDE:
        BESIDE[kind](scene, record)
    elif kind not in MARKS:
        for name in tables(kind):
            table(scene, record, name)


def _parted(marks: Iterable[Mark]) -> tuple[list[Mark], list[Mark]]:
    """The map's cells, and the lines on them."""
    both: tuple[list[Mark], list[Mark]] = [], []
    for mark in marks:
        both[not isinstance(mark, Cells)].append(mark)
    return both


def draw_changed(scene: Scene, grid: SimplifiedGrid) -> None:
    """Log how many cells were changed, by reason."""
    counts = [np.count_nonzero(grid.reason == code) for code in range(len(REASONS))]
    scene.log_text(", ".join(f"{count} cells {name}" for name, count in zip(REASONS, counts, strict=True) if count))


def draw_walk(scene: Scene, path: BoundaryPath) -> None:
    """Draw the walker along the timeline `sample`."""
    shown = walked(scene, path)
    at = pixels(path.free_cell[shown])
    scene.columns("map/walker", "sample", shown, rr.Points2D.columns(positions=at))
    scene.keep("map/walker", rr.Points2D.from_fields(colors=style.WALKER, radii=-5.0, draw_order=240.0))
    heading = HEADING_PX[path.heading[shown]] * 3
    scene.columns("map/heading", "sample", shown, rr.Arrows2D.columns(origins=at, vectors=heading))
    scene.keep("map/heading", rr.Arrows2D.from_fields(colors=style.WALKER, radii=-1.5, draw_order=241.0))


def draw_curvature(scene: Scene, curvature: Curvature) -> None:
    """Draw the chart of the angle, and f and b at the walker."""
    path = scene.run.path
    shown = walked(scene, path)
    chart = angle_chart(scene.run, scene.threshold_deg)
    draw_chart(scene, "charts/curvature", chart)
    at = placed(chart, along_m(path)[shown], np.degrees(curvature.angle_rad[shown]))
    scene.columns("charts/curvature/walker", "sample", shown, rr.Points2D.columns(positions=at))
    scene.keep("charts/curvature/walker", rr.Points2D.from_fields(colors=style.WALKER, radii=-6.0, draw_order=9.0))
    origins = np.repeat(path.half[shown][:, ::-1] / 2, 2, axis=0)
    vectors = np.stack([curvature.forward[shown], curvature.backward[shown]], axis=1).reshape(-1, 2)[:, ::-1] / 2
    scene.columns(
        "map/vectors",
        "sample",
        shown,
        rr.Arrows2D.columns(origins=origins, vectors=vectors).partition(np.full(len(shown), 2)),
    )
    both = rr.Arrows2D.from_fields(colors=[style.FORWARD, style.BACKWARD], radii=-1.5, draw_order=242.0)
    scene.keep("map/vectors", both)


def draw_candidates(scene: Scene, _: Candidates) -> None:
    """Draw the chart of the angle again, with the candidates."""
    draw_chart(scene, "charts/curvature", angle_chart(scene.run, scene.threshold_deg))


def draw_doors(scene: Scene, doors: VirtualDoors) -> None:
    """Log how many doors were rejected and why, and their table."""
    counts = np.bincount(doors.verdict, minlength=len(VERDICTS))
    scene.log_text(", ".join(f"{count} {name}" for name, count in zip(VERDICTS, counts, strict=True)))
    table(scene, doors, "door")


def walked(scene: Scene, path: BoundaryPath) -> np.ndarray[Any, np.dtype[np.int64]]:
    """Samples at which the walker is drawn: all, or every k-th if there are too many."""
    every = -(-len(path.cell) // MOST_PLACES)
    if every > 1:
        scene.log_text(f"one in {every} of {len(path.cell)} samples is drawn along the timeline `sample`")
    return np.arange(0, len(path.cell), max(every, 1))


BESIDE: dict[type[Record], Callable[[Scene, Any], None]] = {
    SimplifiedGrid: draw_changed,
    BoundaryPath: draw_walk,
    Curvature: draw_curvature,
    Candidates: draw_candidates,
    Corners: lambda scene, corners: table(scene, corners, "corner"),
    VirtualDoors: draw_doors,
    DoorScores: draw_scores,
    Generation: draw_generation,
    Certificate: draw_certificate,
    Edits: lambda scene, edits: table(scene, edits, "edit"),
    TopologicalMap: draw_final_graph,
    Route: draw_route,
    Coverage: draw_coverage,
}
"""What is drawn of records beside their marks."""
