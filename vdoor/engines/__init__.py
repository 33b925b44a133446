"""Work over many items, by an engine: worker processes of this machine, or a cluster.

An engine is one function, `(work, items, limits) -> Iterator[Ended]`, in a file of its own; `ENGINES` lists them.
"""

from vdoor.engines.cluster import dask
from vdoor.engines.endings import Ended, Engine, Limits, OutOfMemoryError, Over, WorkerDiedError, in_order
from vdoor.engines.processes import over, processes

ENGINES: dict[str, Engine] = {"processes": processes, "dask": dask}
"""Engines by name."""

__all__ = [
    "ENGINES", "Ended", "Engine", "Limits", "OutOfMemoryError", "Over", "WorkerDiedError", "dask", "in_order", "over",
    "processes",
]  # fmt: skip
