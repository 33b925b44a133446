"""Edits on record, and doors that were shut when the map was made."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

import finished_maps
import maps
import numpy as np
import pytest
import small_recording
from edited_flat import at, flat, run_with

import vdoor
from vdoor.editing.apply import VERDICTS, EditRooms, Edits
from vdoor.errors import RecordingError
from vdoor.grid import FREE, OCCUPIED, OccupancyGrid
from vdoor.pipeline import PRESETS, RECORDS
from vdoor.record import equal
from vdoor.recording.compare import differences
from vdoor.topology import TopologicalMap


@pytest.mark.parametrize("preset", sorted(PRESETS))
def test_edits_are_on_record_in_every_preset(preset: str) -> None:
    grid = finished_maps.grid("flat")
    topology, seen = run_with((f"name {at(1)} Kitchen", "merge 900,900 1,1"), grid, preset)
    assert [type(record) for record in seen[-2:]] == [Edits, TopologicalMap]
    assert [VERDICTS[code] for code in seen[-2].verdict] == ["done", "no room there"]  # type: ignore[attr-defined]
    assert topology.room_named("Kitchen").area_m2 > 5
    pipeline = dataclasses.replace(PRESETS[preset], edit=EditRooms(edits=("name 1,1 A",)))
    order = [record for record in RECORDS if record in pipeline.records]
    assert list(pipeline.records) == order
    assert Edits in pipeline.records
    assert Edits not in PRESETS[preset].records


def test_names_survive_a_recording(tmp_path: Path) -> None:
    names = ("Küche", "a = b", "", "台所", "حمّام")
    lines = tuple(f"name {at(room)} {name}" for room, name in enumerate(names, start=1) if name)
    topology, seen = run_with((*lines, f"number {at(2)} 77"), finished_maps.grid("flat"))
    info = dataclasses.replace(small_recording.small_run()[0], source=finished_maps.grid("flat").source)
    read = small_recording.read(small_recording.write(tmp_path / "a.mcap", seen, info))
    assert all(map(equal, read[-2:], seen[-2:]))
    (back,) = [record for record in read if isinstance(record, TopologicalMap)]
    assert back.rooms == topology.rooms
    assert {room.id: room.name for room in back.rooms} == {1: "Küche", 3: "", 4: "台所", 5: "حمّام", 77: "a = b"}


def test_names_that_differ_are_told_by_room() -> None:
    one, other = vdoor.edited(flat(), [f"name {at(2)} Hall"]), vdoor.edited(flat(), [f"name {at(2)} Bath"])
    (found,) = differences(one, other)
    assert (found.field, found.count, found.worst.expected, found.worst.found) == ("name", 1, "Hall", "Bath")
    (found,) = differences(one, flat())
    assert (found.worst.expected, found.worst.found, found.worst.index) == ("Hall", "", (1,))


@pytest.mark.parametrize(
    "names", [("A",), ("A", "B\n", "", "", ""), ("A",) * 6, ["A"] * 5, ("A" * 101, "", "", "", "")]
)
def test_record_refuses_other_names(names: Any) -> None:
    with pytest.raises(RecordingError, match="name"):
        dataclasses.replace(flat(), name=names)


def test_rows_that_are_not_the_labels_are_refused() -> None:
    labels = flat().labels.copy()
    labels[labels == 3] = 2
    with pytest.raises(RecordingError, match="4 rooms, found 5"):
        _ = dataclasses.replace(flat(), labels=labels).rooms


# Doors that were shut


@pytest.mark.parametrize("finer", [1, 4])
@pytest.mark.parametrize("preset", ["paper", "default", "voronoi-doors"])
@pytest.mark.parametrize("aside_m", [0.0, 0.3])
def test_closed_door_opens_the_room_behind_it(preset: str, finer: int, aside_m: float) -> None:
    cells = finished_maps.house(3, (1, 6, 4)).repeat(finer, axis=0).repeat(finer, axis=1)
    grid = OccupancyGrid.from_array(cells, maps.CELL_M / finer)
    wall_m = (2 * 18 + 1) * maps.CELL_M, 10 * maps.CELL_M
    shut = vdoor.run(grid, preset)
    assert all(3 not in room.neighbours for room in shut.rooms)
    topology, seen = run_with((f"closed-door {wall_m[0] + aside_m},{wall_m[1]}",), grid, preset)
    assert equal(seen[0], grid)
    assert [room.neighbours for room in topology.rooms] == [(2,), (1, 3), (2,)]
    door = topology.doors_of(3)[0]
    middle = np.mean([door.start_m, door.end_m], axis=0)
    assert np.hypot(*(middle - wall_m)) < 0.4
    assert door.width_m == pytest.approx(0.8, abs=0.25)
    edits = seen[-2]
    assert isinstance(edits, Edits)
    assert [VERDICTS[code] for code in edits.verdict] == ["done"]


def test_closed_door_is_a_door_where_the_search_would_merge() -> None:
    cells = finished_maps.house(2)
    cells[2:-2, 20:-2] = OCCUPIED
    cells[6:14, 20:23] = FREE  # a closet of a square metre, too small to be a room by the paper's cost
    grid = OccupancyGrid.from_array(cells, maps.CELL_M)
    topology, seen = run_with((f"closed-door {19 * maps.CELL_M},{10 * maps.CELL_M}",), grid)
    edits = seen[-2]
    assert isinstance(edits, Edits)
    assert [VERDICTS[code] for code in edits.verdict] == ["done"]
    assert [(room.id, room.neighbours) for room in topology.rooms] == [(1, (2,)), (2, (1,))]
    assert [door.kind for door in topology.doors] == ["added"]


def test_door_that_stands_open_by_now_needs_no_edit() -> None:
    grid = OccupancyGrid.from_array(finished_maps.house(2, (1, 6, 4)), maps.CELL_M)
    _, seen = run_with((f"closed-door {19 * maps.CELL_M},{10 * maps.CELL_M}",), grid)
    edits = seen[-2]
    assert isinstance(edits, Edits)
    assert [VERDICTS[code] for code in edits.verdict] == ["not needed"]


def test_open_wall_is_no_closed_door() -> None:
    cells = finished_maps.house(2)
    pipeline = dataclasses.replace(PRESETS["paper"], edit=EditRooms(edits=("closed-door 2,2", "closed-door 0.1,2")))
    grid = OccupancyGrid.from_array(cells, maps.CELL_M)
    assert pipeline.edit.open_doors(grid).grid is grid
