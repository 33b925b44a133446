"""What the map shows as free but no room has, and why."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from vdoor.export.report.sheet import Layer, Sheet, colour_text
from vdoor.grid import OccupancyGrid
from vdoor.history.provenance import Provenance
from vdoor.history.records import RunRecords
from vdoor.method.simplify import REASONS, SimplifiedGrid
from vdoor.raster.runs import parts_of_mask
from vdoor.topology import TopologicalMap
from vdoor.viz.rerun import style

MOST_PLACES = 20
"""Maximum number of places in the list; the others are summed up."""
LEAST_M2 = 0.01
COLOUR: style.Colour = (208, 60, 140)
UNKNOWN_WHY = "free in the map, but in no room; the page of a recording says why"
NOT_REACHED = "free in the map, but no room reaches it"
WHY = {
    "unreachable": "the robot cannot get there",
    "notch": "a short dent in a wall, closed to make the wall straight",
    "slit": "too narrow for the robot",
}
TOO_SMALL = "the robot cannot get there, and it is smaller than the {least:g} m² of a room"
NO_ROOM = "the robot cannot get there, and it is too narrow or has too little wall around it to be a room"


class LeftOut(NamedTuple):
    """A list for the page, and the layer, if anything was left out."""

    places: list[dict[str, Any]]
    layer: list[Layer]


class Place(NamedTuple):
    """Connected cells that were left out for one reason."""

    cells: int
    middle: tuple[float, float]
    """Row, col of the cell nearest to their mean."""
    why: str


def left_out(sheet: Sheet, topology: TopologicalMap, provenance: Provenance | None) -> LeftOut:
    """Free cells of the input without a room: their places, the largest first, and a picture of them."""
    if provenance is None or not provenance.run.has(OccupancyGrid):
        return LeftOut([], [])
    grid = provenance.run.input
    lost = grid.free & (topology.labels == 0)
    area_m2 = grid.frame.resolution_m**2
    places = sorted(_places(lost, provenance, area_m2), key=lambda place: (-place.cells, place.middle))
    if not places:
        return LeftOut([], [])
    layer = Layer(
        "left-out",
        "Left out of the map",
        note=f"{np.count_nonzero(lost) * area_m2:.1f} m² that are free, but in no room",
    )
    layer.picture = sheet.picture(lost.astype(np.uint8), {1: COLOUR}, grid.frame)
    layer.key = [(colour_text(COLOUR), "free, but in no room")]
    rows = [
        {
            "area_m2": round(place.cells * area_m2, 3),
            "at": sheet.points(np.array([place.middle]), grid.frame)[0].round(3).tolist(),
            "place_m": grid.frame.world_from_cell(np.array([place.middle]))[0].round(3).tolist(),
            "why": place.why,
        }
        for place in places[:MOST_PLACES]
    ]
    return LeftOut(rows + _rest(places[MOST_PLACES:], area_m2), [layer])


def _rest(places: list[Place], area_m2: float) -> list[dict[str, Any]]:
    if not places:
        return []
    cells = sum(place.cells for place in places)
    return [{"area_m2": round(cells * area_m2, 3), "at": None, "place_m": None, "why": f"{len(places)} smaller places"}]


def _places(lost: NDArray[np.bool_], provenance: Provenance, area_m2: float) -> Iterator[Place]:
    """The connected places of one reason each, but for single cells and the like."""
    codes = _reasons(provenance.run, lost)
    least_m2 = _least_part_m2(provenance)
    for code in np.unique(codes[lost]).tolist():
        found = parts_of_mask(lost & (codes == code), 2)
        cells, boxes = found.cells(found.most), found.boxes(found.most)
        word = "" if code < 0 else REASONS[code]
        for number in np.flatnonzero(cells * area_m2 >= LEAST_M2).tolist():
            size = int(cells[number])
            top, left, bottom, right = boxes[number].tolist()
            box = slice(top, bottom), slice(left, right)
            middle = _middle(found.inside(box).image() == number + 1, box)
            yield Place(size, middle, _why(word, size * area_m2, least_m2))


def _reasons(run: RunRecords, lost: NDArray[np.bool_]) -> NDArray[np.int16]:
    """The reason of each cell (h, w) as an index into `REASONS`; -1 if it was not recorded."""
    if not run.has(SimplifiedGrid):
        return np.full(lost.shape, -1, np.int16)
    rows, cols = (np.arange(side) // run.simplified.factor for side in lost.shape)
    return run.simplified.reason[np.ix_(rows, cols)].astype(np.int16)


def _middle(own: NDArray[np.bool_], box: tuple[slice, ...]) -> tuple[float, float]:
    cells = np.argwhere(own)
    nearest = cells[np.argmin(((cells - cells.mean(axis=0)) ** 2).sum(axis=1))]
    return float(nearest[0] + box[0].start), float(nearest[1] + box[1].start)


def _why(word: str, area_m2: float, least_m2: float) -> str:
    if not word:
        return UNKNOWN_WHY
    if word == "unreachable" and least_m2:
        return TOO_SMALL.format(least=least_m2) if area_m2 < least_m2 else NO_ROOM
    return WHY.get(word, NOT_REACHED)


def _least_part_m2(provenance: Provenance) -> float:
    """The least area of a room that the robot cannot reach; 0 if there are no such rooms."""
    table = provenance.settings.get("simplify")
    value = table.get("least_part_m2", 0.0) if isinstance(table, dict) else 0.0
    return float(value) if isinstance(value, (int, float)) else 0.0
