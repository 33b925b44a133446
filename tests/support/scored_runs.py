"""Runs with scored doors, by curves simple enough to know each score by hand."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from maps import drawn
from terminals import recorded
from two_rooms import TWO_ROOMS

from vdoor.method.scoring.features import FEATURES, FIRST
from vdoor.method.scoring.score import ScoreDoors
from vdoor.method.search.certificate import BoundEnergy
from vdoor.method.search.costs import DoorEnergy
from vdoor.method.search.memetic import MemeticSearch
from vdoor.method.wide_doors import ProposeWideDoors
from vdoor.pipeline import Pipeline

BIAS = -1.25
CURVES = {
    "length_m": ((0.5, 1.0, 2.0), (-1.0, 1.0, -0.25)),
    "pair": ((0.0, 1.0), (1.0, 2.0)),
    "same_contour": ((0.0, 1.0), (0.0, 0.75)),
}
"""All other features say nothing."""
GENEROUS = ProposeWideDoors(
    pair_m=2.7, single_m=2.5, extension_m=3.5, apart_cosine=0.8, pair_detour=1.5, single_detour=1.8
)
"""Proposes more than the doors that are there, also on small maps."""
DOOR_SAYS = 2.0 + 1.0 + 0.75
SINGLE_SAYS = 1.0 - 0.25 + 0.75


def write_curves(path: Path, bias: float = BIAS) -> Path:
    """A file as `vdoor train` writes it, ragged maps scored as others, the second look as the first."""
    table: dict[str, Any] = {"made": {}, "rough": {"middle_per_m": 0.75, "softness": 0.25}}
    for look, names in (("first", FIRST), ("last", FEATURES)):
        curves: dict[str, Any] = {name: {"at": [0.0], "clean": [0.0], "rough": [0.0]} for name in names}
        curves |= {name: {"at": at, "clean": says, "rough": says} for name, (at, says) in CURVES.items()}
        table[look] = {"bias": {"clean": bias, "rough": bias}, "curves": curves}
    path.write_text(json.dumps(table))
    return path


def scored(folder: Path, **settings: Any) -> Path:
    """The recording of a scored run on two rooms, whose door is pair 0; singles lead from its jambs into the rooms."""
    pipeline = Pipeline(
        doors=GENEROUS,
        score=ScoreDoors(model=str(write_curves(folder / "curves.json")), **{"least_log_odds": -2.0, **settings}),
        cost=DoorEnergy(lack_weight=4.0, lack_weight_rough=4.0, bias=0.25, bias_rough=0.25),
        search=MemeticSearch(),
        certify=BoundEnergy(),
    )
    return recorded(folder, drawn(TWO_ROOMS), pipeline, preset="default")
