"""One map of a batch: a map in, a result folder and a row of the table out. Any engine can do it, here or elsewhere."""

from __future__ import annotations

import platform
import re
import resource
import shutil
import time
import warnings
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from vdoor import __version__
from vdoor.api import prepared, run_info, run_prepared
from vdoor.batch.sources import Item, at_hand
from vdoor.batch.store import Place, StoreError, key_of
from vdoor.config import DEFAULT_PRESET, with_settings
from vdoor.emit import RunInfo, Stopwatch, silent
from vdoor.engines import Engine, Limits
from vdoor.errors import VdoorError
from vdoor.evaluate import Division, evaluate, read_reference, rooms_of
from vdoor.evaluate.label_files import read_labels, read_table
from vdoor.formats import read_annotations, read_map
from vdoor.grid import OccupancyGrid
from vdoor.pipeline import METHODS, AnyPipeline, preset_named
from vdoor.results.segments import named_by_robot
from vdoor.results.writing import contents_of, document_of

Row = dict[str, Any]
"""A row of the table, by column; what is missing is empty."""
KB_PER_MB = 1024


@dataclass(frozen=True, kw_only=True)
class Recipe:
    """How every map of a batch is run, and where its result goes; can be pickled."""

    batch: Path
    """The batch's folder, which all workers must reach."""
    home: Path = field(default_factory=Path.cwd)
    """Where relative paths of maps begin."""
    preset: str = DEFAULT_PRESET
    settings: Mapping[str, Any] = field(default_factory=dict)
    """Settings that differ from the preset's, as nested tables."""
    seed: int = 0
    options: Mapping[str, Any] = field(default_factory=dict)
    """Keywords of `vdoor.read_map`."""
    force: bool = False
    """Whether to run maps again that are done."""
    version: str = __version__
    """Of the program that gives out the work."""


def done(item: Item, recipe: Recipe) -> Row:
    """The row of a map, whose result is that of an earlier equal run, or made now.

    Errors that a user can mend are part of the row.
    """
    begin_s = time.perf_counter()
    try:
        _refuse_other_version(recipe)
        return _done(item, recipe, begin_s)
    except VdoorError as error:
        return failed(item, error)


def _refuse_other_version(recipe: Recipe) -> None:
    """Raise `VdoorError` where a worker has another version than the one that gave out the work."""
    if recipe.version != __version__:
        raise VdoorError(f"worker: wanted vdoor {recipe.version} as where the batch runs, found {__version__}")


def failed(item: Item, error: Exception) -> Row:
    """The row of a map without a result."""
    text = str(error) if isinstance(error, VdoorError) else f"{type(error).__name__}: {error}"
    return {"map": item.map, "error_kind": type(error).__name__, "error": text}


def _done(item: Item, recipe: Recipe, begin_s: float) -> Row:
    begin_cpu_s = time.process_time()
    _forget_peak()
    with at_hand(item.map, recipe.home) as path, warnings.catch_warnings():
        warnings.simplefilter("ignore")  # a run of the map alone shows them
        grid = read_map(path, **_options(item, recipe))
    pipeline = prepared(_pipeline(item, recipe), grid).pipeline
    info = run_info(grid, recipe.preset, pipeline, recipe.seed)
    place = Place(recipe.batch, f"{_stem(grid, item)}-{key_of(info)}")
    measured: Row = {}
    document: Mapping[str, Any] | None = None
    if recipe.force:
        shutil.rmtree(place.result, ignore_errors=True)
    if not place.result.is_dir():
        watch = Stopwatch(silent)
        document = _run(grid, pipeline, info, place, watch)
        measured = {"stages_s": {stage: round(seconds, 6) for stage, seconds in watch.cpu_s.items()}}
        measured |= {"cpu_s": sum(watch.cpu_s.values()), "all_cpu_s": time.process_time() - begin_cpu_s}
        measured |= {"wall_s": time.perf_counter() - begin_s, "peak_mb": _peak_mb(), "host": platform.node()}
    before = place.read_row()
    if not measured and before.get("map") == item.map and before.get("reference", "") == item.reference:
        return before | {"again": True}
    row = _described(item, grid, place, recipe, document or read_table(place.result / "map.json")) | (
        {name: before[name] for name in MEASURED if name in before} | measured
    )
    place.write_row(row)
    return row | {"again": not measured}


MEASURED = ("cpu_s", "all_cpu_s", "wall_s", "peak_mb", "stages_s", "host")
"""Columns that differ from run to run; `all_cpu_s` is that of the method with reading and writing."""


def _options(item: Item, recipe: Recipe) -> Mapping[str, Any]:
    own = {} if item.resolution_m is None else {"resolution_m": item.resolution_m}
    return {**recipe.options, **own}


def _pipeline(item: Item, recipe: Recipe) -> AnyPipeline:
    pipeline = with_settings(preset_named(recipe.preset), recipe.settings, METHODS)
    if item.robot_x_m is None:
        return pipeline
    return with_settings(pipeline, {"simplify": {"robot_m": [item.robot_x_m, item.robot_y_m]}}, METHODS)


def _stem(grid: OccupancyGrid, item: Item) -> str:
    """The map's name without its suffix, of characters that all file systems take."""
    name = grid.source.files[0][0] if grid.source.files else item.map
    return re.sub(r"[^\w.-]", "_", Path(name).stem)[:80]


def _run(
    grid: OccupancyGrid, pipeline: AnyPipeline, info: RunInfo, place: Place, watch: Stopwatch
) -> Mapping[str, Any]:
    """Run the method and write the files of `vdoor run MAP --out DIR`, without times; the content of map.json."""
    found = run_prepared(grid, pipeline, seed=info.seed, emit=watch)
    topology = named_by_robot(found, read_annotations(grid.source))
    document = document_of(topology, info, {})
    place.write_result(contents_of(place.result, grid, topology, document))
    return document


def _described(item: Item, grid: OccupancyGrid, place: Place, recipe: Recipe, document: Mapping[str, Any]) -> Row:
    """What a map and its result are, and how good that is where there is a reference: equal for equal runs."""
    return {
        "map": item.map,
        "key": place.name.rpartition("-")[2],
        "folder": str(place.result.relative_to(recipe.batch)),
        "height": grid.frame.height,
        "width": grid.frame.width,
        "resolution_m": grid.frame.resolution_m,
        "rooms": len(document["rooms"]),
        "doors": len(document["doors"]),
        "area_m2": round(sum(room["area_m2"] for room in document["rooms"]), 6),
        "reference": item.reference,
        **(_measures(item, grid, place, recipe) if item.reference else {}),
    }


def _measures(item: Item, grid: OccupancyGrid, place: Place, recipe: Recipe) -> Mapping[str, float]:
    """The figures of `vdoor evaluate`."""
    labels = rooms_of(read_labels(place.result / "rooms.png").astype(np.int32), grid.frame.resolution_m)
    division = Division(name=item.map, grid=grid, free=grid.free, rooms=labels)
    with at_hand(item.reference, recipe.home, beside=[".png"]) as path:
        figures = evaluate(division, read_reference(path, None, division)).figures()
    return {name: value for name, value in figures.items() if np.isfinite(value)}


def _forget_peak() -> None:
    """Begin to count this process's peak memory anew."""
    with suppress(OSError):
        Path("/proc/self/clear_refs").write_text("5", encoding="ascii")


def _peak_mb() -> float:
    """Peak memory of this process since `_forget_peak`."""
    with suppress(OSError):
        status = Path("/proc/self/status").read_text(encoding="ascii", errors="replace")
        if found := re.search(r"VmHWM:\s+(\d+) kB", status):
            return int(found[1]) / KB_PER_MB
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / KB_PER_MB


def rows_of(items: Sequence[Item], recipe: Recipe, engine: Engine, limits: Limits) -> Iterator[Row]:
    """The row of each map as it comes from an engine.

    Raises `VdoorError` if results can no longer be written, or the engine is lost; an equal call goes on.
    """
    for ended in engine(partial(done, recipe=recipe), items, limits):
        row = ended.result or failed(items[ended.number], ended.error or RuntimeError("no result"))
        if row.get("error_kind") == StoreError.__name__:
            raise VdoorError(f"{row['error']}; the batch was stopped, and the same command goes on")
        yield row


def line_of(row: Row) -> str:
    """One line for people."""
    if "error" in row:
        return f"failed  {row['map']}: {row['error']}"
    seconds = "   done" if row["again"] else f"{row['wall_s']:7.1f} s"
    return f"{row['rooms']:4d} rooms {row['doors']:4d} doors {row['area_m2']:9.1f} m2 {seconds:>9s}  {row['map']}"
