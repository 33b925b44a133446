"""Runs on trial maps, and the figures of many runs in one row."""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

import numpy as np

from vdoor.api import prepared
from vdoor.emit import Emit, silent
from vdoor.errors import MapError
from vdoor.evaluate import Evaluation, evaluate, means, pooled, rooms_of
from vdoor.experiments.cases import Trial
from vdoor.pipeline import AnyPipeline

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
"""Of a row, in this order; `iou_sym` only where a reference has rooms."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Outcome:
    """What a run found, measured."""

    evaluation: Evaluation
    cpu_s: float
    """Of the method alone."""


@dataclass(frozen=True, kw_only=True)
class Row:
    """Figures of runs over all maps."""

    name: str
    figures: dict[str, float]
    """By the names in `FIGURES`: means over the maps but for the pooled, worst, median (`cpu_s`) and largest ones."""
    worst_map: str = ""
    door_f1: dict[str, float] = field(default_factory=dict)
    """Of each map."""


def measured(trial: Trial, pipeline: AnyPipeline, *, seed: int = 0, emit: Emit = silent) -> Outcome:
    """The division of one map by the pipeline prepared for it, against the truth.

    Raises `MapError` with the map's name where it finds nothing.
    """
    grid = trial.division.grid
    try:
        there = prepared(pipeline, grid).pipeline
        start_s = time.process_time()
        topology = there(grid, np.random.default_rng(seed), emit)
        cpu_s = time.process_time() - start_s
    except MapError as error:
        raise MapError(f"{trial.name}: {error}") from error
    division = dataclasses.replace(trial.division, rooms=rooms_of(topology.labels, grid.frame.resolution_m))
    return Outcome(evaluation=evaluate(division, trial.reference), cpu_s=cpu_s)


def warm_up(trials: Sequence[Trial], pipeline: AnyPipeline) -> None:
    """Run the smallest map once, so that no figure holds what libraries do the first time."""
    measured(min(trials, key=lambda trial: trial.division.free.size), pipeline)


def summarised(name: str, outcomes: Iterable[Outcome]) -> Row:
    """One row of all maps' outcomes."""
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
    chosen = {key: figures[key] for key in FIGURES if key in figures}
    return Row(name=name, figures=chosen, worst_map=worst, door_f1=door_f1)
