"""Fit the curves that score doors, from synthetic maps and, if wanted, maps somebody has labelled."""

from __future__ import annotations

import json
from pathlib import Path

from vdoor.files import write_whole
from vdoor.pipeline import PRESETS, Pipeline
from vdoor.stages.door_model import DoorModel, table_of
from vdoor.train.examples import (
    Examples,
    RealDoors,
    examples,
    marked_real,
    real_doors,
    synthetic_examples,
    weighted,
)
from vdoor.train.fit import fitted
from vdoor.train.labelled import labelled_examples

__all__ = [
    "Examples", "RealDoors", "default_pipeline", "examples", "fitted", "labelled_examples", "marked_real", "real_doors",
    "synthetic_examples", "weighted", "write_model",
]  # fmt: skip


def default_pipeline() -> Pipeline:
    """The one whose virtual doors are scored."""
    pipeline = PRESETS["default"]
    assert isinstance(pipeline, Pipeline)
    return pipeline


def write_model(path: Path, model: DoorModel) -> None:
    """The model as JSON, one curve a line."""
    table = table_of(model)
    curves = ",\n".join(f"  {json.dumps(name)}: {json.dumps(curve)}" for name, curve in table.pop("curves").items())
    head = ",\n".join(f" {json.dumps(name)}: {json.dumps(value)}" for name, value in table.items())
    write_whole(path, f'{{\n{head},\n "curves": {{\n{curves}\n }}\n}}\n'.encode())
