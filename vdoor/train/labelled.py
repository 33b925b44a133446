"""Examples from maps that somebody has labelled."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from vdoor.errors import VdoorError
from vdoor.evaluate import Division, MapChoice, read_reference
from vdoor.evaluate.cases import references_in, serving
from vdoor.evaluate.division import IMAGES
from vdoor.evaluate.reference import bare_name
from vdoor.formats import READERS, read_map
from vdoor.pipeline import Pipeline
from vdoor.train.examples import Examples, examples, marked_real

SUFFIXES = tuple(suffix for reader in READERS for suffix in reader.suffixes)


def labelled_examples(
    maps: Path, reference: Path, pipeline: Pipeline, *, bare: Path | None = None, resolution_m: float | None = None
) -> list[Examples]:
    """Examples of every map in a folder that a reference serves by its name; VdoorError where there is none."""
    references = references_in(reference)
    truths = {path for path, _ in references.values()}
    found = []
    paths = sorted(maps.iterdir()) if maps.is_dir() else [maps]
    described = {path.stem for path in paths if path.suffix.lower() in (".yaml", ".yml")}
    for path in paths:
        known = serving(path.stem, references)
        if path.stem in described and path.suffix.lower() in IMAGES:
            continue  # the image of a map_server YAML
        if known is None or path in truths or bare_name(path) != path.stem or path.suffix.lower() not in SUFFIXES:
            continue
        grid = read_map(path, resolution_m=None if path.suffix.lower() in (".json", ".yaml") else resolution_m)
        division = Division(name=path.stem, grid=grid, free=grid.free, rooms=np.zeros(grid.cells.shape, np.int32))
        choice = None if bare is None else MapChoice(path=bare, resolution_m=resolution_m)
        truth = read_reference(*references[known], division, choice)
        unsure = None if truth.unsure is None else truth.unsure.ends
        real = marked_real(truth.doors.ends, truth.doors.width_m, grid.frame, unsure)
        found.append(examples(grid, real, pipeline))
    if not found:
        raise VdoorError(f"--maps: wanted maps that {reference} has the truth of, found none: {maps}")
    return found
