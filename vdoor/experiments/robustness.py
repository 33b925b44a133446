"""Robustness: the method on changed versions of the same maps."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Sequence
from functools import partial

import numpy as np
from numpy.typing import NDArray

from vdoor.engines import Over
from vdoor.evaluate import Doors
from vdoor.experiments.cases import Trial
from vdoor.experiments.changes import CHANGES, Change, Sheet
from vdoor.experiments.measure import Outcome, Row, summarised, timed
from vdoor.frame import Frame
from vdoor.pipeline import AnyPipeline

DIFFERENCE = "door_f1_difference"


def robustness(
    trials: Sequence[Trial],
    pipeline: AnyPipeline,
    *,
    changes: Sequence[Change] = CHANGES,
    seed: int = 0,
    over: Over = map,
) -> Iterator[Row]:
    """One row per change, with the difference of its mean door F1 to that of the first."""
    first: float | None = None
    for change in changes:
        work = partial(_timed_changed, change=change, pipeline=pipeline, seed=seed)
        row = summarised(change.name, over(work, trials))
        first = row.figures["door_f1"] if first is None else first
        yield dataclasses.replace(row, figures=row.figures | {DIFFERENCE: row.figures["door_f1"] - first})


def _timed_changed(trial: Trial, *, change: Change, pipeline: AnyPipeline, seed: int) -> Outcome:
    return timed(changed(trial, change, np.random.default_rng(seed)), pipeline, seed=seed)


def changed(trial: Trial, change: Change, rng: np.random.Generator) -> Trial:
    """The trial on the changed map, with true and unsure doors transformed to its frame, without rooms."""
    division, reference = trial.division, trial.reference
    sheet = change.make(Sheet(division.grid, division.free), rng)
    old, new = division.frame, sheet.grid.frame
    return Trial(
        name=trial.name,
        division=dataclasses.replace(
            division, grid=sheet.grid, free=sheet.free, rooms=np.zeros(sheet.free.shape, np.int32)
        ),
        reference=dataclasses.replace(
            reference,
            rooms=None,
            doors=moved(reference.doors, old, new),
            unsure=None if reference.unsure is None else moved(reference.unsure, old, new),
        ),
    )


def moved(doors: Doors, old: Frame, new: Frame) -> Doors:
    """The same doors in another frame of the map, with unchanged widths."""

    def cells(points: NDArray[np.float64]) -> NDArray[np.float64]:
        return new.cell_from_world(old.world_from_cell(points))

    centre = cells((doors.centre_m / old.resolution_m - 0.5)[:, ::-1])
    return Doors(
        centre_m=(centre[:, ::-1] + 0.5) * new.resolution_m,
        width_m=doors.width_m,
        ends=cells(doors.ends.reshape(-1, 2)).reshape(-1, 2, 2),
    )
