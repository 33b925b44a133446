"""From a map to its rooms in one call, for the command and for Python alike: prepare the pipeline, then run it.

Both use the annotations in the map file: the robot's position and the origin of the robot's own frame.
"""

from __future__ import annotations

import dataclasses
import warnings
from typing import NamedTuple

import numpy as np

from vdoor import __version__
from vdoor.config import DEFAULT_PRESET, settings_of
from vdoor.emit import Emit, RunInfo, silent
from vdoor.errors import MapError, MapWarning
from vdoor.formats import described, read_annotations
from vdoor.grid import OccupancyGrid, Source
from vdoor.memory import available_bytes, refuse_too_large
from vdoor.method.simplify import SimplifyGrid
from vdoor.pipeline import METHODS, AnyPipeline, preset_named
from vdoor.topology import TopologicalMap


class Prepared(NamedTuple):
    """A pipeline for one map, and a note for the user."""

    pipeline: AnyPipeline
    note: str = ""
    """What had to be assumed; empty if nothing."""


def prepared(pipeline: AnyPipeline, grid: OccupancyGrid) -> Prepared:
    """The pipeline that `run` uses for this map: with the robot's position from the map file, unless it is set.

    A position that is already set is kept, so preparing twice changes nothing.
    """
    simplify, note = placed(pipeline.simplify, grid)
    return Prepared(dataclasses.replace(pipeline, simplify=simplify), note)


def run(
    grid: OccupancyGrid, preset: str | AnyPipeline = DEFAULT_PRESET, *, seed: int = 0, emit: Emit = silent
) -> TopologicalMap:
    """The topological map of `grid`, by a preset or a pipeline of your own; equal seeds give equal results.

    Does what `vdoor run` does: `prepared`, then `run_prepared`. To record a run, call both yourself and record the
    settings of the prepared pipeline: they reproduce the run.

    Warns
    -----
    MapWarning
        if no free cell is near the robot's position given in the map file

    """
    pipeline, note = prepared(preset_named(preset) if isinstance(preset, str) else preset, grid)
    if note:
        warnings.warn(note, MapWarning, stacklevel=2)
    return run_prepared(grid, pipeline, seed=seed, emit=emit)


def run_prepared(grid: OccupancyGrid, pipeline: AnyPipeline, *, seed: int = 0, emit: Emit = silent) -> TopologicalMap:
    """The topological map of `grid` by a pipeline used as it is, without the robot's position from the map file.

    Raises MapError, with the map's name and its cells in counts, if there is nothing to divide, or too little memory.
    """
    try:
        refuse_too_large(grid.cells.size, pipeline.simplify.factor(grid.frame), available_bytes())
        topology = pipeline(grid, np.random.default_rng(seed), emit)
    except MapError as error:
        raise MapError(f"{error}; {described(grid)}") from error
    return in_own_frame(topology, grid.source)


def run_info(grid: OccupancyGrid, preset: str, pipeline: AnyPipeline, seed: int) -> RunInfo:
    """What a recording or result says of a run with a prepared pipeline."""
    settings = settings_of(pipeline, METHODS)
    return RunInfo(version=__version__, preset=preset, seed=seed, settings=settings, source=grid.source)


class Placed(NamedTuple):
    """The first stage for one map, and a note for the user."""

    simplify: SimplifyGrid
    note: str = ""
    """What had to be assumed; empty if nothing."""


def placed(simplify: SimplifyGrid, grid: OccupancyGrid) -> Placed:
    """The stage with the robot's position from the map file, or else its charger's, unless a position is already set.

    A position with no free cell near it is skipped, since the stage would reject it.
    """
    annotations = None if simplify.robot_m else read_annotations(grid.source)
    places_m = annotations.places_m if annotations else ()
    for place_m in places_m:
        there = dataclasses.replace(simplify, robot_m=place_m)
        try:
            there(grid)
        except MapError:
            continue
        return Placed(there)
    note = "the robot's position in the map file is not free; using the largest free space"
    return Placed(simplify, note if places_m else "")


def in_own_frame(topology: TopologicalMap, source: Source) -> TopologicalMap:
    """The map with its origin in the robot's own frame (`own_origin_cm`), if the map file gives one."""
    annotations = read_annotations(source)
    return dataclasses.replace(topology, own_origin_cm=annotations.own_origin_cm) if annotations else topology
