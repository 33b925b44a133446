"""Examples from maps that somebody has labelled."""

from __future__ import annotations

from pathlib import Path

from vdoor.pipeline import Pipeline
from vdoor.train.examples import Examples, examples, marked_real
from vdoor.trials import Choice, Trial, read_trials


def labelled_examples(
    maps: Path, reference: Path, pipeline: Pipeline, *, bare: Path | None = None, resolution_m: float | None = None
) -> list[Examples]:
    """Examples of every map in a folder that a reference serves by its name; VdoorError where there is none."""
    choice = Choice(reference=reference, bare=bare, resolution_m=resolution_m)
    return [_of_trial(trial, pipeline) for trial in read_trials(maps, choice).trials]


def _of_trial(trial: Trial, pipeline: Pipeline) -> Examples:
    """The virtual doors of one map, judged by its reference."""
    doors, unsure, grid = trial.reference.doors, trial.reference.unsure, trial.division.grid
    real = marked_real(doors.ends, doors.width_m, grid.frame, None if unsure is None else unsure.ends)
    return examples(grid, real, pipeline)
