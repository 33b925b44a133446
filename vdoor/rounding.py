"""Numbers as they are written for people and programs: as exact as they are worth, by the unit in their names."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

DECIMALS = {"m": 3, "m2": 4, "deg": 2, "rad": 4, "s": 3}
"""Decimals of a number by the unit that its name ends with: a map is not more exact than a millimetre.

Records and recordings keep all digits; rooms and doors are rounded where they are made, see `TopologicalMap.written`.
"""
OTHER = 6
"""Decimals of numbers without a unit, such as shares."""


def rounded(value: Any, name: str = "", decimals: Mapping[str, int] = DECIMALS) -> Any:
    """A document of plain values with its numbers rounded; those in a list have the unit of the list's name."""
    if isinstance(value, float):
        return round(value, decimals.get(name.rpartition("_")[2], OTHER)) + 0.0  # no -0.0
    if isinstance(value, Mapping):
        return {key: rounded(item, key, decimals) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [rounded(item, name, decimals) for item in value]
    return value
