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
from vdoor.evaluate.door_places import nearest_pairs
from vdoor.paper.walk import paper
from vdoor.synth import SyntheticMap
from vdoor.topology import TopologicalMap

Lines = NDArray[np.float64]

MATCHED_WITHIN_M = 0.5
"""How far the middles of a real and a virtual door may be apart."""
ISLANDS_UP_TO_M = 1.0
"""Where there is furniture, what stands free and is at most so long is taken out for every method."""
PROPOSED = "proposed"
ISLANDS_KEPT = "islands-kept"
"""The proposed method where there is furniture and nothing is taken out, as the paper knows no such step."""
METHODS: Mapping[str, Any] = MappingProxyType(  # Any: pipelines of several classes, all called alike
    {
        "voronoi-doors": VoronoiDoorsPipeline(),  # after [8]
        "eroded-space": ErodedSpacePipeline(),  # after [8]
        PROPOSED: paper(),
    }
)
"""The existing algorithm's two stand-ins, and the paper's method; all at its working resolution."""
CALLED = {
    "voronoi-doors": "Voronoi doors",
    "eroded-space": "eroded space",
    PROPOSED: "proposed",
    ISLANDS_KEPT: "proposed with islands kept",
}
"""What they are called in tables."""
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


@dataclass(frozen=True, eq=False)
class Detection:
    """What a method reports on one map, beside the truth."""

    real_m: Lines
    virtual_m: Lines
    """Ends of each door (k, 2, 2) as x, y; one that borders more than two rooms is there once."""
    pairs: tuple[tuple[int, int], ...]
    """Which real door is which virtual one."""

    @property
    def count(self) -> DoorCount:
        """How many."""
        return DoorCount(real=len(self.real_m), virtual=len(self.virtual_m), matched=len(self.pairs))


def methods_for(made: SyntheticMap) -> dict[str, Any]:
    """Every method as it runs on a map, by name; where that is furnished, the proposed one `ISLANDS_KEPT` beside."""
    found = {name: for_map(made, method) for name, method in METHODS.items()}
    return found | ({ISLANDS_KEPT: METHODS[PROPOSED]} if is_furnished(made) else {})


def counted_all(made: SyntheticMap, *, seed: int = 0) -> dict[str, DoorCount]:
    """Doors of one map by every method."""
    return {name: detected(made, method, seed=seed).count for name, method in methods_for(made).items()}


def counted(made: SyntheticMap, method: Any, *, seed: int = 0) -> DoorCount:
    """Doors of one map by one method, which takes small islands out where the map is furnished."""
    return detected(made, for_map(made, method), seed=seed).count


def detected(made: SyntheticMap, method: Any, *, seed: int = 0) -> Detection:
    """Doors of one map by one method just as it is, those at the same place as pairs."""
    found = method(made.grid, np.random.default_rng(seed))
    real, virtual = real_lines_m(made), lines_m(found)
    rows, columns = nearest_pairs(real.mean(axis=1), virtual.mean(axis=1), MATCHED_WITHIN_M)
    return Detection(real, virtual, tuple(zip(rows.tolist(), columns.tolist(), strict=True)))


def for_map(made: SyntheticMap, method: Any) -> Any:
    """The method as it runs on a map: it takes small islands out where the map is furnished."""
    simplify = dataclasses.replace(method.simplify, max_island_m=ISLANDS_UP_TO_M if is_furnished(made) else 0.0)
    return dataclasses.replace(method, simplify=simplify)


def is_furnished(made: SyntheticMap) -> bool:
    """Whether the map was drawn with furniture."""
    return bool(getattr(made.settings, "furniture", False))


def real_lines_m(made: SyntheticMap) -> Lines:
    """Ends (k, 2, 2) of the true doors as x, y."""
    return np.array([(door.start_m, door.end_m) for door in made.doors], np.float64).reshape(-1, 2, 2)


def lines_m(found: TopologicalMap) -> Lines:
    """Ends (k, 2, 2) of each door as x, y, of one that borders more than two rooms once, in order."""
    ends = np.concatenate([found.start_m, found.end_m], axis=1).round(9)
    return np.asarray(np.unique(ends, axis=0).reshape(-1, 2, 2))
