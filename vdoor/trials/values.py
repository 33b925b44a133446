"""Values of a setting as text: ``0.7..0.98:0.02``, ``a,b,c``, or both together."""

from __future__ import annotations

import tomllib
from decimal import Decimal
from typing import Any

from vdoor.errors import SettingError

MOST_VALUES = 1000
"""More are a slip of the pen."""
RANGE, STEP = "..", ":"


def values_in(text: str, place: str) -> tuple[Any, ...]:
    """The values, in the order of the text; SettingError names `place` where there is none or a range is no range.

    A range is FROM..TO:STEP, both ends included, and in steps of 1 where it names none. A list is whatever TOML takes
    between brackets, else bare words between commas.
    """
    if not text.strip():
        raise SettingError(f"{place}: wanted FROM..TO:STEP or values with commas between, found nothing")
    values = _listed(text)
    if values is None:
        parts = [part.strip() for part in text.split(",")]
        values = tuple(value for part in parts for value in (_range(part, place) if RANGE in part else [_word(part)]))
    if len(values) > MOST_VALUES:
        raise SettingError(f"{place}: wanted at most {MOST_VALUES} values, found {len(values)}")
    return values


def _listed(text: str) -> tuple[Any, ...] | None:
    """The values of a TOML list; None where the text is none."""
    try:
        return tuple(tomllib.loads(f"values = [{text}]")["values"])
    except tomllib.TOMLDecodeError:
        return None


def _word(text: str) -> Any:
    """One value as TOML has it, or the text itself."""
    one = _listed(text)
    return one[0] if one else text


def _range(text: str, place: str) -> list[int | float]:
    """All numbers of a range, as exact as they are written: 0.1..0.3:0.1 holds 0.3."""
    ends, _, step_text = text.partition(STEP)
    first, _, last = ends.partition(RANGE)
    try:
        low, high, step = Decimal(first), Decimal(last), Decimal(step_text or "1")
        steps = int((high - low) / step) if high >= low and step > 0 else -1
    except (ArithmeticError, ValueError):  # no number, one without end, or one beyond all bounds
        steps = -1
    if steps < 0:
        raise SettingError(f"{place}: wanted a range FROM..TO:STEP that ascends, say 0.7..0.98:0.02, found {text!r}")
    if steps >= MOST_VALUES:
        raise SettingError(f"{place}: wanted at most {MOST_VALUES} values, found more: {text!r}")
    whole = all(number == number.to_integral_value() for number in (low, step))
    return [int(number) if whole else float(number) for number in (low + step * count for count in range(steps + 1))]
