"""Table I over many apartments, since three carry little: the claim itself, with how sure it is."""

from __future__ import annotations

import dataclasses
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from vdoor.evidence.doors_counted import METHODS, DoorCount, counted
from vdoor.synth import PRESETS, Apartment, SyntheticMap, synthesize

FIRST_SEED = 1000
ROOMS = (4, 5, 6)
SEARCH_SEEDS = 4


@dataclass(frozen=True, kw_only=True)
class Study:
    """Doors of all apartments together, by the name of the method."""

    apartments: int
    furniture: bool
    cell_m: float
    """Of the maps; every method works at 20 cm."""
    doors: Mapping[str, DoorCount]
    complete: Mapping[str, int]
    """In how many apartments all real doors were matched and no other one was reported."""


def apartments(count: int = 200, *, furniture: bool = False, cell_m: float = 0.2) -> Study:
    """The table over `count` apartments of the paper's kind, 4 to 6 rooms in turn, seeds 1000 and up."""
    doors = dict.fromkeys(METHODS, DoorCount())
    complete = Counter(dict.fromkeys(METHODS, 0))
    for number, made in enumerate(drawn(count, furniture=furniture, cell_m=cell_m)):
        for name, method in METHODS.items():
            found = counted(made, method, seed=number % SEARCH_SEEDS)
            doors[name] += found
            complete[name] += found.real == found.virtual == found.matched
    return Study(apartments=count, furniture=furniture, cell_m=cell_m, doors=doors, complete=dict(complete))


def drawn(count: int, *, furniture: bool, cell_m: float) -> Iterator[SyntheticMap]:
    """The apartments, one after the other."""
    for number in range(count):
        settings: Apartment = dataclasses.replace(
            PRESETS["paper"], rooms=ROOMS[number % len(ROOMS)], furniture=furniture, cell_m=cell_m
        )
        yield synthesize(settings, np.random.default_rng(FIRST_SEED + number))
