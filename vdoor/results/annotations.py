"""The annotations of a robot's map file as a table of map.json, and read back."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vdoor.errors import VdoorError
from vdoor.formats.source import shown
from vdoor.grid import Annotations, Line, Point, Segment
from vdoor.raster.runs import runs_of

LINES = ("virtual_walls_m", "no_go_areas_m", "no_mop_areas_m")


def table_of(annotations: Annotations) -> dict[str, Any]:
    """The annotations as a table; each segment has its cells as runs of row, first column, length."""
    table = dataclasses.asdict(annotations)
    labels = table.pop("labels")
    if labels is not None:
        runs = runs_of(labels)
        rows = np.stack([runs.row, runs.begin, runs.length], axis=1)
        for segment in table["segments"]:
            segment["runs"] = rows[runs.label == segment["label"]].ravel().tolist()
    return table


def read_table(table: Mapping[str, Any], shape: tuple[int, int]) -> Annotations:
    """The annotations in a table of map.json, for a map of that shape (h, w).

    Raises `VdoorError` for invalid values, and `KeyError` and similar exceptions for a table of a different structure.
    """
    segments = tuple(
        Segment(label=at, id=str(row["id"]), name=str(row["name"])) for at, row in enumerate(table["segments"], start=1)
    )
    places = {name: _point(table[name]) if table[name] is not None else None for name in ("robot_m", "charger_m")}
    return Annotations(
        own_origin_cm=_point(table["own_origin_cm"]),
        labels=_labels([row.get("runs", []) for row in table["segments"]], shape) if segments else None,
        segments=segments,
        robot_m=places["robot_m"],
        charger_m=places["charger_m"],
        virtual_walls_m=_lines(table["virtual_walls_m"]),
        no_go_areas_m=_lines(table["no_go_areas_m"]),
        no_mop_areas_m=_lines(table["no_mop_areas_m"]),
    )


def _labels(runs: list[Any], shape: tuple[int, int]) -> NDArray[np.int32]:
    """The label image (h, w) of segments 1, 2, ... from the runs of each."""
    labels = np.zeros(shape, np.int32)
    for label, numbers in enumerate(runs, start=1):
        for row, begin, length in np.array(numbers, np.int64).reshape(-1, 3).tolist():
            if not (0 <= row < shape[0] and begin >= 0 and 0 < length <= shape[1] - begin):
                raise VdoorError(f"map.json: wanted the runs of segment {label} within the map, found others")
            labels[row, begin : begin + length] = label
    return labels


def _lines(lines: Any) -> tuple[Line, ...]:
    return tuple(tuple(_point(point) for point in line) for line in lines)


def _point(values: Any) -> Point:
    x, y = values
    for value in (x, y):
        if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
            raise VdoorError(f"map.json: wanted a finite number, found {shown(value)}")
    return x, y
