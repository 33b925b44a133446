"""Fitting the curves that score doors: what counts as real, and that the fit finds what is there."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from commands import call
from project import FLAT

from vdoor.method.scoring.features import FEATURES, FIRST
from vdoor.method.scoring.model import Curve, Curves, DoorModel, Rough, model_named, table_of, wide_log_odds
from vdoor.pipeline import Pipeline
from vdoor.synth import PRESETS, synthesize, write_synthetic
from vdoor.train import RealDoors, default_pipeline, fitted_model, labelled_maps, mean_of, synthetic_maps
from vdoor.train.examples import Examples, examples, judged
from vdoor.train.fit import fitted, hat_basis, knots_of, mean_curves


def door(unsure: bool = False) -> RealDoors:
    """One real door, 0.9 m wide, along x around 5, 5."""
    return RealDoors(np.array([[4.55, 5.0]]), np.array([[5.45, 5.0]]), np.array([0.9]), np.array([unsure]))


@pytest.mark.parametrize(
    ("start", "end", "label", "weight"),
    [
        ((4.5, 5.1), (5.5, 5.1), 1, 1),
        ((4.5, 5.4), (5.5, 5.4), 0, 0),  # 0.4 m beside it: nobody asks
        ((4.5, 5.6), (5.5, 5.6), 0, 1),
        ((5.0, 4.5), (5.0, 5.5), 0, 0),  # across it
        ((3.9, 5.0), (6.1, 5.0), 0, 0),  # much too long
    ],
)
def test_what_counts_as_a_real_door(
    start: tuple[float, float], end: tuple[float, float], label: int, weight: int
) -> None:
    found = judged(np.array([start]), np.array([end]), door())
    assert (found[0][0], found[1][0]) == (label, weight)


def test_near_an_unsure_door_nobody_asks() -> None:
    near, far = judged(np.array([[4.5, 5.1], [4.5, 8.0]]), np.array([[5.5, 5.1], [5.5, 8.0]]), door(unsure=True))[1]
    assert (near, far) == (0, 1)


def test_shares_of_knots_interpolate() -> None:
    at = knots_of(np.linspace(0.0, 1.0, 1001))
    values = np.array([-1.0, 0.0, 0.3, 0.77, 2.0])
    basis = hat_basis(values, at)
    assert basis.sum(axis=1) == pytest.approx(np.ones(5))
    assert basis @ at == pytest.approx(np.clip(values, at[0], at[-1]))


def toy(seed: int, corners_per_m: float, sign: float) -> Examples:
    """Doors that are real where their first feature is large (sign 1) or small (-1); the others say nothing."""
    rng = np.random.default_rng(seed)
    feature = rng.random((400, len(FIRST)))
    real = (sign * (feature[:, 0] - 0.5) > 0).astype(np.float64)
    return Examples(feature, real, np.ones(400), Rough().share(corners_per_m))


def test_the_fit_finds_what_is_there_in_clean_and_ragged_maps() -> None:
    curves = fitted([toy(0, 0.2, 1.0), toy(1, 2.5, -1.0)], FIRST, smooth=0.1, ridge=0.1, together=0.0)
    rng = np.random.default_rng(2)
    feature = rng.random((500, len(FIRST)))
    for corners_per_m, sign in ((0.2, 1.0), (2.5, -1.0)):
        odds = curves.log_odds(feature, Rough().share(corners_per_m))
        assert np.mean((odds > 0) == (sign * (feature[:, 0] - 0.5) > 0)) > 0.9
    said = curves.says(feature, 0.0)
    assert np.abs(said[:, 0]).mean() > 5 * np.abs(said[:, 1:]).mean()


def test_a_feature_for_clean_maps_alone_says_nothing_of_ragged_ones() -> None:
    data = [toy(0, 0.2, 1.0), toy(1, 2.5, 1.0)]
    curves = fitted(data, FIRST, clean_only=FIRST[:1], smooth=0.1, ridge=0.1)
    feature = 0.9 * np.random.default_rng(2).random((500, len(FIRST)))  # no door too long for a home
    assert np.abs(curves.says(feature, 0.0)[:, 0]).mean() > 1
    assert (curves.says(feature, 1.0)[:, 0] == 0).all()


def test_the_mean_lies_between_at_the_first_ones_knots() -> None:
    one = Curves({"x": Curve((0.0, 2.0), (0.0, 4.0), (1.0, 1.0))}, -1.0, 0.5)
    other = Curves({"x": Curve((1.0, 3.0), (2.0, 6.0), (0.0, 2.0))}, -2.0, 0.0)
    curve = Curve((0.0, 2.0), (1.0, 4.0), (0.5, 1.0))
    assert mean_curves([one, other]) == Curves({"x": curve}, -1.5, 0.25)
    assert mean_curves([one]) == one


def test_equal_seeds_give_equal_curves() -> None:
    def curves(seed: int) -> DoorModel:
        return fitted_model(synthetic_maps(2, 1, seed), default_pipeline(), {})

    assert curves(1) == curves(1)
    assert curves(1) != curves(2)


def test_a_labelled_synthetic_map_gives_the_examples_of_its_truth(tmp_path: Path) -> None:
    made = synthesize(PRESETS["paper-5cm"], np.random.default_rng(4))
    write_synthetic(made, tmp_path / "flat", seed=4)
    pipeline: Pipeline = default_pipeline()
    (training_map,) = labelled_maps(tmp_path, tmp_path, weight=3.0)
    found = examples(training_map, pipeline)
    assert found.real.sum() >= len(made.doors)
    assert set(found.weight.tolist()) <= {0.0, 3.0}
    assert found.weight.any()
    again = examples(training_map, pipeline, model_named("shipped").first)
    assert (again.feature[:, : len(FIRST)] == found.feature).all()
    assert again.feature.shape[1] == len(FEATURES)


def test_the_command_writes_curves_that_a_run_can_use(tmp_path: Path) -> None:
    curves = tmp_path / "curves.json"
    done = call("train", "-o", curves, "--homes", "3", "--offices", "1", "--rounds", "2")
    assert "8 maps" in done.stdout
    assert tuple(model_named(str(curves)).last.curves) == FEATURES
    made = json.loads(curves.read_text())["made"]
    assert made["command"] == "vdoor train --homes 3 --offices 1 --seed 0 --rounds 2"
    rounds = [fitted_model(synthetic_maps(3, 1, seed), default_pipeline(), {"labelled_maps": 0}) for seed in (0, 1)]
    assert made["examples"] == sum(one.made["examples"] for one in rounds)
    assert table_of(model_named(str(curves))) == table_of(mean_of(rounds, made))
    assert call("train", "-o", curves, "--homes", "1", code=2).stdout == ""
    call("run", FLAT, "-q", "--set", f"score.model={curves}")


@pytest.mark.parametrize(("share_rough", "against"), [(0.5, 0.0), (0.75, 2.2), (1.0, 2.2)])
def test_a_long_door_is_less_likely_on_maps_as_rough_as_homes(share_rough: float, against: float) -> None:
    assert wide_log_odds(np.array([0.9, 1.2]), share_rough).tolist() == [0.0, -against]
