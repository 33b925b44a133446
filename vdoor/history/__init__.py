"""A recorded run in memory: each stage's record, and the search as numbers and packed strings."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from vdoor.baselines import ErodedSpace, GrownRooms, Narrows, Skeleton, VoronoiDoorsPipeline
from vdoor.editing.apply import Edits
from vdoor.emit import RunInfo
from vdoor.errors import RecordingError
from vdoor.grid import OccupancyGrid
from vdoor.history.convergence import Course
from vdoor.method.boundary import BoundaryPath
from vdoor.method.corners import Candidates, Corners
from vdoor.method.curvature import Curvature
from vdoor.method.doors import VirtualDoors
from vdoor.method.final_map import merged
from vdoor.method.initial_map import InitialMap
from vdoor.method.scoring.score import DoorScores
from vdoor.method.search.certificate import Certificate
from vdoor.method.search.costs import Cost, Term
from vdoor.method.search.generation import Generation
from vdoor.method.search.problem import MergeProblem
from vdoor.method.simplify import SimplifiedGrid
from vdoor.pipeline import RECORDS, AnyPipeline, Pipeline, recorded
from vdoor.record import Record
from vdoor.topology import TopologicalMap

R = TypeVar("R", bound=Record)

STAGES = tuple(record.topic for record in RECORDS)
SEARCH = Generation.topic

REFERENCES = (
    ("curvature.cell", "path.cell", None),
    ("candidates.sample", "path.cell", 0),
    ("corners.sample", "path.cell", 0),
    ("path.contour", "path.first", 0),
    ("path.first", "path.cell", 0),
    ("doors.corner_start", "corners.sample", 0),
    ("doors.corner_end", "corners.sample", -1),
    ("doors.line_door", "doors.start", 0),
    ("door_scores.door", "doors.start", 0),
    ("door_scores.rival_a", "door_scores.door", 0),
    ("door_scores.rival_b", "door_scores.door", 0),
    ("initial_map.door", "doors.start", 0),
    ("initial_map.idle_door", "doors.start", 0),
    ("initial_map.border_edge", "initial_map.door", 0),
    ("initial_map.border_region", "initial_map.area_m2", 0),
    ("initial_map.cover_edge", "initial_map.door", 0),
    ("initial_map.cover_atom", "initial_map.atom_area_m2", 0),
    ("generation.removed", "initial_map.door", None),
    ("map.edge", "initial_map.door", -1),
)
"""Columns that count the rows of another: each value from the number given up to the other's length, or, where that
is None, the two are equally long."""


class Recorded(Protocol):
    """A recording that is read as it is iterated over."""

    @property
    def path(self) -> Path:
        """Where it lies."""
        ...

    @property
    def info(self) -> RunInfo:
        """What run it is of."""
        ...

    def __iter__(self) -> Iterator[tuple[int, Record]]:
        """Pairs of step and record."""
        ...


@dataclass(frozen=True)
class History:
    """A run as far as it was recorded."""

    file: Path
    info: RunInfo
    method: AnyPipeline
    """The method with the settings of this run."""
    records: dict[str, Record] = field(default_factory=dict)
    """Every stage's record by its topic, but for the search."""
    steps: dict[str, int] = field(default_factory=dict)
    """Step of every stage, of the first generation for the search."""
    search: Course = field(default_factory=Course)
    damage: str = ""
    """What ended the recording before its end; empty where it is whole."""

    @classmethod
    def read(cls, recording: Recorded) -> History:
        """All of a recording that is whole; `RecordingError` where nothing is, or its records do not fit together."""
        pipeline = recorded(recording.info)
        history = cls(recording.path, recording.info, pipeline)
        damage = ""
        try:
            for step, record in recording:
                history.add(step, record)
        except RecordingError as error:
            damage = str(error)
        if OccupancyGrid.topic not in history.steps:
            raise RecordingError(damage or f"recording: wanted at least a map, found none: {recording.path}")
        if not damage and TopologicalMap.topic not in history.steps:
            damage = f"recording: ends before the final map: {recording.path}"
        history.check()
        return replace(history, damage=damage)

    @property
    def pipeline(self) -> Pipeline:
        """The method with its settings; `RecordingError` for a run of a baseline."""
        if not isinstance(self.method, Pipeline):
            raise RecordingError(f"run: wanted one of the method itself, found preset {self.info.preset}: {self.file}")
        return self.method

    @property
    def cost(self) -> Cost:
        """What a choice of doors costs; `RecordingError` for a run without such a choice."""
        return self.method.cost if isinstance(self.method, VoronoiDoorsPipeline) else self.pipeline.cost

    def terms(self, generation: int) -> tuple[Term, ...]:
        """What the cost of a generation's best string is made of, with the weights for this map."""
        return self.problem.terms(self.search[generation].removed)

    def add(self, step: int, record: Record) -> None:
        """Take one more record; `RecordingError` for a second one of a stage that has but one."""
        if record.topic in self.records:
            raise RecordingError(f"step {step}: a second record of {record.topic}: {self.file}")
        self.steps.setdefault(record.topic, step)
        if isinstance(record, Generation):
            self.search.add(record)
        else:
            self.records[record.topic] = record

    def check(self) -> None:
        """Raise `RecordingError` where a column counts rows that are not there, or two frames should be one."""
        for column, target, lowest in REFERENCES:
            values, rows = self._column(column), self._column(target)
            if values is None or rows is None:
                continue
            good = len(values) == len(rows)
            if lowest is not None:
                good = not len(values) or bool(values.min() >= lowest and values.max() < len(rows))
            if not good:
                raise RecordingError(f"{column}: wanted rows of {target} ({len(rows)}), found others: {self.file}")
        scored, edges = self._column("door_scores.door"), self._column("initial_map.door")
        if scored is not None and edges is not None and not np.isin(edges, scored).all():
            raise RecordingError(f"initial_map.door: wanted doors that have scores, found others: {self.file}")
        bordering = self._column("initial_map.border_edge")
        if bordering is not None and edges is not None and not _each_in_order(bordering, len(edges)):
            raise RecordingError(f"initial_map.border_edge: wanted each edge, in order, found others: {self.file}")
        working = [self.records[topic] for topic in STAGES[1:-1] if topic in self.records]
        frames = {record.frame for record in working if hasattr(record, "frame")}
        if len(frames) > 1:
            raise RecordingError(f"frame: wanted one in all stages before the search, found {len(frames)}: {self.file}")

    def _column(self, name: str) -> NDArray[np.int32] | None:
        topic, _, name = name.partition(".")
        if topic == SEARCH:
            return self.search[0].removed.astype(np.int32) if len(self.search) else None
        values: NDArray[np.int32] | None = getattr(self.records.get(topic), name, None)
        return values

    @property
    def stages(self) -> tuple[str, ...]:
        """Topics of the stages that were recorded, in the order of the method."""
        return tuple(topic for topic in STAGES if topic in self.steps)

    def stage_of(self, step: int) -> tuple[str, int]:
        """Stage that a step belongs to, and which of its records; `RecordingError` for a step that is not there."""
        for topic in self.stages:
            count = len(self.search) if topic == SEARCH else 1
            if self.steps[topic] <= step < self.steps[topic] + count:
                return topic, step - self.steps[topic]
        raise RecordingError(f"step: wanted 0 to {self.last_step}, found {step}: {self.file}")

    @property
    def last_step(self) -> int:
        """Step of the last record."""
        topic = self.stages[-1]
        return self.steps[topic] + (len(self.search) - 1 if topic == SEARCH else 0)

    def get(self, record: type[R]) -> R:
        """One stage's record; `RecordingError` where the recording ends before it."""
        found = self.records.get(record.topic)
        if not isinstance(found, record):
            raise RecordingError(f"stage {record.topic}: not recorded, the last one is {self.stages[-1]}: {self.file}")
        return found

    def has(self, record: type[Record]) -> bool:
        """Whether a stage was recorded."""
        return record.topic in self.steps

    @property
    def input(self) -> OccupancyGrid:
        """The map as read."""
        return self.get(OccupancyGrid)

    @property
    def simplified(self) -> SimplifiedGrid:
        """Section II.A."""
        return self.get(SimplifiedGrid)

    @property
    def path(self) -> BoundaryPath:
        """Section II.B."""
        return self.get(BoundaryPath)

    @property
    def curvature(self) -> Curvature:
        """Eq. 1 to 5."""
        return self.get(Curvature)

    @property
    def candidates(self) -> Candidates:
        """Eq. 6."""
        return self.get(Candidates)

    @property
    def corners(self) -> Corners:
        """Local maxima of curvature."""
        return self.get(Corners)

    @property
    def doors(self) -> VirtualDoors:
        """Section II.C."""
        return self.get(VirtualDoors)

    @property
    def scores(self) -> DoorScores:
        """What speaks for and against each door, where that was asked."""
        return self.get(DoorScores)

    @property
    def initial(self) -> InitialMap:
        """The map before the search."""
        return self.get(InitialMap)

    @property
    def skeleton(self) -> Skeleton:
        """Of the baseline `voronoi-doors`, as the next."""
        return self.get(Skeleton)

    @property
    def narrows(self) -> Narrows:
        """Narrow places of the skeleton."""
        return self.get(Narrows)

    @property
    def eroded(self) -> ErodedSpace:
        """Of the baseline `eroded-space`, as the next."""
        return self.get(ErodedSpace)

    @property
    def grown(self) -> GrownRooms:
        """Rooms that the cores grew to."""
        return self.get(GrownRooms)

    @property
    def certificate(self) -> Certificate:
        """What was proven of the search's choice, where that was asked."""
        return self.get(Certificate)

    @property
    def edits(self) -> Edits:
        """What came of each edit, where there were any."""
        return self.get(Edits)

    @property
    def topology(self) -> TopologicalMap:
        """The result."""
        return self.get(TopologicalMap)

    @cached_property
    def problem(self) -> MergeProblem:
        """What the search worked on."""
        return MergeProblem(self.initial, self.cost, self.scores if self.has(DoorScores) else None)

    @cached_property
    def edge_of_door(self) -> dict[int, int]:
        """Edge of the initial map of each door that is one."""
        return {door: edge for edge, door in enumerate(self.initial.door.tolist())}

    @cached_property
    def separating(self) -> frozenset[int]:
        """Edges that part two rooms of the working grid in the end."""
        _, rows = merged(self.problem, self.search[-1].removed)
        return frozenset(edge for edge, _, _ in rows)


def _each_in_order(values: NDArray[np.int32], count: int) -> bool:
    """Whether values (k,) ascend from 0 to `count` - 1 and leave none out."""
    return bool((np.diff(values, prepend=-1, append=count) <= 1).all() and (np.diff(values) >= 0).all())
