"""Rooms and doors by id, name or place, wherever one is taken."""

from __future__ import annotations

from pathlib import Path

import commands
import finished_maps
import pytest

import vdoor
from vdoor.editing.lookup import find_door, find_room, middle_m
from vdoor.errors import SettingError


def test_every_room_and_door_is_found_by_each_of_its_words() -> None:
    flat = finished_maps.topology("flat")
    names = [f"name {room.centre_m[0]},{room.centre_m[1]} Room {room.id}th" for room in flat.rooms]
    named = vdoor.edited(flat, names)
    for room in named.rooms:
        place = "{},{}".format(*room.centre_m)
        found = {find_room(named, word).room.id for word in (str(room.id), room.name, place)}
        assert found == {room.id}
    for door in flat.doors:
        place = "{},{}".format(*middle_m(door))
        assert {find_door(flat, word).door.id for word in (str(door.id), place)} == {door.id}


@pytest.mark.parametrize(
    ("word", "says"),
    [
        ("77", "--room: wanted one of 1, 2, 3, 4, 5, found 77"),
        ("Kichen", "--room: wanted a room's id, its name or X,Y, found 'Kichen'; did you mean 'Kitchen'?"),
        ("hALL", "--room: wanted a room's id, its name or X,Y, found 'hALL'; did you mean 'Hall'?"),
        ("-9,-9", "--room: wanted a point in a room, found none at -9,-9"),
        ("Hall", "--room: wanted one room, found 'Hall' as the name of rooms 2, 3"),
        ("", "--room: wanted a room's id, its name or X,Y, found ''"),
    ],
)
def test_a_word_for_no_room_or_for_two_is_refused(word: str, says: str) -> None:
    flat = finished_maps.topology("flat")
    lines = zip(flat.rooms, ("Kitchen", "Hall", "Hall"), strict=False)
    named = vdoor.edited(flat, [f"name {room.centre_m[0]},{room.centre_m[1]} {name}" for room, name in lines])
    with pytest.raises(SettingError) as error:
        find_room(named, word, what="--room")
    assert str(error.value) == says


def test_a_place_far_from_every_door_is_refused() -> None:
    with pytest.raises(SettingError, match=r"^door: no door there, wanted one at most 0.5 m from -9,-9$"):
        find_door(finished_maps.topology("flat"), "-9,-9")


def test_an_export_takes_a_room_by_name_and_by_place(tmp_path: Path, command: commands.Command) -> None:
    result = finished_maps.result("flat", tmp_path / "r")
    assert command("rename", result, "4", "Kitchen").code == 0
    x_m, y_m = finished_maps.topology("flat").room(4).centre_m
    words = ("4", "Kitchen", f"{x_m},{y_m}")
    walls = [command("export", result, "--to", "virtual-walls", "--room", word) for word in words]
    assert [(done.code, done.out) for done in walls] == [(0, walls[0].out)] * 3
    refused = command("export", result, "--to", "virtual-walls", "--room", "Kitchn")
    assert (refused.code, "did you mean 'Kitchen'?" in refused.err, str(result) in refused.err) == (2, True, True)
