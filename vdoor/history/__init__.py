"""A recorded run in memory: the record of each stage, and the search as numbers and packed bit strings."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from vdoor.baselines import VoronoiDoorsPipeline
from vdoor.emit import RunInfo
from vdoor.errors import RecordingError
from vdoor.grid import OccupancyGrid
from vdoor.history.records import SEARCH, STAGES, RunRecords
from vdoor.method.final_map import merged
from vdoor.method.scoring.score import DoorScores
from vdoor.method.search.costs import Cost, Term
from vdoor.method.search.problem import MergeProblem
from vdoor.pipeline import RECORDS, AnyPipeline, Pipeline, recorded
from vdoor.record import Record, specs
from vdoor.topology import TopologicalMap

REFERENCES = tuple(
    (f"{record.topic}.{name}", spec) for record in RECORDS for name, (spec, _) in specs(record).items() if spec.of
)
"""Columns whose values are row numbers of a table."""


__all__ = ["SEARCH", "STAGES", "History", "Recorded", "RunRecords"]


class Recorded(Protocol):
    """A recording that is read during iteration."""

    @property
    def path(self) -> Path:
        """Path of the file."""
        ...

    @property
    def info(self) -> RunInfo:
        """Information on the recorded run."""
        ...

    def __iter__(self) -> Iterator[tuple[int, Record]]:
        """Pairs of step and record."""
        ...


@dataclass(frozen=True, kw_only=True)
class History(RunRecords):
    """All that a recording contains of a run."""

    file: Path
    info: RunInfo
    method: AnyPipeline
    """The method with the settings of this run."""
    damage: str = ""
    """Why the recording ends early; empty if it is complete."""

    @classmethod
    def read(cls, recording: Recorded) -> History:
        """Intact part of a recording; `RecordingError` if it has no map or its records do not fit together."""
        pipeline = recorded(recording.info)
        history = cls(file=recording.path, info=recording.info, method=pipeline)
        damage = ""
        try:
            for step, record in recording:
                history.write(step, record)
        except RecordingError as error:
            damage = str(error)
        if OccupancyGrid.topic not in history.steps:
            raise RecordingError(damage or f"recording: wanted at least a map, found none: {recording.path}")
        if not damage and TopologicalMap.topic not in history.steps:
            damage = f"recording: ends before the final map: {recording.path}"
        history.check()
        return replace(history, damage=damage)

    @property
    def place(self) -> str:
        """End of error messages: the recording's path."""
        return f": {self.file}"

    @property
    def pipeline(self) -> Pipeline:
        """The method with its settings; `RecordingError` for a run of a baseline."""
        if not isinstance(self.method, Pipeline):
            raise RecordingError(f"run: wanted one of the method itself, found preset {self.info.preset}{self.place}")
        return self.method

    @property
    def cost(self) -> Cost:
        """Cost function of the search; `RecordingError` for a run without a search."""
        return self.method.cost if isinstance(self.method, VoronoiDoorsPipeline) else self.pipeline.cost

    def terms(self, generation: int) -> tuple[Term, ...]:
        """Terms of the cost of a generation's best string, with the weights for this map."""
        return self.problem.terms(self.search[generation].removed)

    def check(self) -> None:
        """Raise `RecordingError` if a column refers to missing rows, or if frames differ that must be equal."""
        for column, spec in REFERENCES:
            values, rows = self._column(column), self._column(spec.of)
            if values is None or rows is None:
                continue
            good = len(values) == len(rows)
            if spec.kind == "column":
                good = not len(values) or bool(values.min() >= -spec.or_none and values.max() < len(rows))
            if not good:
                raise RecordingError(f"{column}: wanted rows of {spec.of} ({len(rows)}), found others{self.place}")
        scored, edges = self._column("door_scores.door"), self._column("initial_map.door")
        if scored is not None and edges is not None and not np.isin(edges, scored).all():
            raise RecordingError(f"initial_map.door: wanted doors that have scores, found others{self.place}")
        bordering = self._column("initial_map.border_edge")
        if bordering is not None and edges is not None and not _each_in_order(bordering, len(edges)):
            raise RecordingError(f"initial_map.border_edge: wanted each edge, in order, found others{self.place}")
        working = [
            self.records[topic] for topic in STAGES[1 : STAGES.index(TopologicalMap.topic)] if topic in self.records
        ]
        frames = {record.frame for record in working if hasattr(record, "frame")}
        if len(frames) > 1:
            raise RecordingError(f"frame: wanted one in all stages before the search, found {len(frames)}{self.place}")

    def _column(self, name: str) -> NDArray[np.int32] | None:
        topic, _, name = name.partition(".")
        if topic == SEARCH:
            return self.search[0].removed.astype(np.int32) if len(self.search) else None
        values: NDArray[np.int32] | None = getattr(self.records.get(topic), name, None)
        return values

    def stage_of(self, step: int) -> tuple[str, int]:
        """Stage that a step belongs to, and the index among its records; `RecordingError` for an unrecorded step."""
        for topic in self.stages:
            count = len(self.search) if topic == SEARCH else 1
            if self.steps[topic] <= step < self.steps[topic] + count:
                return topic, step - self.steps[topic]
        raise RecordingError(f"step: wanted 0 to {self.last_step}, found {step}{self.place}")

    @property
    def last_step(self) -> int:
        """Step of the last record."""
        topic = self.stages[-1]
        return self.steps[topic] + (len(self.search) - 1 if topic == SEARCH else 0)

    @cached_property
    def problem(self) -> MergeProblem:
        """The optimisation problem that the search solved."""
        return MergeProblem(self.initial, self.cost, self.scores if self.has(DoorScores) else None)

    @cached_property
    def edge_of_door(self) -> dict[int, int]:
        """Edge of the initial map by door, for the doors that are edges."""
        return {door: edge for edge, door in enumerate(self.initial.door.tolist())}

    @cached_property
    def separating(self) -> frozenset[int]:
        """Edges that separate two rooms of the working grid in the final map."""
        _, rows = merged(self.problem, self.search[-1].removed)
        return frozenset(edge for edge, _, _ in rows)


def _each_in_order(values: NDArray[np.int32], count: int) -> bool:
    """Whether the sorted values (k,) run from 0 to `count` - 1 without a gap."""
    return bool((np.diff(values, prepend=-1, append=count) <= 1).all() and (np.diff(values) >= 0).all())
