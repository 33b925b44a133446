"""A Dask cluster on this machine: a scheduler and workers, each a process of its own, on loopback."""

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

DASK = Path(sys.executable).parent / "dask"
HERE = Path(__file__).parent
QUIET = ("--no-dashboard", "--host", "127.0.0.1")


class Cluster(NamedTuple):
    address: str
    scheduler: subprocess.Popen[bytes]
    workers: list[subprocess.Popen[bytes]]


@contextlib.contextmanager
def cluster(folder: Path, workers: int = 2) -> Iterator[Cluster]:
    """A cluster whose files lie in a folder; all of it is gone afterwards."""
    started: list[subprocess.Popen[bytes]] = []

    def start(*words: str | Path) -> subprocess.Popen[bytes]:
        environment = os.environ | {"PYTHONPATH": str(HERE), "DASK_DISTRIBUTED__SCHEDULER__ALLOWED_FAILURES": "1"}
        log = (folder / f"log{len(started)}").open("wb")
        started.append(subprocess.Popen([DASK, *map(str, words)], stdout=log, stderr=log, env=environment))
        return started[-1]

    try:
        said = folder / "scheduler.json"
        scheduler = start("scheduler", *QUIET, "--port", "0", "--scheduler-file", said)
        address = _address(said)
        own = ("--nthreads", "1", "--no-nanny", "--local-directory", folder)
        yield Cluster(address, scheduler, [start("worker", address, *QUIET, *own) for _ in range(workers)])
    finally:
        for process in reversed(started):
            process.kill()
            process.wait()


def _address(file: Path) -> str:
    for _ in range(300):
        with contextlib.suppress(OSError, ValueError):
            return str(json.loads(file.read_text())["address"])
        time.sleep(0.1)
    raise AssertionError(f"no scheduler: {(file.parent / 'log0').read_text()}")
