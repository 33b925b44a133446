"""Maps of robot vacuums served by Valetudo: JSON from ``GET /api/v2/robot/state/map``.

The grid is the bounding box of all known cells plus a margin, its lower left corner at (0, 0). `read_annotations` reads
the rest of the file, except the robot's path, obstacles and goals, which are ignored.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vdoor.formats.source import Request, agreed_resolution_m, check_size, checked_resolution_m
from vdoor.formats.valetudo_json import LAYERS, Home, Layer, home_of, is_valetudo, parse
from vdoor.grid import FREE, OCCUPIED, UNKNOWN, Annotations, Line, OccupancyGrid, Point, Segment

__all__ = ["is_valetudo", "read", "read_annotations", "segment_labels"]

MARGIN = 2
CM_PER_M = 100


@dataclass(frozen=True, kw_only=True)
class Crop:
    """The part of a map that becomes the grid."""

    left: int
    top: int
    height: int
    width: int

    def runs(self, layer: Layer) -> Iterator[tuple[int, slice]]:
        """The row and the columns of each run of a layer."""
        for x, y, count in (layer.runs - (self.left, self.top, 0)).tolist():
            yield y, slice(x, x + count)


def read(request: Request) -> OccupancyGrid:
    """The grid of a Valetudo map: floor and segments are free, walls are occupied, even where they overlap others."""
    name = request.name
    with request.naming(name):
        request.refuse_unknown_value("a Valetudo map")
        request.refuse_levels("a Valetudo map")
        home = parse(request.data(name))
        resolution_m = agreed_resolution_m(checked_resolution_m(home.cell_cm / CM_PER_M), request.resolution_m)
        cells = _cells(home, _crop(home, max_cells=request.max_cells))
    for at, layer in enumerate(home.layers):
        found = int(layer.runs[:, 2].sum())
        if layer.declared_cells not in (None, found):
            request.note(f"layers[{at}].dimensions: {layer.declared_cells} cells declared, {found} found", name)
    return OccupancyGrid.from_array(cells, resolution_m, source=request.source)


def read_annotations(request: Request) -> Annotations:
    """The annotations of a Valetudo map; raises the same errors as `read`."""
    with request.naming(request.name):
        home = parse(request.data(request.name))
        crop = _crop(home, max_cells=request.max_cells)
    segments = [layer for layer in home.layers if layer.kind == "segment"]
    lines = {kind: _lines(home, crop, kind) for kind in ("virtual_wall", "no_go_area", "no_mop_area")}
    return Annotations(
        robot_m=_place(home, crop, "robot_position"),
        charger_m=_place(home, crop, "charger_location"),
        virtual_walls_m=lines["virtual_wall"],
        no_go_areas_m=lines["no_go_area"],
        no_mop_areas_m=lines["no_mop_area"],
        segments=tuple(Segment(label=at, id=s.segment_id, name=s.name) for at, s in enumerate(segments, start=1)),
        labels=_labels(home, crop) if segments else None,
        own_origin_cm=_own_origin_cm(home, crop),
    )


def segment_labels(table: object, *, max_cells: int) -> NDArray[np.int32]:
    """The segments 1, 2, ... (h, w), in the file's order, of a map parsed as JSON; raises MapError if it is invalid."""
    home = home_of(table)
    return _labels(home, _crop(home, max_cells=max_cells))


def _crop(home: Home, *, max_cells: int) -> Crop:
    """The bounding box of all known cells plus the margin; raises MapError if it is too large."""
    runs = np.concatenate([layer.runs for layer in home.layers])
    left, top = (runs[:, :2].min(axis=0) - MARGIN).tolist()
    right, bottom = (runs[:, 0] + runs[:, 2]).max() + MARGIN, runs[:, 1].max() + 1 + MARGIN
    crop = Crop(left=left, top=top, height=int(bottom - top), width=int(right - left))
    check_size(crop.height, crop.width, max_cells=max_cells)
    check_size(1, int(runs[:, 2].sum()), max_cells=max_cells)  # any number of layers may overlap
    return crop


def _cells(home: Home, crop: Crop) -> NDArray[np.int8]:
    """The occupancy (h, w) int8."""
    cells = np.full((crop.height, crop.width), UNKNOWN, np.int8)
    for layer in sorted(home.layers, key=lambda layer: LAYERS.index(layer.kind)):
        for row, columns in crop.runs(layer):
            cells[row, columns] = OCCUPIED if layer.kind == "wall" else FREE
    return cells


def _labels(home: Home, crop: Crop) -> NDArray[np.int32]:
    """The segments 1, 2, ... (h, w), without wall cells."""
    labels = np.zeros((crop.height, crop.width), np.int32)
    label = 0
    for layer in sorted(home.layers, key=lambda layer: LAYERS.index(layer.kind)):
        label += layer.kind == "segment"
        for row, columns in crop.runs(layer) if layer.kind != "floor" else ():
            labels[row, columns] = label if layer.kind == "segment" else 0
    return labels


def _own_origin_cm(home: Home, crop: Crop) -> Point:
    """The lower left corner of the grid in the robot's own frame, in centimetres."""
    return crop.left * home.cell_cm, (crop.top + crop.height) * home.cell_cm


def _lines(home: Home, crop: Crop, kind: str) -> tuple[Line, ...]:
    """The points in the map frame of all entities of a kind, one line per entity."""
    left_cm, bottom_cm = _own_origin_cm(home, crop)
    return tuple(
        tuple(((x_cm - left_cm) / CM_PER_M, (bottom_cm - y_cm) / CM_PER_M) for x_cm, y_cm in entity.points_cm.tolist())
        for entity in home.entities
        if entity.kind == kind
    )


def _place(home: Home, crop: Crop, kind: str) -> Point | None:
    """The first point of the first entity of a kind; None if there is none."""
    return next((line[0] for line in _lines(home, crop, kind)), None)
