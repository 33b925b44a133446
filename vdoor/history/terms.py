"""What the cost of a generation's best string is made of."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

from vdoor.history import History
from vdoor.stages.cost import LOG_ODDS_UNIT, DoorEnergy


class Term(NamedTuple):
    """One term of the cost: a weight times a value."""

    name: str
    weight: float
    value: float
    unit: str = ""

    @property
    def cost(self) -> float:
        """What it adds."""
        return self.weight * self.value


def terms_of(run: History, generation: int) -> Iterator[Term]:
    """The terms of the best string of one generation, by eq. 7 or by the energy of scored doors."""
    found, cost = run.search[generation], run.problem.cost  # with the weights for this map
    if isinstance(cost, DoorEnergy):
        yield from _energy(run, generation, cost)
        return
    yield Term("NumSmallNode", cost.small_weight, found.small_rooms)
    yield Term("AreaSD", cost.area_weight_per_m2, found.area_sd_m2, "m2")
    yield Term("DegSD", cost.tilt_weight_per_deg, found.tilt_sd_deg, "deg")


def _energy(run: History, generation: int, cost: DoorEnergy) -> Iterator[Term]:
    """What doors say and clash is summed again; the rest of the recorded energy is what rooms lack."""
    found, problem = run.search[generation], run.problem
    kept = ~found.removed
    rooms, _ = problem.rooms(found.removed[None])
    (parting,), (pairs,) = problem.parting(found.removed[None], rooms)
    says = Term("log-odds", -1.0, float(problem.log_odds[parting].sum() * LOG_ODDS_UNIT))
    doors = Term("parting doors", -cost.bias, int(parting.sum()))
    further = Term("of them further ones", -cost.further_bias, int(parting.sum() - pairs))
    clashes = Term("clashes", cost.clash_weight, int((kept[problem.rivals[0]] & kept[problem.rivals[1]]).sum()))
    rest = found.best_cost - says.cost - doors.cost - further.cost - clashes.cost
    yield Term("lack of area", cost.lack_weight, rest / cost.lack_weight if cost.lack_weight else 0.0, "rooms")
    yield from (clashes, says, doors, further)
