"""Maximum-likelihood curves with penalties on bends and values: a logistic regression on piecewise linear bases."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import partial
from typing import Any

import numpy as np
import scipy
from numpy.typing import NDArray

from vdoor.engines import Over
from vdoor.errors import VdoorError
from vdoor.method.scoring.closed_features import SHUT
from vdoor.method.scoring.features import FEATURES, FIRST
from vdoor.method.scoring.model import Curve, Curves, DoorModel, Rough
from vdoor.pipeline import Pipeline
from vdoor.train.examples import Draw, Examples, drawn_examples

Floats = NDArray[np.float64]

FIRST_EVERY = 3
"""Pass 1 is fitted to every third map, which is enough."""
QUANTILES = (0.01, 0.1, 0.25, 0.5, 0.75, 0.9, 0.99)
"""Quantiles of a feature's values that are knots of its curve."""
SMOOTH, RIDGE, TOGETHER = 10.0, 2.0, 10.0
"""Weights of the penalties on bends, on values, and on differences between the curves of clean and rough maps."""


def fitted_model(
    training_maps: Sequence[Draw], pipeline: Pipeline, made: dict[str, Any], *, over: Over = map
) -> DoorModel:
    """Curves for both passes; the numbers of examples and real doors are added to `made`."""
    drawn = training_maps[::FIRST_EVERY]
    first = fitted(list(over(partial(drawn_examples, pipeline=pipeline), drawn)), FIRST)
    data = list(over(partial(drawn_examples, pipeline=pipeline, first_pass=first), training_maps))
    count = sum(int((part.weight > 0).sum()) for part in data)
    real = sum(int(part.real.sum()) for part in data)
    return DoorModel(
        first, fitted(data, FEATURES, clean_only=SHUT), Rough(), {**made, "examples": count, "real_doors": real}
    )


def mean_of(models: Sequence[DoorModel], made: dict[str, Any]) -> DoorModel:
    """Mean of models fitted to different maps, which makes close decisions depend less on chance."""
    counts = {name: sum(model.made[name] for model in models) for name in ("examples", "real_doors")}
    return DoorModel(
        mean_curves([model.first for model in models]),
        mean_curves([model.last for model in models]),
        models[0].rough,
        {**made, **counts},
    )


def mean_curves(fits: Sequence[Curves]) -> Curves:
    """Mean of several models' curves for one pass, at the knots of the first model."""
    curves = {}
    for name, curve in fits[0].curves.items():
        same = [fit.curves[name] for fit in fits]
        clean = np.mean([np.interp(curve.at, one.at, one.clean) for one in same], axis=0)
        rough = np.mean([np.interp(curve.at, one.at, one.rough) for one in same], axis=0)
        curves[name] = Curve(curve.at, short(clean), short(rough))
    return Curves(curves, *short(np.mean([(fit.bias_clean, fit.bias_rough) for fit in fits], axis=0)))


def short(values: Floats) -> tuple[float, ...]:
    """Log-odds rounded to four decimals, as in the file."""
    return tuple(float(f"{value:.4f}") for value in values)


def fitted(
    data: Sequence[Examples],
    names: Sequence[str],
    *,
    clean_only: Sequence[str] = (),
    smooth: float = SMOOTH,
    ridge: float = RIDGE,
    together: float = TOGETHER,
) -> Curves:
    """Maximum-likelihood curves for the examples, with penalties on bends and values.

    Features in `clean_only` have no effect on rough maps, where furniture is taken for doors.
    """
    feature, real, weight, share = (
        np.concatenate(parts)
        for parts in zip(
            *((part.feature, part.real, part.weight, np.full(len(part.real), part.share_rough)) for part in data),
            strict=True,
        )
    )
    keep = weight > 0
    if not keep.any():
        raise VdoorError("train: wanted virtual doors to fit to, found none")
    feature, real, weight, share = feature[keep], real[keep], weight[keep], share[keep]
    knots = [knots_of(column) for column in feature.T]
    hats = np.concatenate([hat_basis(column, at) for column, at in zip(feature.T, knots, strict=True)], axis=1)
    both = np.concatenate([np.full(len(at), name not in clean_only) for name, at in zip(names, knots, strict=True)])
    columns = [hats * (1 - share)[:, None], (hats * share[:, None])[:, both], np.stack([1 - share, share], axis=1)]
    basis = np.concatenate(columns, axis=1)
    found = likeliest(basis, real, weight, _full_penalty(penalties(knots, smooth, ridge), both, together))

    clean, rough = found[: len(both)], np.zeros(len(both))
    rough[both] = found[len(both) : -2]
    begin = np.cumsum([0, *map(len, knots)]).tolist()
    curves = {
        name: Curve(
            tuple(float(f"{x:.4g}") for x in at),
            *(short(side[low : low + len(at)]) for side in (clean, rough)),
        )
        for name, at, low in zip(names, knots, begin[:-1], strict=True)
    }
    return Curves(curves, *short(found[-2:]))


def likeliest(basis: Floats, real: Floats, weight: Floats, penalty: Floats) -> Floats:
    """Coefficients (c,) of a logistic regression on `basis` (n, c), with a quadratic penalty (c, c)."""

    def loss(c: Floats) -> tuple[float, Floats]:
        z, gradient = basis @ c, penalty @ c
        value = float((weight * (np.logaddexp(0, z) - real * z)).sum()) + 0.5 * float(c @ gradient)
        return value, basis.T @ (weight * (1 / (1 + np.exp(-z)) - real)) + gradient

    found = scipy.optimize.minimize(
        loss, np.zeros(basis.shape[1]), jac=True, method="L-BFGS-B", options={"maxiter": 400}
    )
    return np.asarray(found.x)


def _full_penalty(penalty: Floats, both: NDArray[np.bool_], together: float) -> Floats:
    """Quadratic penalty on clean and rough values; the two biases are not penalised."""
    clean, rough = np.arange(len(both)), len(both) + np.arange(np.count_nonzero(both))
    full = np.zeros((len(both) + len(rough) + 2,) * 2)
    full[np.ix_(clean, clean)] = penalty
    full[np.ix_(rough, rough)] = penalty[np.ix_(both, both)]
    for one, other in ((clean[both], rough), (rough, clean[both])):
        full[one, one] += together
        full[one, other] -= together
    return full


def knots_of(column: Floats) -> Floats:
    """Knots of a feature's curve, ascending; at least two."""
    at = np.unique([float(f"{x:.4g}") for x in np.quantile(column, QUANTILES)])
    return at if len(at) > 1 else np.array([at[0], at[0] + 1.0])


def hat_basis(column: Floats, at: Floats) -> Floats:
    """Weights (n, knots) of the knots for each value, in linear interpolation."""
    x = np.clip(column, at[0], at[-1])
    right = np.clip(np.searchsorted(at, x, "right"), 1, len(at) - 1)
    share = (x - at[right - 1]) / (at[right] - at[right - 1])
    out = np.zeros((len(x), len(at)))
    out[np.arange(len(x)), right - 1] = 1 - share
    out[np.arange(len(x)), right] += share
    return out


def penalties(knots: Iterable[Floats], smooth: float, ridge: float) -> Floats:
    """Quadratic penalty on the bends and values of all curves, as a block diagonal matrix."""
    blocks = []
    for at in knots:
        block = ridge * np.eye(len(at))
        if len(at) > 2:  # noqa: PLR2004  # a bend needs three knots
            x = np.arange(len(at), dtype=np.float64)
            bend = np.diff(np.eye(len(x)), 2, axis=0)
            block = block + smooth * bend.T @ bend
        blocks.append(block)
    size = sum(map(len, blocks))
    whole, begin = np.zeros((size, size)), 0
    for block in blocks:
        end = begin + len(block)
        whole[begin:end, begin:end] = block
        begin = end
    return whole
