"""Rooms that the user chose."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np

from vdoor.errors import SettingError, VdoorError
from vdoor.topology import TopologicalMap


def check_rooms(topology: TopologicalMap, rooms: Sequence[int]) -> None:
    """Raise `SettingError` for the first of `rooms` that the map does not have."""
    known = {room.id for room in topology.rooms}
    for room in rooms:
        if room not in known:
            raise SettingError(f"--room: wanted one of the map's {len(known)} rooms, found {room}")


def refuse_not_finite(topology: TopologicalMap) -> None:
    """VdoorError naming the first part of a map that has a number which is not finite, as damaged recordings have."""
    columns = {field.name: getattr(topology, field.name) for field in dataclasses.fields(topology)}
    pose = {f"frame.{name}": np.array(value, np.float64) for name, value in vars(topology.frame).items()}
    for name, values in (columns | pose).items():
        if isinstance(values, np.ndarray) and values.dtype == np.float64 and not np.isfinite(values).all():
            raise VdoorError(f"map: wanted finite numbers, found {values[~np.isfinite(values)].item(0)} in {name}")
