"""What lies over what in the viewer, and in which colours, read back from its recordings."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any

import vacuum
from report_pages import driven
from rerun.chunk import RrdReader

import vdoor
from vdoor.emit import RunInfo
from vdoor.export.report.layers import layers
from vdoor.export.report.sheet import Sheet
from vdoor.navigate.cover_floor import Coverage
from vdoor.record import Record
from vdoor.viz.rerun.sink import RerunSink


def drawn(path: Path, records: Iterable[Record]) -> Path:
    sink = RerunSink.to_file(path, RunInfo(version="test", preset="paper", seed=0, settings={}))
    for step, record in enumerate(records):
        sink.write(step, record)
    sink.close()
    return path


def logged(path: Path, entity: str, column: str) -> list[Any]:
    """The values of a column of an entity, row by row."""
    batches = (chunk.to_record_batch() for chunk in RrdReader(path).stream().filter(content=entity))
    return [row for batch in batches if column in batch.schema.names for row in batch.column(column).to_pylist()]


def test_swept_floor_has_the_colour_that_it_has_in_the_report(tmp_path: Path) -> None:
    provenance, topology = driven()
    path = drawn(tmp_path / "driven.rrd", provenance.run.records.values())
    (((none, swept),),) = logged(path, "/coverage/floor", "AnnotationContext:context")
    (layer,) = (each for each in layers(Sheet(topology.frame), provenance) if each.id == Coverage.topic)
    colour, _ = layer.key[0]
    assert f"#{swept['class_description']['info']['color']:08x}" == f"{colour}ff"
    assert none["class_description"]["info"]["color"] & 0xFF == 0


def test_walls_that_only_the_robot_knows_lie_over_the_rooms(tmp_path: Path) -> None:
    table = vacuum.home(virtual_wall=[*vacuum.centre_cm(2, 6), *vacuum.centre_cm(2, 9)])
    grid = vdoor.read_map(vacuum.write_home(tmp_path / "home.json", table))
    path = drawn(tmp_path / "home.rrd", [grid, vdoor.run(grid)])
    ((wall,),) = logged(path, "/input/map/virtual_wall", "LineStrips2D:draw_order")
    ((rooms,),) = logged(path, "/rooms/rooms", "SegmentationImage:draw_order")
    assert wall > rooms
