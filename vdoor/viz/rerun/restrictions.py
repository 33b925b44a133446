"""Where the robot must not go, as the map's file says: drawn in the recording and in the report."""

from __future__ import annotations

from collections.abc import Sequence

from vdoor.errors import MapError
from vdoor.formats import read_annotations
from vdoor.grid import Line, OccupancyGrid
from vdoor.viz.rerun import style


def restrictions(grid: OccupancyGrid) -> list[tuple[str, style.Colour, Sequence[Line]]]:
    """Kinds of restrictions with their colour and lines, x and y in metres, areas closed; none where none are known."""
    try:
        said = read_annotations(grid.source)
    except MapError:  # the files of a recording can be any
        said = None
    if said is None:
        return []
    return [
        ("virtual wall", style.VIRTUAL_WALL, said.virtual_walls_m),
        ("no-go area", style.NO_GO, [(*area, area[0]) for area in said.no_go_areas_m]),
        ("no-mop area", style.NO_MOP, [(*area, area[0]) for area in said.no_mop_areas_m]),
    ]
