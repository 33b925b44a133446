"""What a batch costs beside the method, on each engine, and what is left of it when processes are killed."""

from __future__ import annotations

import os
import resource
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import psutil

from vdoor.batch.job import MEASURED, Recipe, Row, rows_of
from vdoor.batch.report import write_report
from vdoor.batch.sources import Item
from vdoor.batch.table import SCHEMA, table_of, write_tables
from vdoor.engines import Engine, Limits, dask, processes
from vdoor.engines.loopback import loopback_cluster
from vdoor.synth import PRESETS, synthesize, write_synthetic

MANY_ROWS = 100_000
WORKERS = 2
STARTING = 2 * WORKERS
"""Maps from whose end on maps per second are counted, so that start-up is not."""


@dataclass(frozen=True, kw_only=True)
class Rate:
    """One run over all maps."""

    name: str
    maps: int
    maps_per_s: float
    """After the start."""
    method_cpu_s: float
    """Of the method alone, a map."""
    all_cpu_s: float
    """Of all processes, a map, without their start-up."""

    def to_text(self, alone: Rate) -> str:
        """One line, with the rate as a multiple of another run's."""
        over = self.all_cpu_s / self.method_cpu_s - 1
        times = self.maps_per_s / alone.maps_per_s
        return (
            f"{self.name:24s} {self.maps:5d} maps  {self.maps_per_s:7.2f} maps/s  {times:5.2f} x"
            f"  method {self.method_cpu_s * 1000:6.1f} ms CPU a map, all {self.all_cpu_s * 1000:6.1f} ms: {over:+.1%}"
        )


def homes(folder: Path, count: int) -> list[Item]:
    """Synthetic homes, by seeds from 0, written into a folder."""
    for seed in range(count):
        write_synthetic(synthesize(PRESETS["home"], np.random.default_rng(seed)), folder / f"home{seed:05d}", seed=seed)
    return [Item(str(path)) for path in sorted(folder.glob("*.yaml"))]


def rates(items: Sequence[Item], folder: Path) -> Iterator[Rate]:
    """The same maps by one process, two, and a cluster of two."""
    yield _rate("processes, 1 worker", items, folder / "one", processes, Limits(workers=1))
    yield _rate("processes, 2 workers", items, folder / "two", processes, Limits(workers=WORKERS))
    with loopback_cluster(_made(folder / "cluster"), WORKERS) as there:
        limits = Limits(scheduler=there.address)
        yield _rate("dask, 2 workers", items, folder / "dask", dask, limits)


def _rate(name: str, items: Sequence[Item], out: Path, engine: Engine, limits: Limits) -> Rate:
    """One run; CPU is that of this process and of all below it, less what the same costs for no map at all."""
    nothing = [Item(str(out / f"none{number}.npy")) for number in range(8 * WORKERS)]
    start = _cpu_s()
    list(rows_of(nothing, Recipe(batch=out), engine, limits))
    start_cpu_s = (_cpu_s() - start) if engine is processes else 0.0  # a cluster's workers stay as they are
    begin, ends, found = _cpu_s(), [], []
    for row in rows_of(items, Recipe(batch=out), engine, limits):
        ends.append(time.perf_counter())
        found.append(row)
    return Rate(
        name=name,
        maps=len(found),
        maps_per_s=(len(ends) - STARTING) / (ends[-1] - ends[STARTING - 1]),
        method_cpu_s=sum(row["cpu_s"] for row in found) / len(found),
        all_cpu_s=(_cpu_s() - begin - start_cpu_s) / len(found),
    )


def _cpu_s() -> float:
    """CPU seconds of this process, its children that ended, and those that live."""
    ended = resource.getrusage(resource.RUSAGE_CHILDREN)
    living = [process.cpu_times() for process in _below()]
    of_living = sum(times.user + times.system + times.children_user + times.children_system for times in living)
    return float(time.process_time() + ended.ru_utime + ended.ru_stime + of_living)


def _below() -> list[Any]:
    return list(psutil.Process().children(recursive=True))


def _made(folder: Path) -> Path:
    folder.mkdir(parents=True)
    return folder


# --- kills


@dataclass(frozen=True, kw_only=True)
class Killed:
    """What was left after kills."""

    name: str
    kills: int
    whole: int
    """How often all maps were done, none twice in the table, and all results equal to those undisturbed."""
    again: int | None = None
    """Maps that were finished before a kill and done again; None if that was not counted."""

    def to_text(self) -> str:
        """One line."""
        again = "" if self.again is None else f", {self.again} finished maps done again"
        return f"{self.name:44s} {self.whole} of {self.kills} whole{again}"


def kills(items: Sequence[Item], folder: Path, count: int) -> Iterator[Killed]:
    """Kill -9 at a third of the way: a worker process, a worker of a cluster, and the program itself."""
    wanted = _state(folder / "calm", rows_of(items, Recipe(batch=folder / "calm"), processes, Limits(workers=WORKERS)))
    limits = Limits(workers=WORKERS)
    whole = 0
    for number in range(count):
        out = folder / f"worker{number}"
        rows = rows_of(items, Recipe(batch=out), processes, limits)
        whole += _state(out, _disturbed(rows, len(items) // 3, _kill_worker)) == wanted
    yield Killed(name="kill -9 of one of two worker processes", kills=count, whole=whole)
    yield _cluster_kills(items, folder, count, wanted)
    yield _driver_kills(items, folder, count, wanted)


def _cluster_kills(items: Sequence[Item], folder: Path, count: int, wanted: Any) -> Killed:
    whole = 0
    for number in range(count):
        out = folder / f"cluster{number}"
        with loopback_cluster(_made(folder / f"cluster{number}_logs"), WORKERS) as there:
            rows = rows_of(items, Recipe(batch=out), dask, Limits(scheduler=there.address))
            whole += _state(out, _disturbed(rows, len(items) // 3, there.workers[0].kill)) == wanted
    return Killed(name="kill -9 of one of two workers of a cluster", kills=count, whole=whole)


def _driver_kills(items: Sequence[Item], folder: Path, count: int, wanted: Any) -> Killed:
    """Kill `vdoor batch`, let its orphans finish what they have in work, and call it again."""
    whole = again = 0
    for number in range(count):
        out = folder / f"driver{number}"
        words = ["batch", *(item.map for item in items), "--out", str(out), "-j", str(WORKERS)]
        with subprocess.Popen([sys.executable, "-m", "vdoor", *words], stdout=subprocess.PIPE) as driver:  # noqa: S603
            assert driver.stdout is not None
            for _ in range(len(items) // 3):
                driver.stdout.readline()
            driver.kill()
        with _quiet(out):
            finished = {path: path.stat().st_mtime_ns for path in out.glob("results/*/*/map.json")}
        whole += _state(out, rows_of(items, Recipe(batch=out), processes, Limits(workers=WORKERS))) == wanted
        again += sum(path.stat().st_mtime_ns != stamp for path, stamp in finished.items())
    return Killed(name="kill -9 of the program", kills=count, whole=whole, again=again)


@contextmanager
def _quiet(out: Path) -> Iterator[None]:
    """Wait until a killed program's workers, which finish the map they have, are gone."""
    before = -1
    while before != (now := len([*out.glob("results/*/*"), *out.glob("partial/*")])):
        before = now
        time.sleep(2)
    yield


def _disturbed(rows: Iterator[Row], at: int, kill: Callable[[], None]) -> Iterator[Row]:
    for number, row in enumerate(rows):
        if number == at:
            kill()
        yield row


def _kill_worker() -> None:
    """Kill one of the worker processes below this one."""
    workers = [process for process in _below() if any("vdoor.engines.worker" in word for word in process.cmdline())]
    os.kill(workers[0].pid, signal.SIGKILL)


def _state(out: Path, rows: Iterator[Row]) -> tuple[Any, dict[str, bytes]]:
    """The table without what differs from run to run, and the bytes of all results."""
    table = table_of(rows).drop_columns(list(MEASURED)).to_pylist()
    results = {str(path.relative_to(out)): path.read_bytes() for path in out.glob("results/*/*/*")}
    return table, results


# --- the report of many rows


def report_of_many(rows: Sequence[Row], count: int = MANY_ROWS) -> tuple[float, float]:
    """Wall seconds and peak memory in MB of the report of so many rows, drawn from some, in a process of its own."""
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder)
        rng = np.random.default_rng(0)
        write_tables(out, table_of(map(partial(_like, rows, rng), range(count))))
        begin_s = time.perf_counter()
        program = f"from pathlib import Path; from {__name__} import told_peak; told_peak(Path({str(out)!r}))"
        done = subprocess.run([sys.executable, "-c", program], check=True, capture_output=True, text=True)  # noqa: S603
        return time.perf_counter() - begin_s, float(done.stdout)


def told_peak(out: Path) -> None:
    """Write a report, and print this process's peak memory in MB."""
    write_report(out)
    sys.stdout.write(f"{resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024}\n")


def _like(rows: Sequence[Row], rng: np.random.Generator, number: int) -> Row:
    """A row like one of those, by another name, with other times, now and then failed."""
    row = {name: value for name, value in rows[number % len(rows)].items() if name in SCHEMA.names}
    row |= {"map": f"maps/{number:07d}.yaml", "cpu_s": float(row["cpu_s"] * rng.lognormal(0, 0.5))}
    row |= {"door_f1": float(rng.beta(8, 1))}
    if rng.random() < 0.01:  # noqa: PLR2004  # one in a hundred
        return {"map": row["map"], "error_kind": "MapError", "error": f"map: wanted a map, found none: {row['map']}"}
    return row
