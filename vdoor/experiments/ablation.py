"""Ablation: the effect of each part of the method, measured on the same maps with and without it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from vdoor.config import with_settings
from vdoor.engines import Over
from vdoor.experiments.cases import Trial
from vdoor.experiments.measure import Row, summarised, timed
from vdoor.method.scoring.model import model_named
from vdoor.pipeline import METHODS, AnyPipeline, preset_named

Tables = Mapping[str, Mapping[str, Any]]
NO_EXTENSION_M = 0.1
"""Maximum length of extensions that excludes them all."""
NO_DOOR_LOG_ODDS = 100.0
"""Threshold above all log-odds: no door is closed in pass 2, which then equals pass 1."""
SHORT_M = 1.2
"""Maximum length of a virtual door in the paper."""


@dataclass(frozen=True, kw_only=True)
class Variant:
    """One row of the table: the pipeline with some settings changed."""

    name: str
    settings: Tables = field(default_factory=dict)
    """Settings that override the pipeline's, as in a settings file."""
    preset: str | None = None
    """Preset to use instead of the pipeline."""

    def of(self, pipeline: AnyPipeline) -> AnyPipeline:
        """The pipeline in this variant; `SettingError` if it does not have these settings."""
        base = pipeline if self.preset is None else preset_named(self.preset)
        return with_settings(base, self.settings, METHODS, place=f"variant '{self.name}'")


VARIANTS = (
    Variant(name="full method"),
    Variant(name="islands kept", settings={"simplify": {"max_island_m": 0.0}}),
    Variant(name="thin unknown lines kept", settings={"simplify": {"thin_unknown_m": 0.0}}),
    Variant(name="gaps not closed", settings={"simplify": {"gap_m": 0.0}}),
    Variant(name="slits not closed", settings={"simplify": {"slit_m": 0.0, "channel_m": 0.0}}),
    Variant(name="largest free space only", settings={"simplify": {"least_part_m2": 0.0}}),
    Variant(name="no wall extensions", settings={"doors": {"extension_m": NO_EXTENSION_M}}),
    Variant(
        name="short doors only",
        settings={"doors": {"pair_m": SHORT_M, "single_m": SHORT_M, "extension_m": NO_EXTENSION_M}},
    ),
    Variant(name="one pass", settings={"score": {"sure_log_odds": NO_DOOR_LOG_ODDS}}),
    Variant(name="no room term", settings={"cost": {"lack_weight": 0.0, "lack_weight_rough": 0.0}}),
    Variant(name="no bias for further doors", settings={"cost": {"further_bias": 0.0, "further_bias_rough": 0.0}}),
    Variant(name="greedy choice", settings={"search": {"generations": 0}}),
    Variant(name="cells of 20 cm", settings={"simplify": {"cell_m": 0.2}}),
    Variant(name="preset paper", preset="paper"),
)


def variants_with(models: Sequence[Path]) -> tuple[tuple[Variant, ...], tuple[Variant, ...]]:
    """The variants, and one variant for each file of curves; `SettingError` if a file has no valid curves."""
    for path in models:
        model_named(str(path))
    return VARIANTS, tuple(
        Variant(name=f"model {path.name}", settings={"score": {"model": str(path)}}) for path in models
    )


def ablation(
    trials: Sequence[Trial],
    pipeline: AnyPipeline,
    *,
    variants: Sequence[Variant] = VARIANTS,
    models: Sequence[Variant] = (),
    seed: int = 0,
    over: Over = map,
) -> Iterator[Row]:
    """One row per variant and model, then mean and spread over the models if there are several."""
    # All settings are checked before the first run.
    pipelines = {variant.name: variant.of(pipeline) for variant in (*variants, *models)}
    found = []
    for variant in (*variants, *models):
        row = summarised(variant.name, over(partial(timed, pipeline=pipelines[variant.name], seed=seed), trials))
        found.append(row)
        yield row
    if len(models) > 1:
        yield from mean_and_spread(found[-len(models) :])


def mean_and_spread(rows: Sequence[Row]) -> tuple[Row, Row]:
    """Mean and sample standard deviation of each figure over the rows."""
    values = {name: [row.figures[name] for row in rows] for name in rows[0].figures}
    count = f"of {len(rows)} models"
    return (
        Row(name=f"mean {count}", figures={name: float(np.mean(column)) for name, column in values.items()}),
        Row(name=f"spread {count}", figures={name: float(np.std(column, ddof=1)) for name, column in values.items()}),
    )
