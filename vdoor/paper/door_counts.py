"""Table I: real, virtual and matched doors by method, on its three environments and on many apartments."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vdoor.baselines import ErodedSpacePipeline, VoronoiDoorsPipeline
from vdoor.engines import Over
from vdoor.evaluate.door_places import nearest_pairs
from vdoor.paper.walkthrough import Progress, no_progress, paper_apartment, paper_pipeline
from vdoor.synth import SyntheticMap
from vdoor.topology import TopologicalMap

Lines = NDArray[np.float64]

MATCHED_WITHIN_M = 0.5
"""How far apart the middles of a real and a virtual door may be."""
ISLANDS_UP_TO_M = 1.0
"""On furnished maps every method removes free-standing obstacles up to this length."""
EXISTING, PROPOSED = "existing", "proposed"
ISLANDS_KEPT = "islands-kept"
"""The proposed method on furnished maps without that removal, which the paper does not have."""
METHODS: Mapping[str, Any] = MappingProxyType(  # Any: pipelines of several classes, all called alike
    {
        "voronoi-doors": VoronoiDoorsPipeline(),  # after [8]
        "eroded-space": ErodedSpacePipeline(),  # after [8]
        PROPOSED: paper_pipeline(),
    }
)
"""Two stand-ins for the existing algorithm, and the paper's method; all at its working resolution."""
STAND_INS = tuple(name for name in METHODS if name != PROPOSED)
METHOD_TITLES = {
    "voronoi-doors": "Voronoi doors",
    "eroded-space": "eroded space",
    PROPOSED: "proposed",
    ISLANDS_KEPT: "proposed with islands kept",
}
FURNISHING = ("empty", "furnished")
"""Of maps, by whether they have furniture."""
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
    """Pairs of a real and a virtual door at the same place."""

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

    @property
    def without_error(self) -> bool:
        """Whether every real door was matched and no other door reported."""
        return self.real == self.virtual == self.matched


CountByMethod = Mapping[str, DoorCount]


def total(counts: Iterable[CountByMethod]) -> dict[str, DoorCount]:
    """The doors of all maps together, by method."""
    each = list(counts)
    return {name: sum((count[name] for count in each), DoorCount()) for name in each[0]}


@dataclass(frozen=True, eq=False)
class Detection:
    """What a method reports on one map, beside the truth; lines are ends (k, 2, 2) as x, y in metres."""

    real_m: Lines
    virtual_m: Lines
    """A door that borders more than two rooms is there once."""
    pairs: tuple[tuple[int, int], ...]
    """Row of a real door, row of the virtual door that it is matched with."""

    @property
    def count(self) -> DoorCount:
        """How many."""
        return DoorCount(real=len(self.real_m), virtual=len(self.virtual_m), matched=len(self.pairs))

    @property
    def is_matched(self) -> NDArray[np.bool_]:
        """Which of the virtual doors (k,) are real ones."""
        found = np.zeros(len(self.virtual_m), np.bool_)
        found[[virtual for _, virtual in self.pairs]] = True
        return found


def detect_doors(made: SyntheticMap, method: Any, *, seed: int = 0) -> Detection:
    """Doors of one map by one method as it is."""
    real, virtual = real_doors_m(made), virtual_doors_m(method(made.grid, np.random.default_rng(seed)))
    rows, columns = nearest_pairs(real.mean(axis=1), virtual.mean(axis=1), MATCHED_WITHIN_M)
    return Detection(real, virtual, tuple(zip(rows.tolist(), columns.tolist(), strict=True)))


def real_doors_m(made: SyntheticMap) -> Lines:
    """Ends (k, 2, 2) of the true doors as x, y."""
    return np.array([(door.start_m, door.end_m) for door in made.doors], np.float64).reshape(-1, 2, 2)


def virtual_doors_m(found: TopologicalMap) -> Lines:
    """Ends (k, 2, 2) of the doors found as x, y, in order; a door that borders more than two rooms is there once."""
    ends = np.concatenate([found.start_m, found.end_m], axis=1).round(9)
    return np.asarray(np.unique(ends, axis=0).reshape(-1, 2, 2))


def count_doors(made: SyntheticMap, method: Any, *, seed: int = 0) -> DoorCount:
    """Doors of one map by one method, which removes small islands where the map is furnished."""
    return detect_doors(made, for_map(made, method), seed=seed).count


def count_by_method(made: SyntheticMap, *, seed: int = 0) -> dict[str, DoorCount]:
    """Doors of one map by every method."""
    return {name: detect_doors(made, method, seed=seed).count for name, method in methods_for(made).items()}


def methods_for(made: SyntheticMap) -> dict[str, Any]:
    """Every method as it runs on a map, by name; on a furnished one also the proposed method `ISLANDS_KEPT`."""
    found = {name: for_map(made, method) for name, method in METHODS.items()}
    return found | ({ISLANDS_KEPT: METHODS[PROPOSED]} if _is_furnished(made) else {})


def for_map(made: SyntheticMap, method: Any) -> Any:
    """A method as it runs on a map: small islands are removed where the map is furnished."""
    simplify = dataclasses.replace(method.simplify, max_island_m=ISLANDS_UP_TO_M if _is_furnished(made) else 0.0)
    return dataclasses.replace(method, simplify=simplify)


def _is_furnished(made: SyntheticMap) -> bool:
    return bool(getattr(made.settings, "furniture", False))


@dataclass(frozen=True, kw_only=True)
class Environment:
    """A stand-in for one of the paper's environments, which are not public: an apartment with as many real doors.

    The seed is the first one from 0 up (for case 2 the second one) whose apartment of so many rooms has that many
    doors; so it was settled before any method ran on it.
    """

    name: str
    rooms: int
    doors: int
    seed: int
    furniture: bool = False
    """The same rooms and doors either way."""

    @property
    def made(self) -> SyntheticMap:
        """The map and its truth."""
        return paper_apartment(self.seed, rooms=self.rooms, rooms_spread=0, furniture=self.furniture)


@dataclass(frozen=True, kw_only=True)
class TableRow:
    """One line of Table I."""

    environment: Environment
    printed: CountByMethod
    """For `EXISTING` and `PROPOSED`."""
    found: CountByMethod


PRINTED: Mapping[str, CountByMethod] = MappingProxyType(
    {
        "case 1": {
            EXISTING: DoorCount(real=4, virtual=9, matched=4),
            PROPOSED: DoorCount(real=4, virtual=7, matched=4),
        },
        "case 2": {
            EXISTING: DoorCount(real=4, virtual=5, matched=2),
            PROPOSED: DoorCount(real=4, virtual=4, matched=4),
        },
        "case 3": {
            EXISTING: DoorCount(real=3, virtual=5, matched=3),
            PROPOSED: DoorCount(real=3, virtual=3, matched=3),
        },
    }
)
"""Table I as printed, by environment."""

ENVIRONMENTS = (
    Environment(name="case 1", rooms=5, doors=4, seed=3),
    Environment(name="case 2", rooms=5, doors=4, seed=4),
    Environment(name="case 3", rooms=4, doors=3, seed=0),
)


def environments(*, furniture: bool) -> tuple[Environment, ...]:
    """The three environments, empty or furnished."""
    return tuple(dataclasses.replace(environment, furniture=furniture) for environment in ENVIRONMENTS)


def table_one(*, furniture: bool, seed: int = 0) -> tuple[TableRow, ...]:
    """Table I on the environments, empty or furnished; searches draw from `seed`."""
    return tuple(
        TableRow(
            environment=environment,
            printed=PRINTED[environment.name],
            found=count_by_method(environment.made, seed=seed),
        )
        for environment in environments(furniture=furniture)
    )


FIRST_SEED = 1000
ROOMS = (4, 5, 6)
SEARCH_SEEDS = 4
PROGRESS_EVERY = 20


@dataclass(frozen=True, kw_only=True)
class ApartmentStudy:
    """Table I over many apartments, since three environments carry little."""

    furniture: bool
    cell_m: float
    """Cell size of the maps; every method works at 20 cm."""
    each: tuple[CountByMethod, ...]
    """One an apartment."""

    @property
    def doors(self) -> dict[str, DoorCount]:
        """Of all apartments together, by method."""
        return total(self.each)

    @property
    def without_error(self) -> dict[str, Share]:
        """Apartments without any error, by method."""
        return {
            name: Share(part=sum(counts[name].without_error for counts in self.each), of=len(self.each))
            for name in self.each[0]
        }


def study_apartments(
    count: int = 200,
    *,
    furniture: bool = False,
    cell_m: float = 0.2,
    seed: int = 0,
    progress: Progress = no_progress,
    over: Over = map,
) -> ApartmentStudy:
    """Count the doors of `count` apartments; searches draw from `seed` and the three seeds after it in turn."""
    each = []
    work = partial(_count_apartment, furniture=furniture, cell_m=cell_m, seed=seed)
    for number, counts in enumerate(over(work, range(count)), start=1):
        each.append(counts)
        if number % PROGRESS_EVERY == 0 and number < count:
            progress(f"{FURNISHING[furniture]} apartments: {number} of {count}")
    return ApartmentStudy(furniture=furniture, cell_m=cell_m, each=tuple(each))


def _count_apartment(number: int, *, furniture: bool, cell_m: float, seed: int) -> dict[str, DoorCount]:
    made = apartment_map(number, furniture=furniture, cell_m=cell_m)
    return count_by_method(made, seed=seed + number % SEARCH_SEEDS)


def apartment_maps(count: int, *, furniture: bool, cell_m: float) -> Iterator[SyntheticMap]:
    """Apartments of the paper's kind with 4 to 6 rooms in turn, drawn from seeds 1000 and up."""
    yield from (apartment_map(number, furniture=furniture, cell_m=cell_m) for number in range(count))


def apartment_map(number: int, *, furniture: bool, cell_m: float) -> SyntheticMap:
    """One of these apartments, from 0."""
    rooms = ROOMS[number % len(ROOMS)]
    return paper_apartment(FIRST_SEED + number, rooms=rooms, furniture=furniture, cell_m=cell_m)
