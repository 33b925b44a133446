"""Ids, names and edits of an older run carried over to a new one."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np

from vdoor.api import prepared, run_prepared
from vdoor.config import replaced
from vdoor.editing.apply import DONE, NEEDLESS, VERDICTS, EditRooms, Edits
from vdoor.editing.edits import FORMS, MOST_ID, Edit
from vdoor.errors import SettingError
from vdoor.grid import OccupancyGrid
from vdoor.matching.align import aligned
from vdoor.matching.room_matching import Match, match
from vdoor.pipeline import AnyPipeline
from vdoor.record import Record
from vdoor.topology import TopologicalMap

R = TypeVar("R", bound=Record)


@dataclass(frozen=True)
class Older:
    """The run that rooms are matched with."""

    topology: TopologicalMap
    edits: tuple[Edit, ...] = ()
    taken: int = 0
    """The highest id that a room had before it."""

    @classmethod
    def of(cls, topology: TopologicalMap, settings: Mapping[str, Any]) -> Older:
        """A finished run by its map and settings; `SettingError` for edits that are none."""
        stage = replaced(EditRooms(), _table(settings), "settings of the result: edit")
        return cls(topology, stage.parsed, stage.taken)


def carried_over(
    older: Older, grid: OccupancyGrid, pipeline: AnyPipeline, *, seed: int, edits_too: bool
) -> tuple[AnyPipeline, Match]:
    """The pipeline with the edits that give rooms the ids and names of an older run; and what became of its rooms.

    To find them the run is done once, and once more where the older run has edits that come over with it (`edits_too`):
    those that change where rooms and doors are, moved to where they belong on the new map. Ids and names that the
    pipeline's own edits give stand. The pipeline is prepared for the map, if it is not.
    """
    pipeline = prepared(pipeline, grid).pipeline
    topology, edits = _run(pipeline, grid, seed)
    alignment = aligned(older.topology, topology)
    shapes = [str(edit.moved(alignment.shift_m)) for edit in older.edits if edit.shapes and edits_too]
    if shapes:
        pipeline = _with_edits(pipeline, [*shapes, *pipeline.edit.edits])
        topology, edits = _run(pipeline, grid, seed)
    found = match(
        older.topology,
        topology,
        alignment=alignment,
        taken=max(older.taken, pipeline.edit.taken),
        numbered=_rooms_of(edits, "number"),
        named=_rooms_of(edits, "name"),
    )
    return _with_edits(pipeline, [*pipeline.edit.edits, *found.edits], taken=found.taken), found


def _table(settings: Mapping[str, Any]) -> Mapping[str, Any]:
    table = settings.get("edit", {})
    if not isinstance(table, Mapping):
        raise SettingError(f"settings of the result: edit: wanted a table of settings, found {table!r}")
    return table


def _run(pipeline: AnyPipeline, grid: OccupancyGrid, seed: int) -> tuple[TopologicalMap, Edits | None]:
    """The map, and what came of its edits."""
    seen: list[Edits] = []

    def emit(record: R, /) -> R:
        if isinstance(record, Edits):
            seen.append(record)
        return record

    return run_prepared(grid, pipeline, seed=seed, emit=emit), (seen[0] if seen else None)


def _with_edits(pipeline: AnyPipeline, edits: Sequence[str], *, taken: int | None = None) -> AnyPipeline:
    own = pipeline.edit
    edit = dataclasses.replace(own, edits=tuple(edits), taken=own.taken if taken is None else min(taken, MOST_ID))
    return dataclasses.replace(pipeline, edit=edit)


def _rooms_of(edits: Edits | None, kind: str) -> set[int]:
    """The rooms that edits of one kind speak of and that are there."""
    if edits is None:
        return set()
    good = np.isin(edits.verdict, [VERDICTS.index(word) for word in (DONE, NEEDLESS)])
    rows = np.flatnonzero(good & (edits.kind == tuple(FORMS).index(kind)))
    return set(edits.touched_room[np.isin(edits.touched_edit, rows)].tolist())
