"""One map of a batch: a map in, a result folder out. Any engine can call `done`, here or on another machine."""

from __future__ import annotations

import json
import time
import warnings
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from vdoor.api import prepared, run_info, run_prepared
from vdoor.config import DEFAULT_PRESET, with_settings
from vdoor.emit import RunInfo, Stopwatch, silent
from vdoor.errors import VdoorError
from vdoor.evaluate.label_files import read_table
from vdoor.formats import read_annotations, read_map
from vdoor.pipeline import METHODS, preset_named
from vdoor.results.segments import named_by_robot
from vdoor.results.writing import document_of, source_table, write_result

SAME = ("vdoor", "source", "preset", "settings", "seed")
"""What must be equal in map.json for a result to be that of the job."""


@dataclass(frozen=True, kw_only=True)
class Job:
    """A map, how to run it, and the folder for its result; can be pickled."""

    map_file: Path
    folder: Path
    preset: str = DEFAULT_PRESET
    settings: Mapping[str, Any] = field(default_factory=dict)
    """Settings that differ from the preset's, as nested tables."""
    seed: int = 0
    options: Mapping[str, Any] = field(default_factory=dict)
    """Keywords of `vdoor.read_map`."""


@dataclass(frozen=True, kw_only=True)
class Outcome:
    """What became of a job."""

    map_file: Path
    folder: Path
    rooms: int = 0
    doors: int = 0
    area_m2: float = 0.0
    seconds: float = 0.0
    """Wall time; 0 for a result that was there already."""
    error: str = ""
    """Why there is no result; empty if there is one."""

    @property
    def line(self) -> str:
        """One line for people."""
        if self.error:
            return f"failed  {self.map_file}: {self.error}"
        return (
            f"{self.rooms:4d} rooms {self.doors:4d} doors {self.area_m2:9.1f} m2 {self.seconds:7.1f} s  {self.map_file}"
        )


def done(job: Job) -> Outcome:
    """The outcome of a job: the folder of an earlier run of the same job, or a new one, whose map.json is written last.

    Errors that a user can mend are part of the outcome. The files are those of `vdoor run MAP --out DIR`.
    """
    try:
        return _done(job)
    except VdoorError as error:
        return Outcome(map_file=job.map_file, folder=job.folder, error=str(error))


def _done(job: Job) -> Outcome:
    begin = time.perf_counter()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # a run of the map alone shows them
        grid = read_map(job.map_file, **job.options)
    pipeline = with_settings(preset_named(job.preset), job.settings, METHODS)
    pipeline = prepared(pipeline, grid).pipeline
    info = run_info(grid, job.preset, pipeline, job.seed)
    before = _before(job)
    if before is not None and _same(before, info):
        return _outcome(job, before, 0.0)
    if before is not None:
        raise VdoorError(f"result: made with other settings or another map, --force overwrites it: {job.folder}")
    watch = Stopwatch(silent)
    found = run_prepared(grid, pipeline, seed=job.seed, emit=watch)
    topology = named_by_robot(found, read_annotations(grid.source))
    document = document_of(topology, info, watch.cpu_s)
    write_result(job.folder, grid, topology, document)  # map.json last: without it the job is done again
    return _outcome(job, document, time.perf_counter() - begin)


def _before(job: Job) -> dict[str, Any] | None:
    """The map.json of an earlier run, None if there is none."""
    path = job.folder / "map.json"
    return read_table(path) if path.is_file() else None


def _same(document: Mapping[str, Any], info: RunInfo) -> bool:
    """Whether a result is that of the run."""
    wanted = {
        "vdoor": info.version,
        "source": source_table(info.source),
        "preset": info.preset,
        "settings": info.settings,
        "seed": info.seed,
    }
    return all(document.get(key) == json.loads(json.dumps(wanted[key])) for key in SAME)


def _outcome(job: Job, document: Mapping[str, Any], seconds: float) -> Outcome:
    rooms = document["rooms"]
    return Outcome(
        map_file=job.map_file,
        folder=job.folder,
        rooms=len(rooms),
        doors=len(document["doors"]),
        area_m2=sum(room["area_m2"] for room in rooms),
        seconds=seconds,
    )
