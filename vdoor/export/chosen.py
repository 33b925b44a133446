"""Rooms that the user chose."""

from __future__ import annotations

from collections.abc import Sequence

from vdoor.errors import SettingError
from vdoor.topology import TopologicalMap


def check_rooms(topology: TopologicalMap, rooms: Sequence[int]) -> None:
    """Raise `SettingError` for the first of `rooms` that the map does not have."""
    known = {room.id for room in topology.rooms}
    for room in rooms:
        if room not in known:
            raise SettingError(f"--room: wanted one of the map's {len(known)} rooms, found {room}")
