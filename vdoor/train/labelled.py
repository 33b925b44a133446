"""Maps that somebody has labelled."""

from __future__ import annotations

from pathlib import Path

from vdoor.train.examples import Lesson, marked_real
from vdoor.trials import Choice, Trial, read_trials


def labelled_lessons(
    maps: Path, reference: Path, *, weight: float = 1.0, bare: Path | None = None, resolution_m: float | None = None
) -> list[Lesson]:
    """Every map in a folder that a reference serves by its name; VdoorError where there is none."""
    choice = Choice(reference=reference, bare=bare, resolution_m=resolution_m)
    return [_of_trial(trial, weight) for trial in read_trials(maps, choice).trials]


def _of_trial(trial: Trial, weight: float) -> Lesson:
    """One map with the doors of its reference."""
    doors, unsure, grid = trial.reference.doors, trial.reference.unsure, trial.division.grid
    real = marked_real(doors.ends, doors.width_m, grid.frame, None if unsure is None else unsure.ends)
    return Lesson(grid, real, weight)
