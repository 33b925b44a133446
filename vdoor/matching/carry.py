"""Carrying over ids, names and edits of an older run to a new one."""

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
    """The older run whose rooms are matched."""

    topology: TopologicalMap
    edits: tuple[Edit, ...] = ()
    taken: int = 0
    """The highest room id used before that run."""

    @classmethod
    def of(cls, topology: TopologicalMap, settings: Mapping[str, Any]) -> Older:
        """A finished run from its map and settings; raises `SettingError` for invalid edits."""
        stage = replaced(EditRooms(), _table(settings), "settings of the result: edit")
        return cls(topology, stage.parsed, stage.taken)


def carried_over(
    older: Older, grid: OccupancyGrid, pipeline: AnyPipeline, *, seed: int, edits_too: bool
) -> tuple[AnyPipeline, Match]:
    """The pipeline with edits that give rooms the ids and names of an older run, and the match of the two maps' rooms.

    This runs the pipeline once and, with `edits_too`, again if the older run has edits that change rooms or doors.
    These are carried over first, shifted to the new map's frame. Ids and names from the pipeline's own edits are kept.
    The pipeline is prepared for the map if it is not yet.
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
    """The topological map, and the record of its edits, None if it has none."""
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
    """The ids of the rooms that successful edits of one kind refer to."""
    if edits is None:
        return set()
    good = np.isin(edits.verdict, [VERDICTS.index(word) for word in (DONE, NEEDLESS)])
    rows = np.flatnonzero(good & (edits.kind == tuple(FORMS).index(kind)))
    return set(edits.touched_room[np.isin(edits.touched_edit, rows)].tolist())
