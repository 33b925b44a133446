"""A Dask cluster on this machine, for tests and measurements: each part a process of its own, on loopback."""

from __future__ import annotations

import contextlib
import json
import os
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from vdoor.errors import VdoorError

QUIET = ("--no-dashboard", "--dashboard-address", "127.0.0.1:0", "--host", "127.0.0.1")
"""Without a dashboard there is a small server for status all the same, which would listen on all addresses."""
SETTINGS = {
    "DASK_DISTRIBUTED__SCHEDULER__ALLOWED_FAILURES": "1",
    "DASK_DISTRIBUTED__WORKER__PROFILE__ENABLED": "False",  # it stops each worker a hundred times a second
    "DASK_DISTRIBUTED__ADMIN__TICK__INTERVAL": "1s",  # 20 ms otherwise
}
WAIT_S = 60.0


class Cluster(NamedTuple):
    """A running cluster."""

    address: str
    scheduler: subprocess.Popen[bytes]
    workers: list[subprocess.Popen[bytes]]


@contextlib.contextmanager
def loopback_cluster(folder: Path, workers: int = 2) -> Iterator[Cluster]:
    """A scheduler and workers of one thread each, whose files lie in `folder`; all are gone afterwards."""
    started: list[subprocess.Popen[bytes]] = []

    def start(part: str, *words: str | Path) -> subprocess.Popen[bytes]:
        command = [sys.executable, "-m", f"distributed.cli.dask_{part}", *map(str, words), *QUIET]
        with (folder / f"{part}{len(started)}.log").open("wb") as log:
            started.append(subprocess.Popen(command, stdout=log, stderr=log, env=os.environ | SETTINGS))  # noqa: S603
        return started[-1]

    try:
        said = folder / "scheduler.json"
        scheduler = start("scheduler", "--port", "0", "--scheduler-file", said)
        address = _address(said)
        own = ("--nthreads", "1", "--no-nanny", "--local-directory", folder)
        yield Cluster(address, scheduler, [start("worker", address, *own) for _ in range(workers)])
    finally:
        for process in reversed(started):
            process.kill()
            process.wait()


def _address(file: Path) -> str:
    """The scheduler's address, once it has said it; raises `VdoorError` if it does not."""
    until_s = time.monotonic() + WAIT_S
    while time.monotonic() < until_s:
        with contextlib.suppress(OSError, ValueError):
            return str(json.loads(file.read_text(encoding="utf-8"))["address"])
        time.sleep(0.1)
    raise VdoorError(f"cluster: wanted a scheduler within {WAIT_S:g} s, found none: {file}")


def small_tasks(cluster: Cluster, count: int) -> None:
    """Have so many tasks done that take no time, to see what a task costs."""
    from distributed import Client  # noqa: PLC0415  # an extra

    with Client(cluster.address, set_as_default=False) as client:
        client.gather([client.submit(pow, number, 2, pure=False) for number in range(count)])
