"""Edits of rooms and doors: their language and file, and what they do to a map."""

from __future__ import annotations

from pathlib import Path

import finished_maps
import maps
import numpy as np
import pytest
from edited_flat import at, flat, outcome
from hypothesis import given
from hypothesis import strategies as st
from skimage.measure import label

import vdoor
from vdoor.editing.apply import EditRooms
from vdoor.editing.edits import FORMS, Edit, appended, parse, read_edits
from vdoor.editing.places import place_text
from vdoor.editing.split_room import line_cells, within
from vdoor.errors import SettingError
from vdoor.grid import OCCUPIED, OccupancyGrid
from vdoor.method.final_doors import to_segment_m
from vdoor.raster.components import contacts
from vdoor.record import equal
from vdoor.topology import TopologicalMap

WORDS = st.text(st.characters(categories=("L", "N", "P", "S")), min_size=1, max_size=12)
PLACES = st.tuples(*[st.integers(-9_999_999, 9_999_999).map(lambda value: value / 1000)] * 2)


@st.composite
def any_edit(draw: st.DrawFn) -> Edit:
    kind = draw(st.sampled_from(sorted(FORMS)))
    places = tuple(draw(PLACES) for _ in FORMS[kind].places)
    name = " ".join(draw(st.lists(WORDS, min_size=1, max_size=3))) if kind == "name" else ""
    return Edit(kind, places, name, draw(st.integers(1, 65_535)) if kind == "number" else 0)


# The language and the file


@given(any_edit())
@maps.law
def test_edit_is_the_same_as_a_line(edit: Edit) -> None:
    assert parse(str(edit)) == edit


@given(st.lists(any_edit(), min_size=1, max_size=5))
@maps.law
def test_edit_is_the_same_in_a_file_that_grows(tmp_path_factory: pytest.TempPathFactory, edits: list[Edit]) -> None:
    path = tmp_path_factory.mktemp("edits") / "edits.toml"
    path.write_bytes(appended(path, edits[:1]))
    mine = path.read_text(encoding="utf-8") + "# mine, without a line's end"
    path.write_text(mine, encoding="utf-8")
    path.write_bytes(appended(path, edits[1:]))
    assert read_edits(path) == edits
    assert path.read_text(encoding="utf-8").startswith(mine + "\n")


@pytest.mark.parametrize(
    ("line", "says"),
    [
        ("", "one of name, number"),
        ("paint 1,2 red", "one of name, number"),
        ("name 1,2", "name X,Y NAME"),
        ("name 1;2 Kitchen", "X,Y"),
        ("name 1,2 " + "x" * 101, "100 characters"),
        ("name 1,2 a\x07b", "one line"),
        ("name 1,2 a\u2028b", "one line"),
        ("number 1,2 0", "1 to 65535"),
        ("number 1,2 65536", "1 to 65535"),
        ("number 1,2 two", "1 to 65535"),
        ("merge 1,2", "merge X,Y X,Y"),
        ("split 1,2 3,4 5,6", "split X,Y X,Y"),
        ("closed-door nan,1", "finite"),
        ("remove-door 1e10,1", "finite"),
    ],
)
def test_line_that_is_no_edit_is_refused(line: str, says: str) -> None:
    with pytest.raises(SettingError, match=says):
        parse(line)
    with pytest.raises(SettingError, match=r"edit\.edits: .*" + says):
        EditRooms(edits=(line,))


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("[[edit]]\ndo = 'paint'", "edit 1: wanted do = one of"),
        ("[[edit]]\ndo = 'name'\nat = [1, 2]", "edit 1: wanted the keys do, at, name, found do, at"),
        ("[[edit]]\ndo = 'merge'\nat = [1, 2]\nwith = [1, 2]\nid = 3", "edit 1: wanted the keys"),
        ("[[edit]]\ndo = 'remove-door'\nat = [1, 2]\n[[edit]]\ndo = 'split'\nfrom = [1]\nto = [1, 2]", "edit 2: from"),
        ("[[edit]]\ndo = 'number'\nat = [1, 2]\nid = '3'", "id: wanted a whole number, found '3'"),
        ("[[edit]]\ndo = 'number'\nat = [1, 2]\nid = true", "id: wanted a whole number, found True"),
        ("[[edit]]\ndo = 'name'\nat = [1, inf]\nname = 'a'", "edit 1: at: wanted finite"),
        ("edit = 3", "nothing else, found edit = 3"),
        ("[door]\nx = 1", "nothing else, found 'door'"),
        ("do =", "wanted TOML"),
        ("[[edit]]\ndo = 'number'\nat = [1, 2]\nid = " + "9" * 5000, "wanted TOML"),
        ("a = " + "[" * 5000, "wanted TOML"),
    ],
)
def test_file_that_holds_no_edits_is_refused(tmp_path: Path, text: str, says: str) -> None:
    path = tmp_path / "edits.toml"
    path.write_text(text)
    with pytest.raises(SettingError) as refused:
        read_edits(path)
    assert says in str(refused.value)
    assert str(refused.value).endswith(str(path))
    assert "\n" not in str(refused.value)


# What each edit does


def test_without_edits_nothing_is_made_anew() -> None:
    assert EditRooms()(flat()) == (flat(), None)


def test_name_is_the_rooms_until_it_is_renamed() -> None:
    after, verdicts, rooms = outcome(flat(), f"name {at(3)} Bad", f"name {at(4)} Küche", f"name {at(3)} Bath room")
    assert [room.name for room in after.rooms] == ["", "", "Bath room", "Küche", ""]
    assert after.room_named("Küche") == after.room(4)
    assert after.room(4).title == "Küche"
    assert after.room(5).title == "room 5"
    assert (verdicts, rooms) == (["done"] * 3, [[3], [4], [3]])
    assert (after.labels == flat().labels).all()


def test_number_moves_all_that_belongs_to_the_room() -> None:
    before = flat()
    after, verdicts, _ = outcome(before, f"number {at(3)} 40", f"name {at(3)} Bath")
    assert after.room_ids == (1, 2, 4, 5, 40)
    assert verdicts == ["done", "done"]
    for old, new in zip((1, 2, 4, 5, 3), after.room_ids, strict=True):
        was, now = before.room(old), after.room(new)
        assert (was.area_m2, was.centre_m, was.polygon_m, was.corners) == (
            now.area_m2, now.centre_m, now.polygon_m, now.corners,
        )  # fmt: skip
        assert ((before.labels == old) == (after.labels == new)).all()
    assert after.room(2).neighbours == (1, 40)
    assert [door.rooms for door in after.doors] == [(1, 2), (2, 40), (5, 40), (4, 5)]
    assert after.room(40).name == "Bath"
    graph = after.to_networkx()
    assert {(*sorted((one, other)), key) for one, other, key in graph.edges(keys=True)} == {
        (1, 2, 1), (2, 40, 2), (5, 40, 3), (4, 5, 4),
    }  # fmt: skip


def test_rooms_trade_ids() -> None:
    after, _, _ = outcome(flat(), f"number {at(1)} 5")
    assert ((flat().labels == 1) == (after.labels == 5)).all()
    assert ((flat().labels == 5) == (after.labels == 1)).all()
    again, verdicts, _ = outcome(after, f"number {at(1)} 5")
    assert verdicts == ["not needed"]
    assert equal(again, after)


def test_merged_rooms_are_one() -> None:
    before = flat()
    after, verdicts, rooms = outcome(before, f"name {at(2)} Hall", f"merge {at(2)} {at(1)}")
    assert after.room_ids == (2, 3, 4, 5)
    assert (after.labels[before.labels == 1] == 2).all()
    assert after.room(2).area_m2 == pytest.approx(before.room(1).area_m2 + before.room(2).area_m2)
    assert after.room(2).name == "Hall"
    assert [door.rooms for door in after.doors] == [(2, 3), (3, 5), (4, 5)]
    assert (verdicts, rooms) == (["done", "done"], [[2], [2]])


def test_rooms_that_do_not_touch_stay_two() -> None:
    after, verdicts, _ = outcome(flat(), f"merge {at(1)} {at(4)}")
    assert verdicts == ["rooms do not touch"]
    assert equal(after, flat())


def test_two_doors_between_the_same_rooms_go_together() -> None:
    before = finished_maps.topology("pillars")
    assert [door.rooms for door in before.doors] == [(1, 2), (2, 3), (1, 2)]
    middle = np.mean([before.doors[2].start_m, before.doors[2].end_m], axis=0)
    after, verdicts, rooms = outcome(before, f"remove-door {place_text(tuple(middle))}")
    assert (verdicts, len(rooms[0])) == (["done"], 1)
    assert [len(set(door.rooms) & set(rooms[0])) for door in after.doors] == [1]
    assert len(after.rooms) == 2


def test_split_goes_from_wall_to_wall() -> None:
    grid = OccupancyGrid.from_array(finished_maps.house(1), maps.CELL_M)
    topology = vdoor.run(grid, "paper")
    after, verdicts, rooms = outcome(
        topology, "split 1.51,1 1.51,1.2"
    )  # a stroke; cells of col 7 are cut, and go to the larger part
    assert (verdicts, rooms) == (["done"], [[1, 2]])
    free = 16 * maps.CELL_M
    assert after.area_m2.tolist() == pytest.approx([11 * maps.CELL_M * free, 5 * maps.CELL_M * free])
    assert set(np.unique(after.labels[2:-2, 2:7])) == {2}
    assert set(np.unique(after.labels[2:-2, 7:-2])) == {1}
    (door,) = after.doors
    assert (door.kind, door.rooms, door.width_m) == ("added", (1, 2), pytest.approx(free))
    assert after.room(1).neighbours == (2,)
    corners = {room.id: {corner.point_m for corner in room.corners} for room in after.rooms}
    assert corners[1] | corners[2] == {corner.point_m for corner in topology.room(1).corners}
    assert all(x_m > 1.5 for x_m, _ in corners[1])
    assert all(x_m < 1.5 for x_m, _ in corners[2])
    assert all(corners.values())


def test_split_goes_on_behind_furniture_and_is_done_once() -> None:
    cells = finished_maps.house(1)
    cells[8:10, 8:10] = OCCUPIED
    topology = vdoor.run(OccupancyGrid.from_array(cells, maps.CELL_M), "paper")
    line = "split 1.7,3.1 1.7,3.3"
    after, verdicts, rooms = outcome(topology, line, line)
    assert (verdicts, rooms) == (["done", "parts nothing"], [[1, 2], [1]])
    assert np.count_nonzero(after.labels == 2) == 6 * 16
    wide = cells.copy()
    wide[8:11, 7:10] = OCCUPIED  # more than half a metre
    topology = vdoor.run(OccupancyGrid.from_array(wide, maps.CELL_M), "paper")
    assert outcome(topology, line)[1] == ["parts nothing"]
    assert outcome(topology, "split 1.7,0.5 1.7,3.3")[1] == ["done"]


def test_split_gives_doors_to_the_parts_they_lead_to() -> None:
    before = flat()
    x_m, y_m = before.room(3).centre_m
    after, _, rooms = outcome(before, f"split {x_m},{y_m} {x_m},{y_m + 0.2}")
    assert rooms == [[3, 6]]
    assert after.room(3).area_m2 >= after.room(6).area_m2
    assert sorted(neighbour for room in (3, 6) for neighbour in after.room(room).neighbours if neighbour < 3) == [2, 2]
    assert after.room(4) == before.room(4)


def test_line_as_long_as_can_be_costs_no_more_than_the_map() -> None:
    after, verdicts, rooms = outcome(flat(), "split 2.9,-900000000 2.9,900000000")
    assert (verdicts, len(rooms[0])) == (["done"], 2)
    assert len(after.rooms) == 6


def test_two_doors_of_a_room_that_is_split_go_to_the_parts_they_lead_to() -> None:
    before = finished_maps.topology("pillars")
    one, other = before.doors[0], before.doors[2]
    middles_m = [np.mean([door.start_m, door.end_m], axis=0) for door in (one, other)]
    between, inwards = np.mean(middles_m, axis=0), np.array(before.room(1).centre_m) - np.mean(middles_m, axis=0)
    line = f"split {place_text(tuple(between + 0.3 * inwards))} {place_text(tuple(between + 0.9 * inwards))}"
    after, verdicts, _ = outcome(before, line)
    assert verdicts == ["done"]
    ends = {(door.start_m, door.end_m): door.rooms for door in after.doors if door.kind != "added"}
    rooms = [ends[door.start_m, door.end_m] for door in (one, other)]
    assert sorted(rooms) == [(1, 2), (2, 4)]


def test_line_that_parts_nothing_changes_nothing() -> None:
    before = flat()
    x_m, y_m = before.room(1).centre_m
    for line in (f"add-door {x_m},{y_m} {x_m},{y_m + 0.2}", f"split {x_m - 20},{y_m} {x_m - 19},{y_m}"):
        after, verdicts, _ = outcome(before, line)
        assert verdicts[0] in ("parts nothing", "no room there")
        assert equal(after, before)


def test_added_door_can_be_removed() -> None:
    before = flat()
    x_m, y_m = before.room(4).centre_m
    line = f"add-door {x_m},{y_m - 1.3} {x_m},{y_m + 1.3}"
    after, verdicts, _ = outcome(before, line, f"remove-door {x_m},{y_m}")
    assert verdicts == ["done", "done"]
    assert (after.labels == before.labels).all()
    assert sorted(door.rooms for door in after.doors) == sorted(door.rooms for door in before.doors)


def test_room_made_after_another_is_gone_is_not_taken_for_it() -> None:
    lines = ("split 7.3,4.3 7.3,4.5", f"name {at(3)} Hall", "merge 7,4.3 7.6,4.3", "split 2.9,1.5 2.9,4.3")
    after, verdicts, rooms = outcome(flat(), *lines)
    assert verdicts == ["done"] * 4
    assert after.room_ids == (1, 2, 3, 4, 5, 6)
    assert rooms == [[3], [3], [3], [4, 6]]


def test_places_just_outside_a_room_are_its_own() -> None:
    before = flat()
    row, col = np.argwhere(before.labels == 1)[0]
    wall_m = before.frame.world_from_cell(np.array([[row - 2, col]]))[0]
    far_m = before.frame.world_from_cell(np.array([[row - 4, col]]))[0]
    _, verdicts, rooms = outcome(before, *(f"name {place_text(tuple(point))} A" for point in (wall_m, far_m)))
    assert (verdicts, rooms) == (["done", "no room there"], [[1], []])


@pytest.mark.parametrize("place", ["900,900", "-5,3", "900000000,1"])
@pytest.mark.parametrize("kind", sorted(FORMS))
def test_edit_far_away_is_a_verdict(kind: str, place: str) -> None:
    line = " ".join([kind, *[place] * len(FORMS[kind].places), *{"name": ["A"], "number": ["9"]}.get(kind, [])])
    after, verdicts, rooms = outcome(flat(), line)
    assert verdicts[0] in {"no room there", "no door there", "no wall there"}
    assert rooms == [[]]
    assert equal(after, flat())


@st.composite
def edited_maps(draw: st.DrawFn) -> tuple[TopologicalMap, list[str]]:
    """A map, and edits at places of it, most of them in rooms."""
    topology = finished_maps.topology(draw(st.sampled_from(finished_maps.NAMES)))
    cells = np.argwhere(topology.labels)

    def place() -> str:
        cell = cells[draw(st.integers(0, len(cells) - 1))] + draw(st.sampled_from([0.0, 0.3, 4.0]))
        return place_text(tuple(topology.frame.world_from_cell(cell[None])[0].tolist()))

    lines = []
    for _ in range(draw(st.integers(1, 5))):
        kind = draw(st.sampled_from(sorted(set(FORMS) - {"closed-door"})))
        word = {"name": "A", "number": str(draw(st.integers(1, 9)))}.get(kind, "")
        lines.append(" ".join([kind, *(place() for _ in FORMS[kind].places), word]).strip())
    return topology, lines


@given(edited_maps())
@maps.law
def test_edited_maps_hold_together(case: tuple[TopologicalMap, list[str]]) -> None:
    before, lines = case
    after, verdicts, _ = outcome(before, *lines)
    assert ((after.labels > 0) == (before.labels > 0)).all()
    assert len(set(after.room_ids)) == len(after.rooms) == len(after.area_m2)
    place, pair = contacts(after.labels)
    touching = set(map(tuple, pair.tolist()))
    assert {door.rooms for door in after.doors} == touching
    place_m = after.frame.world_from_cell(place)
    for both in touching:
        own = place_m[(pair == both).all(axis=1)]
        ends = [(door.start_m, door.end_m) for door in after.doors if door.rooms == both]
        apart = np.array([to_segment_m(own, *map(np.array, end)) for end in ends])
        assert (apart.min(axis=0) <= maps.CELL_M + 1e-9).all()
        assert (apart.min(axis=1) <= maps.CELL_M + 1e-9).all()
    for room in after.rooms:
        own = after.labels == room.id
        assert room.area_m2 == pytest.approx(np.count_nonzero(own) * after.frame.resolution_m**2)
        assert after.room_at(room.centre_m) == room
        assert label(own, connectivity=1).max() == 1
    assert len(verdicts) == len(lines)


def crossed(topology: TopologicalMap, edit: Edit) -> int:
    """How many rooms a line lies in."""
    cells = line_cells(*topology.frame.cell_from_world(np.array(edit.places_m)))
    return len(set(topology.labels[tuple(cells[within(cells, topology.labels.shape)].T)].tolist()) - {0})


@given(edited_maps())
@maps.law
def test_edits_done_twice_are_done_once(case: tuple[TopologicalMap, list[str]]) -> None:
    before, lines = case[0], case[1][:1]
    edit = parse(lines[0])
    if edit.kind == "remove-door" or (edit.kind in ("split", "add-door") and crossed(before, edit) > 1):
        return  # there may be another door near, or another room that the line lies in
    once = vdoor.edited(before, lines)
    twice, (first, second), _ = outcome(before, *lines, *lines)
    assert equal(once, twice)
    assert second != "done"
    assert first != "not needed" or second == "not needed"


def test_edit_says_no_more_than_it_knows() -> None:
    with pytest.raises(SettingError, match="one of 1, 2, 3, 4, 5, found 6"):
        flat().room(6)
    with pytest.raises(SettingError, match="4 doors, found 5"):
        flat().door(5)
    with pytest.raises(SettingError, match="names are none"):
        flat().room_named("Kitchen")
    assert flat().room_at((-100.0, 0.0)) is None
    assert [door.id for door in flat().doors_of(2)] == [1, 2]
