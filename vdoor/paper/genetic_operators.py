"""Figure 4: crossover and mutation as the search does them, on the strings that the paper draws."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vdoor.method.search.optimisers import GeneticSearch

Bits = NDArray[np.bool_]

CROSSED = 7
EXCHANGED = (0, 1, 6)
"""How long the figure's parents are with one bit for the dots, and which bits they exchange: two and the last."""
STRING = "00010110000"
MUTATED = "10010100000"
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
    """How many bits each share is of."""


def crossover() -> Operation:
    """Two parents of unlike bits exchange those that the figure's parents do; neither mutates."""
    search = GeneticSearch(mutate_to_removed=0.0, mutate_to_kept=0.0)
    before = _unlike(CROSSED)
    after = before.copy()
    after[:, list(EXCHANGED)] ^= True
    return Operation(before=_texts(before), after=_texts(after), changed=EXCHANGED, seed=_first(search, before, after))


def mutation() -> Operation:
    """The figure's string becomes its result, by the printed rates and without crossover."""
    search = GeneticSearch(crossover=0.0)
    before, after = (np.array([[bit == "1" for bit in text]]) for text in (STRING, MUTATED))
    changed = np.flatnonzero(before[0] ^ after[0]).tolist()
    seed = _first(search, before, after)
    return Operation(before=_texts(before), after=_texts(after), changed=tuple(changed), seed=seed)


def measured_rates(search: GeneticSearch | None = None, *, bits: int = 100_000, seed: int = 0) -> Rates:
    """How often the operators change bits, the printed ones or those of another search, over strings so long."""
    search = search or GeneticSearch()
    parents = _unlike(bits)
    crossing = dataclasses.replace(search, mutate_to_removed=0.0, mutate_to_kept=0.0)
    mutating = dataclasses.replace(search, crossover=0.0)
    exchanged, _ = (_offspring(crossing, parents, seed) != parents).mean(axis=1).tolist()
    to_removed, to_kept = (_offspring(mutating, parents, seed) != parents).mean(axis=1).tolist()
    return Rates(exchanged=exchanged, to_removed=to_removed, to_kept=to_kept, bits=bits)


def _unlike(bits: int) -> Bits:
    """Two parents (2, bits) with no bit in common: all 0, all 1."""
    return np.repeat([[False], [True]], bits, axis=1)


def _first(search: GeneticSearch, before: Bits, after: Bits) -> int:
    """The first seed by which strings become others."""
    for seed in range(MOST_SEEDS):
        if (_offspring(search, before, seed) == after).all():
            return seed
    raise AssertionError(f"no seed below {MOST_SEEDS} draws the figure")


def _offspring(search: GeneticSearch, parents: Bits, seed: int) -> Bits:
    """The children, each in the place of the parent that it has its other bits from."""
    order = np.random.default_rng(seed).permutation(len(parents))  # who mates with whom is drawn first
    return search.offspring(parents, np.random.default_rng(seed))[np.argsort(order)]


def _texts(strings: Bits) -> tuple[str, ...]:
    return tuple("".join("01"[int(bit)] for bit in string) for string in strings)
