"""START HERE: the method, one line per stage.

"Generating Topological Map from Occupancy Grid-map using Virtual Door Detection": simplify the grid (II.A), walk its
boundary and measure curvature (II.B, eq. 1 to 6), propose virtual doors (II.C), and search for the ones to keep
(III, eq. 7).
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from vdoor.baselines import CriticalLines, ErodedSpace, ErodedSpacePipeline, GrownRooms, Skeleton, VoronoiDoorsPipeline
from vdoor.config import with_settings
from vdoor.editing.apply import EditRooms, Edits
from vdoor.emit import Emit, RunInfo, silent
from vdoor.errors import SettingError, no_such
from vdoor.grid import OccupancyGrid
from vdoor.method.boundary import BoundaryPath, TraceBoundary
from vdoor.method.corners import Candidates, Corners, FindCandidates, FindCorners
from vdoor.method.curvature import Curvature, EstimateCurvature
from vdoor.method.doors import ProposeDoors, VirtualDoors
from vdoor.method.final_map import MergeRooms
from vdoor.method.initial_map import DivideRooms, InitialMap
from vdoor.method.scoring.score import DoorScores, NoScores, ScoreDoors
from vdoor.method.search.certificate import BoundEnergy, Certificate, NoProof
from vdoor.method.search.costs import DoorEnergy, MapCost
from vdoor.method.search.generation import Generation
from vdoor.method.search.memetic import MemeticSearch
from vdoor.method.search.optimisers import AnnealingSearch, ExhaustiveSearch, GeneticSearch
from vdoor.method.search.problem import MergeProblem
from vdoor.method.simplify import SimplifiedGrid, SimplifyGrid
from vdoor.method.wide_doors import ProposeWideDoors
from vdoor.navigate.cover_floor import Coverage, CoverFloor
from vdoor.navigate.find_route import FindRoute, Route
from vdoor.navigate.tasks import WithTasks, done
from vdoor.record import Record
from vdoor.topology import TopologicalMap

RECORDS: tuple[type[Record], ...] = (
    OccupancyGrid,
    SimplifiedGrid,
    Skeleton,
    CriticalLines,
    BoundaryPath,
    Curvature,
    Candidates,
    Corners,
    VirtualDoors,
    DoorScores,
    InitialMap,
    Generation,
    Certificate,
    ErodedSpace,
    GrownRooms,
    Edits,
    TopologicalMap,
    Route,
    Coverage,
)
"""All records that runs emit, in this order, with one `Generation` per generation of the search. The ones that a given
pipeline emits are its `records`."""

METHODS: dict[str, dict[str, type]] = {
    "doors": {"paper": ProposeDoors, "wide": ProposeWideDoors},
    "score": {"none": NoScores, "curves": ScoreDoors},
    "cost": {"paper": MapCost, "energy": DoorEnergy},
    "search": {
        "genetic": GeneticSearch,
        "exhaustive": ExhaustiveSearch,
        "annealing": AnnealingSearch,
        "memetic": MemeticSearch,
    },
    "certify": {"none": NoProof, "bound": BoundEnergy},
}
"""Stages with alternative implementations, and these by name."""


class Proposals(NamedTuple):
    """Virtual doors, and the records they were derived from."""

    simplified: SimplifiedGrid
    path: BoundaryPath
    corners: Corners
    doors: VirtualDoors


@dataclass(frozen=True, kw_only=True)
class Pipeline(WithTasks):
    """The method with its settings; the defaults are the paper's."""

    simplify: SimplifyGrid = field(default_factory=SimplifyGrid)
    trace: TraceBoundary = field(default_factory=TraceBoundary)
    curvature: EstimateCurvature = field(default_factory=EstimateCurvature)
    candidates: FindCandidates = field(default_factory=FindCandidates)
    corners: FindCorners = field(default_factory=FindCorners)
    doors: ProposeDoors | ProposeWideDoors = field(default_factory=ProposeDoors)
    score: NoScores | ScoreDoors = field(default_factory=NoScores)
    divide: DivideRooms = field(default_factory=DivideRooms)
    cost: MapCost | DoorEnergy = field(default_factory=MapCost)
    search: GeneticSearch | ExhaustiveSearch | AnnealingSearch | MemeticSearch = field(default_factory=GeneticSearch)
    certify: NoProof | BoundEnergy = field(default_factory=NoProof)
    merge: MergeRooms = field(default_factory=MergeRooms)
    edit: EditRooms = field(default_factory=EditRooms)
    route: FindRoute = field(default_factory=FindRoute)
    cover: CoverFloor = field(default_factory=CoverFloor)

    @property
    def records(self) -> tuple[type[Record], ...]:
        """The records that a run emits, in order."""
        left_out: set[type[Record]] = {Skeleton, CriticalLines, ErodedSpace, GrownRooms}
        left_out |= {task.record for task in self.tasks if not task.asked}
        left_out |= {DoorScores} if isinstance(self.score, NoScores) else set()
        proven = isinstance(self.certify, BoundEnergy) and self.cost.counts_separating
        left_out |= set() if proven else {Certificate}
        left_out |= set() if self.edit.edits else {Edits}
        return tuple(record for record in RECORDS if record not in left_out)

    def __call__(self, grid: OccupancyGrid, rng: np.random.Generator, emit: Emit = silent) -> TopologicalMap:
        """Rooms and doors of `grid`; `emit` is called with every stage's record."""
        opened = self.edit.open_doors(emit(grid))
        simplified, path, corners, doors = self.propose(opened.grid, emit)
        scores = self.score(simplified, path, corners, doors)
        if scores is not None:
            emit(scores)
        initial = emit(self.divide(simplified, path, corners, doors, scores))
        problem = MergeProblem(initial, self.cost, scores)
        best = deque((emit(generation) for generation in self.search(problem, rng)), maxlen=1).pop()
        certificate = self.certify(problem, best)
        if certificate is not None:
            emit(certificate)
        merged = self.merge(opened.grid, simplified, initial, best, problem, path=path)
        topology, edits = self.edit(merged, opened)
        if edits is not None:
            emit(edits)
        return done(self.tasks, grid, emit(topology), emit)

    def propose(self, grid: OccupancyGrid, emit: Emit = silent) -> Proposals:
        """The stages of section II up to the virtual doors."""
        simplified = emit(self.simplify(grid))
        path = emit(self.trace(simplified))
        curvature = emit(self.curvature(path))
        candidates = emit(self.candidates(path, curvature))
        corners = emit(self.corners(path, curvature, candidates))
        doors = emit(self.doors(simplified, path, corners))
        return Proposals(simplified, path, corners, doors)


AnyPipeline = Pipeline | VoronoiDoorsPipeline | ErodedSpacePipeline
"""The method or a baseline: settings by stage, `simplify` first, and `records`."""

PRESETS: dict[str, AnyPipeline] = {
    "paper": Pipeline(),
    "default": Pipeline(
        simplify=SimplifyGrid(
            cell_m=0.0,
            thin_unknown_m=0.1,
            least_part_m2=1.0,
            sill_m=0.2,
            max_island_m=1.0,
            slit_m=0.1,
            channel_m=0.3,
            gap_m=0.2,
        ),
        divide=DivideRooms(in_input=True),
        merge=MergeRooms(passages=False, half_seen_m=0.25, straight_m=0.4, centre_m=1.0),
        doors=ProposeWideDoors(),
        score=ScoreDoors(),
        cost=DoorEnergy(further_bias=1.0),
        search=MemeticSearch(),
        certify=BoundEnergy(),
    ),
    "voronoi-doors": VoronoiDoorsPipeline(),
    "eroded-space": ErodedSpacePipeline(),
}


def preset_named(name: str) -> AnyPipeline:
    """The preset with that name; raises SettingError if there is none."""
    if name not in PRESETS:
        raise SettingError(f"preset: {no_such('preset', name, PRESETS)}")
    return PRESETS[name]


def recorded(info: RunInfo) -> AnyPipeline:
    """The pipeline of a recorded run; based on the paper's if its preset is unknown.

    A recording stores all settings of its version. Settings it lacks were added later and are off, as in the paper.
    """
    preset = PRESETS.get(info.preset, Pipeline())
    base = Pipeline() if isinstance(preset, Pipeline) else preset
    return with_settings(base, info.settings, METHODS, place="recorded settings")


def emitted(info: RunInfo) -> tuple[type[Record], ...]:
    """The records that a recorded run emits; if its settings are invalid, those of its preset."""
    try:
        return recorded(info).records
    except SettingError:
        return PRESETS.get(info.preset, Pipeline()).records
