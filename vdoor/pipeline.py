"""START HERE: the method, one line a stage.

"Generating Topological Map from Occupancy Grid-map using Virtual Door Detection": simplify the grid (II.A), walk its
boundary and measure curvature (II.B, eq. 1 to 6), propose virtual doors (II.C), and let a search decide which of them
are doors (III, eq. 7).
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field

import numpy as np

from vdoor.emit import Emit, silent
from vdoor.errors import SettingError
from vdoor.grid import OccupancyGrid
from vdoor.record import Record
from vdoor.stages.corners import Candidates, Corners, FindCandidates, FindCorners
from vdoor.stages.cost import MapCost, MergeProblem
from vdoor.stages.curvature import Curvature, EstimateCurvature
from vdoor.stages.doors import ProposeDoors, VirtualDoors
from vdoor.stages.merge import MergeRooms
from vdoor.stages.rooms import DivideRooms, InitialMap
from vdoor.stages.search import AnnealingSearch, ExhaustiveSearch, Generation, GeneticSearch
from vdoor.stages.simplify import SimplifiedGrid, SimplifyGrid
from vdoor.stages.trace import BoundaryPath, TraceBoundary
from vdoor.topology import TopologicalMap

RECORDS: tuple[type[Record], ...] = (
    OccupancyGrid,
    SimplifiedGrid,
    BoundaryPath,
    Curvature,
    Candidates,
    Corners,
    VirtualDoors,
    InitialMap,
    Generation,
    TopologicalMap,
)
"""What a run emits, in this order; `Generation` as often as the search has generations."""

SEARCHES: dict[str, type[GeneticSearch | ExhaustiveSearch | AnnealingSearch]] = {
    "genetic": GeneticSearch,
    "exhaustive": ExhaustiveSearch,
    "annealing": AnnealingSearch,
}


@dataclass(frozen=True, kw_only=True)
class Pipeline:
    """The method with its settings on; the defaults are the paper's."""

    simplify: SimplifyGrid = field(default_factory=SimplifyGrid)
    trace: TraceBoundary = field(default_factory=TraceBoundary)
    curvature: EstimateCurvature = field(default_factory=EstimateCurvature)
    candidates: FindCandidates = field(default_factory=FindCandidates)
    corners: FindCorners = field(default_factory=FindCorners)
    doors: ProposeDoors = field(default_factory=ProposeDoors)
    divide: DivideRooms = field(default_factory=DivideRooms)
    cost: MapCost = field(default_factory=MapCost)
    search: GeneticSearch | ExhaustiveSearch | AnnealingSearch = field(default_factory=GeneticSearch)
    merge: MergeRooms = field(default_factory=MergeRooms)

    def __call__(self, grid: OccupancyGrid, rng: np.random.Generator, emit: Emit = silent) -> TopologicalMap:
        """Rooms and doors of `grid`; `emit` sees every stage's record on the way."""
        emit(grid)
        simplified = emit(self.simplify(grid))
        path = emit(self.trace(simplified))
        curvature = emit(self.curvature(path))
        candidates = emit(self.candidates(path, curvature))
        corners = emit(self.corners(path, curvature, candidates))
        doors = emit(self.doors(simplified, path, corners))
        initial = emit(self.divide(simplified, path, corners, doors))
        problem = MergeProblem(initial, self.cost)
        best = deque((emit(generation) for generation in self.search(problem, rng)), maxlen=1).pop()
        return emit(self.merge(grid, simplified, initial, best, problem))


PRESETS: dict[str, Pipeline] = {
    "paper": Pipeline(),
    "default": Pipeline(simplify=SimplifyGrid(cell_m=0.0), search=AnnealingSearch()),
}


def preset_named(name: str) -> Pipeline:
    """The preset of that name."""
    if name not in PRESETS:
        raise SettingError(f"preset {name!r}: wanted one of {', '.join(PRESETS)}")
    return PRESETS[name]


def run(grid: OccupancyGrid, preset: str | Pipeline = "paper", *, seed: int = 0, emit: Emit = silent) -> TopologicalMap:
    """The topological map of `grid` by a preset or a pipeline of your own; equal seeds give equal results."""
    pipeline = preset_named(preset) if isinstance(preset, str) else preset
    return pipeline(grid, np.random.default_rng(seed), emit)
