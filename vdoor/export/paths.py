"""Paths as files for robots and map programs: Nav2 waypoints, GeoJSON, CSV."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import yaml
from numpy.typing import NDArray

from vdoor.errors import SettingError
from vdoor.export.geojson import collection_text, feature
from vdoor.export.geometry import to_mm
from vdoor.partial import write_whole
from vdoor.rounding import rounded

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class DrivenPath:
    """A path to drive, in the map frame."""

    point_m: Floats
    """Points x, y (k, 2) in metres, straight between them."""
    yaw_rad: Floats
    """The heading (k,) at each point."""
    properties: Mapping[str, object] = field(default_factory=dict)
    """What a map program shows of the path, such as its length."""


def to_csv(path: DrivenPath) -> str:
    """Lines x, y, yaw in metres and radians, below a line with these names."""
    rows = np.column_stack([path.point_m, path.yaw_rad]).tolist()
    return "".join(["x_m,y_m,yaw_rad\n", *(f"{x_m:.3f},{y_m:.3f},{yaw_rad:.4f}\n" for x_m, y_m, yaw_rad in rows)])


def to_path_geojson(path: DrivenPath) -> str:
    """A feature collection with one LineString in metres of the map frame; of one point, a line of no length."""
    points = [*map(to_mm, path.point_m)]
    line = points if len(points) > 1 else points * 2
    return collection_text("vdoor path", [feature("LineString", line, {"type": "path", **rounded(path.properties)})])


def to_waypoints(path: DrivenPath) -> str:
    """Waypoints as the Nav2 panel of RViz saves and loads them: pose x, y, z and orientation w, x, y, z."""
    waypoints = {
        f"waypoint{number}": {
            "pose": [*to_mm(point_m), 0.0],
            "orientation": rounded([math.cos(yaw_rad / 2), 0.0, 0.0, math.sin(yaw_rad / 2)]),
        }
        for number, (point_m, yaw_rad) in enumerate(zip(path.point_m, path.yaw_rad.tolist(), strict=True))
    }
    return yaml.safe_dump({"waypoints": waypoints}, sort_keys=False, default_flow_style=None)


PATH_WRITERS: dict[str, Callable[[DrivenPath], str]] = {
    "csv": to_csv,
    "geojson": to_path_geojson,
    "waypoints": to_waypoints,
}
"""Formats of paths, by name."""


@dataclass(frozen=True)
class PathExport:
    """One requested file of a path."""

    name: str
    path: Path

    @classmethod
    def parse(cls, text: str, names: Iterable[str]) -> PathExport:
        """The export of FORMAT=FILE with one of the formats `names`; `SettingError` for any other text."""
        name, equals, path = text.partition("=")
        if not equals or not path or name not in names:
            raise SettingError(f"--export: wanted FORMAT=FILE with {', '.join(names)}, found {text!r}")
        return cls(name, Path(path))

    def write(self, text: str) -> Path:
        """Write the file, whole or not at all; `VdoorError` if it cannot be written."""
        return write_whole(self.path, text.encode())
