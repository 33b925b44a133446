"""Edits in `vdoor run`: from files and options, from an older result, and notes on their results."""

from __future__ import annotations

import contextlib
import dataclasses
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from vdoor.errors import SettingError, VdoorError, say

if TYPE_CHECKING:
    from vdoor.emit import Sink
    from vdoor.grid import OccupancyGrid
    from vdoor.matching import Match
    from vdoor.pipeline import AnyPipeline
    from vdoor.record import Record

LEAST_OVERLAP = 0.5
"""Maps that share less of their rooms' area are probably not of the same place."""


def with_edits(
    pipeline: AnyPipeline, file: Path | None, closed_doors: Sequence[str], grid: OccupancyGrid
) -> AnyPipeline:
    """The pipeline with the edits of a file, then closed doors to open; `SettingError` for a point without a wall."""
    from vdoor.editing.closed_doors import THICKEST_M, openings
    from vdoor.editing.edits import Edit, read_edits
    from vdoor.editing.places import parse_place

    edits = read_edits(file) if file is not None else []
    for text in closed_doors:
        place = parse_place(text, what="--closed-door")
        if openings(grid.free, grid.frame, [place])[0] is None:
            raise SettingError(
                f"--closed-door: wanted a wall of at most {THICKEST_M:g} m between free cells, found none at {text}"
            )
        edits.append(Edit("closed-door", (place,)))
    if not edits:
        return pipeline
    edit = dataclasses.replace(pipeline.edit, edits=(*pipeline.edit.edits, *map(str, edits)))
    return dataclasses.replace(pipeline, edit=edit)


def edit_files(folder: Path, lines: Sequence[str], *, quiet: bool) -> list[tuple[Path, bytes]]:
    """The files, with contents, that keep the edits of a run in its folder; other edits there get another name."""
    from vdoor.editing.edits import MOST_BYTES, appended, parse, read_edits
    from vdoor.files import read_regular
    from vdoor.results.editor import EDITS

    path, before = folder / EDITS, folder / f"before.{EDITS}"
    edits = [parse(line) for line in lines]
    existing = read_regular(path, "edits as TOML", limit=MOST_BYTES) if path.exists() else None
    if not edits:
        if existing is not None and not quiet:
            say(f"note: edits in the folder were not applied (--edits applies them): {path}")
        return []
    if existing is not None:
        with contextlib.suppress(VdoorError):  # for example invalid text written by hand
            if read_edits(path) == edits:
                return []
        if not quiet:
            say(f"note: the folder had other edits, which are kept: {before}")
    kept = [(before, existing)] if existing is not None else []
    return [*kept, (path, appended(path, edits, keep=False))]


def matched(
    older: Path, grid: OccupancyGrid, pipeline: AnyPipeline, *, seed: int, edits_too: bool, quiet: bool
) -> tuple[AnyPipeline, Match]:
    """The pipeline with the ids and names of an older result, and the match, which is printed on stderr."""
    from vdoor.export import read_finished
    from vdoor.matching import Older, carried_over

    place = older.parent if older.name == "map.json" else older
    finished = read_finished(place)
    old = Older.of(finished.topology, finished.settings)
    pipeline, found = carried_over(old, grid, pipeline, seed=seed, edits_too=edits_too)
    for line in () if quiet else found.lines():
        say(line)
    if found.alignment.overlap < LEAST_OVERLAP and not quiet:
        say(f"note: the two maps overlap little; are they of the same place? {older}")
    return pipeline, found


class EditNotes:
    """A sink that prints on stderr which edits could not be applied."""

    def __init__(self, lines: Sequence[str]) -> None:
        self._lines = lines

    @classmethod
    def sinks(cls, pipeline: AnyPipeline, *, quiet: bool) -> list[Sink]:
        """One such sink if the run has edits, unless quiet."""
        return [cls(pipeline.edit.edits)] if pipeline.edit.edits and not quiet else []

    def write(self, step: int, record: Record) -> None:
        """Print notes on the record of edits; ignore other records."""
        from vdoor.editing.apply import DONE, NEEDLESS, Edits, told

        del step
        if not isinstance(record, Edits):
            return
        for line, verdict in told(record, self._lines):
            if verdict not in (DONE, NEEDLESS):
                say(f"note: an edit could not be applied, {verdict}: {line}")

    def close(self) -> None:
        """Nothing to finish."""
