"""The results of an evaluation as text and as JSON."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from vdoor.errors import SettingError
from vdoor.evaluate.cases import Cases
from vdoor.evaluate.door_places import TOLERANCES_M, Doors
from vdoor.evaluate.evaluation import Evaluation, means, pooled
from vdoor.frame import Frame

COLUMNS = {
    "rooms": "rooms_found",
    "of": "rooms_true",
    "iou": "iou",
    "iou_sym": "iou_sym",
    "mcc": "mcc",
    "recall": "room_recall",
    "prec": "room_precision",
    "doors": "doors_found",
    "of ": "doors_true",
    "door P": "door_precision",
    "door R": "door_recall",
    "door F1": "door_f1",
    "narrow": "narrow_recall",
    "F1 1 m": "door_f1_1m",
    "off m": "hits_apart_m",
    "tilt": "hits_tilt_deg",
}
"""Column headings of the table -> the figure in each."""


def summary(evaluations: Sequence[Evaluation]) -> dict[str, float]:
    """The means over the maps, and the door measures of all maps together."""
    return means(evaluations) | pooled(evaluations)


def lines(evaluations: Sequence[Evaluation]) -> Iterator[str]:
    """The lines of the table and, for a single map, of the doors that are not hits."""
    yield from table(evaluations)
    if len(evaluations) == 1:
        yield from door_lines(evaluations[0])


def lonely(cases: Cases) -> Iterator[tuple[str, str]]:
    """The name of each result without a reference, and what is missing; if there are several, also the reverse."""
    yield from ((name, "reference") for name in cases.without_reference)
    yield from ((name, "result") for name in cases.without_result if len(cases.cases) > 1)


def table(evaluations: Sequence[Evaluation]) -> Iterator[str]:
    """One line per map and, for several, their mean and the door measures of all maps together."""
    rows = {evaluation.name: evaluation.figures() for evaluation in evaluations}
    if len(rows) > 1:
        rows["mean"] = means(evaluations)
        rows["all doors"] = {name.removeprefix("pooled_"): value for name, value in pooled(evaluations).items()}
    width = max(map(len, rows))
    yield f"{'map':{width}s}  " + " ".join(f"{head.strip():>7s}" for head in COLUMNS)
    for name, figures in rows.items():
        yield f"{name:{width}s}  " + " ".join(f"{_shown(figures.get(key)):>7s}" for key in COLUMNS.values())


def _shown(value: float | None) -> str:
    if value is None:
        return "-"
    return str(value) if isinstance(value, int) else f"{value:.3f}"


def door_lines(evaluation: Evaluation) -> Iterator[str]:
    """A line for each missed, false or excused door, with its position in the map frame."""
    for fate, doors in fates(evaluation).items():
        if fate != "hits":
            for door in _places(doors, evaluation.division.frame):
                yield f"{fate:8s} {door['x_m']:8.2f},{door['y_m']:.2f}  {door['width_m']:.2f} m wide"


def fates(evaluation: Evaluation) -> dict[str, Doors]:
    """The doors by outcome at the smaller tolerance; hits are at their found positions."""
    match = evaluation.matches[TOLERANCES_M[0]]
    return {
        "hits": evaluation.doors[match.hit_found],
        "missed": evaluation.reference.doors[match.missed],
        "false": evaluation.doors[match.false],
        "excused": evaluation.doors[match.excused],
    }


def document(evaluations: Sequence[Evaluation], cases: Cases) -> dict[str, Any]:
    """All results as a JSON document."""
    return {
        "schema": 1,
        "maps": [_map(evaluation) for evaluation in evaluations],
        "summary": summary(evaluations),
        "without_reference": cases.without_reference,
        "without_result": cases.without_result,
    }


def _map(evaluation: Evaluation) -> dict[str, Any]:
    frame = evaluation.division.frame
    pairs = [] if evaluation.rooms is None else zip(
        evaluation.rooms.pairs.tolist(), evaluation.rooms.pair_iou.tolist(), strict=True
    )  # fmt: skip
    return {
        "name": evaluation.name,
        "reference": str(evaluation.reference.path),
        "figures": evaluation.figures(),
        "doors": {fate: _places(doors, frame) for fate, doors in fates(evaluation).items()},
        "room_pairs": [{"true": true, "found": found, "iou": iou} for (true, found), iou in pairs],
    }


def _places(doors: Doors, frame: Frame) -> list[dict[str, float]]:
    """The centre of each door in the map frame, and its width."""
    right_down = doors.centre_m / frame.resolution_m - 0.5
    points_m = frame.world_from_cell(right_down[:, ::-1])
    rows = np.column_stack([points_m, doors.width_m]).round(3).tolist()
    return [{"x_m": x_m, "y_m": y_m, "width_m": width_m} for x_m, y_m, width_m in rows]


def shortfalls(figures: dict[str, float], wanted: Sequence[str]) -> list[str]:
    """A line for each figure below its minimum, given as `door_f1=0.9`; raises `SettingError` for an unknown figure."""
    short = []
    for text in wanted:
        name, _, least = text.partition("=")
        if name not in figures:
            raise SettingError(f"--min: wanted a figure of {', '.join(figures)}, found {name!r}")
        try:
            limit = float(least)
        except ValueError:
            raise SettingError(f"--min: wanted {name}=NUMBER, found {text!r}") from None
        if not figures[name] >= limit:
            short.append(f"{name}: wanted at least {limit:g}, found {figures[name]:.4f}")
    return short
