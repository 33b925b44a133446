"""Places as people write them: X,Y."""

from __future__ import annotations

import math

from vdoor.errors import SettingError

Point = tuple[float, float]
FARTHEST = 1e9


def parse_place(text: str, *, what: str = "place", wanted: str = "X,Y") -> Point:
    """Two numbers, of a size that a map can have; `SettingError` that says `what` they are for, and what was wanted."""
    try:
        x, y = (float(part) for part in text.split(","))
    except ValueError:
        raise SettingError(f"{what}: wanted {wanted}, found {text!r}") from None
    if not math.hypot(x, y) < FARTHEST:
        raise SettingError(f"{what}: wanted finite numbers below {FARTHEST:g}, found {text!r}")
    return x, y


def place_text(place: Point) -> str:
    """X,Y to a millimetre, as short as can be."""
    return ",".join(f"{round(value, 3) + 0.0:.3f}".rstrip("0").rstrip(".") for value in place)
