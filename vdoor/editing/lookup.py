"""A room or a door of a finished map by what people call it: an id, a name or a place.

>>> import vdoor
>>> topology = vdoor.run(vdoor.read_map("recordings/flat.yaml"))
>>> find_room(topology, "2.9,6.5").room.id, find_door(topology, "2").door.id
(1, 2)
"""

from __future__ import annotations

import difflib
import re
from typing import NamedTuple

import numpy as np

from vdoor.editing.places import Point, parse_place
from vdoor.errors import SettingError
from vdoor.method.final_doors import to_segment_m
from vdoor.topology import Door, Room, TopologicalMap

ID = re.compile("[0-9]{1,9}")
"""Pattern of room and door ids; no id is longer."""
REACH_M = 0.5
"""A place this close to a door means that door."""


class FoundRoom(NamedTuple):
    """A room, and the place it was found by: the given one, or the room's centre."""

    room: Room
    place_m: Point


class FoundDoor(NamedTuple):
    """A door, and the place it was found by: the given one, or the door's middle."""

    door: Door
    place_m: Point


def find_room(topology: TopologicalMap, word: str, *, what: str = "room") -> FoundRoom:
    """The room with that id, else the one with that name, else the one at X,Y in the map frame.

    Raises `SettingError`, which begins with `what`, unless the word means exactly one room.
    """
    if ID.fullmatch(word) and int(word) in topology.room_ids:
        room = topology.room(int(word))
    elif word and word in topology.name:
        room = _named(topology, word, what)
    elif "," in word:
        return _room_at(topology, word, what)
    else:
        raise SettingError(f"{what}: {_unknown_room(topology, word)}")
    return FoundRoom(room, room.centre_m)


def find_door(topology: TopologicalMap, word: str, *, what: str = "door") -> FoundDoor:
    """The door with that id, or the one nearest to X,Y in the map frame, within `REACH_M`.

    Raises `SettingError`, which begins with `what`, if there is none.
    """
    if ID.fullmatch(word):
        if not 1 <= int(word) <= len(topology.doors):
            raise SettingError(f"{what}: wanted one of the map's {len(topology.doors)} doors, found {word}")
        door = topology.door(int(word))
        return FoundDoor(door, middle_m(door))
    place_m = parse_place(word, what=what, wanted="a door's id or X,Y")
    apart_m = [to_segment_m(np.array([place_m]), start, end)[0] for start, end in _ends_m(topology)]
    if not apart_m or min(apart_m) > REACH_M:
        raise SettingError(f"{what}: no door there, wanted one at most {REACH_M:g} m from {word}")
    return FoundDoor(topology.door(int(np.argmin(apart_m)) + 1), place_m)


def middle_m(door: Door) -> Point:
    """The middle of a door."""
    return (door.start_m[0] + door.end_m[0]) / 2, (door.start_m[1] + door.end_m[1]) / 2


def _ends_m(topology: TopologicalMap) -> zip[tuple[np.ndarray[tuple[int], np.dtype[np.float64]], ...]]:
    return zip(topology.start_m, topology.end_m, strict=True)


def _named(topology: TopologicalMap, name: str, what: str) -> Room:
    if topology.name.count(name) > 1:
        ids = (str(room) for room, own in zip(topology.room_ids, topology.name, strict=True) if own == name)
        raise SettingError(f"{what}: wanted one room, found {name!r} as the name of rooms {', '.join(ids)}")
    return topology.room_named(name)


def _room_at(topology: TopologicalMap, word: str, what: str) -> FoundRoom:
    place_m = parse_place(word, what=what, wanted="a room's id, its name or X,Y")
    room = topology.room_at(place_m)
    if room is None:
        raise SettingError(f"{what}: wanted a point in a room, found none at {word}")
    return FoundRoom(room, place_m)


def _unknown_room(topology: TopologicalMap, word: str) -> str:
    """What was wanted, for a word that is no room's id and no room's name."""
    if ID.fullmatch(word):
        return f"wanted one of {', '.join(map(str, topology.room_ids))}, found {word}"
    names = {name.casefold(): name for name in topology.name if name}
    close = difflib.get_close_matches(word.casefold(), names, n=1)
    hint = f"; did you mean {names[close[0]]!r}?" if close else ""
    return f"wanted a room's id, its name or X,Y, found {word!r}{hint}"
