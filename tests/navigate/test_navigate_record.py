"""A route on record: drawn in the viewer and the report, recorded by every preset, off unless asked for."""

from __future__ import annotations

import dataclasses
import functools
from pathlib import Path

import numpy as np
import pytest
from rerun.chunk import RrdReader

import vdoor
from vdoor.config import settings_of
from vdoor.emit import RunInfo
from vdoor.errors import SettingError
from vdoor.export.report import to_report
from vdoor.grid import FREE, OCCUPIED, OccupancyGrid
from vdoor.history.provenance import Provenance
from vdoor.navigate.find_route import FindRoute, Route, crossed
from vdoor.pipeline import METHODS, PRESETS, recorded
from vdoor.record import Record
from vdoor.viz.rerun.sink import RerunSink

FLAT = Path(__file__).parents[2] / "recordings" / "flat.yaml"
ROUTE = FindRoute(start="1", goal="4")


@functools.cache
def run_with_route(preset: str = "paper") -> tuple[RunInfo, list[Record]]:
    pipeline = dataclasses.replace(PRESETS[preset], route=ROUTE)
    records: list[Record] = []

    def emit(record: Record, /) -> Record:
        records.append(record)
        return record

    grid = vdoor.read_map(FLAT)
    pipeline(grid, np.random.default_rng(0), emit)  # type: ignore[arg-type]  # it returns what it is given
    settings = settings_of(pipeline, METHODS)
    return RunInfo(version="test", preset=preset, seed=0, settings=settings, source=grid.source), records


@pytest.mark.parametrize("preset", PRESETS)
def test_a_route_is_the_last_record_of_every_preset_that_is_asked_for_one(preset: str) -> None:
    assert "route" not in settings_of(PRESETS[preset], METHODS)
    assert Route not in PRESETS[preset].records
    info, records = run_with_route(preset)
    assert isinstance(records[-1], Route)
    assert recorded(info).records[-1] is Route
    assert recorded(info).route == ROUTE


def test_the_robot_drives_along_the_path_on_a_timeline_of_its_own(tmp_path: Path) -> None:
    info, records = run_with_route()
    sink = RerunSink.to_file(tmp_path / "a.rrd", info)
    for step, record in enumerate(records):
        sink.write(step, record)
    sink.close()
    route = records[-1]
    assert isinstance(route, Route)
    places = {}
    for chunk in RrdReader(tmp_path / "a.rrd").stream().filter(content="/route/robot"):
        for row in chunk.to_record_batch().to_pylist():
            if row.get("Points2D:positions"):
                places[row["drive"]] = row["Points2D:positions"][0]
    assert min(places) == 0
    assert max(places) == round(100 * route.length_m)
    cells = route.frame.cell_from_world(route.point_m)
    for at_m, cell in zip(route.along_m, cells, strict=True):  # every bend is passed
        assert places[round(100 * at_m)] == pytest.approx(cell[::-1] + 0.5, abs=0.06)  # a centimetre


def test_the_report_draws_a_route_and_what_is_in_the_way() -> None:
    info, records = run_with_route()
    grid, topology, route = records[0], records[-2], records[-1]
    assert isinstance(grid, OccupancyGrid)
    assert isinstance(topology, vdoor.TopologicalMap)
    assert isinstance(route, Route)
    closed = dataclasses.replace(ROUTE, closed=("2",))(grid, topology)
    for record, words in ((route, f"{route.length_m:.2f} m, doors 1, 2, 3, 4"), (closed, "door 2 is closed")):
        provenance = Provenance.of(info)
        for step, one in enumerate((grid, record)):
            provenance.run.write(step, one)
        assert words in to_report(topology, provenance=provenance)


def test_a_place_in_free_cells_outside_all_rooms_is_refused() -> None:
    cells = np.full((30, 60), OCCUPIED, np.int8)
    cells[2:28, 2:40] = FREE
    cells[10:18, 46:56] = FREE
    grid = OccupancyGrid.from_array(cells, 0.1)
    topology = vdoor.run(grid)
    assert not topology.labels[14, 50]  # too small a part to be a room
    with pytest.raises(SettingError, match=r"goal: wanted a place in a room, found none at 5\.05,1\.55"):
        FindRoute(start="1", goal="5.05,1.55")(grid, topology)


def test_doors_are_counted_once_where_a_path_grazes_the_line_between_rooms() -> None:
    _, records = run_with_route()
    topology = records[-2]
    assert isinstance(topology, vdoor.TopologicalMap)
    row, col = np.argwhere((topology.labels[:, :-1] == 1) & (topology.labels[:, 1:] == 2))[0]
    there = np.array([[row, col - 5], [row, col + 5]])
    assert crossed(topology, there) == [1]
    assert crossed(topology, np.concatenate([there, there[:1]])) == [1, 1]  # there and back
    assert crossed(topology, np.array([[row, col], [row, col + 1], [row, col]])) == []  # only over the line
    assert crossed(topology, there[:1]) == []
