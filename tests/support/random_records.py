"""Records drawn at random from their specs, for tests that hold for every type of record."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from vdoor.frame import Frame
from vdoor.pipeline import RECORDS
from vdoor.record import Record, Spec, specs

__all__ = ["RECORDS", "random_record"]

R = TypeVar("R", bound=Record)

TEXTS = ("", "Kitchen", "a = b", "Küche", "台所", "حمّام", "کتاب\u200cخانه", "🛏")  # noqa: RUF001  # any language
SPECIAL = np.array([np.inf, -np.inf, np.nan, 0.0, -0.0, 5e-324, 1.7976931348623157e308])


def random_record(record: type[R], rng: np.random.Generator, *, sizes: Mapping[str, int] | None = None) -> R:
    """Draw a record whose arrays have the lengths that `sizes` gives for their axes, 0 to 6 where it does not."""
    lengths = dict(sizes or {})
    fields: dict[str, Any] = {}
    for name, (spec, dtype) in specs(record).items():
        shape = tuple(
            int(axis) if axis.isdigit() else lengths.setdefault(axis, int(rng.integers(0, 7))) for axis in spec.axes
        )
        if spec.kind == "text":
            fields[name] = tuple(map(str, rng.choice(TEXTS, shape))) if rng.random() < 0.5 else ()
        else:
            fields[name] = _scalar(spec, rng) if dtype is None else _array(spec, rng, shape=shape, dtype=dtype)
    if "frame" in record.__dataclass_fields__:  # type: ignore[attr-defined]  # made a dataclass by Record
        height, width = (lengths.get(axis, int(rng.integers(0, 100))) for axis in ("height", "width"))
        fields["frame"] = Frame(height, width, float(rng.uniform(0.01, 0.5)), *rng.normal(0, 10, 3).tolist())
    return record(**fields)


def _scalar(spec: Spec, rng: np.random.Generator) -> float | int:
    return int(rng.integers(0, 2**53)) if spec.kind == "count" else float(_floats(rng, (1,))[0])


def _array(spec: Spec, rng: np.random.Generator, *, shape: tuple[int, ...], dtype: np.dtype[Any]) -> NDArray[Any]:
    if dtype == np.float64:
        return _floats(rng, shape)
    if dtype == np.bool_:
        return rng.random(shape) < 0.5
    low, high = {
        "occupancy": (-1, 101),
        "codes": (0, len(spec.words)),
        "code": (0, len(spec.words)),
        "labels": (0, int(rng.choice([5, 2**16, 2**31]))),
        "cell": (-2, 100),
    }.get(spec.kind, (np.iinfo(dtype).min, np.iinfo(dtype).max + 1))
    return rng.integers(low, high, shape, dtype=dtype)


def _floats(rng: np.random.Generator, shape: tuple[int, ...]) -> NDArray[np.float64]:
    """Draw ordinary numbers, and one in five that is not."""
    return np.where(rng.random(shape) < 0.2, rng.choice(SPECIAL, shape), rng.normal(0, 100, shape))
