"""Virtual walls and no-go areas from the map's file, for the recording and the report."""

from __future__ import annotations

from collections.abc import Sequence

from vdoor.errors import MapError
from vdoor.formats import read_annotations
from vdoor.grid import Annotations, Line, OccupancyGrid
from vdoor.viz.rerun import style


def restrictions(grid: OccupancyGrid) -> list[tuple[str, style.Colour, Sequence[Line]]]:
    """Kinds of restrictions with colour and lines, x and y in metres, areas closed; empty if the file has none."""
    try:
        return restriction_lines(read_annotations(grid.source))
    except MapError:  # a recording can contain any files
        return []


def restriction_lines(found: Annotations | None) -> list[tuple[str, style.Colour, Sequence[Line]]]:
    """The same of annotations that are known."""
    if found is None:
        return []
    return [
        ("virtual wall", style.VIRTUAL_WALL, found.virtual_walls_m),
        ("no-go area", style.NO_GO, [(*area, area[0]) for area in found.no_go_areas_m]),
        ("no-mop area", style.NO_MOP, [(*area, area[0]) for area in found.no_mop_areas_m]),
    ]
