"""Least and most of each setting of apartments, homes and offices, and the check against them."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING

from vdoor.config import check_range
from vdoor.errors import SettingError
from vdoor.synth.canvas import FINE_M

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

Bounds = Mapping[str, tuple[float, float]]
"""Least and most of settings, by name; `wall_m` is short for `wall_min_m` and `wall_max_m`."""

CHANCE = (0.0, 1.0)
APARTMENT_BOUNDS: Bounds = MappingProxyType(
    {
        "area_m2": (4.0, 2000.0),
        "aspect_max": (1.0, 4.0),
        "rooms": (1, 200),
        "rooms_spread": (0, 100),
        "room_side_min_m": (1.6, 10.0),  # a shared wall must hold the widest door and two jambs
        "corridor_m": (0.95, 3.0),
        "wall_m": (0.1, 0.4),  # thinner walls would leak when they are turned
        "door_m": (0.7, 1.2),  # narrower doors may vanish at 20 cm
        "jamb_m": (0.1, 1.0),
        "wall_pieces_per_m2": CHANCE,
        "free_pieces_per_m2": CHANCE,
        "aisle_m": (0.5, 4.0),
        "door_clear_m": (0.7, 2.0),
        "juts_per_room": (0.0, 20.0),
        "wall_noise": (0.0, 0.5),
        "windows": (0.0, 20.0),
        "speckles": (0.0, 1000.0),
        "rotation_deg": (-360.0, 360.0),
        "margin_m": (0.4, 10.0),
        "cell_m": (FINE_M, 0.2),
    }
)
HOMES_AND_OFFICES: Bounds = MappingProxyType(
    {
        "unsure_from_m": (1.2, 10.0),
        "rough_max": (0.0, 0.5),
        "hollow_wall_m": (0.15, 0.6),
        "dash_gap_max_m": (0.0, 0.3),
    }
)
HOME_BOUNDS: Bounds = MappingProxyType(
    {
        "area_m2": (8.0, 1000.0),
        "aspect_max": (1.0, 4.0),
        "room_m2": (4.0, 200.0),
        "room_side_min_m": (1.0, 5.0),
        "corridor_m": (0.8, 3.0),
        "wall_m": (0.075, 0.6),  # thinner walls would leak when they are turned
        "door_m": (0.5, 1.2),
        "wall_pieces_per_m2": CHANCE,
        "free_pieces_per_m2": CHANCE,
        "clutter_per_m2": (0.001, 3.0),
        "wall_piece_clear_m": (0.0, 2.0),
        "clutter_clear_m": (0.0, 2.0),
        "shafts": (0.0, 20.0),
        "windows": (0.0, 20.0),
        "specks": (0.0, 100.0),
        "unknown_max": (0.0, 0.9),
        "scans_per_m2": (0.05, 10.0),
        "rays": (30, 4000),
        "range_m": (1.0, 30.0),
        "noise_max_m": (0.0, 0.2),
        "drift_max_m": (0.0, 0.3),
        "drift_max_deg": (0.0, 10.0),
        "hit_share": (0.01, 0.9),
        "glass": (0.0, 20.0),
        "people": (0.0, 20.0),
        "cell_m": (0.025, 0.05),  # walls are drawn for cells no larger
        **HOMES_AND_OFFICES,
    }
)
OFFICE_BOUNDS: Bounds = MappingProxyType(
    {
        "length_m": (8.0, 200.0),
        "corridors_max": (1, 12),
        "corridor_m": (1.0, 8.0),
        "room_depth_m": (2.0, 20.0),
        "room_width_m": (1.8, 20.0),
        "wall_m": (0.1, 0.6),
        "door_m": (0.7, 1.3),
        "cell_m": (0.025, 0.1),
        **HOMES_AND_OFFICES,
    }
)


def check(settings: DataclassInstance, bounds: Bounds) -> None:
    """Raise `SettingError` unless every value lies within its bounds, both included."""
    for field in dataclasses.fields(settings):
        value, (low, high) = getattr(settings, field.name), _bounds(field.name, bounds)
        check_range(value, low, high, f"{type(settings).__name__}.{field.name}")


def _bounds(name: str, bounds: Bounds) -> tuple[float, float]:
    """Return least and most of a setting; 0 to 1 for chances and 0 to 1e4 for others that have no bounds."""
    for key in (name, name.replace("_min", "").replace("_max", "")):
        if key in bounds:
            return bounds[key]
    return CHANCE if "_chance" in name else (0.0, 1e4)


def check_order(settings: DataclassInstance) -> None:
    """Raise `SettingError` if a setting that ends in `_max` is less than the one that ends in `_min`."""
    values = {field.name: getattr(settings, field.name) for field in dataclasses.fields(settings)}
    for low in (name for name in values if "_min" in name):
        high = low.replace("_min", "_max")
        if values[low] > values.get(high, math.inf):
            place = f"{type(settings).__name__}.{high}"
            raise SettingError(f"{place}: wanted at least {low} = {values[low]:g}, found {values[high]:g}")
