"""Rows of figures as text and as JSON."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from vdoor.experiments.cases import Trial
from vdoor.experiments.measure import Row
from vdoor.experiments.robustness import DIFFERENCE

ABLATION = {
    "door P": "door_precision",
    "door R": "door_recall",
    "door F1": "door_f1",
    "pooled": "pooled_door_f1",
    "worst": "worst_door_f1",
    "iou_sym": "iou_sym",
    "CPU s": "cpu_s",
    "largest": "cpu_max_s",
}
"""Column headings of the table and their figures."""
ROBUSTNESS = {
    "door P": "door_precision",
    "door R": "door_recall",
    "door F1": "door_f1",
    "differs": DIFFERENCE,
    "pooled": "pooled_door_f1",
    "worst": "worst_door_f1",
}
SIGNED = {DIFFERENCE}


def table(rows: Sequence[Row], columns: Mapping[str, str], first: str) -> Iterator[str]:
    """Table with one line per row; `first` is the heading of the names."""
    width = max(len(name) for name in (first, *(row.name for row in rows)))
    yield f"{first:{width}s}  " + " ".join(f"{head:>7s}" for head in columns) + "  worst map"
    for row in rows:
        shown = " ".join(f"{_shown(key, row.figures.get(key)):>7s}" for key in columns.values())
        yield f"{row.name:{width}s}  {shown}  {row.worst_map or '-'}"


def _shown(key: str, value: float | None) -> str:
    if value is None:
        return "-"
    return f"{value:+.3f}" if key in SIGNED else f"{value:.3f}"


def document(rows: Sequence[Row], trials: Sequence[Trial], preset: str, seed: int) -> dict[str, Any]:
    """Document for JSON."""
    return {
        "schema": 1,
        "preset": preset,
        "seed": seed,
        "maps": [{"name": trial.name, "reference": str(trial.reference.path)} for trial in trials],
        "rows": [
            {
                "name": row.name,
                "figures": row.figures,
                "worst_map": row.worst_map or None,
                "door_f1": row.door_f1,
            }
            for row in rows
        ],
    }
