"""Evidence for and against a virtual door: its score, the features that made it, and conflicting doors."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vdoor.errors import SettingError
from vdoor.history import History
from vdoor.method.scoring.features import FEATURES
from vdoor.method.scoring.model import DoorModel, model_named
from vdoor.method.scoring.score import JUDGEMENTS, DoorScores, ScoreDoors

MOST_REASONS = 3
"""Number of features listed for and against a door."""
SAME_LOG_ODDS = 1e-6
"""Tolerance on the recorded sum; curves that differ by more are not those that the run used."""


@dataclass(frozen=True, kw_only=True)
class Reason:
    """One feature of a door, and its contribution to the score."""

    feature: str
    value: float
    log_odds: float
    """Above 0 it is evidence for a door."""


@dataclass(frozen=True, kw_only=True)
class Conflict:
    """Another likely door that conflicts with this one: at most one of the two can be real."""

    door: int
    log_odds: float
    kept: bool | None
    """Whether the search kept it; None if that was not recorded or the door borders fewer than two regions."""


@dataclass(frozen=True, kw_only=True)
class ScoreFate:
    """Score of one door."""

    log_odds: float
    judgement: str
    """likely, unlikely or outdone; only likely doors are passed to the search."""
    least_log_odds: float
    """Doors below this are unlikely."""
    share_rough: float
    """Weight of the curves for rough maps, 0 to 1."""
    sure: bool = False
    """Likely enough in pass 1 to be closed in pass 2."""
    suppressed_by: int = -1
    """For outdone doors, the likeliest door at nearly the same place; -1 otherwise."""
    outdone_by_log_odds: float = 0.0
    bias: float | None = None
    """Log-odds before any feature; None if the curves that the run used are not available."""
    reasons_for: tuple[Reason, ...] = ()
    """Strongest features for the door, strongest first."""
    reasons_against: tuple[Reason, ...] = ()
    """Strongest features against the door, strongest first."""
    conflicts: tuple[Conflict, ...] = ()
    """Conflicting doors, likeliest first."""


def score_fate(run: History, door: int) -> ScoreFate | None:
    """Score of a virtual door; None if it was not scored."""
    if not run.has(DoorScores):
        return None
    scores, settings = run.scores, run.pipeline.score
    row = int(np.searchsorted(scores.door, door))
    if row == len(scores.door) or scores.door[row] != door or not isinstance(settings, ScoreDoors):
        return None
    judgement = JUDGEMENTS[scores.judgement[row]]
    better = suppressed_by(run, row, settings.same_place_m) if judgement == "outdone" else -1
    bias, reasons = reasons_of(scores, row, model=settings.model)
    return ScoreFate(
        log_odds=float(scores.log_odds[row]),
        judgement=judgement,
        least_log_odds=settings.least_log_odds,
        share_rough=scores.share_rough,
        sure=bool(scores.sure[row]),
        suppressed_by=int(scores.door[better]) if better >= 0 else -1,
        outdone_by_log_odds=float(scores.log_odds[better]) if better >= 0 else 0.0,
        bias=bias,
        reasons_for=tuple(reason for reason in reasons[:MOST_REASONS] if reason.log_odds > 0),
        reasons_against=tuple(reason for reason in reasons[: -MOST_REASONS - 1 : -1] if reason.log_odds < 0),
        conflicts=conflicts_of(run, row),
    )


def reasons_of(scores: DoorScores, row: int, *, model: str) -> tuple[float | None, list[Reason]]:
    """The bias, and all features of a scored door, from the strongest for it to the strongest against it.

    None and no features if the curves that the run used are not available.
    """
    curves = model_used(scores, row, model=model)
    if curves is None:
        return None, []
    contributions = curves.last.says(scores.feature[[row]], scores.share_rough)[0]
    reasons = [
        Reason(feature=name, value=float(scores.feature[row, at]), log_odds=float(contributions[at]))
        for at, name in enumerate(FEATURES)
    ]
    return curves.last.bias(scores.share_rough), sorted(reasons, key=lambda reason: -reason.log_odds)


def model_used(scores: DoorScores, row: int, *, model: str) -> DoorModel | None:
    """The curves that scored a door; None if they are missing, or give another score now."""
    try:
        curves = model_named(model)
    except SettingError:
        return None
    again = curves.last.log_odds(scores.feature[[row]], scores.share_rough)[0]
    return curves if abs(again - scores.log_odds[row]) <= SAME_LOG_ODDS else None


def suppressed_by(run: History, row: int, near_m: float) -> int:
    """The likeliest scored door that is likelier than this one and has its middle near by; -1 if there is none."""
    scores = run.scores
    middle = middles(run)
    away = np.hypot(*(middle - middle[row]).T)
    near = np.flatnonzero((away <= near_m / scores.frame.resolution_m) & (scores.log_odds > scores.log_odds[row]))
    return int(near[np.argmax(scores.log_odds[near])]) if len(near) else -1


def middles(run: History) -> NDArray[np.float64]:
    """Middle (scored, 2) of each scored door, as row, col of working cells."""
    doors = run.scores.door
    return np.asarray((run.doors.start[doors] + run.doors.end[doors]) / 2)


def conflicts_of(run: History, row: int) -> tuple[Conflict, ...]:
    """Doors in conflict with a scored door, likeliest first."""
    scores = run.scores
    others = np.concatenate([scores.rival_b[scores.rival_a == row], scores.rival_a[scores.rival_b == row]])
    others = np.sort(others)
    order = others[np.argsort(-scores.log_odds[others].round(9), kind="stable")]
    doors = scores.door[order].tolist()
    return tuple(
        Conflict(door=door, log_odds=log_odds, kept=kept(run, door))
        for door, log_odds in zip(doors, scores.log_odds[order].tolist(), strict=True)
    )


def kept(run: History, door: int) -> bool | None:
    """Whether the search kept a virtual door; None if it is not an edge or the search was not recorded."""
    edge = run.edge_of_door.get(door) if len(run.search) else None
    return None if edge is None else not run.search[-1].removed[edge]
