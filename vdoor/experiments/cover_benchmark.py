"""Covering maps room by room against covering them as one: coverage, length, turns, changes of room, CPU time."""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import networkx as nx
import numpy as np

from vdoor.api import prepared
from vdoor.grid import OccupancyGrid
from vdoor.navigate.cover_floor import UNITS, Coverage, CoverFloor
from vdoor.pipeline import AnyPipeline
from vdoor.topology import TopologicalMap

HEADING = (
    f"{'map':36s} {'unit':5s} {'m2':>7s} {'rooms':>5s} {'covered':>8s} {'length m':>9s} {'excess':>7s} {'twice':>6s} "
    f"{'turns/m2':>8s} {'changes':>7s} {'least':>5s} {'clear m':>8s} {'CPU s':>6s}"
)


@dataclass(frozen=True, kw_only=True)
class CoverReport:
    """Figures of one map, or means over several."""

    name: str
    unit: str
    """room or map, see `CoverFloor.unit`."""
    area_m2: float
    """Swept area."""
    rooms: float
    covered: float
    length_m: float
    excess: float
    swept_twice: float
    turns_per_m2: float
    room_changes: float
    least_changes: float
    """The fewest that a closed tour of the swept rooms needs."""
    clear_m: float
    cpu_s: float

    def to_text(self) -> str:
        """One line of a table."""
        return (
            f"{self.name[:36]:36s} {self.unit:5s} {self.area_m2:7.1f} {self.rooms:5.1f} {self.covered:8.4f} "
            f"{self.length_m:9.1f} {self.excess:7.3f} {self.swept_twice:6.3f} {self.turns_per_m2:8.2f} "
            f"{self.room_changes:7.1f} {self.least_changes:5.1f} {self.clear_m:8.4f} {self.cpu_s:6.2f}"
        )


def measured(
    grids: Mapping[str, OccupancyGrid], pipeline: AnyPipeline, cover: CoverFloor, units: Sequence[str] = UNITS
) -> Iterator[CoverReport]:
    """Reports of each map and unit, for paths that return to their start, with the time of `cover` alone."""
    for name, grid in grids.items():
        topology = prepared(pipeline, grid).pipeline(grid, np.random.default_rng(0))
        for unit in units:
            since_s = time.process_time()
            found = dataclasses.replace(cover, unit=unit, end="start")(grid, topology)
            yield _report(name, unit, found, topology, time.process_time() - since_s)


def means(reports: Sequence[CoverReport]) -> list[CoverReport]:
    """The means of all maps, for each unit; of the clearance the least."""
    found = []
    for unit in dict.fromkeys(report.unit for report in reports):
        own = [report for report in reports if report.unit == unit]
        numbers = [field.name for field in dataclasses.fields(CoverReport) if field.name not in {"name", "unit"}]
        mean = {name: float(np.mean([getattr(report, name) for report in own])) for name in numbers}
        mean["clear_m"] = min(report.clear_m for report in own)
        found.append(CoverReport(name=f"mean of {len(own)}", unit=unit, **mean))
    return found


def _report(name: str, unit: str, found: Coverage, topology: TopologicalMap, cpu_s: float) -> CoverReport:
    swept = set(topology.room_ids) - set(found.missed.tolist())
    return CoverReport(
        name=name,
        unit=unit,
        area_m2=found.length_m * found.tool_m / found.excess,
        rooms=len(swept),
        covered=found.covered,
        length_m=found.length_m,
        excess=found.excess,
        swept_twice=found.swept_twice,
        turns_per_m2=found.turns_per_m2,
        room_changes=found.room_changes,
        least_changes=least_changes(topology, swept),
        clear_m=found.clear_m,
        cpu_s=cpu_s,
    )


def least_changes(topology: TopologicalMap, rooms: set[int]) -> int:
    """A bound on the changes of room of a closed tour: each room is entered once, and a room that parts others anew.

    Between the blocks of the graph of rooms there is no way but over one room, so that each block costs as many
    changes as it has rooms, or two if it has two.
    """
    graph = nx.Graph(topology.to_networkx().subgraph(rooms))
    return sum(len(block) for block in nx.biconnected_components(graph))
