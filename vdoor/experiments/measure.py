"""Runs on trial maps, and their figures summarised in one row."""

from __future__ import annotations

import dataclasses
import functools
import time
from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np

from vdoor.api import prepared
from vdoor.config import DEFAULT_PRESET
from vdoor.emit import Emit, silent
from vdoor.errors import MapError
from vdoor.evaluate import Evaluation, evaluate, means, pooled, rooms_of
from vdoor.experiments.cases import Trial
from vdoor.pipeline import AnyPipeline, preset_named
from vdoor.synth import PRESETS as KINDS
from vdoor.synth import synthesize

FIGURES = (
    "door_precision",
    "door_recall",
    "door_f1",
    "pooled_door_f1",
    "worst_door_f1",
    "iou_sym",
    "cpu_s",
    "cpu_max_s",
)
"""Figures of a row, in this order; `iou_sym` only if a reference has rooms."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Outcome:
    """Result of a run, evaluated."""

    evaluation: Evaluation
    cpu_s: float
    """CPU seconds of the method alone."""


@dataclass(frozen=True, kw_only=True)
class Row:
    """Figures of runs over all maps."""

    name: str
    figures: dict[str, float]
    """By the names in `FIGURES`: means over the maps, but pooled, worst, median (`cpu_s`) and maximum as named."""
    worst_map: str = ""
    door_f1: dict[str, float] = field(default_factory=dict)
    """Door F1 by map."""


def measured(trial: Trial, pipeline: AnyPipeline, *, seed: int = 0, emit: Emit = silent) -> Outcome:
    """Result of the pipeline on one map, evaluated against the truth.

    Raises `MapError` with the map's name if the pipeline finds nothing.
    """
    grid = trial.division.grid
    try:
        ready = prepared(pipeline, grid).pipeline
        start_s = time.process_time()
        topology = ready(grid, np.random.default_rng(seed), emit)
        cpu_s = time.process_time() - start_s
    except MapError as error:
        raise MapError(f"{trial.name}: {error}") from error
    division = dataclasses.replace(trial.division, rooms=rooms_of(topology.labels, grid.frame.resolution_m))
    return Outcome(evaluation=evaluate(division, trial.reference), cpu_s=cpu_s)


def timed(trial: Trial, pipeline: AnyPipeline, *, seed: int = 0) -> Outcome:
    """The same in a process that is warm, so that no figure includes the first-time cost of libraries."""
    warm_up()
    return measured(trial, pipeline, seed=seed)


@functools.cache
def warm_up() -> None:
    """Run a small map once in this process."""
    grid = synthesize(KINDS["paper"], np.random.default_rng(0)).grid
    preset_named(DEFAULT_PRESET)(grid, np.random.default_rng(0))


def summarised(name: str, outcomes: Iterable[Outcome]) -> Row:
    """One row that summarises the outcomes of all maps."""
    outcomes = list(outcomes)
    evaluations = [outcome.evaluation for outcome in outcomes]
    door_f1 = {evaluation.name: evaluation.figures()["door_f1"] for evaluation in evaluations}
    worst = min(door_f1, key=door_f1.__getitem__)
    cpu_s = [outcome.cpu_s for outcome in outcomes]
    figures = {
        **means(evaluations),
        **pooled(evaluations),
        "worst_door_f1": door_f1[worst],
        "cpu_s": float(np.median(cpu_s)),
        "cpu_max_s": max(cpu_s),
    }
    present = {key: figures[key] for key in FIGURES if key in figures}
    return Row(name=name, figures=present, worst_map=worst, door_f1=door_f1)
