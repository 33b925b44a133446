"""How likely a virtual door is real: a sum of one curve per feature, fitted beforehand by `vdoor train`."""

from __future__ import annotations

import functools
import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vdoor.errors import SettingError
from vdoor.method.scoring.features import FEATURES, FIRST

Floats = NDArray[np.float64]
SHIPPED = "shipped"
FILE = "door_score.json"
MOST, MOST_BYTES = 1e6, 1_000_000


WIDE_M, WIDE_LOG_ODDS = (0.9, 1.05, 1.2, 1.35), (0.0, -0.8, -2.2, -3.0)
"""Prior on the length of doors in homes, added to its curve: 50 of 52 doors of real homes are 0.5 to 1.1 m long. The
synthetic homes have more long doors, so that they are learned, and office floors have many."""
HOMES_FROM, HOMES_TO = 0.5, 0.75
"""Share of rough above which a map is one of a home, so that the prior counts, and from which it counts in full: homes
have over 0.7, office floors up to 0.4."""


@dataclass(frozen=True)
class Curve:
    """Log-odds as a piecewise linear function of a feature's value, constant outside the given values."""

    at: tuple[float, ...]
    """The values, ascending."""
    clean: tuple[float, ...]
    """Log-odds on clean maps: drawn or neatly scanned."""
    rough: tuple[float, ...]
    """Log-odds on rough maps: with ragged walls and furniture."""

    def says(self, values: Floats, share_rough: float) -> Floats:
        """The log-odds (k,) for values (k,)."""
        both = np.array(self.clean) * (1 - share_rough) + np.array(self.rough) * share_rough
        return np.interp(values, self.at, both)


@dataclass(frozen=True)
class Rough:
    """How rough a map is, as a logistic function of the logarithm of its corners per metre of boundary."""

    middle_per_m: float = 0.75
    """Corners per metre at which a map is half rough: office floors have 0.2 to 0.7, homes 1 to 2.5."""
    softness: float = 0.24
    """Change of the logarithm of corners per metre that changes the log-odds of rough by 1."""

    def share(self, corners_per_m: float) -> float:
        """How rough a map is, 0 to 1."""
        away = math.log(max(corners_per_m, 1e-3) / self.middle_per_m) / self.softness
        return 1 / (1 + math.exp(-min(max(away, -30.0), 30.0)))


@dataclass(frozen=True)
class Curves:
    """Curves by feature; the log-odds of a door are their sum plus the bias."""

    curves: Mapping[str, Curve]
    bias_clean: float
    bias_rough: float

    def bias(self, share_rough: float) -> float:
        """The log-odds of a door before any feature is counted."""
        return self.bias_clean * (1 - share_rough) + self.bias_rough * share_rough

    def says(self, features: Floats, share_rough: float) -> Floats:
        """The log-odds (k, features) from each feature, in the order of `curves`."""
        columns = {
            name: curve.says(features[:, at], share_rough) for at, (name, curve) in enumerate(self.curves.items())
        }
        if "length_m" in columns:
            length_m = features[:, list(columns).index("length_m")]
            columns["length_m"] = columns["length_m"] + wide_log_odds(length_m, share_rough)
        return np.stack([*columns.values()], axis=1) if columns else np.zeros((len(features), 0))

    def log_odds(self, features: Floats, share_rough: float) -> Floats:
        """The log-odds (k,) that doors with these features (k, features) are real.

        Rounded to 1e-9, so that equivalent doors are equally likely on every machine.
        """
        return np.asarray(np.round(self.says(features, share_rough).sum(axis=1) + self.bias(share_rough), 9))


def wide_log_odds(length_m: Floats, share_rough: float) -> Floats:
    """The log-odds (k,) against doors (k,) that are longer than those of homes, on maps as rough as those of homes."""
    share = np.clip((share_rough - HOMES_FROM) / (HOMES_TO - HOMES_FROM), 0, 1)
    return np.asarray(share * np.interp(length_m, WIDE_M, WIDE_LOG_ODDS))


@dataclass(frozen=True)
class DoorModel:
    """The curves of pass 1, and of pass 2, in which the surest doors are closed."""

    first: Curves
    """Pass 1: curves of the features `FIRST`."""
    last: Curves
    """Pass 2: curves of the features `FEATURES`."""
    rough: Rough
    made: Mapping[str, Any]
    """How the model was made: the command, maps and seed."""


def model_from(table: Mapping[str, Any]) -> DoorModel:
    """The model in a table made by `table_of`; raises ValueError and similar exceptions for an invalid one."""
    first, last = (_curves(table[key], names) for key, names in (("first", FIRST), ("last", FEATURES)))
    middle_per_m, softness = (_number(table["rough"][name]) for name in ("middle_per_m", "softness"))
    if min(middle_per_m, softness) <= 0:
        raise ValueError("rough: a number that is not positive")
    return DoorModel(first, last, Rough(middle_per_m, softness), dict(table["made"]))


def _curves(table: Mapping[str, Any], names: tuple[str, ...]) -> Curves:
    """The curves of one pass; raises ValueError unless they are for the features `names`, in this order."""
    if tuple(table["curves"]) != names:
        other = sorted({*names} ^ {*table["curves"]})
        raise ValueError(f"curves for different features: {', '.join(other[:3]) or 'in a different order'}")
    curves = {
        name: _curve(name, *(curve[part] for part in ("at", "clean", "rough")))
        for name, curve in table["curves"].items()
    }
    return Curves(curves, *(_number(table["bias"][name]) for name in ("clean", "rough")))


def _number(value: object) -> float:
    """The value as float; raises ValueError unless it is a number up to `MOST`."""
    if isinstance(value, bool) or not isinstance(value, int | float) or not abs(value) <= MOST:
        raise ValueError(f"{str(value)[:40]!r} instead of a number")
    return float(value)


def _curve(name: str, at: Any, clean: Any, rough: Any) -> Curve:
    """A curve; raises ValueError unless its values ascend and each has log-odds."""
    curve = Curve(*(tuple(map(_number, part)) for part in (at, clean, rough)))
    if not 0 < len(curve.at) == len(curve.clean) == len(curve.rough) or list(curve.at) != sorted(set(curve.at)):
        raise ValueError(f"{name}: a curve whose values do not ascend, or lack log-odds")
    return curve


def table_of(model: DoorModel) -> dict[str, Any]:
    """The model as a table for JSON, starting with how it was made."""
    return {
        "made": dict(model.made),
        "rough": {"middle_per_m": model.rough.middle_per_m, "softness": model.rough.softness},
        "first": _table(model.first),
        "last": _table(model.last),
    }


def _table(curves: Curves) -> dict[str, Any]:
    return {
        "bias": {"clean": curves.bias_clean, "rough": curves.bias_rough},
        "curves": {
            name: {"at": list(curve.at), "clean": list(curve.clean), "rough": list(curve.rough)}
            for name, curve in curves.curves.items()
        },
    }


@functools.cache
def model_named(name: str) -> DoorModel:
    """The shipped model, or the one in a file; raises SettingError if it is invalid or for different features."""
    try:
        return model_from(json.loads(_text(name)))
    except OSError as error:
        raise SettingError(
            f"score.model: wanted {SHIPPED!r} or a readable file, found {error.strerror}: {name}"
        ) from error
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
        found = f"no key {error}" if isinstance(error, KeyError) else str(error)
        raise SettingError(f"score.model: wanted a file from `vdoor train`, found {found}: {name}") from error


def _text(name: str) -> str:
    """The text of a model's file; raises ValueError unless it is a regular file of plausible size."""
    if name == SHIPPED:
        return resources.files("vdoor.method.scoring").joinpath(FILE).read_text(encoding="utf-8")
    path = Path(name)
    if path.stat().st_size > MOST_BYTES or not path.is_file():
        raise ValueError("something else")
    return path.read_text(encoding="utf-8")
