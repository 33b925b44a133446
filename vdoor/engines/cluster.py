"""The engine of a Dask cluster: batches of items go to its workers, each of which does them as `processes` does.

A worker of the cluster keeps a process beside it for the work. So an item that dies or runs out of memory costs that
process alone, as on a laptop, and the cluster's own worker stays free to answer its scheduler.
"""

from __future__ import annotations

import dataclasses
import logging
import pickle
import threading
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from itertools import islice
from typing import Any, NamedTuple, TypeVar

from vdoor.engines.endings import Ended, Limits, WorkerDiedError
from vdoor.engines.processes import Pool
from vdoor.errors import SettingError, VdoorError

T = TypeVar("T")
R = TypeVar("R")
Numbered = tuple[int, Any]

CONNECT_S = 10
"""How long to wait for the scheduler, and for a first worker."""
BATCH_S = 10.0
"""Work in a batch, where there is much left to do: a scheduler starts hundreds of tasks a second, not more."""
LEAST_BATCH_S = 0.5
AHEAD = 2
"""Batches given for each thread of a worker, so that none waits for the network."""


class Done(NamedTuple):
    """What a worker of the cluster sends back of a batch."""

    endings: list[Ended[Any]]
    """Numbered from 0 within the batch."""
    wall_s: float


def dask(work: Callable[[T], R], items: Iterable[T], limits: Limits) -> Iterator[Ended[R]]:
    """The engine: every item on a worker of the Dask cluster at `limits.scheduler`.

    Raises `VdoorError` if there is no scheduler, or if it is lost.
    """
    client = _client(limits.scheduler)
    try:
        yield from _Course(client, work, list(enumerate(items)), limits).endings()
    finally:
        client.close(timeout=1)


def _client(scheduler: str) -> Any:
    """A client of the scheduler, which has a worker; raises `VdoorError` if that cannot be had."""
    if not scheduler:
        raise SettingError("--engine dask: wanted --scheduler with it, such as tcp://127.0.0.1:8786, found none")
    try:
        from distributed import Client  # noqa: PLC0415  # an extra
    except ImportError as error:
        raise VdoorError("--engine dask: wanted the package distributed (pip install 'vdoor[cluster]')") from error
    _quiet()
    try:
        client = Client(scheduler, timeout=CONNECT_S, set_as_default=False)
        client.wait_for_workers(1, timeout=CONNECT_S)
    except (OSError, ValueError) as error:
        found = error or "no worker"
        raise VdoorError(f"scheduler: wanted one with workers, found none ({found}): {scheduler}") from error
    return client


def _quiet() -> None:
    """Keep Distributed from saying in pages what we say in a line; some of its loggers have levels of their own."""
    for name in ("distributed", *logging.root.manager.loggerDict):
        if name.partition(".")[0] == "distributed":
            logging.getLogger(name).setLevel(logging.CRITICAL)


class _Course:
    """Items on their way through a cluster: how many are in a batch follows from how long they take."""

    def __init__(self, client: Any, work: Callable[[Any], Any], items: Sequence[Numbered], limits: Limits) -> None:
        self._client, self._limits = client, limits
        self._work = pickle.dumps(work)
        """As bytes, into which the scheduler does not look."""
        self._left, self._items = len(items), iter(items)
        self._item_s = BATCH_S
        """Seconds an item takes; not known at first, so that batches begin small."""
        self._given: dict[Any, list[Numbered]] = {}

    def endings(self) -> Iterator[Ended[Any]]:
        """The end of each item; raises `VdoorError` when the scheduler is lost."""
        from distributed import as_completed  # noqa: PLC0415

        coming = as_completed(loop=self._client.loop)
        self._give(coming)
        while self._given:
            for future in next(coming.batches()):
                batch = self._given.pop(future)
                yield from self._ended(future, batch)
            self._give(coming)

    def _ended(self, future: Any, batch: list[Numbered]) -> Iterator[Ended[Any]]:
        """The end of each item of a batch; those of a batch that killed its workers have died."""
        from distributed import KilledWorker  # noqa: PLC0415
        from distributed.comm.core import CommClosedError  # noqa: PLC0415

        if future.status in ("lost", "cancelled"):
            raise self._lost()
        try:
            done: Done = future.result()
        except CommClosedError as error:  # while the result was fetched
            raise self._lost() from error
        except KilledWorker as error:
            died = WorkerDiedError(f"cluster: wanted a result, found that its workers ended ({error})")
            done = Done([Ended(number=number, error=died) for number in range(len(batch))], BATCH_S)
        self._item_s = done.wall_s / len(batch)
        yield from (dataclasses.replace(ended, number=batch[ended.number][0]) for ended in done.endings)

    def _lost(self) -> VdoorError:
        hint = "the same command goes on where it was"
        return VdoorError(f"scheduler: wanted an answer, found that it is lost; {hint}: {self._limits.scheduler}")

    def _give(self, coming: Any) -> None:
        """Give batches to the cluster until every thread has some ahead."""
        threads = max(1, self._client.scheduler_info(n_workers=0)["total_threads"])
        while len(self._given) < AHEAD * threads and (batch := list(islice(self._items, self._size(threads)))):
            self._left -= len(batch)
            items = [pickle.dumps(item) for _, item in batch]
            future = self._client.submit(_done, self._work, items, self._limits.memory_mb, pure=False)
            self._given[future] = batch
            coming.add(future)

    def _size(self, threads: int) -> int:
        """Items in the next batch: for some seconds, and fewer towards the end, so that all threads end together."""
        share_s = self._left * self._item_s / (AHEAD * AHEAD * threads)
        return max(1, int(min(BATCH_S, max(LEAST_BATCH_S, share_s)) / self._item_s))


_own = threading.local()
"""The process beside each thread of a worker of the cluster."""


def _done(work: bytes, items: list[bytes], memory_mb: int) -> Done:
    """Do a batch, on a worker of the cluster."""
    if getattr(_own, "memory_mb", None) != memory_mb:
        _own.pool, _own.memory_mb = Pool(Limits(memory_mb=memory_mb)), memory_mb
    begin_s = time.perf_counter()
    endings = list(_own.pool.ended_packed(work, items))
    return Done(endings, time.perf_counter() - begin_s)
