"""How likely each virtual door is a real one: log-odds from its features, which are on record."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, ClassVar

import numpy as np
from numpy.typing import NDArray

from vdoor.config import Within
from vdoor.frame import Frame
from vdoor.grid import FREE
from vdoor.method.boundary import BoundaryPath
from vdoor.method.corners import Corners
from vdoor.method.doors import PROPOSED, VirtualDoors
from vdoor.method.scoring.closed_features import shut_features
from vdoor.method.scoring.conflicts import conflicts, suppressed, surest
from vdoor.method.scoring.features import FEATURES, first_features
from vdoor.method.scoring.model import SHIPPED, Curves, model_named
from vdoor.method.scoring.segments import Segments
from vdoor.method.scoring.space_features import room_around
from vdoor.method.simplify import SimplifiedGrid
from vdoor.record import Record, Spec

Floats = NDArray[np.float64]
Ints = NDArray[np.int32]
Mask = NDArray[np.bool_]

JUDGEMENTS = ("likely", "unlikely", "outdone")
LIKELY = JUDGEMENTS.index("likely")


class DoorScores(Record):
    """Proposed doors with what speaks for and against them; the search decides among the likely ones."""

    topic: ClassVar[str] = "door_scores"

    middle: Annotated[NDArray[np.int32], Spec("cell", "scored 2")]
    door: Annotated[NDArray[np.int32], Spec("column", "scored", of="doors.start")]
    """Row in `VirtualDoors`."""
    log_odds: Annotated[NDArray[np.float64], Spec("column", "scored", tolerance=1e-6)]
    """That it is a real door: 0 is one in two, 3 is twenty to one."""
    judgement: Annotated[NDArray[np.uint8], Spec("code", "scored", words=JUDGEMENTS)]
    """Outdone: a better one lies across nearly the same place."""
    feature: Annotated[NDArray[np.float64], Spec("column", f"scored {len(FEATURES)}", tolerance=1e-6)]
    """The values of `FEATURES`, in that order."""
    sure: Annotated[NDArray[np.bool_], Spec("column", "scored")]
    """Closed in pass 2."""
    rival_a: Annotated[NDArray[np.int32], Spec("column", "rival", of="door_scores.door")]
    rival_b: Annotated[NDArray[np.int32], Spec("column", "rival", of="door_scores.door")]
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
    """Score the proposed doors in two passes, the second with the surest ones closed, and list those in conflict."""

    least_log_odds: Annotated[float, Within(-100, 100)] = -6.0
    """Less likely doors are left out of the search. An unlikely one may still close the last gap beside likely ones."""
    same_place_m: Annotated[float, Within(0, 5)] = 0.25
    """Of two doors whose middles are nearer than this only the likelier is searched."""
    apart_m: Annotated[float, Within(0, 5)] = 0.6
    """Two real doors have their middles at least this far apart."""
    sure_log_odds: Annotated[float, Within(-100, 100)] = 0.5
    """Doors likelier than this in pass 1 are closed in pass 2."""
    model: str = SHIPPED
    """The curves: those that ship with the package, or the path of a file that `vdoor train` wrote."""

    def __call__(
        self, simplified: SimplifiedGrid, path: BoundaryPath, corners: Corners, doors: VirtualDoors
    ) -> DoorScores:
        """Scores in the order of the proposed doors."""
        model = model_named(self.model)
        rows = np.flatnonzero(doors.verdict == PROPOSED)
        ragged = corners_per_m(path, corners)
        share_rough = model.rough.share(ragged)
        feature, sure = self.features(simplified, path, corners, doors, first_pass=model.first, share_rough=share_rough)
        log_odds = model.last.log_odds(feature, share_rough)
        segments = Segments(doors, rows)
        judgement = np.where(log_odds < self.least_log_odds, JUDGEMENTS.index("unlikely"), LIKELY).astype(np.uint8)
        judgement[suppressed(segments, log_odds, self.same_place_m) & (judgement == LIKELY)] = JUDGEMENTS.index(
            "outdone"
        )
        pairs = conflicts(segments, np.flatnonzero(judgement == LIKELY), self.apart_m)
        return DoorScores(
            middle=np.floor(segments.middle).astype(np.int32),
            door=rows.astype(np.int32),
            log_odds=log_odds,
            judgement=judgement,
            feature=feature,
            sure=np.isin(np.arange(len(rows)), sure),
            rival_a=pairs[:, 0].astype(np.int32),
            rival_b=pairs[:, 1].astype(np.int32),
            corners_per_m=ragged,
            share_rough=share_rough,
            frame=path.frame,
        )

    def features(
        self,
        simplified: SimplifiedGrid,
        path: BoundaryPath,
        corners: Corners,
        doors: VirtualDoors,
        *,
        first_pass: Curves,
        share_rough: float,
    ) -> tuple[Floats, NDArray[np.intp]]:
        """Values (k, features) of `FEATURES` for the proposed doors, and which (m,) of them were closed for that."""
        rows = np.flatnonzero(doors.verdict == PROPOSED)
        segments, free = Segments(doors, rows), simplified.cells == FREE
        distance = room_around(free)
        first = first_features(simplified, path, doors, rows, corners.sample, distance=distance)
        sure = surest(segments, first_pass.log_odds(first, share_rough), self.sure_log_odds, self.apart_m)
        again = shut_features(free, segments, doors, rows, sure, distance=distance)
        return np.concatenate([first, again], axis=1), sure


def corners_per_m(path: BoundaryPath, corners: Corners) -> float:
    """How ragged a map is: corners per metre of its boundary."""
    return len(corners.sample) / max(float(path.length_m.sum()), path.frame.resolution_m)
