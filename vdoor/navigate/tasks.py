"""What robots are asked to do on a finished map: further stages of a run, each off until its settings ask for it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

from vdoor.emit import Emit
from vdoor.grid import Annotations, OccupancyGrid
from vdoor.navigate.cover_floor import CoverFloor
from vdoor.navigate.find_route import FindRoute
from vdoor.navigate.room_table import Tables
from vdoor.record import Record
from vdoor.topology import TopologicalMap


class Task(Protocol):
    """A stage that works on the finished map and the input; a frozen dataclass of its settings."""

    @property
    def asked(self) -> bool:
        """Whether the settings ask for it."""
        ...

    @property
    def record(self) -> type[Record]:
        """What it returns."""
        ...

    def __call__(self, grid: OccupancyGrid, topology: TopologicalMap) -> Record:
        """The result; raises `SettingError` for settings that do not fit the map."""
        ...

    def found(
        self,
        grid: OccupancyGrid,
        topology: TopologicalMap,
        annotations: Annotations | None = None,
        tables: Tables | None = None,
    ) -> Record:
        """The result with restrictions that are known; `tables` holds distances of earlier queries."""
        ...


class WithTasks:
    """What pipelines have in common: each has a field for every task."""

    route: FindRoute
    cover: CoverFloor

    @property
    def tasks(self) -> tuple[Task, ...]:
        """The stages after the final map, most of them not asked for."""
        return (self.route, self.cover)


def records_of(tasks: Sequence[Task]) -> tuple[type[Record], ...]:
    """The records of the tasks that are asked for."""
    return tuple(task.record for task in tasks if task.asked)


def done(tasks: Sequence[Task], grid: OccupancyGrid, topology: TopologicalMap, emit: Emit) -> TopologicalMap:
    """The map, after the tasks that are asked for."""
    for task in tasks:
        if task.asked:
            emit(task(grid, topology))
    return topology
