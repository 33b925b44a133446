"""How much speaks for each virtual door: log-odds from its geometry, feature by feature on record."""

from __future__ import annotations

import functools
from dataclasses import dataclass
from typing import Annotated, ClassVar

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from vdoor.config import Within
from vdoor.record import Frame, Record, Spec
from vdoor.stages.corners import Corners
from vdoor.stages.door_model import SHIPPED, model_named
from vdoor.stages.doors import PROPOSED, VirtualDoors
from vdoor.stages.features import FEATURES, door_features
from vdoor.stages.segments import Segments
from vdoor.stages.simplify import SimplifiedGrid
from vdoor.stages.trace import BoundaryPath

Floats = NDArray[np.float64]
Ints = NDArray[np.int32]
Mask = NDArray[np.bool_]

JUDGEMENTS = ("likely", "unlikely", "outdone")
LIKELY = JUDGEMENTS.index("likely")


class DoorScores(Record):
    """Proposed doors with what speaks for and against them; the search decides among the likely ones."""

    topic: ClassVar[str] = "door_scores"

    middle: Annotated[NDArray[np.int32], Spec("cell", "scored 2")]
    door: Annotated[NDArray[np.int32], Spec("column", "scored")]
    """Row in `VirtualDoors`."""
    log_odds: Annotated[NDArray[np.float64], Spec("column", "scored", tolerance=1e-6)]
    """That it is a real door: 0 is one in two, 3 is twenty to one."""
    judgement: Annotated[NDArray[np.uint8], Spec("code", "scored", words=JUDGEMENTS)]
    """Outdone: a better one lies across nearly the same place."""
    feature: Annotated[NDArray[np.float64], Spec("column", f"scored {len(FEATURES)}", tolerance=1e-6)]
    """The values of `FEATURES`, in that order."""
    rival_a: Annotated[NDArray[np.int32], Spec("column", "rival")]
    rival_b: Annotated[NDArray[np.int32], Spec("column", "rival")]
    """Pairs of likely doors (rows here, a < b, sorted) of which at most one can be real."""
    corners_per_m: Annotated[float, Spec("number", unit="1/m", tolerance=1e-9)]
    """Of boundary: how ragged the map is."""
    share_rough: Annotated[float, Spec("number", tolerance=1e-9)]
    """How much the curves for ragged maps count, 0 to 1."""
    frame: Frame


@dataclass(frozen=True, kw_only=True)
class NoScores:
    """Every virtual door counts alike (paper)."""

    def __call__(self, simplified: SimplifiedGrid, path: BoundaryPath, corners: Corners, doors: VirtualDoors) -> None:
        """Nothing."""


@dataclass(frozen=True, kw_only=True)
class ScoreDoors:
    """Score the proposed doors by the shipped curves, and name those that exclude each other."""

    least_log_odds: Annotated[float, Within(-100, 100)] = -2.0
    """Less likely doors are left out of the search."""
    same_place_m: Annotated[float, Within(0, 5)] = 0.25
    """Of two doors whose middles are nearer than this only the likelier is searched."""
    apart_m: Annotated[float, Within(0, 5)] = 0.6
    """Two real doors have their middles at least this far apart."""
    model: str = SHIPPED
    """The curves: those that ship with the package, or the path of a file that `vdoor train` wrote."""

    def __call__(
        self, simplified: SimplifiedGrid, path: BoundaryPath, corners: Corners, doors: VirtualDoors
    ) -> DoorScores:
        """Scores in the order of the proposed doors."""
        model = model_named(self.model)
        rows = np.flatnonzero(doors.verdict == PROPOSED)
        feature = door_features(simplified, path, doors, rows, corners.sample)
        ragged = corners_per_m(path, corners)
        share_rough = model.share_rough(ragged)
        log_odds = model.log_odds(feature, share_rough)
        segments = Segments(doors, rows)
        judgement = np.where(log_odds < self.least_log_odds, JUDGEMENTS.index("unlikely"), LIKELY).astype(np.uint8)
        judgement[outdone(segments, log_odds, self.same_place_m) & (judgement == LIKELY)] = JUDGEMENTS.index("outdone")
        pairs = rivals(segments, np.flatnonzero(judgement == LIKELY), self.apart_m)
        return DoorScores(
            middle=np.floor(segments.middle).astype(np.int32),
            door=rows.astype(np.int32),
            log_odds=log_odds,
            judgement=judgement,
            feature=feature,
            rival_a=pairs[:, 0].astype(np.int32),
            rival_b=pairs[:, 1].astype(np.int32),
            corners_per_m=ragged,
            share_rough=share_rough,
            frame=path.frame,
        )


def corners_per_m(path: BoundaryPath, corners: Corners) -> float:
    """How ragged a map is: corners per metre of its boundary."""
    return len(corners.sample) / max(float(path.length_m.sum()), path.frame.resolution_m)


def outdone(door: Segments, log_odds: Floats, near_m: float) -> Mask:
    """Which doors (k,) have a likelier one with its middle nearer than `near_m`."""
    lost = np.zeros(len(log_odds), np.bool_)
    if len(log_odds):
        pairs = cKDTree(door.middle).query_pairs(near_m / door.cell_m, output_type="ndarray")
        one, other = log_odds[pairs[:, 0]], log_odds[pairs[:, 1]]
        lost[pairs[one < other, 0]] = True
        lost[pairs[one > other, 1]] = True
    return lost


PARALLEL = 0.8
"""Doors whose directions have a greater cosine count as parallel."""


def rivals(door: Segments, among: NDArray[np.intp], apart_m: float) -> NDArray[np.intp]:
    """Pairs (m, 2), sorted, of doors that cross, lie near each other, or side by side across one opening."""
    if not len(among):
        return np.zeros((0, 2), np.intp)
    reach = max(apart_m / door.cell_m, float(door.length[among].max()))
    near = cKDTree(door.middle[among]).query_pairs(reach, output_type="ndarray")
    pairs = among[np.sort(near, axis=1)].reshape(-1, 2)
    a, b = pairs.T
    away_m = np.hypot(*(door.middle[a] - door.middle[b]).T) * door.cell_m
    side_by_side = np.abs((door.along[a] * door.along[b]).sum(axis=1)) > PARALLEL
    shorter_m = np.minimum(door.length[a], door.length[b]) * door.cell_m
    together = side_by_side & (away_m < np.minimum(shorter_m, 1.5) / 2 + 0.25)
    pairs = pairs[(away_m < apart_m) | crossing(door, a, b) | together]
    return np.asarray(pairs[np.lexsort((pairs[:, 1], pairs[:, 0]))])


def crossing(door: Segments, a: NDArray[np.intp], b: NDArray[np.intp]) -> Mask:
    """Whether segments (k,) cross, a common end left out."""
    span_a, span_b = door.end[a] - door.start[a], door.end[b] - door.start[b]
    between = door.start[b] - door.start[a]
    turn = functools.partial(lambda one, other: one[:, 0] * other[:, 1] - one[:, 1] * other[:, 0])
    area = turn(span_a, span_b)
    safe = np.where(area == 0, 1.0, area)
    on_a, on_b = turn(between, span_b) / safe, turn(between, span_a) / safe
    inside = [(share > 0.02) & (share < 0.98) for share in (on_a, on_b)]  # noqa: PLR2004  # not at an end
    return np.asarray((area != 0) & inside[0] & inside[1])
