"""A worker process: does one item after the other, so that imports are done once a worker.

It is a plain program at the end of a pipe, not a child of `multiprocessing`: the workers of a Dask cluster may have no
such children. It ends when its pipe does.
"""

from __future__ import annotations

import contextlib
import functools
import pickle
import resource
import signal
import sys
import traceback
import warnings
from multiprocessing.connection import Connection
from typing import Any, NamedTuple

BYTES_PER_MB = 1024 * 1024


class Reply(NamedTuple):
    """Result of one item, or the error that it ended with, and the warnings on the way."""

    result: Any = None
    error: Exception | None = None
    notes: tuple[Warning, ...] = ()


def serve(pipe: Connection) -> None:
    """Work until the pipe ends, or until memory runs out, since a heap that was full once stays fragmented."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is the parent's, who ends its workers
    sys.path[:], memory_mb = pipe.recv()
    if memory_mb:
        limit = memory_mb * BYTES_PER_MB
        resource.setrlimit(resource.RLIMIT_DATA, (limit, limit))
    with contextlib.suppress(EOFError, ConnectionError):
        while True:
            reply = replied(pipe.recv_bytes(), pipe.recv_bytes())
            pipe.send_bytes(packed(reply))
            if isinstance(reply.error, MemoryError):
                return


@functools.lru_cache(maxsize=1)
def unpacked(work: bytes) -> Any:
    """The work, which is the same for many items."""
    return pickle.loads(work)  # noqa: S301  # from the process that started this one


def replied(work: bytes, item: bytes) -> Reply:
    """Reply to a piece of work on an item, both pickled."""
    notes: list[warnings.WarningMessage] = []
    try:
        with warnings.catch_warnings(record=True) as notes:
            warnings.simplefilter("always")
            result = unpacked(work)(pickle.loads(item))  # noqa: S301  # as above
    except Exception as error:  # noqa: BLE001  # whatever goes wrong with one item, the others go on
        error.add_note(traceback.format_exc())
        return Reply(error=error)
    return Reply(result, notes=tuple(note.message for note in notes if isinstance(note.message, Warning)))


def packed(reply: Reply) -> bytes:
    """The reply as bytes; one that cannot be pickled becomes an error that says so."""
    try:
        return pickle.dumps(reply)
    except Exception as error:  # noqa: BLE001  # objects raise what they like
        what = reply.error if reply.result is None else f"a result that cannot be pickled: {error}"
        return pickle.dumps(Reply(error=RuntimeError(f"{type(what).__name__}: {what}")))
