"""Positions written as text: X,Y."""

from __future__ import annotations

import math

from vdoor.errors import SettingError

Point = tuple[float, float]
FARTHEST = 1e9


def parse_place(text: str, *, what: str = "place", wanted: str = "X,Y") -> Point:
    """A position as x, y; raises `SettingError`, with `what` and `wanted`, unless the text is two valid numbers."""
    try:
        x, y = (float(part) for part in text.split(","))
    except ValueError:
        raise SettingError(f"{what}: wanted {wanted}, found {text!r}") from None
    if not math.hypot(x, y) < FARTHEST:
        raise SettingError(f"{what}: wanted finite numbers below {FARTHEST:g}, found {text!r}")
    return x, y


def place_text(place: Point) -> str:
    """X,Y rounded to a millimetre, without trailing zeros."""
    return ",".join(f"{round(value, 3) + 0.0:.3f}".rstrip("0").rstrip(".") for value in place)
