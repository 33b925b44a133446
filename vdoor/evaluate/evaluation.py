"""The measures of one map, and their means over several."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from vdoor.evaluate.cases import Case
from vdoor.evaluate.division import Division, MapChoice, read_division
from vdoor.evaluate.door_places import TOLERANCES_M, DoorMatch, Doors, Tally, angles_rad, match_doors
from vdoor.evaluate.reference import Reference, read_reference
from vdoor.evaluate.room_scores import RoomScore, compare_rooms

ENDINGS = dict(zip(TOLERANCES_M, ("", "_1m"), strict=True))
"""Suffix of the figures' names for each tolerance in metres."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Evaluation:
    """A map's division compared with the ground truth."""

    name: str
    division: Division
    reference: Reference
    rooms: RoomScore | None
    """None if the reference has doors only."""
    doors: Doors
    """The found doors."""
    matches: dict[float, DoorMatch]
    """By tolerance in metres."""

    def figures(self) -> dict[str, float]:
        """All measures by name."""
        rooms = {} if self.rooms is None else room_figures(self.rooms)
        counts = {"doors_true": len(self.reference.doors), "doors_found": len(self.doors)}
        doors = door_figures({limit: match.tally for limit, match in self.matches.items()})
        return rooms | counts | doors | self._hit_figures()

    def _hit_figures(self) -> dict[str, float]:
        """The mean distance of the hits from the true doors, and the mean angle between them; empty without hits."""
        match = self.matches[TOLERANCES_M[0]]
        true, found = self.reference.doors[match.hit_true], self.doors[match.hit_found]
        if not len(true):
            return {}
        apart_m = np.hypot(*(true.centre_m - found.centre_m).T)
        return {
            "hits_apart_m": float(apart_m.mean()),
            "hits_tilt_deg": float(np.degrees(angles_rad(true, found)).mean()),
        }


def evaluate(division: Division, reference: Reference) -> Evaluation:
    """The evaluation of a divided map against its ground truth."""
    found = division.doors()
    return Evaluation(
        name=division.name,
        division=division,
        reference=reference,
        rooms=None if reference.rooms is None else compare_rooms(reference.rooms, division.rooms, division.free),
        doors=found,
        matches={limit: match_doors(reference.doors, found, limit, unsure=reference.unsure) for limit in TOLERANCES_M},
    )


def evaluate_case(case: Case, maps: MapChoice, bare: Path | None = None) -> Evaluation:
    """The evaluation of a result file; `bare` is the map, or folder of maps, on which label references were drawn."""
    division = read_division(case.name, case.result, maps)
    choice = None
    if bare is not None:
        choice = MapChoice(path=bare, resolution_m=division.frame.resolution_m, free_from=maps.free_from)
    return evaluate(division, read_reference(case.reference, case.key, division, choice))


def room_figures(score: RoomScore) -> dict[str, float]:
    """The room measures by name."""
    return {
        "rooms_true": score.true,
        "rooms_found": score.found,
        "rooms_off": abs(score.found - score.true),
        "room_recall": score.recall,
        "room_precision": score.precision,
        "room_recall_by_area": score.recall_by_area,
        "room_precision_by_area": score.precision_by_area,
        "iou": score.iou,
        "iou_sym": score.iou_sym,
        "mcc": score.mcc,
        "mcc_loose": score.mcc_loose,
    }


def door_figures(tallies: dict[float, Tally]) -> dict[str, float]:
    """The door measures by name, with the suffix of their tolerance."""
    return {
        f"{name}{ENDINGS[limit]}": value
        for limit, tally in tallies.items()
        for name, value in (
            ("door_precision", tally.precision),
            ("door_recall", tally.recall),
            ("door_f1", tally.f1),
            ("narrow_recall", tally.narrow_recall),
        )
    }


def means(evaluations: Sequence[Evaluation]) -> dict[str, float]:
    """The mean of each figure over the maps that have it."""
    figures = [evaluation.figures() for evaluation in evaluations]
    names = dict.fromkeys(name for row in figures for name in row)
    return {name: float(np.mean([row[name] for row in figures if name in row])) for name in names}


def pooled(evaluations: Sequence[Evaluation]) -> dict[str, float]:
    """The door measures from the counts of all maps together."""
    tallies = {
        limit: sum((evaluation.matches[limit].tally for evaluation in evaluations), Tally()) for limit in TOLERANCES_M
    }
    return {f"pooled_{name}": value for name, value in door_figures(tallies).items()}
