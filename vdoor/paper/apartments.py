"""Table I over many apartments, since three carry little: the claim itself, with how sure it is."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from vdoor.paper.doors_counted import DoorCount, Share, counted_all
from vdoor.synth import PRESETS, Apartment, SyntheticMap, synthesize

FIRST_SEED = 1000
ROOMS = (4, 5, 6)
SEARCH_SEEDS = 4
TOLD_EVERY = 20

Told = Callable[[str], None]


def nobody(_: str) -> None:
    """Tell nobody how far it is."""


@dataclass(frozen=True, kw_only=True)
class Study:
    """Doors of each apartment, by the name of the method."""

    furniture: bool
    cell_m: float
    """Of the maps; every method works at 20 cm."""
    each: tuple[Mapping[str, DoorCount], ...]

    @property
    def doors(self) -> dict[str, DoorCount]:
        """Of all apartments together."""
        return {name: sum((found[name] for found in self.each), DoorCount()) for name in self.each[0]}

    @property
    def complete(self) -> dict[str, Share]:
        """In how many apartments all real doors were matched and no other one was reported."""
        return {
            name: Share(
                part=sum(found[name].real == found[name].virtual == found[name].matched for found in self.each),
                of=len(self.each),
            )
            for name in self.each[0]
        }


def apartments(
    count: int = 200, *, furniture: bool = False, cell_m: float = 0.2, seed: int = 0, told: Told = nobody
) -> Study:
    """The table over `count` apartments of the paper's kind, 4 to 6 rooms in turn, drawn by seeds 1000 and up.

    The searches have `seed` and the three after it in turn. Every so often `told` hears how far it is.
    """
    each = []
    for number, made in enumerate(drawn(count, furniture=furniture, cell_m=cell_m)):
        if number and number % TOLD_EVERY == 0:
            told(f"{'furnished' if furniture else 'empty'} apartments: {number} of {count}")
        each.append(counted_all(made, seed=seed + number % SEARCH_SEEDS))
    return Study(furniture=furniture, cell_m=cell_m, each=tuple(each))


def drawn(count: int, *, furniture: bool, cell_m: float) -> Iterator[SyntheticMap]:
    """The apartments, one after the other."""
    for number in range(count):
        settings: Apartment = dataclasses.replace(
            PRESETS["paper"], rooms=ROOMS[number % len(ROOMS)], furniture=furniture, cell_m=cell_m
        )
        yield synthesize(settings, np.random.default_rng(FIRST_SEED + number))
