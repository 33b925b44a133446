"""One map's measures."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from vdoor.evaluate.cases import Case
from vdoor.evaluate.division import Division, MapChoice, read_division
from vdoor.evaluate.door_places import TOLERANCES_M, DoorMatch, Doors, Tally, match_doors
from vdoor.evaluate.reference import Reference, read_reference
from vdoor.evaluate.room_scores import RoomScore, compare_rooms

ENDINGS = dict(zip(TOLERANCES_M, ("", "_1m"), strict=True))
"""How the figures of each tolerance are called."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Evaluation:
    """A map's division against the truth."""

    name: str
    division: Division
    reference: Reference
    rooms: RoomScore | None
    """None where the reference has doors only."""
    doors: Doors
    """Found ones."""
    matches: dict[float, DoorMatch]
    """By tolerance in metres."""

    def figures(self) -> dict[str, float]:
        """Every measure by name."""
        rooms = {} if self.rooms is None else room_figures(self.rooms)
        counts = {"doors_true": len(self.reference.doors), "doors_found": len(self.doors)}
        return rooms | counts | door_figures({limit: match.tally for limit, match in self.matches.items()})


def evaluate(division: Division, reference: Reference) -> Evaluation:
    """Measures of a divided map against the truth about it."""
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
    """The same from files; `bare` is the map, or a folder of maps, that label references were drawn on."""
    division = read_division(case.name, case.result, maps)
    choice = None
    if bare is not None:
        choice = MapChoice(path=bare, resolution_m=division.frame.resolution_m, free_from=maps.free_from)
    return evaluate(division, read_reference(case.reference, case.key, division, choice))


def room_figures(score: RoomScore) -> dict[str, float]:
    """Measures of rooms by name."""
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
    """Measures of doors by name, those at 1 m with an ending."""
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
    """Mean of each figure over the maps that have it."""
    figures = [evaluation.figures() for evaluation in evaluations]
    names = dict.fromkeys(name for row in figures for name in row)
    return {name: float(np.mean([row[name] for row in figures if name in row])) for name in names}


def pooled(evaluations: Sequence[Evaluation]) -> dict[str, float]:
    """Measures of the doors of all maps together."""
    tallies = {
        limit: sum((evaluation.matches[limit].tally for evaluation in evaluations), Tally()) for limit in TOLERANCES_M
    }
    return {f"pooled_{name}": value for name, value in door_figures(tallies).items()}
