"""From a map to its rooms in one call, the same for the command and for Python: prepare the pipeline, then run it.

What a map's file says beside its cells counts in both: where the robot is, and where its own frame lies.
"""

from __future__ import annotations

import dataclasses
import warnings
from typing import NamedTuple

import numpy as np

from vdoor.config import DEFAULT_PRESET
from vdoor.emit import Emit, silent
from vdoor.errors import MapError, MapWarning
from vdoor.formats import read_annotations
from vdoor.grid import OccupancyGrid, Source
from vdoor.method.simplify import SimplifyGrid
from vdoor.pipeline import AnyPipeline, preset_named
from vdoor.topology import TopologicalMap


class Prepared(NamedTuple):
    """A pipeline for one map, and what its user should know of it; empty where nothing had to be assumed."""

    pipeline: AnyPipeline
    note: str = ""


def prepared(pipeline: AnyPipeline, grid: OccupancyGrid) -> Prepared:
    """The pipeline as `run` takes it for this map: with the robot where the map's file says, unless its place is set.

    A place that is set stands, so that to prepare twice changes nothing.
    """
    simplify, note = placed(pipeline.simplify, grid)
    return Prepared(dataclasses.replace(pipeline, simplify=simplify), note)


def run(
    grid: OccupancyGrid, preset: str | AnyPipeline = DEFAULT_PRESET, *, seed: int = 0, emit: Emit = silent
) -> TopologicalMap:
    """The topological map of `grid` by a preset or a pipeline of your own; equal seeds give equal results.

    The same as `vdoor run`: the pipeline is `prepared` for the map, then it is `run_prepared`. To record a run do both
    yourself: it can be done again with the settings of the prepared pipeline.

    Warns
    -----
    MapWarning
        where the map's file names a place of the robot that cannot be

    """
    pipeline, note = prepared(preset_named(preset) if isinstance(preset, str) else preset, grid)
    if note:
        warnings.warn(note, MapWarning, stacklevel=2)
    return run_prepared(grid, pipeline, seed=seed, emit=emit)


def run_prepared(grid: OccupancyGrid, pipeline: AnyPipeline, *, seed: int = 0, emit: Emit = silent) -> TopologicalMap:
    """The same by a pipeline whose settings stand as they are, wherever the map's file says that the robot is."""
    return in_own_frame(pipeline(grid, np.random.default_rng(seed), emit), grid.source)


class Placed(NamedTuple):
    """The first stage for one map, and what its user should know of it."""

    simplify: SimplifyGrid
    note: str = ""
    """Empty where nothing had to be assumed."""


def placed(simplify: SimplifyGrid, grid: OccupancyGrid) -> Placed:
    """The stage with the robot, or else its charger, where the map's file says, unless its place is set already.

    A place without a free cell near it is passed over, as the stage would refuse it.
    """
    said = None if simplify.robot_m else read_annotations(grid.source)
    places_m = said.places_m if said else ()
    for place_m in places_m:
        there = dataclasses.replace(simplify, robot_m=place_m)
        try:
            there(grid)
        except MapError:
            continue
        return Placed(there)
    note = "the robot's place in the map's file is not free; the largest free space is taken"
    return Placed(simplify, note if places_m else "")


def in_own_frame(topology: TopologicalMap, source: Source) -> TopologicalMap:
    """The map that knows where it lies in the frame of the robot whose file it was made of, if that says so."""
    said = read_annotations(source)
    return dataclasses.replace(topology, own_origin_cm=said.own_origin_cm) if said else topology
