"""Which function makes the marks of which record."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping

import numpy as np

from vdoor.baselines import CriticalLines, ErodedSpace, GrownRooms, Skeleton
from vdoor.editing.apply import Edits
from vdoor.frame import Frame
from vdoor.grid import OccupancyGrid
from vdoor.history.records import RunRecords
from vdoor.method.boundary import BoundaryPath
from vdoor.method.corners import Candidates, Corners
from vdoor.method.curvature import Curvature
from vdoor.method.doors import VirtualDoors
from vdoor.method.initial_map import InitialMap
from vdoor.method.scoring.score import DoorScores
from vdoor.method.search.generation import Generation
from vdoor.method.simplify import SimplifiedGrid
from vdoor.navigate.cover_floor import Coverage
from vdoor.navigate.find_route import Route
from vdoor.record import RASTERS, Record, specs
from vdoor.topology import TopologicalMap
from vdoor.viz.marks import boundary, doors, maps
from vdoor.viz.marks.kinds import Cells, Dots, Mark, wrapped
from vdoor.viz.rerun import style

MARKS: Mapping[type[Record], Callable[[RunRecords], Iterable[Mark]]] = {
    OccupancyGrid: boundary.input_map,
    SimplifiedGrid: boundary.simplified,
    BoundaryPath: boundary.walk,
    Curvature: boundary.curvature,
    Candidates: boundary.candidates,
    Corners: boundary.corners,
    Skeleton: doors.skeleton,
    CriticalLines: doors.narrow_places,
    ErodedSpace: doors.cores,
    GrownRooms: doors.grown,
    VirtualDoors: doors.doors,
    DoorScores: doors.scores,
    InitialMap: maps.initial_map,
    Generation: maps.choice,
    Edits: maps.edits,
    TopologicalMap: maps.final_map,
    Route: maps.route,
    Coverage: maps.coverage,
}


def marks_of(run: RunRecords, record: type[Record]) -> Iterator[Mark]:
    """The marks of a recorded stage; without a function of its own, its rasters and the rows that lie in cells."""
    yield from MARKS[record](run) if record in MARKS else _plain(run.records[record.topic])


def _plain(record: Record) -> Iterator[Mark]:
    frame = getattr(record, "frame", None)
    for name, (spec, _) in specs(type(record)).items():
        values = np.asarray(getattr(record, name))
        if spec.kind in RASTERS:
            place = frame or Frame(values.shape[0], values.shape[1], resolution_m=1.0)
            codes = wrapped(values.astype(np.int32))
            colours = {int(code): (style.room(int(code)), f"{name} {code}") for code in np.unique(codes) if code}
            yield Cells(name=name, frame=place, codes=codes, colours=colours, opacity=0.8, listed=False)
        elif spec.kind == "cell" and frame is not None:
            meaning = f"{name} ({len(values)})"
            yield Dots(name=name, frame=frame, cell=values, colour=style.CONVEX, meaning=meaning, wide_px=5)
