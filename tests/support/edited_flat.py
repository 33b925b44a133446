"""The flat, edited: what tests of edits share."""

from __future__ import annotations

import dataclasses
from typing import Any

import finished_maps
import numpy as np

from vdoor.editing.apply import VERDICTS, EditRooms
from vdoor.editing.places import place_text
from vdoor.grid import OccupancyGrid
from vdoor.pipeline import PRESETS
from vdoor.record import Record
from vdoor.topology import TopologicalMap

FLAT = finished_maps.HOME / "recordings" / "flat.yaml"


def flat() -> TopologicalMap:
    """Five rooms: 1 and 2 above, 3 to 5 below; doors 1-2, 2-3, 3-5, 4-5."""
    return finished_maps.topology("flat")


def at(room: int, topology: TopologicalMap | None = None) -> str:
    return place_text((topology or flat()).room(room).centre_m)


def outcome(topology: TopologicalMap, *lines: str) -> tuple[TopologicalMap, list[str], list[list[int]]]:
    """The map after edits, the verdict of each, and the rooms it speaks of."""
    after, edits = EditRooms(edits=lines)(topology)
    assert edits is not None
    rooms = [edits.touched_room[edits.touched_edit == row].tolist() for row in range(len(lines))]
    return after, [VERDICTS[code] for code in edits.verdict], rooms


def run_with(lines: tuple[str, ...], grid: OccupancyGrid, preset: str = "paper") -> tuple[TopologicalMap, list[Record]]:
    """The map of a run with edits, and all that it emits."""
    pipeline = dataclasses.replace(PRESETS[preset], edit=EditRooms(edits=lines))
    seen: list[Record] = []

    def emit(record: Any, /) -> Any:
        seen.append(record)
        return record

    return pipeline(grid, np.random.default_rng(0), emit), seen
