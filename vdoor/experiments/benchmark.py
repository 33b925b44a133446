"""CPU time of the method, stage by stage, and the overhead of recording."""

from __future__ import annotations

import json
import resource
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from vdoor.api import prepared
from vdoor.emit import Emit, Recorder, RunInfo, Sink, Stopwatch, silent
from vdoor.grid import FREE, UNKNOWN, OccupancyGrid
from vdoor.method.simplify import SimplifyGrid
from vdoor.pipeline import AnyPipeline
from vdoor.raster.morphology import counted, distances
from vdoor.synth import PRESETS, synthesize

OpenRecordings = Callable[[Path, RunInfo], AbstractContextManager[Sequence[Sink]]]
"""Opens both recordings of a run in a folder."""
LANE_M = 1.0
REPEATS = 5
"""The median of so many reference loops is reported."""


@dataclass(frozen=True, kw_only=True)
class Report:
    """Figures of one map, without imports and reading the map."""

    name: str
    cells: tuple[int, int]
    rooms: int
    doors: int
    stages_s: Mapping[str, float]
    total_s: float
    reference_s: float
    """CPU time of a fixed loop on the same map, by which figures of busy or other machines can be compared."""
    peak_mb: float
    """Peak memory of the process so far."""
    recording_adds: float | None
    """CPU time of both recordings relative to that of the method; None if not measured."""

    def to_json(self) -> str:
        """All figures as one line of JSON."""
        return json.dumps(asdict(self))

    def to_text(self) -> str:
        """All figures as a small table."""
        lines = [f"{self.name}: {self.cells[1]} x {self.cells[0]} cells, {self.rooms} rooms, {self.doors} doors"]
        lines += [f"  {stage:12s} {seconds:8.3f} s" for stage, seconds in self.stages_s.items()]
        lines.append(f"  {'total':12s} {self.total_s:8.3f} s CPU, peak {self.peak_mb:.0f} MB")
        times = f"{self.total_s / self.reference_s:.1f} times one labelling and exact distance pass"
        lines.append(f"  {'reference':12s} {self.reference_s:8.3f} s CPU: the total is {times}")
        if self.recording_adds is not None:
            lines.append(f"  recording to .rrd and .mcap adds {self.recording_adds:.0%}")
        return "\n".join(lines)


def measured(
    grids: Mapping[str, OccupancyGrid], pipeline: AnyPipeline, *, tile: int, record: OpenRecordings | None
) -> Iterator[Report]:
    """Reports of runs on each map, after a warm-up run on a small one; with `record`, each map runs a second time."""
    for grid in own_maps().values():
        pipeline(grid, np.random.default_rng(0), silent)
    for name, single in grids.items():
        grid = tiled(single, tile)
        ready = prepared(pipeline, grid).pipeline
        watch = Stopwatch(silent)
        start_s = time.process_time()
        topology = ready(grid, np.random.default_rng(0), watch)
        total_s = time.process_time() - start_s
        peak_mb = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
        loop_s = reference_s(grid)
        adds = (recorded_s(grid, ready, record) - total_s) / total_s if record else None
        yield Report(
            name=name,
            cells=(grid.frame.height, grid.frame.width),
            rooms=len(topology.area_m2),
            doors=len(topology.kind),
            stages_s=watch.cpu_s,
            total_s=total_s,
            reference_s=loop_s,
            peak_mb=peak_mb,
            recording_adds=adds,
        )


def reference_s(grid: OccupancyGrid) -> float:
    """CPU seconds of one labelling and one exact distance pass of OpenCV over the free cells, the median of five."""
    free, found = grid.free, []
    for _ in range(REPEATS):
        start_s = time.process_time()
        counted(free)
        distances(free)
        found.append(time.process_time() - start_s)
    return max(float(np.median(found)), sys.float_info.epsilon)


def recorded_s(grid: OccupancyGrid, pipeline: AnyPipeline, record: OpenRecordings) -> float:
    """CPU seconds of a run with both recordings, without opening the files and its imports."""
    info = RunInfo(version="", preset="bench", seed=0, settings={}, source=grid.source)
    with tempfile.TemporaryDirectory() as folder:
        with record(Path(folder), info) as sinks:
            emit: Emit = Recorder(sinks)
            start_s = time.process_time()
            pipeline(grid, np.random.default_rng(0), emit)
        return time.process_time() - start_s


def own_maps() -> dict[str, OccupancyGrid]:
    """A synthetic apartment at 5 cm."""
    return {"synthetic apartment, seed 0": synthesize(PRESETS["paper-5cm"], np.random.default_rng(0)).grid}


def tiled(grid: OccupancyGrid, count: int) -> OccupancyGrid:
    """The map repeated `count` x `count` times, with free lanes between the reachable spaces of adjacent copies."""
    if count == 1:
        return grid
    reachable = np.argwhere(SimplifyGrid(cell_m=0.0)(grid).cells == FREE)
    lane = max(1, round(LANE_M / grid.frame.resolution_m))
    height, width = (side + lane for side in grid.cells.shape)
    cells = np.full((height * count, width * count), UNKNOWN, np.int8)
    for row, col in np.ndindex(count, count):
        cells[row * height : row * height + height - lane, col * width : col * width + width - lane] = grid.cells
    top, bottom = reachable[0], reachable[-1]
    left, right = reachable[reachable[:, 1].argmin()], reachable[reachable[:, 1].argmax()]
    for row, col in np.ndindex(count, count):
        corner = np.array([row * height, col * width])
        if col + 1 < count:
            _lane(cells, corner + right, corner + left + [0, width], lane, turn=(row * height, corner[1] + width))
        if row + 1 < count:
            _lane(
                cells.T,
                (corner + bottom)[::-1],
                (corner + top + [height, 0])[::-1],
                lane,
                turn=(col * width, corner[0] + height),
            )
    return OccupancyGrid.from_array(cells, grid.frame.resolution_m)


def _lane(cells: np.ndarray, start: np.ndarray, end: np.ndarray, lane: int, *, turn: tuple[int, int]) -> None:
    """Free a lane that leaves `start` to the right, turns in the gap before column `turn[1]`, and enters at `end`."""
    first, last = turn[1] - lane, turn[1]

    def across(row: int) -> slice:
        return slice(max(turn[0], row - lane // 2), row - lane // 2 + lane)

    cells[across(start[0]), start[1] : last] = FREE
    cells[across(end[0]), first : end[1] + 1] = FREE
    low, high = sorted((int(start[0]), int(end[0])))
    cells[across(low).start : across(high).stop, first:last] = FREE
