"""Steps of a sweep: settings and their values, parsed from text into pipelines that are checked before any run."""

from __future__ import annotations

import tomllib
from collections.abc import Sequence
from dataclasses import dataclass
from decimal import Decimal
from typing import Any

from vdoor.config import METHOD, all_settings_of, field_docs, full_names, with_settings
from vdoor.errors import SettingError
from vdoor.method.scoring.model import model_named
from vdoor.pipeline import METHODS, AnyPipeline

PAPER = (
    "curvature.straightness=0.5..0.98:0.04",
    "candidates.angle_deg=85..175:10",
    "doors.max_length_m=0.4..3:0.2",
    "cost.room_m2=0..10:1",
    "cost.small_weight=0,0.05,0.1,0.25..2:0.25",
    "cost.area_weight_per_m2=0,0.005,0.01,0.02..0.2:0.03",
    "cost.tilt_weight_per_deg=0,0.005,0.01,0.02..0.2:0.03",
    "simplify.cell_m=0.05..0.4:0.05",
    "seed=0..9",
)
"""Settings that the paper fixes or leaves open: U_k, the angle of eq. 5, the longest door, T and weights of eq. 7,
cell size."""
SEED, CURVES = "seed", "score.model"
UNITS = {"_per_m2": "1/m²", "_per_deg": "1/degree", "_m2": "m²", "_deg": "degrees", "_m": "m"}
"""Units of settings by the suffix of their name."""


@dataclass(frozen=True, kw_only=True)
class Setting:
    """A setting that is swept."""

    name: str
    """``stage.field`` or ``seed``."""
    meaning: str

    @property
    def unit(self) -> str:
        """Unit of its values, or empty."""
        return next((unit for ending, unit in UNITS.items() if self.name.endswith(ending)), "")


@dataclass(frozen=True, kw_only=True)
class Step:
    """One value of a setting, and the pipeline and seed of its run."""

    setting: Setting
    value: Any
    """As in the pipeline: a text, bool or number, or a tuple of these."""
    own: bool
    """Whether this is the pipeline's own value."""
    pipeline: AnyPipeline
    seed: int


def planned(sweeps: Sequence[str], pipeline: AnyPipeline, *, seed: int = 0) -> list[Step]:
    """Every step of sweeps like ``stage.field=0.7..0.9:0.1``, ``stage.field=a,b`` or ``seed=0..9``.

    The pipeline's own value is always included, and numbers are sorted. Raises `SettingError` for an unknown setting
    or a value that it cannot have.
    """
    steps: dict[str, list[Step]] = {}
    for text in sweeps:
        name, _, listed = (part.strip() for part in text.partition("="))
        if name in steps:
            raise SettingError(f"sweep: wanted each setting once, found {name} twice")
        if name != SEED and "." not in name:
            meant = " or ".join(f"{full}={listed}" for full in full_names(all_settings_of(pipeline, METHODS), name))
            hint = f"; did you mean {meant}?" if meant else ""
            raise SettingError(f"sweep: wanted stage.field=VALUES or seed=VALUES, found {text!r}{hint}")
        values = values_in(listed, f"sweep: {name}")
        found = seeds(values, pipeline, seed) if name == SEED else settings(name, values, pipeline, seed)
        numbers = all(_is_number(step.value) for step in found)
        steps[name] = sorted(found, key=lambda step: step.value) if numbers else found
    return [step for found in steps.values() for step in found]


def seeds(values: Sequence[Any], pipeline: AnyPipeline, seed: int) -> list[Step]:
    """One step per seed."""
    for value in values:
        if type(value) is not int or value < 0:
            raise SettingError(f"sweep: seed: wanted whole numbers from 0, found {value!r}")
    setting = Setting(name=SEED, meaning="Random seed.")
    return [
        Step(setting=setting, value=value, own=value == seed, pipeline=pipeline, seed=value)
        for value in dict.fromkeys([*values, seed])
    ]


def settings(name: str, values: Sequence[Any], pipeline: AnyPipeline, seed: int) -> list[Step]:
    """One step per value of a setting."""
    stage, _, part = name.partition(".")

    def value_of(changed: AnyPipeline) -> Any:
        value = all_settings_of(changed, METHODS)[stage][part]
        return tuple(value) if isinstance(value, list) else value

    changed = [with_settings(pipeline, {stage: {part: value}}, METHODS, place="sweep") for value in values]
    for curves in values if name == CURVES else ():
        model_named(curves)  # check files as well, as no range does
    setting = Setting(name=name, meaning=_meaning(getattr(pipeline, stage), stage, part))
    own = value_of(pipeline)
    return [
        Step(setting=setting, value=value, own=value == own, pipeline=variant, seed=seed)
        for value, variant in {value_of(variant): variant for variant in (*changed, pipeline)}.items()
    ]


def _meaning(stage: object, name: str, part: str) -> str:
    """Description of a setting, as in `vdoor config`."""
    if part == METHOD:
        return f"One of {', '.join(METHODS[name])}."
    return field_docs(type(stage)).get(part, "")


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


MOST_VALUES = 1000
"""Maximum number of values; more are taken for a typing error."""
RANGE, STEP = "..", ":"


def values_in(text: str, place: str) -> tuple[Any, ...]:
    """Values in the order of the text; `SettingError` with `place` if there are none or a range is invalid.

    A range is FROM..TO:STEP, both ends included; the default step is 1. A list is parsed as a TOML array without
    brackets, or else as bare words separated by commas.
    """
    if not text.strip():
        raise SettingError(f"{place}: wanted FROM..TO:STEP or a list with commas, found nothing")
    values = _listed(text)
    if values is None:
        parts = [part.strip() for part in text.split(",")]
        values = tuple(value for part in parts for value in (_range(part, place) if RANGE in part else [_word(part)]))
    if len(values) > MOST_VALUES:
        raise SettingError(f"{place}: wanted at most {MOST_VALUES} values, found {len(values)}")
    return values


def _listed(text: str) -> tuple[Any, ...] | None:
    """Values of a TOML array without brackets; None if the text is not one."""
    try:
        return tuple(tomllib.loads(f"values = [{text}]")["values"])
    except (ValueError, RecursionError):
        return None


def _word(text: str) -> Any:
    """One TOML value, or the text itself."""
    one = _listed(text)
    return one[0] if one else text


def _range(text: str, place: str) -> list[int | float]:
    """All numbers of a range, in exact decimal arithmetic: 0.1..0.3:0.1 includes 0.3."""
    ends, _, step_text = text.partition(STEP)
    first, _, last = ends.partition(RANGE)
    try:
        low, high, step = Decimal(first), Decimal(last), Decimal(step_text or "1")
        steps = int((high - low) / step) if high >= low and step > 0 else -1
    except (ArithmeticError, ValueError):  # not a number, infinite or out of range
        steps = -1
    if steps < 0:
        raise SettingError(
            f"{place}: wanted a range FROM..TO:STEP in ascending order, such as 0.7..0.98:0.02, found {text!r}"
        )
    if steps >= MOST_VALUES:
        raise SettingError(f"{place}: wanted at most {MOST_VALUES} values, found more: {text!r}")
    whole = all(number == number.to_integral_value() for number in (low, step))
    return [int(number) if whole else float(number) for number in (low + step * count for count in range(steps + 1))]
