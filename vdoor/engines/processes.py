"""The engine of one machine: a pool of worker processes, each of which may die without harm to the others."""

from __future__ import annotations

import pickle
import subprocess
import sys
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from multiprocessing import Pipe
from multiprocessing.connection import wait
from types import TracebackType
from typing import Any, Self, TypeVar

from vdoor.engines.endings import TRIES, Ended, Limits, OutOfMemoryError, Over, WorkerDiedError, in_order
from vdoor.engines.worker import Reply

T = TypeVar("T")
R = TypeVar("R")
STDERR = 2
PROGRAM = "from multiprocessing.connection import Connection as C; from vdoor.engines.worker import serve; serve(C({}))"


def processes(work: Callable[[T], R], items: Iterable[T], limits: Limits) -> Iterator[Ended[R]]:
    """The engine: every item in one of `limits.workers` processes of this machine."""
    with Pool(limits) as pool:
        yield from pool.ended(work, items)


@contextmanager
def over(workers: int) -> Iterator[Over]:
    """A `map` over items with so many at work at a time; with one, the built-in `map` in this process."""
    if workers == 1:
        yield map
        return
    with Pool(Limits(workers=workers)) as pool:
        yield pool.map


@dataclass
class _Task:
    """An item on its way: its number, its work and itself as bytes, and how often it was tried."""

    number: int
    work: bytes
    item: bytes
    tries: int = 0


class Pool:
    """Worker processes, started when there is work for them; they keep what they imported from call to call."""

    def __init__(self, limits: Limits) -> None:
        self._limits = limits
        self._idle: list[_Worker] = []

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self.close()

    def close(self) -> None:
        """End all workers."""
        while self._idle:
            self._idle.pop().end()

    def map(self, work: Callable[[T], R], items: Iterable[T], /) -> Iterator[R]:
        """Results in the order of the items; raises the first error."""
        return in_order(self.ended(work, items))

    def ended(self, work: Callable[[T], R], items: Iterable[T]) -> Iterator[Ended[R]]:
        """The end of each item, in the order in which they come."""
        return self.ended_packed(pickle.dumps(work), map(pickle.dumps, items))

    def ended_packed(self, work: bytes, items: Iterable[bytes]) -> Iterator[Ended[Any]]:
        """The same for what is pickled already: only the workers need to know what is inside."""
        todo = (_Task(number, work, item) for number, item in enumerate(items))
        again: deque[_Task] = deque()
        busy: dict[Any, tuple[_Worker, _Task]] = {}
        try:
            while True:
                while len(busy) < self._limits.workers and (task := again.popleft() if again else next(todo, None)):
                    worker = self._given(task)
                    busy[worker.pipe] = worker, task
                if not busy:
                    return
                for pipe in wait(list(busy)):
                    reply = self._reply(*busy[pipe])
                    _, task = busy.pop(pipe)
                    if isinstance(reply.error, OutOfMemoryError | WorkerDiedError) and task.tries < TRIES:
                        again.append(task)
                    else:
                        yield Ended(number=task.number, result=reply.result, error=reply.error, notes=reply.notes)
        finally:
            for worker, _ in busy.values():
                worker.end()

    def _given(self, task: _Task) -> _Worker:
        """A worker that has been given the task: an idle one that lives, or a new one."""
        while self._idle and not self._idle[-1].lives:
            self._idle.pop().end()
        worker = self._idle.pop() if self._idle else _Worker(self._limits.memory_mb)
        task.tries += 1
        worker.give(task)
        return worker

    def _reply(self, worker: _Worker, task: _Task) -> Reply:
        """The worker's reply to a task; the worker is idle after it, or gone."""
        try:
            reply = worker.reply()
        except (EOFError, OSError):
            ended = f"its process ended with code {worker.end()}, at try {task.tries} of {TRIES}"
            return Reply(error=WorkerDiedError(f"worker: wanted a result, found that {ended}"))
        if isinstance(reply.error, MemoryError):
            worker.end()
            limit = f"{self._limits.memory_mb} MB" if self._limits.memory_mb else "there is"
            return Reply(error=OutOfMemoryError(f"memory: wanted no more than {limit}, found work that needs more"))
        self._idle.append(worker)
        return reply


class _Worker:
    """A worker process, and our end of its pipe."""

    def __init__(self, memory_mb: int) -> None:
        self.pipe, theirs = Pipe()
        number = theirs.fileno()
        command = [sys.executable, "-c", PROGRAM.format(number)]
        # What a library prints must not get among the results on stdout.
        self._process = subprocess.Popen(command, pass_fds=[number], stdin=subprocess.DEVNULL, stdout=STDERR)  # noqa: S603
        theirs.close()
        with suppress(OSError):  # a worker that died at once is noticed when it should reply
            self.pipe.send((sys.path, memory_mb))

    @property
    def lives(self) -> bool:
        """Whether the process is still there."""
        return self._process.poll() is None

    def give(self, task: _Task) -> None:
        """Send a task; that the worker is gone is noticed when it should reply."""
        with suppress(OSError):
            self.pipe.send_bytes(task.work)
            self.pipe.send_bytes(task.item)

    def reply(self) -> Reply:
        """Wait for the reply; raises EOFError or OSError if the worker dies before."""
        return pickle.loads(self.pipe.recv_bytes())  # type: ignore[no-any-return]  # noqa: S301  # our own worker

    def end(self) -> int:
        """Kill the process if it lives; its exit code."""
        self.pipe.close()
        self._process.kill()
        return self._process.wait()
