"""The records of one run, collected one by one from a recording or from the run itself."""

from __future__ import annotations

from array import array
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from vdoor.baselines import CriticalLines, ErodedSpace, GrownRooms, Skeleton
from vdoor.editing.apply import Edits
from vdoor.errors import RecordingError
from vdoor.grid import OccupancyGrid
from vdoor.method.boundary import BoundaryPath
from vdoor.method.corners import Candidates, Corners
from vdoor.method.curvature import Curvature
from vdoor.method.doors import VirtualDoors
from vdoor.method.initial_map import InitialMap
from vdoor.method.scoring.score import DoorScores
from vdoor.method.search.certificate import Certificate
from vdoor.method.search.generation import Generation
from vdoor.method.simplify import SimplifiedGrid
from vdoor.navigate.cover_floor import Coverage
from vdoor.navigate.find_route import Route
from vdoor.pipeline import RECORDS
from vdoor.record import Record, specs
from vdoor.topology import TopologicalMap

R = TypeVar("R", bound=Record)

STAGES = tuple(record.topic for record in RECORDS)
SEARCH = Generation.topic
RECORD_OF = {record.topic: record for record in RECORDS}


class ConvergenceHistory(Sequence[Generation]):
    """The generations of a search, stored as numbers and packed bit strings; each record is built on access."""

    NUMBERS = tuple(name for name in specs(Generation) if name != "removed")

    def __init__(self) -> None:
        self._numbers = array("d")
        self._packed = bytearray()
        self.edges = 0

    def add(self, generation: Generation) -> None:
        """Append a generation; `RecordingError` if its number of doors differs from that of the others."""
        found = len(generation.removed)
        if len(self) and found != self.edges:
            raise RecordingError(f"generation.removed: wanted {self.edges} doors in each, found {found}")
        self.edges = found
        self._packed += np.packbits(generation.removed).tobytes()
        self._numbers.extend(getattr(generation, name) for name in self.NUMBERS)

    def __len__(self) -> int:
        return len(self._numbers) // len(self.NUMBERS)

    def __getitem__(self, index: int) -> Generation:  # type: ignore[override]  # no slices
        row = range(len(self))[index]
        values: dict[str, Any] = {
            name: int(value) if spec.kind == "count" else float(value)
            for (name, (spec, _)), value in zip(specs(Generation).items(), self._rows[row], strict=False)
        }
        removed = np.unpackbits(self._strings[row], count=self.edges).astype(np.bool_)
        return Generation(**values, removed=removed)

    def numbers(self, name: str) -> NDArray[np.float64]:
        """Values (g,) of a numeric field, one per generation."""
        return self._rows[:, self.NUMBERS.index(name)].copy()

    def choices(self, edge: int) -> NDArray[np.bool_]:
        """Whether the best string of each generation removes an edge: flags (g,)."""
        return np.asarray(self._strings[:, edge // 8] >> (7 - edge % 8) & 1, np.bool_)

    @property
    def _rows(self) -> NDArray[np.float64]:
        return np.frombuffer(self._numbers, np.float64).reshape(len(self), len(self.NUMBERS))

    @property
    def _strings(self) -> NDArray[np.uint8]:
        return np.frombuffer(self._packed, np.uint8).reshape(len(self), -(-self.edges // 8))


@dataclass(frozen=True, kw_only=True)
class RunRecords:
    """Record of each stage by topic, and the search as numbers and packed bit strings. A sink and an `Emit`."""

    records: dict[str, Record] = field(default_factory=dict)
    """Record of each stage by topic, except the search."""
    steps: dict[str, int] = field(default_factory=dict)
    """Step of each stage; for the search, that of the first generation."""
    search: ConvergenceHistory = field(default_factory=ConvergenceHistory)

    def __call__(self, record: R, /) -> R:
        """Add the next record of a run, and return it."""
        self.write(len(self.records) + len(self.search), record)
        return record

    @property
    def place(self) -> str:
        """End of error messages: the file of the records, if they come from one."""
        return ""

    def write(self, step: int, record: Record) -> None:
        """Add a record; `RecordingError` for a second record of a stage other than the search."""
        if record.topic in self.records:
            raise RecordingError(f"step {step}: wanted one record of {record.topic}, found a second{self.place}")
        self.steps.setdefault(record.topic, step)
        if isinstance(record, Generation):
            self.search.add(record)
        else:
            self.records[record.topic] = record

    def close(self) -> None:
        """Nothing to finish."""

    @property
    def stages(self) -> tuple[str, ...]:
        """Topics of the stages that were recorded, in the order of the method."""
        return tuple(topic for topic in STAGES if topic in self.steps)

    def get(self, record: type[R]) -> R:
        """Record of a stage; `RecordingError` if it was not recorded."""
        found = self.records.get(record.topic)
        if not isinstance(found, record):
            raise RecordingError(f"stage {record.topic}: not recorded, the last one is {self.stages[-1]}{self.place}")
        return found

    def has(self, record: type[Record]) -> bool:
        """Whether a stage was recorded."""
        return record.topic in self.steps

    @property
    def input(self) -> OccupancyGrid:
        """Input map."""
        return self.get(OccupancyGrid)

    @property
    def simplified(self) -> SimplifiedGrid:
        """Simplified grid (II.A)."""
        return self.get(SimplifiedGrid)

    @property
    def path(self) -> BoundaryPath:
        """Boundary path (II.B)."""
        return self.get(BoundaryPath)

    @property
    def curvature(self) -> Curvature:
        """Curvature of each sample (eq. 1 to 5)."""
        return self.get(Curvature)

    @property
    def candidates(self) -> Candidates:
        """Candidates for corners, convex or concave (eq. 6)."""
        return self.get(Candidates)

    @property
    def corners(self) -> Corners:
        """Corners: candidates with locally maximal curvature (II.B)."""
        return self.get(Corners)

    @property
    def doors(self) -> VirtualDoors:
        """Virtual doors (II.C)."""
        return self.get(VirtualDoors)

    @property
    def scores(self) -> DoorScores:
        """Door scores, for runs that score doors."""
        return self.get(DoorScores)

    @property
    def initial(self) -> InitialMap:
        """Initial map (II.C), before the search."""
        return self.get(InitialMap)

    @property
    def skeleton(self) -> Skeleton:
        """Skeleton of the free space, of the baseline `voronoi-doors`."""
        return self.get(Skeleton)

    @property
    def critical_lines(self) -> CriticalLines:
        """Narrow places of the skeleton, of the baseline `voronoi-doors`."""
        return self.get(CriticalLines)

    @property
    def eroded(self) -> ErodedSpace:
        """Eroded free space, of the baseline `eroded-space`."""
        return self.get(ErodedSpace)

    @property
    def grown(self) -> GrownRooms:
        """Rooms grown back from the cores, of the baseline `eroded-space`."""
        return self.get(GrownRooms)

    @property
    def certificate(self) -> Certificate:
        """Proof of optimality or gap, for runs that certify the search."""
        return self.get(Certificate)

    @property
    def edits(self) -> Edits:
        """Result of each edit, for runs with edits."""
        return self.get(Edits)

    @property
    def topology(self) -> TopologicalMap:
        """Final topological map."""
        return self.get(TopologicalMap)

    @property
    def route(self) -> Route:
        """Route on the final map, for runs that are asked for one."""
        return self.get(Route)

    @property
    def coverage(self) -> Coverage:
        """Path that covers the floor, for runs that are asked for one."""
        return self.get(Coverage)
