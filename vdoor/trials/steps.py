"""What is swept, step by step: settings and their values as text, turned into checked pipelines before any runs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from vdoor.config import METHOD, field_docs, settings_of, with_settings
from vdoor.errors import SettingError
from vdoor.pipeline import METHODS, AnyPipeline
from vdoor.stages.door_model import model_named
from vdoor.trials.values import values_in

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
