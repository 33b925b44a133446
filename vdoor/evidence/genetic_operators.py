"""Figure 4: crossover and mutation as the search does them, on the strings that the paper draws."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vdoor.stages.search import GeneticSearch

Bits = NDArray[np.bool_]

EXCHANGED = (0, 1, 7)
"""Which bits the figure's parents exchange: the first two and the last, of eight here."""
STRING = "0001011000"
MUTATED = "1001010000"
"""The figure's string and its result, with one bit for the dots."""
MOST_SEEDS = 1_000_000


@dataclass(frozen=True, kw_only=True)
class Operation:
    """One operation on given strings; 1 = edge removed."""

    before: tuple[str, ...]
    after: tuple[str, ...]
    changed: tuple[int, ...]
    """Which bits were exchanged or flipped, from 0."""
    seed: int
    """The first that draws just that."""


@dataclass(frozen=True, kw_only=True)
class Rates:
    """How often bits change, over many offspring."""

    exchanged: float
    to_removed: float
    """Of the 0s, how many become 1,"""
    to_kept: float
    """and of the 1s, how many become 0."""
    bits: int
    """How many bits each share is of, at least."""


def crossover() -> Operation:
    """Two parents of unlike bits exchange those that the figure's parents do; neither mutates."""
    search = GeneticSearch(mutate_to_removed=0.0, mutate_to_kept=0.0)
    parents = np.stack([np.zeros(8, np.bool_), np.ones(8, np.bool_)])
    wanted = parents.copy()
    wanted[:, list(EXCHANGED)] ^= True
    seed, offspring = _first(search, parents, lambda found: {*_texts(found)} == {*_texts(wanted)})
    # children come in the order in which their parents were drawn
    in_order = offspring if (offspring == wanted).all() else offspring[::-1]
    return Operation(before=_texts(parents), after=_texts(in_order), changed=EXCHANGED, seed=seed)


def mutation() -> Operation:
    """The figure's string becomes its result, by the printed rates and without crossover."""
    search = GeneticSearch(crossover=0.0)
    before, after = (np.array([[bit == "1" for bit in text]]) for text in (STRING, MUTATED))
    seed, offspring = _first(search, before, lambda found: bool((found == after).all()))
    changed = np.flatnonzero(before[0] ^ after[0]).tolist()
    return Operation(before=_texts(before), after=_texts(offspring), changed=tuple(changed), seed=seed)


def measured_rates(*, strings: int = 2000, bits: int = 100, seed: int = 0) -> Rates:
    """How often the printed operators change bits, over so many strings."""
    rng = np.random.default_rng(seed)
    parents = np.repeat([np.zeros(bits, np.bool_), np.ones(bits, np.bool_)], strings // 2, axis=0)
    exchanged = [
        GeneticSearch(mutate_to_removed=0.0, mutate_to_kept=0.0).offspring(parents[[0, -1]], rng)[0]
        for _ in range(strings)
    ]
    share = np.array(exchanged).mean(axis=1)
    flipped = GeneticSearch(crossover=0.0).offspring(parents, rng).mean(axis=1)
    return Rates(
        exchanged=float(np.abs(share).mean()),
        to_removed=float(flipped[flipped < 0.5].mean()),  # noqa: PLR2004  # these were all 0, the others all 1
        to_kept=float(1 - flipped[flipped > 0.5].mean()),  # noqa: PLR2004
        bits=strings * bits // 2,
    )


def _first(search: GeneticSearch, parents: Bits, wanted: Callable[[Bits], bool]) -> tuple[int, Bits]:
    """The first seed whose offspring are as wanted, and they."""
    for seed in range(MOST_SEEDS):
        offspring = search.offspring(parents, np.random.default_rng(seed))
        if wanted(offspring):
            return seed, offspring
    raise AssertionError(f"no seed below {MOST_SEEDS} draws the figure")


def _texts(strings: Bits) -> tuple[str, ...]:
    return tuple("".join("01"[int(bit)] for bit in string) for string in strings)
