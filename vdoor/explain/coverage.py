"""Coverage in words."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from vdoor.navigate.cover_floor import Coverage
from vdoor.navigate.coverage.path import KINDS

PURPOSES = {"way": "on the way to the next lane or room", "wall": "along walls and islands", "lane": "lanes"}
"""What a part of a path is for, in words."""


def described(coverage: Coverage) -> str:
    """A path in one line: how much it covers, how long and how winding it is."""
    minutes = coverage.time_s / 60
    return (
        f"{coverage.covered:.1%} covered, {coverage.length_m:.1f} m ({coverage.excess:.2f} times the least), "
        f"{minutes:.0f} min, {coverage.turns_per_m2:.1f} turns a m2"
    )


def figures(coverage: Coverage) -> list[tuple[str, str]]:
    """The measures of a path as a table: name and value with its unit."""
    return [
        ("covered", f"{coverage.covered:.2%} of what the tool can reach"),
        ("length", f"{coverage.length_m:.1f} m, {coverage.excess:.3f} times swept area over tool width"),
        ("swept twice", f"{coverage.swept_twice:.1%}"),
        ("turns", f"{coverage.turns}, {coverage.turns_per_m2:.1f} a m2"),
        ("rotation", f"{math.degrees(coverage.rotation_rad):.0f} degrees"),
        ("time", f"{coverage.time_s:.0f} s"),
        ("clearance", f"{coverage.clear_m:.3f} m at least"),
        ("changes of room", str(coverage.room_changes)),
    ]


def document_of(coverage: Coverage) -> dict[str, Any]:
    """A path as plain values."""
    numbers = ("radius_m", "tool_m", "covered", "length_m", "excess", "swept_twice", "turns", "turns_per_m2")
    columns = (coverage.point_m[:, 0], coverage.point_m[:, 1], coverage.yaw_rad, coverage.along_m, coverage.at_s)
    rows = np.stack(columns, axis=1).tolist()
    return {
        **{name: getattr(coverage, name) for name in numbers},
        "rotation_rad": coverage.rotation_rad,
        "time_s": coverage.time_s,
        "clear_m": coverage.clear_m,
        "room_changes": coverage.room_changes,
        "missed_rooms": coverage.missed.tolist(),
        "visits": [
            {"room": room or None, "done_s": done_s}
            for room, done_s in zip(coverage.visit_room.tolist(), coverage.visit_done_s.tolist(), strict=True)
        ],
        "path": [
            {
                "x_m": x_m,
                "y_m": y_m,
                "yaw_rad": yaw,
                "along_m": along_m,
                "at_s": at_s,
                "purpose": KINDS[code],
                "visit": at,
            }
            for (x_m, y_m, yaw, along_m, at_s), code, at in zip(
                rows, coverage.purpose.tolist(), coverage.visit.tolist(), strict=True
            )
        ],
    }
