"""Trials without files: synthetic maps with the truth about them, as they are drawn."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from vdoor.evaluate import Division, Reference, marked_doors, rooms_of
from vdoor.synth import SyntheticMap
from vdoor.trials.cases import Trial


def trial_of(made: SyntheticMap, name: str) -> Trial:
    """A synthetic map as a trial: what is read from the files that it would be written to."""
    grid = made.grid
    frame = grid.frame
    ends_m = np.array([[door.start_m, door.end_m] for door in made.doors], np.float64).reshape(-1, 2)
    ends = frame.cell_from_world(ends_m).round(6).reshape(-1, 2, 2)
    widths_m = np.array([door.width_m for door in made.doors], np.float64)
    return Trial(
        name=name,
        division=Division(name=name, grid=grid, free=grid.free, rooms=np.zeros(grid.cells.shape, np.int32)),
        reference=Reference(
            path=Path(f"{name}_truth.json"),
            rooms=rooms_of(made.rooms, frame.resolution_m),
            doors=marked_doors(ends, frame.resolution_m, widths_m),
        ),
    )
