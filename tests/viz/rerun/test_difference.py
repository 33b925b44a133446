"""What `diff --save` draws: both runs, and marks where they differ and nowhere else."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import TypeVar

import numpy as np
from project import FLAT
from rerun.chunk import RrdReader

import vdoor
from vdoor.emit import RunInfo
from vdoor.method.corners import Corners
from vdoor.method.simplify import SimplifiedGrid
from vdoor.pipeline import RECORDS
from vdoor.record import Record
from vdoor.recording.diff import compare
from vdoor.viz.rerun.difference import DifferenceSink

R = TypeVar("R", bound=Record)
INFO = RunInfo(version="test", preset="paper", seed=0, settings={})


def records() -> list[Record]:
    found: list[Record] = []

    def keep(record: R, /) -> R:
        found.append(record)
        return record

    vdoor.run(vdoor.read_map(FLAT), "paper", emit=keep)
    return found


def entities(path: Path) -> set[str]:
    return {str(chunk.entity_path) for chunk in RrdReader(path).stream()}


def drawn(path: Path, one: list[Record], other: list[Record]) -> set[str]:
    sink = DifferenceSink(path, INFO)
    compare(one, other, types=RECORDS, listen=sink)
    sink.close()
    return entities(path)


def test_equal_runs_are_drawn_twice_and_nothing_is_marked(tmp_path: Path) -> None:
    run = records()
    found = drawn(tmp_path / "equal.rrd", run, run)
    assert not {name for name in found if name.startswith("/difference")}
    assert {"/recorded/rooms/doors", "/again/rooms/doors"} <= found


def test_a_flipped_cell_and_a_moved_corner_are_marked_where_they_are(tmp_path: Path) -> None:
    run = records()
    changed = list(run)
    for index, record in enumerate(run):
        if isinstance(record, SimplifiedGrid):
            cells = record.cells.copy()
            cells[20, 30] = 100 - cells[20, 30]
            changed[index] = dataclasses.replace(record, cells=cells)
        if isinstance(record, Corners):
            angle_rad = record.angle_rad.copy()
            angle_rad[3] += 1e-6
            changed[index] = dataclasses.replace(record, angle_rad=angle_rad)
    path = tmp_path / "changed.rrd"
    found = {name for name in drawn(path, run, changed) if name.startswith("/difference")}
    assert found == {"/difference/working/simplified/cells", "/difference/working/corners/angle_rad"}
    chunks = RrdReader(path).stream().filter(content="/difference/working/corners/angle_rad")
    batches = [chunk.to_record_batch() for chunk in chunks]
    places = [
        row
        for batch in batches
        for name in batch.schema.names
        if "positions" in name
        for row in batch.column(name).to_pylist()
    ]
    corner = next(record for record in run if isinstance(record, Corners)).cell[3]
    assert np.allclose(places, [[corner[::-1] + 0.5]])
