"""How likely each virtual door is real: log-odds from its features, which are recorded."""

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
from vdoor.method.scoring.closed_features import closed_features
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
    """Proposed doors with the evidence for and against them; the search chooses among the likely ones."""

    topic: ClassVar[str] = "door_scores"

    middle: Annotated[NDArray[np.int32], Spec("cell", "scored 2")]
    door: Annotated[NDArray[np.int32], Spec("column", "scored", of="doors.start")]
    """Row in `VirtualDoors`."""
    log_odds: Annotated[NDArray[np.float64], Spec("column", "scored", tolerance=1e-6)]
    """Log-odds that the door is real: 0 is even odds, 3 is 20 to 1."""
    judgement: Annotated[NDArray[np.uint8], Spec("code", "scored", words=JUDGEMENTS)]
    """Outdone: a likelier door is in nearly the same place."""
    feature: Annotated[NDArray[np.float64], Spec("column", f"scored {len(FEATURES)}", tolerance=1e-6)]
    """The values of `FEATURES`, in that order."""
    sure: Annotated[NDArray[np.bool_], Spec("column", "scored")]
    """Whether the door is closed in pass 2."""
    rival_a: Annotated[NDArray[np.int32], Spec("column", "rival", of="door_scores.door")]
    rival_b: Annotated[NDArray[np.int32], Spec("column", "rival", of="door_scores.door")]
    """Conflicts: pairs of likely doors (rows here, a < b, sorted) of which at most one can be real."""
    corners_per_m: Annotated[float, Spec("number", unit="1/m", tolerance=1e-9)]
    """Corners per metre of boundary, a measure of how rough the map is."""
    share_rough: Annotated[float, Spec("number", tolerance=1e-9)]
    """Weight of the curves for rough maps, 0 to 1."""
    frame: Frame


@dataclass(frozen=True, kw_only=True)
class NoScores:
    """All virtual doors are equally likely (paper)."""

    def __call__(self, simplified: SimplifiedGrid, path: BoundaryPath, corners: Corners, doors: VirtualDoors) -> None:
        """No scores."""


@dataclass(frozen=True, kw_only=True)
class ScoreDoors:
    """Score the proposed doors in two passes, the second with the surest ones closed, and find conflicts."""

    least_log_odds: Annotated[float, Within(-100, 100)] = -6.0
    """Doors less likely than this are left out of the search. The limit is low because an unlikely door may be needed
    to close the last gap beside likely ones."""
    same_place_m: Annotated[float, Within(0, 5)] = 0.25
    """Of two doors whose middles are closer than this, only the likelier is searched."""
    apart_m: Annotated[float, Within(0, 5)] = 0.6
    """Doors whose middles are closer than this are in conflict."""
    sure_log_odds: Annotated[float, Within(-100, 100)] = 0.5
    """Doors likelier than this in pass 1 are closed in pass 2."""
    model: str = SHIPPED
    """The curves: shipped with the package, or the path of a file written by `vdoor train`."""

    def __call__(
        self, simplified: SimplifiedGrid, path: BoundaryPath, corners: Corners, doors: VirtualDoors
    ) -> DoorScores:
        """The scores, in the order of the proposed doors."""
        model = model_named(self.model)
        rows = np.flatnonzero(doors.verdict == PROPOSED)
        roughness_per_m = corners_per_m(path, corners)
        share_rough = model.rough.share(roughness_per_m)
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
            corners_per_m=roughness_per_m,
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
        """The values (k, features) of `FEATURES` for the proposed doors, and the doors (m,) closed in pass 2."""
        rows = np.flatnonzero(doors.verdict == PROPOSED)
        segments, free = Segments(doors, rows), simplified.cells == FREE
        distance = room_around(free)
        first = first_features(simplified, path, doors, rows, corners.sample, distance=distance)
        sure = surest(segments, first_pass.log_odds(first, share_rough), self.sure_log_odds, self.apart_m)
        second = closed_features(free, segments, doors, rows, sure, distance=distance)
        return np.concatenate([first, second], axis=1), sure


def corners_per_m(path: BoundaryPath, corners: Corners) -> float:
    """How rough a map is: corners per metre of its boundary."""
    return len(corners.sample) / max(float(path.length_m.sum()), path.frame.resolution_m)
