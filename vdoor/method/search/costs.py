"""Section III: what a choice of doors costs, by eq. 7 or by the energy of scored doors."""

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
    """What a choice of doors costs: eq. 7, or the energy of scored doors."""

    counts_separating: ClassVar[bool]
    """Whether kept doors count by what they separate; only then can the choice be bounded."""

    @property
    def room_m2(self) -> float:
        """Room threshold T."""

    @property
    def conflict_weight(self) -> float:
        """Cost of each pair of conflicting doors of which both are kept."""

    def on_map(self, share_rough: float) -> Cost:
        """The cost with the weights of a map that is rough by this share, 0 to 1."""

    def gain(self, log_odds: Floats) -> Floats:
        """What keeping doors (k,) saves if each separates two rooms, whatever these lack."""

    def most_gain(self, log_odds: Floats) -> Floats:
        """The same if each is one of several doors between its rooms, at least 0."""

    def terms(self, totals: Totals) -> tuple[Term, ...]:
        """What the cost of one choice is made of."""

    def __call__(self, totals: Totals, sqrt: Callable[[Any], Any]) -> Costs:
        """Cost and the terms of eq. 7 from sums over rooms and doors, for one choice or arrays of them."""


@dataclass(frozen=True, kw_only=True)
class MapCost:
    """Weights of eq. 7."""

    room_m2: Annotated[float, Within(0, 1e6)] = 2.0
    """Room threshold T: smaller rooms count as small nodes, and areas are compared with it."""
    small_weight: Annotated[float, Within(0, 1e6)] = 1.0
    """w1, per small room."""
    area_weight_per_m2: Annotated[float, Within(0, 1e6)] = 0.05
    """w2, per m2 of AreaSD."""
    tilt_weight_per_deg: Annotated[float, Within(0, 1e6)] = 0.05
    """w3, per degree of DegSD."""

    counts_separating: ClassVar[bool] = False

    @property
    def conflict_weight(self) -> float:
        """Nothing: this cost knows no conflicts."""
        return 0.0

    def on_map(self, share_rough: float) -> MapCost:
        """The same for every map."""
        del share_rough
        return self

    def gain(self, log_odds: Floats) -> Floats:
        """The log-odds alone, which this cost does not count."""
        return log_odds

    def most_gain(self, log_odds: Floats) -> Floats:
        """The same, at least 0."""
        return np.maximum(log_odds, 0.0)

    def terms(self, totals: Totals) -> tuple[Term, ...]:
        """The three terms of eq. 7."""
        found = self(totals, sqrt=math.sqrt)
        return (
            Term("NumSmallNode", self.small_weight, int(found.small_rooms)),
            Term("AreaSD", self.area_weight_per_m2, found.area_sd_m2, "m2"),
            Term("DegSD", self.tilt_weight_per_deg, found.tilt_sd_deg, "deg"),
        )

    def __call__(self, totals: Totals, sqrt: Callable[[Any], Any]) -> Costs:
        """Eq. 7: the cost and its three terms."""
        mean_square = (totals.area_squared_m4 - 2 * self.room_m2 * totals.area_m2) / totals.rooms + self.room_m2**2
        area_sd_m2 = sqrt(abs(mean_square))  # rounding may leave a zero just below 0
        tilt_sd_deg = sqrt(totals.tilt_squared_deg2 / (totals.doors + (totals.doors == 0)))
        cost = (  # eq. 7
            self.small_weight * totals.small
            + self.area_weight_per_m2 * area_sd_m2
            + self.tilt_weight_per_deg * tilt_sd_deg
        )
        return Costs(cost, totals.small, area_sd_m2, tilt_sd_deg)


@dataclass(frozen=True, kw_only=True)
class DoorEnergy:
    """Weights of the energy over scored doors: what those that part rooms say, against what their rooms lack.

    A kept door around which one can walk says nothing: where three gaps must be shut to part two rooms, none of them
    is a door without the others.
    """

    room_m2: Annotated[float, Within(0, 1e6)] = 2.0
    """Room threshold T."""
    lack_weight: Annotated[float, Within(0, 1e6)] = 1.5
    """Log-odds that a room of no area would cost; one of half the threshold costs half as much."""
    lack_weight_rough: Annotated[float, Within(0, 1e6)] = 8.0
    """The same on ragged maps, where furniture makes rooms that are none."""
    bias: Annotated[float, Within(-100, 100)] = 0.4
    """Added to the log-odds of each door: above 0 more doors are kept."""
    bias_rough: Annotated[float, Within(-100, 100)] = 0.3
    """The same on ragged maps."""
    further_bias: Annotated[float, Within(0, 100)] = 0.0
    """Added as well for each further door between the same two rooms: the first has told that they are two. Of the
    virtual doors that the curves are fitted to, one in three or four is real, so about 1 of what speaks against each
    speaks against there being two rooms at all, and should be counted once."""
    further_bias_rough: Annotated[float, Within(0, 100)] = 0.0
    """The same on ragged maps."""
    clash_weight: Annotated[float, Within(0, 1e6)] = 100.0
    """Per pair of conflicting doors of which both are kept."""

    counts_separating: ClassVar[bool] = True

    @property
    def conflict_weight(self) -> float:
        """What `clash_weight` says."""
        return self.clash_weight

    def on_map(self, share_rough: float) -> DoorEnergy:
        """The energy with each weight between that of a clean map and that of a rough one."""
        weights = {}
        for name in ("lack_weight", "bias", "further_bias"):
            clean, rough = getattr(self, name), getattr(self, f"{name}_rough")
            weights[name] = weights[f"{name}_rough"] = clean * (1 - share_rough) + rough * share_rough
        return replace(self, **weights)

    def gain(self, log_odds: Floats) -> Floats:
        """Log-odds and bias."""
        return log_odds + self.bias

    def most_gain(self, log_odds: Floats) -> Floats:
        """The bias of further doors as well."""
        return np.maximum(self.gain(log_odds) + self.further_bias, 0.0)

    def terms(self, totals: Totals) -> tuple[Term, ...]:
        """What rooms lack, conflicts, and what the doors that separate rooms say."""
        return (
            Term("lack of area", self.lack_weight, totals.lacking_m2 / max(self.room_m2, EPSILON), "rooms"),
            Term("clashes", self.clash_weight, int(totals.clashes)),
            Term("log-odds", -1.0, float(totals.log_odds)),
            Term("parting doors", -self.bias, int(totals.separating)),
            Term("of them further ones", -self.further_bias, int(totals.separating - totals.pairs)),
        )

    def __call__(self, totals: Totals, sqrt: Callable[[Any], Any]) -> Costs:
        """Energy, and eq. 7's terms for comparison, from sums over rooms and doors."""
        terms = MapCost(room_m2=self.room_m2)(totals, sqrt)
        energy = (
            self.lack_weight * totals.lacking_m2 / max(self.room_m2, EPSILON)
            + self.clash_weight * totals.clashes
            - (totals.log_odds + self.bias * totals.separating)
            - self.further_bias * (totals.separating - totals.pairs)
        )
        return terms._replace(cost=energy)


class Totals(NamedTuple):
    """Sums over the rooms and the kept doors of one choice, or arrays (p,) for p choices."""

    rooms: Number
    small: Number
    area_m2: Number
    area_squared_m4: Number
    doors: Number
    tilt_squared_deg2: Number
    lacking_m2: Number
    """What rooms lack of the room threshold, summed over the smaller ones."""
    separating: Number
    """Kept doors that part rooms; 0 but for the energy."""
    pairs: Number
    """Pairs of rooms that they part."""
    log_odds: Number
    """Summed over those; 0 where doors have no scores."""
    clashes: Number
    """Conflicting pairs of which both doors are kept."""


class Term(NamedTuple):
    """One term of the cost of a choice: a weight times a value."""

    name: str
    weight: float
    value: float
    unit: str = ""

    @property
    def cost(self) -> float:
        """What it adds."""
        return self.weight * self.value


class Costs(NamedTuple):
    """The cost, and the terms of eq. 7."""

    cost: Number
    small_rooms: Number
    area_sd_m2: Number
    tilt_sd_deg: Number
