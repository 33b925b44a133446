"""Paths that the page drives along by a slider: a route by metres, a covering path by seconds."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vdoor.export.report.sheet import Sheet
from vdoor.history.provenance import Provenance
from vdoor.navigate.cover_floor import Coverage
from vdoor.navigate.find_route import Route

Floats = NDArray[np.float64]


def drives(sheet: Sheet, provenance: Provenance | None) -> Iterator[dict[str, Any]]:
    """The recorded route, if there is a way, and the recorded covering path."""
    if provenance is None:
        return
    records = provenance.run.records
    route, coverage = records.get(Route.topic), records.get(Coverage.topic)
    if isinstance(route, Route) and route.found:
        yield _drive(sheet, route, "m", route.along_m, radius_m=route.radius_m)
    if isinstance(coverage, Coverage) and len(coverage.point_m):
        yield _drive(sheet, coverage, "s", coverage.at_s, radius_m=coverage.radius_m) | _sweeping(coverage)


def _drive(sheet: Sheet, path: Route | Coverage, unit: str, at: Floats, *, radius_m: float) -> dict[str, Any]:
    """A path with what the slider counts at each point, and how far the point is along the path."""
    return {
        "layer": path.topic,
        "unit": unit,
        "points": sheet.world_points(path.point_m).round(3).tolist(),
        "at": at.round(3).tolist(),
        "along_m": path.along_m.round(3).tolist(),
        "radius_m": radius_m,
    }


def _sweeping(coverage: Coverage) -> dict[str, Any]:
    """The tool's width, the share of the swept cells that are swept up to each point, and the room of each point."""
    last = len(coverage.point_m) - 1
    rows = np.clip(coverage.swept[coverage.swept > 0], 0, last)  # damaged records may hold anything
    swept = np.bincount(rows, minlength=last + 1).cumsum()
    rooms = coverage.visit_room[coverage.visit] if len(coverage.visit_room) else np.zeros(last + 1, np.int32)
    return {
        "tool_m": coverage.tool_m,
        "swept": (swept / max(int(swept[-1]), 1)).round(4).tolist(),
        "rooms": rooms.tolist(),
    }
