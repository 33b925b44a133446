"""Real, virtual and matched doors, as Table I counts them, for the proposed method and the existing ones."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vdoor.baselines import ErodedSpacePipeline, VoronoiDoorsPipeline
from vdoor.evaluate.matching import nearest_pairs
from vdoor.evidence.walk import paper
from vdoor.synth import SyntheticMap
from vdoor.topology import TopologicalMap

MATCHED_WITHIN_M = 0.5
"""How far the middles of a real and a virtual door may be apart."""
ISLANDS_UP_TO_M = 1.0
"""Where there is furniture, what stands free and is at most so long is taken out for every method."""
PROPOSED = "proposed"
METHODS: Mapping[str, Any] = MappingProxyType(  # Any: pipelines of several classes, all called alike
    {
        "voronoi-doors": VoronoiDoorsPipeline(),  # after [8]
        "eroded-space": ErodedSpacePipeline(),  # after [8]
        PROPOSED: paper(),
    }
)
"""The existing algorithm's two stand-ins, and the paper's method; all at its working resolution."""
Z_95 = 1.959963984540054
"""Standard normal deviate of a two-sided interval of 95 %."""


@dataclass(frozen=True, kw_only=True)
class Share:
    """A part of a number, with Wilson's interval of 95 %: doors are taken as independent of each other."""

    part: int
    of: int

    @property
    def value(self) -> float:
        """The share; nan of nothing."""
        return self.part / self.of if self.of else math.nan

    @property
    def interval(self) -> tuple[float, float]:
        """Where the true share lies with 95 % confidence; 0 to 1 of nothing."""
        if not self.of:
            return 0.0, 1.0
        share, weight = self.part / self.of, Z_95**2 / self.of
        middle = (share + weight / 2) / (1 + weight)
        half = math.sqrt(weight * (share * (1 - share) + weight / 4)) / (1 + weight)
        return max(middle - half, 0.0), min(middle + half, 1.0)


@dataclass(frozen=True, kw_only=True)
class DoorCount:
    """Doors of one map or of many."""

    real: int = 0
    virtual: int = 0
    """Doors that the method reports."""
    matched: int = 0
    """Pairs of a real and a virtual one at the same place."""

    def __add__(self, other: DoorCount) -> DoorCount:
        """Both together."""
        return DoorCount(
            real=self.real + other.real,
            virtual=self.virtual + other.virtual,
            matched=self.matched + other.matched,
        )

    @property
    def accuracy(self) -> Share:
        """Matched of virtual doors, the table's B / A."""
        return Share(part=self.matched, of=self.virtual)

    @property
    def found(self) -> Share:
        """Matched of real doors."""
        return Share(part=self.matched, of=self.real)


def counted(made: SyntheticMap, method: Any, *, seed: int = 0) -> DoorCount:
    """Doors of one map by one method, which takes small islands out where the map is furnished."""
    furnished = getattr(made.settings, "furniture", False)
    simplify = dataclasses.replace(method.simplify, max_island_m=ISLANDS_UP_TO_M if furnished else 0.0)
    found = dataclasses.replace(method, simplify=simplify)(made.grid, np.random.default_rng(seed))
    ends = [(door.start_m, door.end_m) for door in made.doors]
    real = np.array(ends, np.float64).reshape(-1, 2, 2).mean(axis=1)
    virtual = middles_m(found)
    matched, _ = nearest_pairs(real, virtual, MATCHED_WITHIN_M)
    return DoorCount(real=len(real), virtual=len(virtual), matched=len(matched))


def middles_m(found: TopologicalMap) -> NDArray[np.float64]:
    """Middle (k, 2) of each door as x, y, of one that borders more than two rooms once."""
    middle = (found.start_m + found.end_m) / 2
    return np.unique(middle.round(9), axis=0)
