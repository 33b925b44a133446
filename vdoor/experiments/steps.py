"""What is swept, step by step: settings and their values as text, turned into checked pipelines before any runs."""

from __future__ import annotations

import tomllib
from collections.abc import Sequence
from dataclasses import dataclass
from decimal import Decimal
from typing import Any

from vdoor.config import METHOD, field_docs, settings_of, with_settings
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
"""What the paper chose, or left unsaid: U_k, the angle of eq. 5, the widest door, T and the weights of eq. 7, cells."""
SEED, CURVES = "seed", "score.model"
UNITS = {"_per_m2": "1/m²", "_per_deg": "1/degree", "_m2": "m²", "_deg": "degrees", "_m": "m"}
"""Of a setting, by how its name ends."""


@dataclass(frozen=True, kw_only=True)
class Setting:
    """What is swept."""

    name: str
    """``stage.field`` or ``seed``."""
    meaning: str

    @property
    def unit(self) -> str:
        """Of its values; empty where they have none."""
        return next((unit for ending, unit in UNITS.items() if self.name.endswith(ending)), "")


@dataclass(frozen=True, kw_only=True)
class Step:
    """One value of a setting and the run that it makes."""

    setting: Setting
    value: Any
    """As the pipeline has it: text, a truth value, a number or a tuple of them."""
    own: bool
    """The pipeline has it anyway."""
    pipeline: AnyPipeline
    seed: int


def planned(sweeps: Sequence[str], pipeline: AnyPipeline, *, seed: int = 0) -> list[Step]:
    """Every step of sweeps like ``stage.field=0.7..0.9:0.1``, ``stage.field=a,b`` or ``seed=0..9``.

    The pipeline's own value is always among them, and numbers ascend. Raises `SettingError` where there is no such
    setting, or it cannot have one of the values.
    """
    steps: dict[str, list[Step]] = {}
    for text in sweeps:
        name, _, listed = (part.strip() for part in text.partition("="))
        if name in steps:
            raise SettingError(f"sweep: wanted each setting once, found {name} twice")
        if name != SEED and "." not in name:
            raise SettingError(f"sweep: wanted stage.field=VALUES or seed=VALUES, found {text!r}")
        values = values_in(listed, f"sweep: {name}")
        found = seeds(values, pipeline, seed) if name == SEED else settings(name, values, pipeline, seed)
        numbers = all(_is_number(step.value) for step in found)
        steps[name] = sorted(found, key=lambda step: step.value) if numbers else found
    return [step for found in steps.values() for step in found]


def seeds(values: Sequence[Any], pipeline: AnyPipeline, seed: int) -> list[Step]:
    """A step for each seed."""
    for value in values:
        if type(value) is not int or value < 0:
            raise SettingError(f"sweep: seed: wanted whole numbers from 0, found {value!r}")
    setting = Setting(name=SEED, meaning="Seed of everything random.")
    return [
        Step(setting=setting, value=value, own=value == seed, pipeline=pipeline, seed=value)
        for value in dict.fromkeys([*values, seed])
    ]


def settings(name: str, values: Sequence[Any], pipeline: AnyPipeline, seed: int) -> list[Step]:
    """A step for each value of one setting."""
    stage, _, part = name.partition(".")

    def value_of(changed: AnyPipeline) -> Any:
        value = settings_of(changed, METHODS)[stage][part]
        return tuple(value) if isinstance(value, list) else value

    changed = [with_settings(pipeline, {stage: {part: value}}, METHODS, place="sweep") for value in values]
    for curves in values if name == CURVES else ():
        model_named(curves)  # a file is no setting's range, but can be as wrong
    setting = Setting(name=name, meaning=_meaning(getattr(pipeline, stage), stage, part))
    own = value_of(pipeline)
    return [
        Step(setting=setting, value=value, own=value == own, pipeline=there, seed=seed)
        for value, there in {value_of(there): there for there in (*changed, pipeline)}.items()
    ]


def _meaning(stage: object, name: str, part: str) -> str:
    """What the setting is, as `vdoor config` says."""
    if part == METHOD:
        return f"One of {', '.join(METHODS[name])}."
    return field_docs(type(stage)).get(part, "")


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


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
