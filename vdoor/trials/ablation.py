"""What each part of the recipe is worth: the same maps with and without it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from vdoor.pipeline import AnyPipeline
from vdoor.trials.cases import Trial
from vdoor.trials.measure import Row, measured, summarised, warm_up
from vdoor.trials.variants import VARIANTS, Variant


def ablation(
    trials: Sequence[Trial],
    pipeline: AnyPipeline,
    *,
    variants: Sequence[Variant] = VARIANTS,
    models: Sequence[Variant] = (),
    seed: int = 0,
) -> Iterator[Row]:
    """A row for each variant and model, then mean and spread over the models if there are several."""
    # All settings are checked before the first run.
    pipelines = {variant.name: variant.of(pipeline) for variant in (*variants, *models)}
    warm_up(trials, pipeline)
    found = []
    for variant in (*variants, *models):
        row = summarised(variant.name, (measured(trial, pipelines[variant.name], seed=seed) for trial in trials))
        found.append(row)
        yield row
    if len(models) > 1:
        yield from mean_and_spread(found[-len(models) :])


def mean_and_spread(rows: Sequence[Row]) -> tuple[Row, Row]:
    """Mean and standard deviation (of a sample) of each figure over the rows."""
    values = {name: [row.figures[name] for row in rows] for name in rows[0].figures}
    count = f"of {len(rows)} models"
    return (
        Row(name=f"mean {count}", figures={name: float(np.mean(column)) for name, column in values.items()}),
        Row(name=f"spread {count}", figures={name: float(np.std(column, ddof=1)) for name, column in values.items()}),
    )
