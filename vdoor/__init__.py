"""Rooms and doors from occupancy grid maps, with every stage recorded.

>>> import vdoor
>>> topology = vdoor.run(vdoor.read_map("recordings/flat.yaml"))
>>> len(topology.rooms), len(topology.doors)
(5, 4)
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from vdoor.lazy import on_first_use

if TYPE_CHECKING:
    from vdoor.api import run
    from vdoor.editing import edited
    from vdoor.errors import MapError, MapWarning, RecordingError, SettingError, VdoorError
    from vdoor.formats import read_map
    from vdoor.grid import OccupancyGrid
    from vdoor.matching import Match, match
    from vdoor.pipeline import PRESETS, Pipeline
    from vdoor.topology import Door, Room, TopologicalMap

__version__ = "0.1.0"
__all__ = [
    "PRESETS",
    "Door",
    "MapError",
    "MapWarning",
    "Match",
    "OccupancyGrid",
    "Pipeline",
    "RecordingError",
    "Room",
    "SettingError",
    "TopologicalMap",
    "VdoorError",
    "edited",
    "match",
    "read_map",
    "run",
]

__getattr__ = on_first_use(
    __name__,
    {
        "errors": ("MapError", "MapWarning", "RecordingError", "SettingError", "VdoorError"),
        "formats": ("read_map",),
        "grid": ("OccupancyGrid",),
        "matching": ("Match", "match"),
        "api": ("run",),
        "editing": ("edited",),
        "pipeline": ("PRESETS", "Pipeline"),
        "topology": ("Door", "Room", "TopologicalMap"),
    },
)
