"""Sweeps as text and as JSON."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from vdoor.experiments.sweep import Point, by_setting

SHARES = {"door P": "door_precision", "door R": "door_recall", "door F1": "door_f1"}
"""Column headings and their figures, which are means over the maps."""
COUNTS = {
    "true": "doors_true",
    "found": "doors_found",
    "hit": "doors_hit",
    "false": "doors_false",
    "virtual": "virtual",
    "matched": "matched",
}
STAGES = {"rooms": "rooms_found", "of": "rooms_true", "corners": "corners", "proposed": "proposed"}
"""Column headings and their figures, which are sums over the maps, as in `COUNTS`."""
OWN = "*"


def lines(points: Sequence[Point]) -> Iterator[str]:
    """One table per setting, the pipeline's own value marked with a star."""
    for number, (setting, own) in enumerate(by_setting(points).items()):
        yield from [""] if number else []
        yield f"{setting.name}: {setting.meaning}"
        yield from table(own)


def table(points: Sequence[Point]) -> Iterator[str]:
    """Table of one sweep, one line per value."""
    rows = [row(point) for point in points]
    width = max(len(cell) for cells in rows for cell in cells[:1])
    heads = ["", *SHARES, *COUNTS, "accuracy", *STAGES, "cost", "failed"]
    for cells in (heads, *rows):
        yield f"{cells[0]:>{width}s}  " + " ".join(f"{cell:>8s}" for cell in cells[1:])


def row(point: Point) -> list[str]:
    """Table cells of one line."""
    shares = (shown(point.figures.get(name)) for name in SHARES.values())
    counts, stages = ([str(point.totals.get(name, "-")) for name in columns.values()] for columns in (COUNTS, STAGES))
    return [
        value_text(point.value) + (OWN if point.own else " "),
        *shares,
        *counts,
        shown(point.figures.get("accuracy")),
        *stages,
        shown(point.figures.get("cost")),
        str(len(point.failed)),
    ]


def shown(value: float | None) -> str:
    """A figure with three decimals, or a dash."""
    return "-" if value is None else f"{value:.3f}"


def value_text(value: Any) -> str:
    """A setting's value as short text that can be read back."""
    if isinstance(value, tuple):
        return ",".join(map(value_text, value))
    return (
        str(value).lower() if isinstance(value, bool) else f"{value:.12g}" if isinstance(value, float) else str(value)
    )


def document(points: Sequence[Point], about: Mapping[str, Any]) -> dict[str, Any]:
    """Document for JSON; `about` describes the runs."""
    return {
        "schema": 1,
        **about,
        "sweeps": [
            {
                "setting": setting.name,
                "meaning": setting.meaning,
                "unit": setting.unit or None,
                "points": [
                    {
                        "value": point.value,
                        "own": point.own,
                        "figures": point.figures,
                        "totals": point.totals,
                        "failed": point.failed,
                        "maps": point.maps,
                    }
                    for point in own
                ],
            }
            for setting, own in by_setting(points).items()
        ],
    }
