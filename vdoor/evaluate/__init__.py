"""How well a map is divided into rooms and doors, measured against ground truth."""

from __future__ import annotations

from typing import TYPE_CHECKING

from vdoor.lazy import on_first_use

if TYPE_CHECKING:
    from vdoor.evaluate.cases import Case, Cases, matched
    from vdoor.evaluate.division import Division, MapChoice, read_division
    from vdoor.evaluate.door_places import DoorMatch, Doors, Tally, contact_doors, marked_doors, match_doors
    from vdoor.evaluate.evaluation import Evaluation, evaluate, evaluate_case, means, pooled
    from vdoor.evaluate.label_files import rooms_of
    from vdoor.evaluate.reference import Reference, read_reference
    from vdoor.evaluate.room_scores import RoomScore, compare_rooms

__all__ = [
    "Case", "Cases", "Division", "DoorMatch", "Doors", "Evaluation", "MapChoice", "Reference", "RoomScore", "Tally",
    "compare_rooms", "contact_doors", "evaluate", "evaluate_case", "marked_doors", "match_doors", "matched", "means",
    "pooled", "read_division", "read_reference", "rooms_of",
]  # fmt: skip

__getattr__ = on_first_use(
    __name__,
    {
        "cases": ("Case", "Cases", "matched"),
        "division": ("Division", "MapChoice", "read_division"),
        "door_places": ("DoorMatch", "Doors", "Tally", "contact_doors", "marked_doors", "match_doors"),
        "evaluation": ("Evaluation", "evaluate", "evaluate_case", "means", "pooled"),
        "label_files": ("rooms_of",),
        "reference": ("Reference", "read_reference"),
        "room_scores": ("RoomScore", "compare_rooms"),
    },
)
