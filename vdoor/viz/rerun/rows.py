"""Tables of records: one row after the other along a timeline."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import rerun as rr
from numpy.typing import NDArray

from vdoor.record import Record, Spec, specs, tables
from vdoor.viz.rerun.scene import Scene

Columns = dict[str, Any]


def table(scene: Scene, record: Record, name: str, *, without: Sequence[str] = ()) -> None:
    """A table of a record, some fields left out: one row each along the timeline of that name."""
    columns: Columns = {}
    for field in (field for field in tables(type(record))[name] if field not in without):
        values, spec = getattr(record, field), specs(type(record))[field][0]
        if not len(values):
            return
        columns |= columns_of(field, values, spec=spec)
    timeline = name if name == "corner" else "row"
    rows = np.arange(len(values))
    scene.columns(f"tables/{record.topic}", timeline, rows, rr.AnyValues.columns(**columns))


def columns_of(field: str, values: NDArray[Any], *, spec: Spec) -> Columns:
    """The columns of one field: words for codes, degrees for angles, one for each part of a vector."""
    if spec.words:
        return {field: np.array(spec.words)[values].tolist()}
    if spec.unit == "rad":
        return {field.replace("_rad", "_deg"): np.degrees(values)}
    if values.ndim == 1:
        return {field: values}
    axes = ("x", "y") if spec.unit == "m" else ("row", "col")
    names = axes if values.shape[1] == len(axes) else range(values.shape[1])
    return {f"{field}_{part}": values[:, at] for at, part in enumerate(names)}
