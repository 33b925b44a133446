"""What engines have in common: their limits, and what becomes of each item."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import Any, Generic, Protocol, TypeVar

from vdoor.errors import VdoorError

T = TypeVar("T")
R = TypeVar("R")

TRIES = 2
"""How often an item is tried whose worker dies or runs out of memory."""


class WorkerDiedError(VdoorError):
    """A worker that ended while it worked on an item."""


class OutOfMemoryError(VdoorError):
    """An item that needs more memory than a worker may have."""


@dataclass(frozen=True, kw_only=True)
class Limits:
    """What an engine may use."""

    workers: int = 1
    """Processes on this machine; a cluster has as many as it has."""
    memory_mb: int = 0
    """Memory of each worker; 0 = no limit."""
    scheduler: str = ""
    """Address of a cluster's scheduler."""


@dataclass(frozen=True, kw_only=True)
class Ended(Generic[R]):
    """What became of one item."""

    number: int
    """The item's place among all, from 0."""
    result: R | None = None
    error: Exception | None = None
    """Why there is no result."""
    notes: tuple[Warning, ...] = ()
    """Warnings of the work."""

    def taken(self) -> R:
        """The result, its warnings issued again here; raises the error if there is one."""
        for note in self.notes:
            warnings.warn(note, stacklevel=2)
        if self.error is not None:
            raise self.error
        return self.result  # type: ignore[return-value]  # None is a result where the work returns None


Engine = Callable[[Callable[[Any], Any], Iterable[Any], Limits], Iterator[Ended[Any]]]
"""Does `work` on every item, and yields each one's end as it comes. Work, items and results are pickled."""


class Over(Protocol):
    """The signature of the built-in `map`, which is the engine of a single process."""

    def __call__(self, work: Callable[[T], R], items: Iterable[T], /) -> Iterator[R]:
        """Results in the order of the items; the first error is raised."""
        ...


def in_order(endings: Iterable[Ended[R]]) -> Iterator[R]:
    """Results in the order of the items, which may end in any order; raises the error of the first that failed."""
    early: dict[int, Ended[R]] = {}
    following = 0
    for ended in endings:
        early[ended.number] = ended
        while following in early:
            yield early.pop(following).taken()
            following += 1
