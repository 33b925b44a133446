"""A fleet on paper: what many maps on many cores would take, from figures that were measured on few."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import psutil

from vdoor.batch.job import Row
from vdoor.engines.cluster import BATCH_S, LEAST_BATCH_S
from vdoor.engines.loopback import loopback_cluster, small_tasks

FILE_OPERATIONS = 11
"""Made, renamed or removed names a map: a folder and four files in it, its new name; a row and its new name; shards."""
PROBES = 1000


@dataclass(frozen=True, kw_only=True)
class Costs:
    """What one map and one task cost, as measured."""

    map_s: float
    """CPU of a worker, which has a core to itself."""
    peak_mb: float
    """Of a worker, at the largest map."""
    result_bytes: float
    row_bytes: float
    """What goes over the network: a row of the table, and the item."""
    task_s: float
    """CPU of the scheduler for one task."""
    start_s: float = 2.0
    """Until a worker has imported what it needs."""


@dataclass(frozen=True, kw_only=True)
class Fleet:
    """What a fleet would take."""

    maps: int
    cores: int
    wall_s: float
    tasks: int
    tasks_per_s: float
    scheduler_busy: float
    """Share of one core; a scheduler is one thread."""
    network_mb_per_s: float
    result_gb: float
    file_operations_per_s: float

    @property
    def breaks_first(self) -> str:
        """The share of what one scheduler, and one file server of 20,000 operations a second, can do."""
        files = self.file_operations_per_s / 20_000
        return f"scheduler {self.scheduler_busy:.0%}, file server {files:.0%}"

    def to_text(self) -> str:
        """Some lines."""
        rate = f"{self.tasks:,} tasks, {self.tasks_per_s:,.1f} a second"
        return "\n".join([
            f"{self.maps:,} maps on {self.cores:,} cores: {self.wall_s:,.0f} s",
            f"  {rate}: {self.scheduler_busy:.1%} of a scheduler's core",
            f"  network to the program: {self.network_mb_per_s:.2f} MB/s; results {self.result_gb:,.1f} GB",
            f"  file system: {self.file_operations_per_s:,.0f} operations a second; in use: {self.breaks_first}",
        ])  # fmt: skip


def fleet(maps: int, cores: int, costs: Costs) -> Fleet:
    """The time is all work by all cores, the start, and half a last batch in which cores wait for the last."""
    wall_s = maps * costs.map_s / cores + costs.start_s + max(LEAST_BATCH_S, costs.map_s) / 2
    per_task = max(1.0, BATCH_S / costs.map_s)
    tasks = int(maps / per_task) + 1
    return Fleet(
        maps=maps,
        cores=cores,
        wall_s=wall_s,
        tasks=tasks,
        tasks_per_s=tasks / wall_s,
        scheduler_busy=tasks / wall_s * costs.task_s,
        network_mb_per_s=maps * costs.row_bytes / wall_s / 1e6,
        result_gb=maps * costs.result_bytes / 1e9,
        file_operations_per_s=maps * FILE_OPERATIONS / wall_s,
    )


def measured_costs(rows: Sequence[Row], out: Path, folder: Path) -> Costs:
    """The costs from rows of a batch in `out`, and from many tasks that do nothing."""
    sizes = [file.stat().st_size for file in out.glob("results/*/*/*")]
    row_sizes = [file.stat().st_size for file in out.glob("rows/*/*")]
    return Costs(
        map_s=sum(row["all_cpu_s"] for row in rows) / len(rows),
        peak_mb=max(row["peak_mb"] for row in rows),
        result_bytes=sum(sizes) / len(rows),
        row_bytes=2 * sum(row_sizes) / len(row_sizes),
        task_s=_task_s(folder),
    )


def _task_s(folder: Path) -> float:
    """CPU of a scheduler for one small task."""
    folder.mkdir(parents=True)
    with loopback_cluster(folder, 1) as there:
        small_tasks(there, 1)
        before_s = _cpu_s(there.scheduler.pid)
        small_tasks(there, PROBES)
        return (_cpu_s(there.scheduler.pid) - before_s) / PROBES


def _cpu_s(process: int) -> float:
    times = psutil.Process(process).cpu_times()
    return float(times.user + times.system)


def lines(costs: Costs, maps: int, wall_s: float) -> Iterator[str]:
    """The costs, the model held against a measured run of two workers, and the model of a large fleet."""
    of_results = f"results {costs.result_bytes / 1000:.1f} kB"
    yield f"a map: {costs.map_s:.3f} s of CPU, {costs.peak_mb:.0f} MB at most, {of_results}"
    yield f"over the network {costs.row_bytes / 1000:.2f} kB a map"
    yield f"scheduler {costs.task_s * 1000:.2f} ms of CPU a task"
    small = fleet(maps, 2, costs)
    apart = f"{small.wall_s / wall_s - 1:+.0%}"
    yield f"model of {maps} maps on 2 cores: {small.wall_s:.1f} s, measured {wall_s:.1f} s: {apart}"
    yield fleet(1_000_000, 1_000, costs).to_text()
