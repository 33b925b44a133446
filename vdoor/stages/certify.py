"""How good the choice of doors can be at best: a bound on the energy, and how far the search is from it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, ClassVar

import numpy as np
from scipy.optimize import Bounds, LinearConstraint, milp
from scipy.sparse import coo_array

from vdoor.config import Within
from vdoor.record import Record, Spec
from vdoor.stages.cost import DoorEnergy, MergeProblem
from vdoor.stages.search import Generation

EPSILON = 1e-6


class Certificate(Record):
    """What can be proven about the best choice."""

    topic: ClassVar[str] = "certificate"

    cost: Annotated[float, Spec("number", tolerance=1e-6)]
    lower_bound: Annotated[float, Spec("number", tolerance=1e-6)]
    """No choice costs less."""
    gap: Annotated[float, Spec("number", tolerance=1e-6)]
    """Log-odds between the two, 0 where the choice is optimal; the bound leaves out what kept doors' rooms lack, and
    counts doors around which one can walk."""
    optimal: Annotated[int, Spec("count")]
    """1 where that is proven."""


@dataclass(frozen=True, kw_only=True)
class NoProof:
    """Nothing is proven (paper)."""

    def __call__(self, problem: MergeProblem, best: Generation) -> None:
        """Nothing."""


@dataclass(frozen=True, kw_only=True)
class BoundEnergy:
    """Bound the energy from below by the best choice of doors without rivals, whatever rooms they make, or part.

    That is a maximum-weight independent set, solved as an integer programme. What rooms lack without any door they
    always lack, and doors only ever add to it; no door saves more than what it gains where it parts rooms. So where
    the choice found reaches the bound it is optimal.
    """

    most_s: Annotated[float, Within(0.01, 3600)] = 10.0
    """The solver stops after so long and gives the bound it has."""

    def __call__(self, problem: MergeProblem, best: Generation) -> Certificate | None:
        """The certificate of the choice; none where it was not the energy that was searched."""
        if not isinstance(problem.cost, DoorEnergy):
            return None
        alone = problem.evaluate(np.ones((1, problem.edges), np.bool_)).cost[0]
        bound = float(alone) - most_gain(problem, problem.cost.clash_weight, self.most_s)
        gap = max(best.best_cost - bound, 0.0)
        return Certificate(
            cost=best.best_cost, lower_bound=bound, gap=gap, optimal=int(abs(best.best_cost - bound) <= EPSILON)
        )


def most_gain(problem: MergeProblem, clash_weight: float, most_s: float) -> float:
    """Greatest sum of what doors gain over all sets without rivals, or a bound above it."""
    gain = np.maximum(problem.gain, 0.0)
    wanted = gain > 0
    pairs = problem.rivals[:, wanted[problem.rivals].all(axis=0)]
    # Only where a clash costs more than the lesser of both doors gains, no best choice keeps both.
    pairs = pairs[:, gain[pairs].min(axis=0) <= clash_weight]
    if not pairs.shape[1]:
        return float(gain.sum())
    row = np.tile(np.arange(pairs.shape[1]), 2)
    matrix = coo_array((np.ones(len(row)), (row, pairs.ravel())), shape=(pairs.shape[1], problem.edges))
    solved = milp(
        -gain,
        constraints=LinearConstraint(matrix.tocsr(), ub=1.0),
        integrality=np.ones(problem.edges, np.int64),
        bounds=Bounds(0.0, 1.0),
        options={"time_limit": most_s, "mip_rel_gap": 0.0},
    )
    if solved.mip_dual_bound is None:
        return float(gain.sum())
    return min(float(gain.sum()), -float(solved.mip_dual_bound))
