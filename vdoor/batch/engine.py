"""A batch on one machine: each map in a process of its own, so that no map stops the others."""

from __future__ import annotations

import multiprocessing
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from multiprocessing.connection import Connection
from pathlib import Path

from vdoor.batch.job import Job, Outcome, done
from vdoor.errors import VdoorError
from vdoor.formats import READERS

Work = Callable[[Job], Outcome]


def outcomes(jobs: Sequence[Job], processes: int, work: Work = done) -> Iterator[Outcome]:
    """The outcome of each job, in the order in which they end, with `processes` of them at work at a time."""
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload(["vdoor.batch.job"])
    with ThreadPoolExecutor(processes) as pool:
        waiting = [pool.submit(_in_process, context, job, work) for job in jobs]
        try:
            for future in as_completed(waiting):
                yield future.result()
        finally:
            for future in waiting:
                future.cancel()


def _in_process(context: multiprocessing.context.ForkServerContext, job: Job, work: Work) -> Outcome:
    """The outcome of a job in a new process; if that dies, this is the outcome."""
    receiver, sender = context.Pipe(duplex=False)
    process = context.Process(target=_send, args=(sender, job, work), daemon=True)
    process.start()
    sender.close()
    with receiver:
        try:
            found: Outcome | str = receiver.recv()
        except EOFError:
            process.join()
            found = f"its process ended with code {process.exitcode}"
    process.join()
    return Outcome(map_file=job.map_file, folder=job.folder, error=found) if isinstance(found, str) else found


def _send(sender: Connection, job: Job, work: Work) -> None:
    """Do a job and send its outcome, or why it failed."""
    try:
        sender.send(work(job))
    except Exception as error:  # noqa: BLE001  # whatever goes wrong with one map, the others go on
        sender.send(f"{type(error).__name__}: {error}")


def jobs_of(paths: Sequence[Path], out: Path) -> list[tuple[Path, Path]]:
    """Each map with the folder for its result: its name below `out`; folders stand for the maps in them.

    Raises `VdoorError` for a folder without maps, and for two maps that would have the same folder.
    """
    found: dict[Path, Path] = {}
    for path in paths:
        for map_file in _maps_in(path) if path.is_dir() else [path]:
            folder = out / map_file.stem
            if found.setdefault(folder, map_file) != map_file:
                raise VdoorError(f"batch: wanted a name for each map, found {found[folder]} and another: {map_file}")
    return [(map_file, folder) for folder, map_file in found.items()]


def _maps_in(folder: Path) -> list[Path]:
    """The maps in a folder: every YAML, and every other map file that is not the image of one."""
    known = {suffix for reader in READERS for suffix in reader.suffixes}
    files = sorted(path for path in folder.iterdir() if path.suffix.lower() in known)
    stems = {path.stem for path in files if path.suffix.lower() in (".yaml", ".yml")}
    maps = [path for path in files if path.suffix.lower() in (".yaml", ".yml") or path.stem not in stems]
    if not maps:
        raise VdoorError(f"batch: wanted maps, found none in the folder: {folder}")
    return maps
