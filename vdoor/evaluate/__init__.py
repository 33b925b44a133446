"""How good a division of a map into rooms is, measured against the truth."""

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
