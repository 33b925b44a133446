"""Training examples: virtual doors of maps with known real doors, synthetic or labelled."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from vdoor.experiments import Choice, Trial, read_trials
from vdoor.frame import Frame
from vdoor.grid import FREE, OccupancyGrid
from vdoor.method.doors import PROPOSED
from vdoor.method.scoring.features import first_features
from vdoor.method.scoring.model import Curves, Rough
from vdoor.method.scoring.score import ScoreDoors, corners_per_m
from vdoor.method.scoring.segments import Segments
from vdoor.method.scoring.space_features import room_around
from vdoor.pipeline import Pipeline
from vdoor.synth import Home, LaserHome, Office, SyntheticMap, synthesize

Floats = NDArray[np.float64]

HIT_M, MISS_M, UNSURE_M = 0.3, 0.5, 1.0
"""Distances between the middles of a virtual and a real door: real up to HIT_M, not real from MISS_M, ignored between.

Near unsure doors, virtual doors that are not real are ignored up to UNSURE_M.
"""
COARSE_EVERY = 4
MOST_TURNED_RAD = math.radians(35)


@dataclass(frozen=True, eq=False)
class RealDoors:
    """The real doors of a map, in metres of the map frame."""

    start_m: Floats
    """(k, 2) as x, y."""
    end_m: Floats
    width_m: Floats
    unsure: NDArray[np.bool_]
    """Whether a door (k,) is ignored, found or not."""

    @property
    def middle_m(self) -> Floats:
        """Middle of each door (k, 2) as x, y."""
        return (self.start_m + self.end_m) / 2

    @property
    def along_rad(self) -> Floats:
        """Direction of each door (k,)."""
        along = self.end_m - self.start_m
        return np.arctan2(along[:, 1], along[:, 0])


def real_doors(made: SyntheticMap) -> RealDoors:
    """The real doors of a synthetic map."""
    return RealDoors(
        np.array([door.start_m for door in made.doors], np.float64).reshape(-1, 2),
        np.array([door.end_m for door in made.doors], np.float64).reshape(-1, 2),
        np.array([door.width_m for door in made.doors], np.float64),
        np.array([door.unsure for door in made.doors], np.bool_),
    )


def marked_real(ends: Floats, widths_m: Floats, frame: Frame, unsure_ends: Floats | None = None) -> RealDoors:
    """Real doors from ends (k, 2, 2) as row, col, and unsure doors from `unsure_ends` (j, 2, 2)."""
    both = ends if unsure_ends is None else np.concatenate([ends, unsure_ends])
    start_m, end_m = (frame.world_from_cell(both[:, at]) for at in (0, 1))
    unsure = np.arange(len(both)) >= len(ends)
    widths = np.concatenate([widths_m, np.hypot(*(end_m - start_m)[len(ends) :].T)])
    return RealDoors(start_m, end_m, widths, unsure)


@dataclass(frozen=True, eq=False)
class Examples:
    """Virtual doors of one map: features (k, features), whether each is real (k,), and its weight (k,)."""

    feature: Floats
    real: Floats
    weight: Floats
    share_rough: float


class TrainingMap(NamedTuple):
    """A map, its real doors, and their weight."""

    grid: OccupancyGrid
    real: RealDoors
    weight: float = 1.0


Draw = Callable[[], TrainingMap]
"""Draws or reads a training map, the same on each call."""


def known(training_map: TrainingMap) -> Draw:
    """Draw that returns a given training map."""
    return partial(_given, training_map)


def _given(training_map: TrainingMap) -> TrainingMap:
    return training_map


def synthetic_maps(homes: int, offices: int, seed: int, laser_homes: int = 0) -> list[Draw]:
    """Draws of synthetic homes, office floors and homes mapped by laser; equal seeds give equal maps."""
    numbers = [(number, index) for number, count in enumerate((homes, offices, laser_homes)) for index in range(count)]
    return [partial(drawn_map, number, index, seed) for number, index in numbers]


def drawn_map(number: int, index: int, seed: int) -> TrainingMap:
    """The index-th synthetic home (0), floor (1) or home mapped by laser (2)."""
    made = synthesize(drawn_kind(number, index), np.random.default_rng([seed, number, index]))
    return TrainingMap(made.grid, real_doors(made))


def drawn_kind(number: int, index: int) -> Home | LaserHome | Office:
    """Settings of the index-th home (0), floor (1) or home mapped by laser (2): one floor in four has coarse cells."""
    if number == 1:
        return Office(cell_m=0.1) if index % COARSE_EVERY == 0 else Office()
    return LaserHome() if number else Home()


def examples(training_map: TrainingMap, pipeline: Pipeline, first_pass: Curves | None = None) -> Examples:
    """The proposed doors of a map as examples: for pass 1, or, given the curves of pass 1, for pass 2."""
    simplified, path, corners, doors = pipeline.propose(training_map.grid)
    rows = np.flatnonzero(doors.verdict == PROPOSED)
    segments = Segments(doors, rows)
    ends_m = [doors.frame.world_from_cell(ends) for ends in (segments.start, segments.end)]
    label, weight = judged(ends_m[0], ends_m[1], training_map.real)
    share_rough = Rough().share(corners_per_m(path, corners))
    if first_pass is None:
        distance = room_around(simplified.cells == FREE)
        feature = first_features(simplified, path, doors, rows, corners.sample, distance=distance)
    else:
        assert isinstance(pipeline.score, ScoreDoors)
        feature, _ = pipeline.score.features(
            simplified, path, corners, doors, first_pass=first_pass, share_rough=share_rough
        )
    return Examples(feature, label, weight * training_map.weight, share_rough)


def drawn_examples(draw: Draw, *, pipeline: Pipeline, first_pass: Curves | None = None) -> Examples:
    """The examples of a map that is drawn where they are made."""
    return examples(draw(), pipeline, first_pass)


def judged(start_m: Floats, end_m: Floats, real: RealDoors) -> tuple[Floats, Floats]:
    """Whether each segment (k,) is a real door, 0 or 1, and its weight, 0 if that is uncertain."""
    middle_m = (start_m + end_m) / 2
    label, weight = np.zeros(len(middle_m)), np.ones(len(middle_m))
    sure = ~real.unsure
    if sure.any():
        away_m = np.hypot(*(middle_m[:, None] - real.middle_m[sure][None]).transpose(2, 0, 1))
        nearest = away_m.argmin(axis=1)
        away_m = away_m.min(axis=1)
        angle = np.arctan2(*(end_m - start_m).T[::-1]) - real.along_rad[sure][nearest]
        turned = np.abs((angle + np.pi / 2) % np.pi - np.pi / 2)
        long = np.hypot(*(end_m - start_m).T) > 1.6 * real.width_m[sure][nearest] + 0.3
        label[(away_m <= HIT_M) & ~(turned > MOST_TURNED_RAD) & ~long] = 1
        weight[(away_m > HIT_M) & (away_m < MISS_M)] = 0
        weight[(away_m <= HIT_M) & (label == 0)] = 0
    if real.unsure.any():
        away_m = np.hypot(*(middle_m[:, None] - real.middle_m[real.unsure][None]).transpose(2, 0, 1)).min(axis=1)
        weight[(away_m < UNSURE_M) & (label == 0)] = 0
    return label, weight


def labelled_maps(
    maps: Path, reference: Path, *, weight: float = 1.0, bare: Path | None = None, resolution_m: float | None = None
) -> list[TrainingMap]:
    """Every map in a folder with a reference of its name; `VdoorError` if there is none."""
    choice = Choice(reference=reference, bare=bare, resolution_m=resolution_m)
    return [_of_trial(trial, weight) for trial in read_trials(maps, choice).trials]


def _of_trial(trial: Trial, weight: float) -> TrainingMap:
    """One map with the doors of its reference."""
    doors, unsure, grid = trial.reference.doors, trial.reference.unsure, trial.division.grid
    real = marked_real(doors.ends, doors.width_m, grid.frame, None if unsure is None else unsure.ends)
    return TrainingMap(grid, real, weight)
