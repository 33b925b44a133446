"""Table I: three environments, the existing algorithm beside the proposed one, as printed and as found here."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from vdoor.paper.doors_counted import DoorCount, counted_all
from vdoor.synth import PRESETS, Apartment, SyntheticMap, synthesize


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
    def settings(self) -> Apartment:
        """What is drawn: the paper's kind at 20 cm."""
        drawn: Apartment = dataclasses.replace(
            PRESETS["paper"], rooms=self.rooms, rooms_spread=0, furniture=self.furniture
        )
        return drawn

    @property
    def made(self) -> SyntheticMap:
        """The map and its truth."""
        return synthesize(self.settings, np.random.default_rng(self.seed))


@dataclass(frozen=True, kw_only=True)
class Row:
    """One line of the table."""

    environment: Environment
    printed: Mapping[str, DoorCount]
    """For ``existing`` and ``proposed``."""
    found: Mapping[str, DoorCount]
    """By the name of the method."""


PRINTED: Mapping[str, Mapping[str, DoorCount]] = MappingProxyType(
    {
        "case 1": {
            "existing": DoorCount(real=4, virtual=9, matched=4),
            "proposed": DoorCount(real=4, virtual=7, matched=4),
        },
        "case 2": {
            "existing": DoorCount(real=4, virtual=5, matched=2),
            "proposed": DoorCount(real=4, virtual=4, matched=4),
        },
        "case 3": {
            "existing": DoorCount(real=3, virtual=5, matched=3),
            "proposed": DoorCount(real=3, virtual=3, matched=3),
        },
    }
)
"""The paper's figures."""

ENVIRONMENTS = (
    Environment(name="case 1", rooms=5, doors=4, seed=3),
    Environment(name="case 2", rooms=5, doors=4, seed=4),
    Environment(name="case 3", rooms=4, doors=3, seed=0),
)
"""The three of them."""


def table_one(*, furniture: bool, seed: int = 0) -> tuple[Row, ...]:
    """The table, on the environments empty or furnished; the paper's are real homes. `seed` is the searches'."""
    return tuple(row(dataclasses.replace(environment, furniture=furniture), seed=seed) for environment in ENVIRONMENTS)


def row(environment: Environment, *, seed: int = 0) -> Row:
    """One line of the table."""
    found = counted_all(environment.made, seed=seed)
    return Row(environment=environment, printed=PRINTED[environment.name], found=found)
