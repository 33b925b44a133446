"""How likely a virtual door is a real one: a sum of one curve a feature, fitted beforehand (`vdoor train`)."""

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


@dataclass(frozen=True)
class Curve:
    """What a feature's value says: log-odds at a few values, straight in between and level beyond."""

    at: tuple[float, ...]
    clean: tuple[float, ...]
    """Where the map is drawn or neatly scanned."""
    rough: tuple[float, ...]
    """Where walls are ragged and furniture stands about."""

    def says(self, values: Floats, share_rough: float) -> Floats:
        """Log-odds (k,) for values (k,)."""
        both = np.array(self.clean) * (1 - share_rough) + np.array(self.rough) * share_rough
        return np.interp(values, self.at, both)


@dataclass(frozen=True)
class Rough:
    """Which maps count as ragged."""

    middle_per_m: float = 0.75
    """Corners per metre of boundary at which a map counts as half rough: floors have 0.2 to 0.7, homes 1 to 2.5."""
    softness: float = 0.24
    """How far from that, as a factor's logarithm, the share of rough changes by one unit of log-odds."""

    def share(self, corners_per_m: float) -> float:
        """How much a map counts as rough, 0 to 1."""
        away = math.log(max(corners_per_m, 1e-3) / self.middle_per_m) / self.softness
        return 1 / (1 + math.exp(-min(max(away, -30.0), 30.0)))


@dataclass(frozen=True)
class Curves:
    """Curves by feature; their sum and the bias are the log-odds of a door."""

    curves: Mapping[str, Curve]
    bias_clean: float
    bias_rough: float

    def bias(self, share_rough: float) -> float:
        """Log-odds of a door of which nothing is known."""
        return self.bias_clean * (1 - share_rough) + self.bias_rough * share_rough

    def says(self, features: Floats, share_rough: float) -> Floats:
        """What each feature says (k, features), in the order of `curves`."""
        columns = [curve.says(features[:, at], share_rough) for at, curve in enumerate(self.curves.values())]
        return np.stack(columns, axis=1) if columns else np.zeros((len(features), 0))

    def log_odds(self, features: Floats, share_rough: float) -> Floats:
        """Log-odds (k,) that doors with these features (k, features) are real.

        Rounded to billionths, so that doors that are alike are equally likely on every machine.
        """
        return np.asarray(np.round(self.says(features, share_rough).sum(axis=1) + self.bias(share_rough), 9))


@dataclass(frozen=True)
class DoorModel:
    """What is said of a door at a first look, and once the surest doors are shut."""

    first: Curves
    """For `FIRST`."""
    last: Curves
    """For `FEATURES`."""
    rough: Rough
    made: Mapping[str, Any]
    """By which command, from which maps and seed."""


def model_from(table: Mapping[str, Any]) -> DoorModel:
    """The model in a table as `table_of` makes it."""
    first, last = (_curves(table[look], names) for look, names in (("first", FIRST), ("last", FEATURES)))
    middle_per_m, softness = (_number(table["rough"][name]) for name in ("middle_per_m", "softness"))
    if min(middle_per_m, softness) <= 0:
        raise ValueError("rough: a number that is not above 0")
    return DoorModel(first, last, Rough(middle_per_m, softness), dict(table["made"]))


def _curves(table: Mapping[str, Any], names: tuple[str, ...]) -> Curves:
    """The curves of one look, which are for these features."""
    if tuple(table["curves"]) != names:
        other = sorted({*names} ^ {*table["curves"]})
        raise ValueError(f"curves for other features: {', '.join(other[:3]) or 'in another order'}")
    curves = {
        name: _curve(name, *(curve[part] for part in ("at", "clean", "rough")))
        for name, curve in table["curves"].items()
    }
    return Curves(curves, *(_number(table["bias"][name]) for name in ("clean", "rough")))


def _number(value: object) -> float:
    """The value, if it is a number that log-odds can have."""
    if isinstance(value, bool) or not isinstance(value, int | float) or not abs(value) <= MOST:
        raise ValueError(f"{str(value)[:40]!r} for a number")
    return float(value)


def _curve(name: str, at: Any, clean: Any, rough: Any) -> Curve:
    """A curve with as many values as places, and places that ascend."""
    curve = Curve(*(tuple(map(_number, part)) for part in (at, clean, rough)))
    if not 0 < len(curve.at) == len(curve.clean) == len(curve.rough) or list(curve.at) != sorted(set(curve.at)):
        raise ValueError(f"{name}: a curve whose places do not ascend or have no value")
    return curve


def table_of(model: DoorModel) -> dict[str, Any]:
    """The model as a table for JSON, how it was made first."""
    return {
        "made": dict(model.made),
        "rough": {"middle_per_m": model.rough.middle_per_m, "softness": model.rough.softness},
        "first": _table(model.first),
        "last": _table(model.last),
    }


def _table(look: Curves) -> dict[str, Any]:
    return {
        "bias": {"clean": look.bias_clean, "rough": look.bias_rough},
        "curves": {
            name: {"at": list(curve.at), "clean": list(curve.clean), "rough": list(curve.rough)}
            for name, curve in look.curves.items()
        },
    }


@functools.cache
def model_named(name: str) -> DoorModel:
    """The shipped model, or the one in a file; SettingError where that is none, or has curves for other features."""
    try:
        return model_from(json.loads(_text(name)))
    except OSError as error:
        raise SettingError(
            f"score.model: wanted {SHIPPED!r} or a readable file, found {error.strerror}: {name}"
        ) from error
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
        found = f"none called {error}" if isinstance(error, KeyError) else str(error)
        raise SettingError(f"score.model: wanted curves as `vdoor train` writes them, found {found}: {name}") from error


def _text(name: str) -> str:
    """What the file holds; ValueError where it is no plain file of a model's size."""
    if name == SHIPPED:
        return resources.files("vdoor.method.scoring").joinpath(FILE).read_text(encoding="utf-8")
    path = Path(name)
    if path.stat().st_size > MOST_BYTES or not path.is_file():
        raise ValueError("something else")
    return path.read_text(encoding="utf-8")
