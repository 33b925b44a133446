"""Maps and the truth about each, read from files once for many runs, or drawn."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from vdoor.errors import VdoorError
from vdoor.evaluate import Division, MapChoice, Reference, marked_doors, read_reference, rooms_of
from vdoor.evaluate.cases import references_in, serving
from vdoor.evaluate.division import IMAGES
from vdoor.evaluate.reference import bare_name
from vdoor.formats import READERS
from vdoor.synth import SyntheticMap

DESCRIPTIONS = (".yaml", ".yml")
SUFFIXES = tuple(suffix for reader in READERS for suffix in reader.suffixes)


@dataclass(frozen=True, kw_only=True, eq=False)
class Trial:
    """One map and the truth about it."""

    name: str
    division: Division
    """The map, not divided yet."""
    reference: Reference


@dataclass(frozen=True, kw_only=True)
class Trials:
    """All maps that have a reference, and the names of those without."""

    trials: list[Trial]
    without_reference: list[str] = field(default_factory=list)


@dataclass(frozen=True, kw_only=True)
class Choice:
    """Which maps are tried, and how they and their references are read."""

    reference: Path
    bare: Path | None = None
    """The unfurnished map, or a folder of them, that label references were drawn on."""
    resolution_m: float | None = None
    free_from: int | None = None
    """The grey from which on a cell of an image is free, when doors and rooms are measured."""
    only: Sequence[str] = ()
    """Where there are any, a map's name must hold one of them."""
    exclude: Sequence[str] = ()

    def wants(self, name: str) -> bool:
        """Whether the map of that name is tried."""
        chosen = not self.only or any(text in name for text in self.only)
        return chosen and not any(text in name for text in self.exclude)


def read_trials(maps: Path, choice: Choice) -> Trials:
    """A map, or the maps in a folder, with the references of the same names.

    Raises `VdoorError` where no map is chosen or has a reference, or a file is missing, damaged, or of another size.
    """
    found = [path for path in map_files(maps) if path.resolve() != choice.reference.resolve()]
    paths = [path for path in found if choice.wants(path.stem)]
    if not paths:
        what = "map" if not found else f"map that is chosen among {len(found)}"
        raise VdoorError(f"maps: wanted a {what}, found none: {maps}")
    references = references_in(choice.reference)
    alone = [*references.values()] == [(choice.reference, None)]
    served = {path: serving(path.stem, references) for path in paths}
    if paths == [maps] and alone:  # one map and one reference, whatever they are called
        served = {maps: next(iter(references))}
    without = [path.stem for path, name in served.items() if name is None]
    if len(without) == len(paths):
        wanted, has = ", ".join(without[:5]), ", ".join([*references][:5])
        raise VdoorError(f"reference: wanted one for {wanted}, found {has}: {choice.reference}")
    trials = [_trial(path, *references[name], choice) for path, name in served.items() if name is not None]
    return Trials(trials=trials, without_reference=without)


def map_files(path: Path) -> list[Path]:
    """The map, or the maps in a folder by name: no references, and no image beside the YAML that describes it."""
    if not path.is_dir():
        return [path]
    files = sorted(entry for entry in path.iterdir() if entry.is_file() and entry.suffix.lower() in SUFFIXES)
    described = {entry.stem for entry in files if entry.suffix.lower() in DESCRIPTIONS}
    return [
        entry
        for entry in files
        if bare_name(entry) == entry.stem and not (entry.suffix.lower() in IMAGES and entry.stem in described)
    ]


def _trial(path: Path, reference: Path, key: str | None, choice: Choice) -> Trial:
    """The map and its reference; `key` is the map's name in one that holds several."""
    own = MapChoice(path=path, resolution_m=choice.resolution_m, free_from=choice.free_from)
    grid, free = own.read(path.stem)
    division = Division(name=path.stem, grid=grid, free=free, rooms=np.zeros(free.shape, np.int32))
    bare = None
    if choice.bare is not None:
        bare = MapChoice(path=choice.bare, resolution_m=grid.frame.resolution_m, free_from=choice.free_from)
    return Trial(name=path.stem, division=division, reference=read_reference(reference, key, division, bare))


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
