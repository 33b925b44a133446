"""What other planners and robots take of a coverage: fields and lanes for opennav_coverage, zones for Valetudo."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import yaml

from vdoor.export.geometry import to_mm
from vdoor.export.valetudo import clean
from vdoor.navigate.cover_floor import Coverage
from vdoor.navigate.coverage.path import KINDS
from vdoor.rounding import rounded
from vdoor.topology import Polygon, TopologicalMap

FRAME = "map"
LANE = KINDS.index("lane")


def to_fields(coverage: Coverage, topology: TopologicalMap) -> str:
    """Goals of opennav_coverage's ComputeCoveragePath, a YAML document for each part of a room, in the path's order.

    The outline of the part comes first, then what it does not contain, in metres of the map frame.
    """
    parts = [part for room in rooms_in_order(coverage, topology) for part in topology.room(room).parts_m]
    return yaml.safe_dump_all(map(_field, parts), sort_keys=False, default_flow_style=None)


def _field(polygon_m: Polygon) -> dict[str, Any]:
    polygons = [{"coordinates": [{"axis1": x_m, "axis2": y_m} for x_m, y_m in map(to_mm, ring)]} for ring in polygon_m]
    return {"use_gml_file": False, "polygons": polygons, "frame_id": FRAME}


def to_lanes(coverage: Coverage, topology: TopologicalMap) -> str:
    """The path as opennav_coverage's PathComponents: the lanes in order, and the way from each to the next."""
    del topology
    ends = np.flatnonzero(coverage.purpose == LANE)
    ends = ends[ends > 0]
    points = [[*to_mm(point_m), 0.0] for point_m in coverage.point_m]
    swaths = [{"start": _named(points[end - 1]), "end": _named(points[end])} for end in ends.tolist()]
    ways = zip(ends[:-1].tolist(), ends[1:].tolist(), strict=True)
    turns = [_way(coverage, first, last) for first, last in ways]
    components = {
        "header": {"frame_id": FRAME},
        "swaths": swaths,
        "turns": turns,
        "contains_turns": True,
        "swaths_ordered": True,
    }
    return yaml.safe_dump(components, sort_keys=False, default_flow_style=None)


def _named(point: list[float]) -> dict[str, float]:
    return dict(zip("xyz", point, strict=True))


def _way(coverage: Coverage, first: int, last: int) -> dict[str, Any]:
    """A nav_msgs/Path from the point that ends a lane to the one before the end of the next."""
    poses = []
    for point_m, yaw_rad in zip(coverage.point_m[first:last], coverage.yaw_rad[first:last].tolist(), strict=True):
        turned = rounded({"x": 0.0, "y": 0.0, "z": math.sin(yaw_rad / 2), "w": math.cos(yaw_rad / 2)})
        pose = {"position": _named([*to_mm(point_m), 0.0]), "orientation": turned}
        poses.append({"header": {"frame_id": FRAME}, "pose": pose})
    return {"header": {"frame_id": FRAME}, "poses": poses}


def to_zones(coverage: Coverage, topology: TopologicalMap) -> str:
    """Valetudo's requests for cleaning zones, a JSON body a line: rectangles that cover each room, in order."""
    requests = clean(topology, rooms_in_order(coverage, topology), None)
    return "".join(f"{request.text}\n" for request in requests)


def rooms_in_order(coverage: Coverage, topology: TopologicalMap) -> list[int]:
    """The ids of the rooms that are swept, each once, in the order of the path.

    If the map is swept as one, by id, those of which most is: a path also meets floor of rooms that it only crosses.
    """
    rooms = dict.fromkeys(coverage.visit_room.tolist())
    if 0 in rooms:
        cells = np.bincount(topology.labels.ravel())
        swept = np.bincount(topology.labels[coverage.swept > 0], minlength=len(cells))
        return [room for room in np.flatnonzero(2 * swept > cells).tolist() if room and room not in coverage.missed]
    return list(rooms)


COVERAGE_WRITERS: dict[str, Callable[[Coverage, TopologicalMap], str]] = {
    "fields": to_fields,
    "lanes": to_lanes,
    "zones": to_zones,
}
"""Formats of coverages beside those of paths, by name."""
