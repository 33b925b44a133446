"""The first baseline after [8]: doors wherever the Voronoi diagram passes between two walls close together."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from vdoor.baselines.critical_lines import NARROW, CriticalLines, FindCriticalLines
from vdoor.baselines.plain import without_corners
from vdoor.baselines.skeleton import DrawSkeleton, Skeleton
from vdoor.editing.apply import EditRooms, Edits
from vdoor.emit import Emit, silent
from vdoor.grid import FREE, OccupancyGrid
from vdoor.method.doors import PROPOSED, VERDICTS, DoorCandidates, VirtualDoors, measures, without_duplicates
from vdoor.method.final_map import MergeRooms
from vdoor.method.initial_map import DivideRooms, InitialMap
from vdoor.method.search.costs import MapCost
from vdoor.method.search.generation import Generation, summary
from vdoor.method.search.problem import MergeProblem
from vdoor.method.simplify import SimplifiedGrid, SimplifyGrid
from vdoor.navigate.cover_floor import CoverFloor
from vdoor.navigate.find_route import FindRoute
from vdoor.navigate.tasks import WithTasks, done, records_of
from vdoor.raster.lines import lines_between
from vdoor.record import Record
from vdoor.topology import KINDS, TopologicalMap

KIND = KINDS.index("pair")  # a door between two points, though these are not corners


@dataclass(frozen=True, kw_only=True)
class CrossNarrows:
    """Place a virtual door across each narrow place, from wall to wall."""

    def __call__(self, simplified: SimplifiedGrid, narrows: CriticalLines) -> VirtualDoors:
        """One virtual door per narrow place with walls on both sides, in their order; corners are -1."""
        free = simplified.cells == FREE
        rows = np.flatnonzero(narrows.fate == NARROW)
        start, end = narrows.start[rows], narrows.end[rows]
        verdict = np.full(len(rows), PROPOSED, np.uint8)
        clear, _, _ = lines_between(free, start, end)
        verdict[~clear] = VERDICTS.index("blocked")
        none = np.full((len(rows), 2), -1, np.int32)
        verdict = without_duplicates(DoorCandidates(start, end, np.full(len(rows), KIND, np.uint8), verdict, none))
        proposed = np.flatnonzero(verdict == PROPOSED)
        _, line_cell, owner = lines_between(free, start[proposed], end[proposed])
        length_m, width_m, tilt_rad = measures(start, end, narrows.frame.resolution_m)
        return VirtualDoors(
            start=start,
            end=end,
            kind=np.full(len(rows), KIND, np.uint8),
            verdict=verdict,
            corner_start=none[:, 0],
            corner_end=none[:, 1],
            length_m=length_m,
            width_m=width_m,
            tilt_rad=tilt_rad,
            line_cell=line_cell,
            line_door=proposed[owner].astype(np.int32),
            frame=narrows.frame,
        )


@dataclass(frozen=True, kw_only=True)
class VoronoiDoorsPipeline(WithTasks):
    """The baseline of doors across the skeleton's narrow places; all doors that separate something are kept."""

    simplify: SimplifyGrid = field(default_factory=SimplifyGrid)
    skeleton: DrawSkeleton = field(default_factory=DrawSkeleton)
    narrows: FindCriticalLines = field(default_factory=FindCriticalLines)
    cross: CrossNarrows = field(default_factory=CrossNarrows)
    divide: DivideRooms = field(default_factory=DivideRooms)
    cost: MapCost = field(default_factory=MapCost)
    merge: MergeRooms = field(default_factory=MergeRooms)
    edit: EditRooms = field(default_factory=EditRooms)
    route: FindRoute = field(default_factory=FindRoute)
    cover: CoverFloor = field(default_factory=CoverFloor)

    @property
    def records(self) -> tuple[type[Record], ...]:
        """The records that a run emits, in order."""
        return (
            OccupancyGrid,
            SimplifiedGrid,
            Skeleton,
            CriticalLines,
            VirtualDoors,
            InitialMap,
            Generation,
            *([Edits] if self.edit.edits else []),
            TopologicalMap,
            *records_of(self.tasks),
        )

    def __call__(self, grid: OccupancyGrid, rng: np.random.Generator, emit: Emit = silent) -> TopologicalMap:
        """Rooms and doors of `grid`; `emit` is called with every stage's record. `rng` is not used."""
        del rng
        opened = self.edit.open_doors(emit(grid))
        simplified = emit(self.simplify(opened.grid))
        skeleton = emit(self.skeleton(simplified))
        narrows = emit(self.narrows(simplified, skeleton))
        doors = emit(self.cross(simplified, narrows))
        path, corners = without_corners(simplified.frame)
        initial = emit(self.divide(simplified, path, corners, doors))
        problem = MergeProblem(initial, self.cost)
        choice = emit(everything_kept(problem))
        merged = self.merge(opened.grid, simplified, initial, choice, problem, path=path)
        topology, edits = self.edit(merged, opened)
        if edits is not None:
            emit(edits)
        return done(self.tasks, grid, emit(topology), emit)


def everything_kept(problem: MergeProblem) -> Generation:
    """The choice that keeps all doors, as a single generation with its cost."""
    nothing_removed = np.zeros((1, problem.edges), np.bool_)
    return summary(0, 1, nothing_removed, problem.evaluate(nothing_removed))
