"""Maps matched with older ones: rooms keep their ids and names, and all outputs say so."""

from __future__ import annotations

import dataclasses
import functools
import json
import shutil
from pathlib import Path
from typing import Any

import finished_maps
import maps
import numpy as np
import pytest
import vacuum
from commands import Command, call, one_line
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image

import vdoor
from vdoor.editing.edits import appended, parse
from vdoor.editing.places import place_text
from vdoor.export import read_finished
from vdoor.grid import FREE, OCCUPIED, UNKNOWN, OccupancyGrid
from vdoor.matching import Older, aligned, carried_over
from vdoor.matching.align import known_shift_m
from vdoor.topology import TopologicalMap

FLAT = finished_maps.HOME / "recordings" / "flat.yaml"
NAMES = {1: "Kitchen", 2: "Hall", 3: "Büro", 4: "Bath", 5: "Bed"}
IDS = {1: 11, 2: 7, 3: 30, 4: 1, 5: 2}
"""Ids of the flat's rooms, by those that they are found with."""


@functools.cache
def old() -> TopologicalMap:
    """The flat, its rooms named and numbered as no search would."""
    flat = finished_maps.topology("flat")
    places = {room: place_text(flat.room(room).centre_m) for room in flat.room_ids}
    lines = [f"name {places[room]} {NAMES[room]}" for room in places]
    return vdoor.edited(flat, [*lines, *(f"number {places[room]} {IDS[room]}" for room in places)])


def flat_cells() -> maps.Cells:
    return finished_maps.grid("flat").cells


def as_before(new: TopologicalMap, shift_m: tuple[float, float], *, off_m: float = 1e-6) -> TopologicalMap:
    """The new map with ids and names of the old one; where each old room was is the room of its id and name."""
    match = vdoor.match(old(), new)
    assert match.alignment.shift_m == pytest.approx(shift_m, abs=off_m)
    after = vdoor.edited(new, match.edits)
    assert (match.new, match.gone) == ((), ())
    assert [(kept.id, kept.name) for kept in match.kept] == [(room.id, room.name) for room in old().rooms]
    assert {room.id: room.name for room in after.rooms} == {room.id: room.name for room in old().rooms}
    for room in old().rooms:
        x_m, y_m = room.centre_m
        assert after.room_at((x_m + shift_m[0], y_m + shift_m[1])) == after.room(room.id)
    return after


@given(st.tuples(*[st.integers(0, 60)] * 4), st.booleans())
@maps.law
def test_ids_hold_on_a_map_that_was_shifted_by_cells(edges: tuple[int, int, int, int], told: bool) -> None:
    top, bottom, left, right = edges
    cells = np.pad(flat_cells(), ((top, bottom), (left, right)), constant_values=UNKNOWN)
    there = (0.0, 0.0) if told else (left * maps.CELL_M, bottom * maps.CELL_M)
    grid = OccupancyGrid.from_array(cells, maps.CELL_M, x_m=there[0] - left * maps.CELL_M, y_m=-bottom * maps.CELL_M)
    grid = grid if told else OccupancyGrid.from_array(cells, maps.CELL_M)
    as_before(finished_map(grid), there)


def finished_map(grid: OccupancyGrid) -> TopologicalMap:
    return vdoor.run(grid, "paper")


@pytest.mark.parametrize("finer", [2, 3, 4])
def test_ids_hold_at_another_resolution(finer: int) -> None:
    cells = flat_cells().repeat(finer, axis=0).repeat(finer, axis=1)
    cells = np.pad(cells, ((0, finer * 4), (finer * 3, 0)), constant_values=UNKNOWN)
    grid = OccupancyGrid.from_array(cells, maps.CELL_M / finer)
    as_before(finished_map(grid), (3 * maps.CELL_M, 4 * maps.CELL_M), off_m=maps.CELL_M / 2)


@pytest.mark.parametrize("yaw_rad", [0.0, 0.7])
def test_ids_hold_in_a_frame_that_lies_askew(yaw_rad: float) -> None:
    turned = OccupancyGrid.from_array(flat_cells(), maps.CELL_M, x_m=-7.0, y_m=3.0, yaw_rad=yaw_rad)
    one = vdoor.edited(finished_map(turned), [])
    match = vdoor.match(one, finished_map(turned))
    assert match.alignment.shift_m == (0.0, 0.0)
    assert [(kept.id, kept.same) for kept in match.kept] == [(room, 1.0) for room in one.room_ids]


@pytest.mark.parametrize("seed", range(6))
def test_ids_hold_under_noise(seed: int) -> None:
    rng = np.random.default_rng(seed)
    cells = np.pad(flat_cells(), ((2, 5), (9, 1)), constant_values=UNKNOWN)
    speck = rng.random(cells.shape)
    cells[(cells == FREE) & (speck < 0.01)] = OCCUPIED
    cells[(cells == OCCUPIED) & (speck > 0.97)] = UNKNOWN
    new = finished_map(OccupancyGrid.from_array(cells, maps.CELL_M))
    match = vdoor.match(old(), new)
    assert match.alignment.shift_m == pytest.approx((9 * maps.CELL_M, 5 * maps.CELL_M), abs=maps.CELL_M)
    after = vdoor.edited(new, match.edits)
    found = {}
    for room in old().rooms:
        there = after.room_at((room.centre_m[0] + 9 * maps.CELL_M, room.centre_m[1] + 5 * maps.CELL_M))
        found[room.id] = there.id if there else 0
    assert len(match.kept) >= 4
    assert all(found[kept.id] in (kept.id, 0) for kept in match.kept)


def test_ids_hold_when_more_of_the_place_is_seen() -> None:
    part = flat_cells().copy()
    part[:, :25] = UNKNOWN  # the rooms on the left are seen later
    one = finished_map(OccupancyGrid.from_array(part, maps.CELL_M))
    new = finished_map(OccupancyGrid.from_array(np.pad(flat_cells(), 6, constant_values=UNKNOWN), maps.CELL_M))
    match = vdoor.match(one, new)
    assert match.alignment.shift_m == pytest.approx((1.2, 1.2))
    assert [kept.id for kept in match.kept] == list(one.room_ids) == [1, 2, 3]
    assert (match.new, match.gone) == ((4, 5), ())
    after = vdoor.edited(new, match.edits)
    for room in one.rooms:
        assert after.room_at((room.centre_m[0] + 1.2, room.centre_m[1] + 1.2)) == after.room(room.id)


def test_room_that_is_new_gets_an_id_of_its_own() -> None:
    small = OccupancyGrid.from_array(finished_maps.house(2, (1, 6, 4)), maps.CELL_M)
    large = OccupancyGrid.from_array(finished_maps.house(3, (1, 6, 4), (2, 6, 4)), maps.CELL_M)
    match = vdoor.match(finished_map(small), finished_map(large))
    assert [(kept.id, round(kept.same, 1)) for kept in match.kept] == [(1, 1.0), (2, 1.0)]
    assert (match.new, match.gone, match.taken) == ((3,), (), 3)
    back = vdoor.match(vdoor.edited(finished_map(large), match.edits), finished_map(small), taken=9)
    assert (back.new, back.gone, back.taken) == ((), (3,), 9)
    again = vdoor.match(finished_map(small), finished_map(large), taken=9)
    assert (again.new, again.taken) == ((10,), 10)


def test_split_and_merged_rooms_are_told() -> None:
    one = finished_map(OccupancyGrid.from_array(finished_maps.house(3, (1, 6, 4), (2, 6, 4)), maps.CELL_M))
    x_m, y_m = one.room(2).centre_m
    parted = vdoor.edited(one, [f"split {x_m + 0.5},{y_m} {x_m + 0.5},{y_m + 1}"])
    match = vdoor.match(one, parted)
    assert (dict(match.split), dict(match.merged), match.new) == ({2: (2, 4)}, {}, (4,))
    back = vdoor.match(vdoor.edited(parted, match.edits), one)
    assert (dict(back.split), dict(back.merged), back.gone) == ({}, {2: (2, 4)}, (4,))
    assert "room 2 was split into 2, 4" in list(match.lines())
    assert "room 2 was merged from 2, 4" in list(back.lines())
    assert json.loads(json.dumps(match.document()))["split"] == [{"room": 2, "into": [2, 4]}]


def test_maps_of_nothing_in_common_share_no_room() -> None:
    far = OccupancyGrid.from_array(finished_maps.house(1), maps.CELL_M, x_m=500.0)
    grid = OccupancyGrid.from_array(finished_maps.house(1)[:, :8], maps.CELL_M)
    alignment = aligned(finished_map(grid), finished_map(far))
    assert alignment.overlap > 0.3  # moved over each other: one room lies in the other
    none = vdoor.match(finished_map(grid), finished_map(far), alignment=type(alignment)((0.0, 0.0), 0.0))
    assert (none.kept, none.new, none.gone) == ((), (2,), (1,))


@pytest.mark.parametrize("fixed", [set(), {1}, {1, 4}])
def test_ids_that_the_user_gave_stand(fixed: set[int]) -> None:
    flat = finished_maps.topology("flat")
    match = vdoor.match(old(), flat, numbered=fixed, named={2} if fixed else ())
    after = vdoor.edited(flat, match.edits)
    assert len(set(after.room_ids)) == 5
    for room in fixed:
        assert after.room_at(flat.room(room).centre_m) == after.room(room)
    named = after.room_at(flat.room(2).centre_m)
    assert named is not None
    assert named.name == ("" if fixed else "Hall")


# Carried over from run to run


def test_edits_come_over_to_where_they_belong() -> None:
    lines = ("split 7.3,4.3 7.3,4.5", "merge 2.9,6.5 7.1,6.7", "name 2.9,6.5 Loft")
    flat = finished_maps.topology("flat")
    older = Older.of(vdoor.edited(flat, lines), {"edit": {"edits": list(lines), "taken": 12}})
    cells = np.pad(flat_cells(), ((1, 4), (7, 0)), constant_values=UNKNOWN)
    pipeline, match = carried_over(
        older, OccupancyGrid.from_array(cells, maps.CELL_M), vdoor.PRESETS["paper"], seed=0, edits_too=True
    )
    assert pipeline.edit.edits[:2] == ("split 8.7,5.1 8.7,5.3", "merge 4.3,7.3 8.5,7.5")
    assert [kept.id for kept in match.kept] == list(older.topology.room_ids)
    topology = vdoor.run(OccupancyGrid.from_array(cells, maps.CELL_M), pipeline)
    assert {room.id: room.name for room in topology.rooms} == {room.id: room.name for room in older.topology.rooms}
    assert pipeline.edit.taken == 12
    without, _ = carried_over(
        older, OccupancyGrid.from_array(cells, maps.CELL_M), vdoor.PRESETS["paper"], seed=0, edits_too=False
    )
    assert all(parse(line).kind in ("name", "number") for line in without.edit.edits)


def test_closed_doors_come_over() -> None:
    cells = finished_maps.house(3, (1, 6, 4))
    cells[2:7, 2:6] = cells[-5:-2, 45:] = OCCUPIED  # so that rooms can be told apart
    grid = OccupancyGrid.from_array(cells, maps.CELL_M)
    pipeline = vdoor.Pipeline(edit=vdoor.Pipeline().edit.__class__(edits=("closed-door 7.4,2",)))
    older = Older(vdoor.run(grid, pipeline), pipeline.edit.parsed)
    moved = OccupancyGrid.from_array(np.pad(grid.cells, 4, constant_values=UNKNOWN), maps.CELL_M)
    again, match = carried_over(older, moved, vdoor.PRESETS["paper"], seed=0, edits_too=True)
    assert again.edit.edits[0] == "closed-door 8.2,2.8"
    assert [kept.id for kept in match.kept] == [1, 2, 3]


def test_maps_of_robots_lie_where_their_own_frame_says(tmp_path: Path) -> None:
    new = vdoor.run(vdoor.read_map(vacuum.write_home(tmp_path / "home.json")))
    corner_cm = (vacuum.LEFT - 2) * vacuum.CELL_CM, (vacuum.TOP + 9 + 2) * vacuum.CELL_CM
    assert new.own_origin_cm == corner_cm
    older = dataclasses.replace(
        finished_maps.topology("flat"), own_origin_cm=(corner_cm[0] + 30.0, corner_cm[1] + 50.0)
    )
    assert known_shift_m(older, new) == pytest.approx((0.3, -0.5))
    assert known_shift_m(vdoor.edited(older, ["name 2.9,6.5 Kitchen"]), new) == known_shift_m(older, new)
    assert known_shift_m(older, finished_maps.topology("flat")) == (0.0, 0.0)


# The command


def shifted_flat(folder: Path) -> Path:
    """The flat's image with more cells on the left and below, in a frame of its own."""
    grey = np.asarray(Image.open(FLAT.with_suffix(".pgm")))
    Image.fromarray(np.pad(grey, ((3, 5), (8, 2)), constant_values=205)).save(folder / "moved.pgm")
    return folder / "moved.pgm"


@pytest.fixture
def older(tmp_path: Path, command: Command) -> Path:
    """A result of the flat with names and ids, and its recording beside it."""
    (tmp_path / "mine.toml").write_bytes(appended(tmp_path / "mine.toml", [parse(line) for line in lines()]))
    words = ("--preset", "paper", "--edits", tmp_path / "mine.toml", "--quiet")
    assert command("run", FLAT, *words, "--out", tmp_path / "old", "--mcap", tmp_path / "old.mcap").code == 0
    return tmp_path


def lines() -> list[str]:
    flat = finished_maps.topology("flat")
    places = {room: place_text(flat.room(room).centre_m) for room in flat.room_ids}
    return [
        line for room in places for line in (f"name {places[room]} {NAMES[room]}", f"number {places[room]} {IDS[room]}")
    ]


@pytest.mark.parametrize("source", ["old/map.json", "old", "old.mcap"])
def test_run_keeps_ids_and_names_on_record(source: str, older: Path, command: Command) -> None:
    words = ("run", shifted_flat(older), "--resolution", "0.2", "--preset", "paper", "--match", older / source)
    done = command(*words, "--out", older / "new", "--mcap", older / "new.mcap", "--json", "--unknown-value", "205")
    assert done.code == 0
    assert {room["id"]: room["name"] for room in done.json["rooms"]} == {IDS[room]: NAMES[room] for room in NAMES}
    assert done.json["match"]["shift_m"] == pytest.approx([1.6, 1.0])
    assert [kept["id"] for kept in done.json["match"]["kept"]] == sorted(IDS.values())
    assert "vdoor: the older map is shifted by 1.60,1.00 m; 100% of the rooms' area is in both maps\n" in done.err
    assert "vdoor: rooms kept: 1 Bath, 2 Bed, 7 Hall, 11 Kitchen, 30 Büro\n" in done.err
    assert json.loads((older / "new" / "map.json").read_text()) == done.json
    shutil.rmtree(older / "old")
    (older / "old.mcap").unlink()
    assert command("verify", older / "new.mcap").code == 0
    tables = [command("rooms", older / place).out for place in ("new", "new.mcap")]
    assert tables[0] == tables[1]
    assert "Kitchen" in tables[0]
    by_id = [
        [(room.id, room.name) for room in read_finished(older / place).topology.rooms] for place in ("new", "new.mcap")
    ]
    assert by_id[0] == by_id[1] == sorted((IDS[room], NAMES[room]) for room in NAMES)


def test_result_can_be_matched_with_itself_again_and_again(older: Path, command: Command) -> None:
    command("merge", older / "old", "1", "2")
    before = command("rooms", older / "old").out
    for _ in range(2):
        words = ("run", FLAT, "--preset", "paper", "--match", older / "old", "--out", older / "old", "--force")
        assert command(*words).code == 0
        assert command("rooms", older / "old").out == before


def test_edits_of_a_file_take_the_place_of_the_older_ones(older: Path, command: Command) -> None:
    (older / "new.toml").write_bytes(
        appended(older / "new.toml", [parse(f"name {place_text(old().room(7).centre_m)} Foyer")])
    )
    command("merge", older / "old", "1", "2")
    words = ("run", FLAT, "--preset", "paper", "--match", older / "old", "--edits", older / "new.toml", "--json")
    rooms = {room["id"]: room["name"] for room in command(*words).json["rooms"]}
    assert len(rooms) == 5
    assert rooms[7] == "Foyer"
    assert rooms[11] == "Kitchen"


@pytest.mark.parametrize(
    ("spoil", "says"),
    [
        (lambda folder: (folder / "rooms.png").unlink(), "found no rooms.png"),
        (lambda folder: (folder / "map.json").write_text("{}"), "schema"),
        (lambda folder: change(folder, settings={"edit": 3}), "edit: wanted a table of settings, found 3"),
        (lambda folder: change(folder, settings={"edit": {"edits": ["paint 1,1"]}}), "wanted one of name, number"),
        (lambda folder: change(folder, settings={"edit": {"taken": -1}}), "taken: wanted 0 to 65535, found -1"),
        (lambda folder: change(folder, settings={"edit": {"colour": 1}}), "no setting 'colour'"),
        (shutil.rmtree, "found none"),
    ],
)
def test_older_map_that_is_none_is_one_line_and_2(spoil: Any, says: str, older: Path) -> None:
    spoil(older / "old")
    done = call("run", FLAT, "--preset", "paper", "--match", older / "old", code=2)
    assert done.stdout == ""
    assert says in one_line(done)


def change(folder: Path, **keys: Any) -> None:
    table = json.loads((folder / "map.json").read_text())
    (folder / "map.json").write_text(json.dumps(table | keys))
