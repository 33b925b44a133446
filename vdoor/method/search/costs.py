"""Section III: the cost of a choice of doors, by eq. 7 or as the energy of scored doors."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Annotated, Any, ClassVar, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from vdoor.config import Within

Floats = NDArray[np.float64]
EPSILON = 1e-9
Number = Any  # a number, or an array (p,) of them


class Cost(Protocol):
    """The cost of a choice of doors: eq. 7, or the energy of scored doors."""

    counts_separating: ClassVar[bool]
    """Whether kept doors count only if they separate rooms; the choice can be bounded only then."""

    @property
    def room_m2(self) -> float:
        """Room threshold T."""

    @property
    def conflict_weight(self) -> float:
        """The cost of keeping both doors of a conflict."""

    def on_map(self, share_rough: float) -> Cost:
        """The cost with the weights for a map that is rough to this degree, 0 to 1."""

    def gain(self, log_odds: Floats) -> Floats:
        """The saving (k,) from keeping each door if it separates two rooms, regardless of the rooms' areas."""

    def most_gain(self, log_odds: Floats) -> Floats:
        """The largest saving (k,) from keeping each door, that of a further one between its rooms; at least 0."""

    def terms(self, totals: Totals) -> tuple[Term, ...]:
        """The terms whose sum is the cost of one choice."""

    def value(self, totals: Totals) -> float:
        """The cost of one choice."""

    def __call__(self, totals: Totals, sqrt: Callable[[Any], Any]) -> Costs:
        """The cost and the terms of eq. 7, from sums over rooms and doors, of one choice or arrays of them."""


@dataclass(frozen=True, kw_only=True)
class MapCost:
    """Weights of eq. 7."""

    room_m2: Annotated[float, Within(0, 1e6)] = 2.0
    """Room threshold T: smaller rooms are small nodes, and AreaSD is measured from it."""
    small_weight: Annotated[float, Within(0, 1e6)] = 1.0
    """w1, per small room."""
    area_weight_per_m2: Annotated[float, Within(0, 1e6)] = 0.05
    """w2, per m2 of AreaSD."""
    tilt_weight_per_deg: Annotated[float, Within(0, 1e6)] = 0.05
    """w3, per degree of DegSD."""

    counts_separating: ClassVar[bool] = False

    @property
    def conflict_weight(self) -> float:
        """0: this cost ignores conflicts."""
        return 0.0

    def on_map(self, share_rough: float) -> MapCost:
        """The cost unchanged: its weights are the same for all maps."""
        del share_rough
        return self

    def gain(self, log_odds: Floats) -> Floats:
        """The log-odds, which this cost does not use."""
        return log_odds

    def most_gain(self, log_odds: Floats) -> Floats:
        """The log-odds, at least 0."""
        return np.maximum(log_odds, 0.0)

    def terms(self, totals: Totals) -> tuple[Term, ...]:
        """The three terms of eq. 7."""
        found = self(totals, sqrt=math.sqrt)
        return (
            Term("NumSmallNode", self.small_weight, int(found.small_rooms)),
            Term("AreaSD", self.area_weight_per_m2, found.area_sd_m2, "m2"),
            Term("DegSD", self.tilt_weight_per_deg, found.tilt_sd_deg, "deg"),
        )

    def value(self, totals: Totals) -> float:
        """The cost of one choice by eq. 7."""
        return float(self(totals, sqrt=math.sqrt).cost)

    def __call__(self, totals: Totals, sqrt: Callable[[Any], Any]) -> Costs:
        """The cost by eq. 7, and its three terms."""
        mean_square = (totals.area_squared_m4 - 2 * self.room_m2 * totals.area_m2) / totals.rooms + self.room_m2**2
        area_sd_m2 = sqrt(abs(mean_square))  # rounding may make a zero slightly negative
        tilt_sd_deg = sqrt(totals.tilt_squared_deg2 / (totals.doors + (totals.doors == 0)))
        cost = (  # eq. 7
            self.small_weight * totals.small
            + self.area_weight_per_m2 * area_sd_m2
            + self.tilt_weight_per_deg * tilt_sd_deg
        )
        return Costs(cost, totals.small, area_sd_m2, tilt_sd_deg)


@dataclass(frozen=True, kw_only=True)
class DoorEnergy:
    """Weights of the energy of scored doors: the area that rooms lack, minus the log-odds of doors that separate rooms.

    Kept doors that separate nothing do not count: if three gaps must be closed to separate two rooms, none of them is a
    door without the others.
    """

    room_m2: Annotated[float, Within(0, 1e6)] = 2.0
    """Room threshold T."""
    room_m2_rough: Annotated[float, Within(0, 1e6)] = 1.6
    """`room_m2` for rough maps: robots map homes, which have smaller rooms than offices."""
    lack_weight: Annotated[float, Within(0, 1e6)] = 1.5
    """Cost, in log-odds, of a room of zero area; falls linearly to 0 at the threshold."""
    lack_weight_rough: Annotated[float, Within(0, 1e6)] = 8.0
    """`lack_weight` for rough maps, on which furniture creates false rooms."""
    bias: Annotated[float, Within(-100, 100)] = 0.4
    """Added to the log-odds of each door: higher values keep more doors."""
    bias_rough: Annotated[float, Within(-100, 100)] = 0.2
    """`bias` for rough maps."""
    further_bias: Annotated[float, Within(0, 100)] = 0.0
    """Added for each further door between the same two rooms, as the first is already evidence that they are two. One
    in three or four of the virtual doors to which the curves are fitted is real, so about 1 of the log-odds against
    each door is evidence against there being two rooms, and should be counted only once."""
    further_bias_rough: Annotated[float, Within(0, 100)] = 0.0
    """`further_bias` for rough maps."""
    clash_weight: Annotated[float, Within(0, 1e6)] = 100.0
    """Cost of keeping both doors of a conflict."""

    counts_separating: ClassVar[bool] = True

    @property
    def conflict_weight(self) -> float:
        """The setting `clash_weight`."""
        return self.clash_weight

    def on_map(self, share_rough: float) -> DoorEnergy:
        """The energy with each weight interpolated between those of clean and rough maps."""
        weights = {}
        for name in ("room_m2", "lack_weight", "bias", "further_bias"):
            clean, rough = getattr(self, name), getattr(self, f"{name}_rough")
            weights[name] = weights[f"{name}_rough"] = clean * (1 - share_rough) + rough * share_rough
        return replace(self, **weights)

    def gain(self, log_odds: Floats) -> Floats:
        """The log-odds plus the bias."""
        return log_odds + self.bias

    def most_gain(self, log_odds: Floats) -> Floats:
        """The gain plus the bias of further doors, at least 0."""
        return np.maximum(self.gain(log_odds) + self.further_bias, 0.0)

    def terms(self, totals: Totals) -> tuple[Term, ...]:
        """The terms: area that rooms lack, conflicts, log-odds of separating doors, and their biases."""
        return (
            Term("lack of area", self.lack_weight, totals.lacking_m2 / max(self.room_m2, EPSILON), "rooms"),
            Term("conflicts", self.clash_weight, int(totals.conflicts)),
            Term("log-odds", -1.0, float(totals.log_odds)),
            Term("separating doors", -self.bias, int(totals.separating)),
            Term("further doors", -self.further_bias, int(totals.separating - totals.pairs)),
        )

    def value(self, totals: Totals) -> float:
        """The energy of one choice."""
        return float(self._energy(totals))

    def __call__(self, totals: Totals, sqrt: Callable[[Any], Any]) -> Costs:
        """The energy, and the terms of eq. 7 for comparison, from sums over rooms and doors."""
        return MapCost(room_m2=self.room_m2)(totals, sqrt)._replace(cost=self._energy(totals))

    def _energy(self, totals: Totals) -> Number:
        return (
            self.lack_weight * totals.lacking_m2 / max(self.room_m2, EPSILON)
            + self.clash_weight * totals.conflicts
            - (totals.log_odds + self.bias * totals.separating)
            - self.further_bias * (totals.separating - totals.pairs)
        )


class Totals(NamedTuple):
    """Sums over the rooms and the kept doors of one choice, or arrays (p,) for p choices."""

    rooms: Number
    small: Number
    area_m2: Number
    area_squared_m4: Number
    doors: Number
    tilt_squared_deg2: Number
    lacking_m2: Number
    """Area by which rooms are smaller than the room threshold, summed over the smaller rooms."""
    separating: Number
    """Number of kept doors that separate rooms; counted for the energy only, else 0."""
    pairs: Number
    """Number of pairs of rooms that these doors separate."""
    log_odds: Number
    """Sum of these doors' log-odds; 0 without scores."""
    conflicts: Number
    """Number of conflicts of which both doors are kept."""


class Term(NamedTuple):
    """One term of the cost: a weight times a value."""

    name: str
    weight: float
    value: float
    unit: str = ""

    @property
    def cost(self) -> float:
        """The term's share of the cost."""
        return self.weight * self.value


class Costs(NamedTuple):
    """The cost and the terms of eq. 7, of one choice or arrays (p,) of them."""

    cost: Number
    small_rooms: Number
    area_sd_m2: Number
    tilt_sd_deg: Number
