"""Colours by name, the same in all views. Corners and doors have the colours of the paper's figures."""

from __future__ import annotations

import colorsys

Colour = tuple[int, int, int]
Glass = tuple[int, int, int, int]

FREE: Colour = (238, 238, 232)
UNKNOWN: Colour = (168, 172, 178)
OCCUPIED: Colour = (38, 40, 46)
BETWEEN: Colour = (120, 122, 128)

UNREACHABLE: Glass = (196, 128, 200, 200)
JUT: Glass = (240, 120, 40, 255)
NOTCH: Glass = (40, 170, 200, 255)
ISLAND: Glass = (220, 190, 40, 230)
THIN_UNKNOWN: Glass = (150, 120, 220, 230)
SLIT: Glass = (40, 150, 150, 230)
SILL: Glass = (200, 90, 130, 230)
CLEAR: Glass = (0, 0, 0, 0)
OF_REASON: dict[str, Glass] = {
    "unreachable": UNREACHABLE,
    "jut": JUT,
    "notch": NOTCH,
    "island": ISLAND,
    "thin unknown": THIN_UNKNOWN,
    "slit": SLIT,
    "sill": SILL,
}
"""Colours of changed cells, by the reason that the simplified grid gives."""

VIRTUAL_WALL: Colour = (150, 40, 190)
NO_GO: Colour = (220, 90, 30)
NO_MOP: Colour = (40, 120, 200)

BOUNDARY: Colour = (226, 178, 20)
WALKER: Colour = (214, 50, 60)
FORWARD: Colour = (214, 50, 60)
BACKWARD: Colour = (120, 70, 200)
CONVEX: Colour = (36, 92, 230)
CONCAVE: Colour = (20, 150, 70)
THRESHOLD: Colour = (214, 50, 60)

DOOR: Colour = (36, 92, 230)
KEPT: Colour = (214, 50, 60)
REMOVED: Colour = (104, 116, 164)
REJECTED: dict[str, Colour] = {
    "blocked": (214, 110, 20),
    "same wall": (128, 134, 40),
    "no gap": (70, 70, 80),
    "duplicate": (30, 146, 190),
    "too narrow": (160, 60, 160),
}
JUDGED: dict[str, Colour] = {"unlikely": (128, 134, 40), "outdone": (30, 146, 190)}
DOUBTFUL: Colour = (240, 150, 30)
SURE: Colour = (20, 120, 60)
SURE_LOG_ODDS = 4.0
"""Log-odds at which a door has the full colour of sure doors; at minus this, that of doubtful doors."""
CONFLICTS: Colour = (200, 60, 160)
EDIT: Colour = (150, 40, 190)

ROUTE: Colour = (30, 90, 220)
STOP: Colour = (20, 40, 120)
OF_PURPOSE: dict[str, Colour] = {"way": (214, 50, 60), "wall": (150, 40, 190), "lane": (30, 90, 220)}
"""Colours of a covering path, by what the robot drives for."""
SWEPT: Colour = (196, 222, 246)
ROBOT: Glass = (30, 90, 220, 150)
IN_THE_WAY: Colour = (214, 50, 60)
NODE: Colour = (236, 196, 30)
EDGE_MIDDLE: Colour = (214, 50, 60)
LINK: Colour = (200, 80, 80)

BEST: Colour = (20, 150, 70)
MEAN: Colour = (36, 92, 230)
WORST: Colour = (150, 150, 150)
BOUND: Colour = (200, 60, 160)

GOLDEN_RATIO = 0.61803398875


def odds(log_odds: float) -> Colour:
    """Colour of a door, between those of doubtful and sure doors."""
    share = min(max(log_odds / SURE_LOG_ODDS, -1.0), 1.0) / 2 + 0.5
    red, green, blue = (round(one + share * (other - one)) for one, other in zip(DOUBTFUL, SURE, strict=True))
    return red, green, blue


def room(number: int) -> Colour:
    """A light colour for a room; neighbouring numbers are far apart in hue."""
    red, green, blue = colorsys.hls_to_rgb(number * GOLDEN_RATIO % 1.0, 0.72 if number % 2 else 0.62, 0.62)
    return round(red * 255), round(green * 255), round(blue * 255)
