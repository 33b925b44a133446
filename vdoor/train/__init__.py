"""Fitting the curves that score doors, to synthetic maps and optionally to labelled maps."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from vdoor.method.scoring.model import DoorModel, table_of
from vdoor.partial import write_whole
from vdoor.pipeline import PRESETS, Pipeline
from vdoor.train.examples import (
    Draw,
    RealDoors,
    TrainingMap,
    known,
    labelled_maps,
    marked_real,
    real_doors,
    synthetic_maps,
)
from vdoor.train.fit import fitted_model, mean_of

__all__ = [
    "Draw",
    "RealDoors",
    "TrainingMap",
    "default_pipeline",
    "fitted_model",
    "known",
    "labelled_maps",
    "marked_real",
    "mean_of",
    "real_doors",
    "synthetic_maps",
    "write_model",
]  # fmt: skip


def default_pipeline() -> Pipeline:
    """The preset `default`, whose virtual doors are scored."""
    pipeline = PRESETS["default"]
    assert isinstance(pipeline, Pipeline)
    return pipeline


def write_model(path: Path, model: DoorModel) -> None:
    """Write the model as JSON, one curve per line."""
    table = table_of(model)
    passes = [f' "{name}": {_one_curve_per_line(table.pop(name))}' for name in ("first", "last")]
    head = [f" {json.dumps(name)}: {json.dumps(value)}" for name, value in table.items()]
    write_whole(path, "{{\n{}\n}}\n".format(",\n".join([*head, *passes])).encode())


def _one_curve_per_line(one_pass: dict[str, Any]) -> str:
    curves = ",\n".join(f"   {json.dumps(name)}: {json.dumps(curve)}" for name, curve in one_pass["curves"].items())
    return f'{{\n  "bias": {json.dumps(one_pass["bias"])},\n  "curves": {{\n{curves}\n  }}\n }}'
