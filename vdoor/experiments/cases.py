"""Maps with their truth, read from files once for many runs, or synthetic."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from vdoor.batch.sources import maps_in
from vdoor.errors import VdoorError
from vdoor.evaluate import Division, MapChoice, Reference, marked_doors, read_reference, rooms_of
from vdoor.evaluate.cases import references_in, serving
from vdoor.synth import SyntheticMap


@dataclass(frozen=True, kw_only=True, eq=False)
class Trial:
    """One map and its truth."""

    name: str
    division: Division
    """The map, not yet divided into rooms."""
    reference: Reference


@dataclass(frozen=True, kw_only=True)
class Trials:
    """All maps that have a reference, and the names of those without."""

    trials: list[Trial]
    without_reference: list[str] = field(default_factory=list)


@dataclass(frozen=True, kw_only=True)
class Choice:
    """Selection of maps, and options for reading them and their references."""

    reference: Path
    bare: Path | None = None
    """Unfurnished map, or folder of maps, on which the rooms of label references were drawn."""
    resolution_m: float | None = None
    free_from: int | None = None
    """Smallest grey of a free cell in an image, for measuring doors and rooms."""
    only: Sequence[str] = ()
    """If not empty, a map's name must contain one of these texts."""
    exclude: Sequence[str] = ()
    """A map's name must contain none of these texts."""

    def wants(self, name: str) -> bool:
        """Whether the map of that name is selected."""
        selected = not self.only or any(text in name for text in self.only)
        return selected and not any(text in name for text in self.exclude)


def read_trials(maps: Path, choice: Choice) -> Trials:
    """A map, or the maps in a folder, with the references of the same names.

    Raises `VdoorError` if no map is selected, if none has a reference, or if a file is missing, damaged or of a wrong
    size.
    """
    found = [path for path in map_files(maps) if path.resolve() != choice.reference.resolve()]
    paths = [path for path in found if choice.wants(path.stem)]
    if not paths:
        what = "a map" if not found else f"one of {len(found)} maps to be selected"
        raise VdoorError(f"maps: wanted {what}, found none: {maps}")
    references = references_in(choice.reference)
    alone = [*references.values()] == [(choice.reference, None)]
    served = {path: serving(path.stem, references) for path in paths}
    if paths == [maps] and alone:  # one map and one reference, whatever their names
        served = {maps: next(iter(references))}
    without = [path.stem for path, name in served.items() if name is None]
    if len(without) == len(paths):
        wanted, has = ", ".join(without[:5]), ", ".join([*references][:5])
        raise VdoorError(f"reference: wanted one for {wanted}, found {has}: {choice.reference}")
    trials = [_trial(path, *references[name], choice) for path, name in served.items() if name is not None]
    return Trials(trials=trials, without_reference=without)


def map_files(path: Path) -> list[Path]:
    """The map, or the maps in a folder, sorted by name, without references and without images that have a YAML."""
    return maps_in(path) if path.is_dir() else [path]


def _trial(path: Path, reference: Path, key: str | None, choice: Choice) -> Trial:
    """The map and its reference; `key` is the map's name in a reference for several maps."""
    own = MapChoice(path=path, resolution_m=choice.resolution_m, free_from=choice.free_from)
    grid, free = own.read(path.stem)
    division = Division(name=path.stem, grid=grid, free=free, rooms=np.zeros(free.shape, np.int32))
    bare = None
    if choice.bare is not None:
        bare = MapChoice(path=choice.bare, resolution_m=grid.frame.resolution_m, free_from=choice.free_from)
    return Trial(name=path.stem, division=division, reference=read_reference(reference, key, division, bare))


def trial_of(made: SyntheticMap, name: str) -> Trial:
    """A synthetic map as a trial, equal to one read from its files."""
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
