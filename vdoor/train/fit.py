"""Curves that make examples likeliest, kept smooth and small: a logistic regression on shares of knots."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

from vdoor.errors import VdoorError
from vdoor.stages.door_model import Curve, DoorModel
from vdoor.stages.features import FEATURES
from vdoor.train.examples import Examples

Floats = NDArray[np.float64]

MIDDLE_PER_M, SOFTNESS = 0.75, 0.24
"""Between drawn floors (0.2 to 0.7 corners per metre) and homes (1 to 2.5)."""
QUANTILES = (0.01, 0.1, 0.25, 0.5, 0.75, 0.9, 0.99)
"""Where curves bend."""
SMOOTH, RIDGE, TOGETHER = 10.0, 2.0, 10.0
"""How strongly bends, values, and the difference between clean and ragged maps are held down."""


def fitted(
    data: Sequence[Examples],
    made: dict[str, Any],
    *,
    smooth: float = SMOOTH,
    ridge: float = RIDGE,
    together: float = TOGETHER,
) -> DoorModel:
    """The curves that make the examples likeliest, kept smooth and small."""
    feature = np.concatenate([part.feature for part in data])
    real = np.concatenate([part.real for part in data])
    weight = np.concatenate([part.weight for part in data])
    keep = weight > 0
    if not keep.any():
        raise VdoorError("train: wanted virtual doors to fit to, found none")
    blank = DoorModel({}, 0.0, 0.0, MIDDLE_PER_M, SOFTNESS, {})
    share = np.concatenate([np.full(len(part.real), blank.share_rough(part.corners_per_m)) for part in data])
    feature, real, weight, share = feature[keep], real[keep], weight[keep], share[keep]
    knots = [knots_of(column) for column in feature.T]
    hats = np.concatenate([hat_basis(column, at) for column, at in zip(feature.T, knots, strict=True)], axis=1)
    basis = np.concatenate(
        [hats * (1 - share)[:, None], hats * share[:, None], np.stack([1 - share, share], 1)], axis=1
    )
    penalty = penalties(knots, smooth, ridge)
    size = hats.shape[1]

    def loss(c: Floats) -> tuple[float, Floats]:
        z = basis @ c
        value = float((weight * (np.logaddexp(0, z) - real * z)).sum())
        gradient = basis.T @ (weight * (1 / (1 + np.exp(-z)) - real))
        for part in (slice(0, size), slice(size, 2 * size)):
            pc = penalty @ c[part]
            value += 0.5 * float(c[part] @ pc)
            gradient[part] += pc
        apart = c[:size] - c[size : 2 * size]
        value += 0.5 * together * float(apart @ apart)
        gradient[:size] += together * apart
        gradient[size : 2 * size] -= together * apart
        return value, gradient

    found = minimize(loss, np.zeros(basis.shape[1]), jac=True, method="L-BFGS-B", options={"maxiter": 400}).x
    begin = np.cumsum([0, *map(len, knots)])
    curves = {
        name: Curve(
            tuple(float(f"{x:.4g}") for x in at),
            tuple(float(f"{x:.4f}") for x in found[low : low + len(at)]),
            tuple(float(f"{x:.4f}") for x in found[size + low : size + low + len(at)]),
        )
        for name, at, low in zip(FEATURES, knots, begin[:-1], strict=True)
    }
    return DoorModel(curves, round(float(found[-2]), 4), round(float(found[-1]), 4), MIDDLE_PER_M, SOFTNESS, made)


def knots_of(column: Floats) -> Floats:
    """Values at which a feature's curve may bend, ascending; at least two."""
    at = np.unique([float(f"{x:.4g}") for x in np.quantile(column, QUANTILES)])
    return at if len(at) > 1 else np.array([at[0], at[0] + 1.0])


def hat_basis(column: Floats, at: Floats) -> Floats:
    """Shares (n, knots) of the knots in each value, as linear interpolation has them."""
    x = np.clip(column, at[0], at[-1])
    right = np.clip(np.searchsorted(at, x, "right"), 1, len(at) - 1)
    share = (x - at[right - 1]) / (at[right] - at[right - 1])
    out = np.zeros((len(x), len(at)))
    out[np.arange(len(x)), right - 1] = 1 - share
    out[np.arange(len(x)), right] += share
    return out


def penalties(knots: Iterable[Floats], smooth: float, ridge: float) -> Floats:
    """The quadratic form that keeps curves smooth (bends) and small (values)."""
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
