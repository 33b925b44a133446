"""Section III: one generation of a search, the same record for all optimisers."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from typing import Annotated, ClassVar, Protocol

import numpy as np
from numpy.typing import NDArray

from vdoor.method.search.costs import Costs
from vdoor.method.search.problem import Bits, MergeProblem
from vdoor.record import Record, Spec


class Generation(Record):
    """The population after one generation; bit 1 = edge removed (as printed)."""

    topic: ClassVar[str] = "generation"

    number: Annotated[int, Spec("count")]
    evaluations: Annotated[int, Spec("count")]
    """Number of strings evaluated so far."""
    # Log-odds are sums of logarithms, whose last bits depend on the machine, rounded to 1e-9.
    best_cost: Annotated[float, Spec("number", tolerance=1e-6)]
    mean_cost: Annotated[float, Spec("number", tolerance=1e-6)]
    worst_cost: Annotated[float, Spec("number", tolerance=1e-6)]
    small_rooms: Annotated[int, Spec("count")]
    """NumSmallNode of the best string."""
    area_sd_m2: Annotated[float, Spec("number", unit="m2", tolerance=1e-9)]
    """AreaSD of the best string."""
    tilt_sd_deg: Annotated[float, Spec("number", unit="deg", tolerance=1e-9)]
    """DegSD of the best string."""
    removed: Annotated[NDArray[np.bool_], Spec("bits", "edge", of="initial_map.door")]
    """The best string, one bit per edge of the initial map."""


class Search(Protocol):
    """An optimiser: yields one generation at a time with the best choice so far; the last one is the result."""

    def __call__(self, problem: MergeProblem, rng: np.random.Generator) -> Iterator[Generation]:
        """The generations of a search; all randomness comes from `rng`."""
        ...


def summary(number: int, evaluations: int, strings: Bits, costs: Costs) -> Generation:
    """The record of a population (p, r) with its costs; of equally good strings the first is the best."""
    best = int(np.argmin(costs.cost))
    return Generation(
        number=number,
        evaluations=evaluations,
        best_cost=float(costs.cost[best]),
        mean_cost=float(costs.cost.mean()),
        worst_cost=float(costs.cost.max()),
        small_rooms=int(costs.small_rooms[best]),
        area_sd_m2=float(costs.area_sd_m2[best]),
        tilt_sd_deg=float(costs.tilt_sd_deg[best]),
        removed=strings[best],
    )


def with_best(generation: Generation, best: Generation) -> Generation:
    """The generation with its best string replaced by that of an earlier one."""
    return dataclasses.replace(
        generation,
        best_cost=best.best_cost,
        small_rooms=best.small_rooms,
        area_sd_m2=best.area_sd_m2,
        tilt_sd_deg=best.tilt_sd_deg,
        removed=best.removed,
    )
