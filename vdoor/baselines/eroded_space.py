"""The second baseline after [8]: rooms are the parts of the eroded free space, grown back."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated, ClassVar

import numpy as np
import skimage
from numpy.typing import NDArray

from vdoor.baselines.plain import map_of_labels
from vdoor.baselines.skeleton import clearance_m
from vdoor.config import Within
from vdoor.editing.apply import EditRooms, Edits
from vdoor.emit import Emit, silent
from vdoor.frame import Frame
from vdoor.grid import FREE, OccupancyGrid
from vdoor.method.simplify import SimplifiedGrid, SimplifyGrid
from vdoor.navigate.cover_floor import CoverFloor
from vdoor.navigate.find_route import FindRoute
from vdoor.navigate.tasks import WithTasks, done, records_of
from vdoor.raster.labels import at_input, flooded, numbered, whole
from vdoor.raster.polygons import centres
from vdoor.raster.runs import runs_of
from vdoor.record import Record, Spec
from vdoor.topology import TopologicalMap

EPSILON = 1e-9


class ErodedSpace(Record):
    """The free space for a robot much larger than the real one: the cores of rooms."""

    topic: ClassVar[str] = "eroded"

    core: Annotated[NDArray[np.int32], Spec("labels", "height width")]
    """4-connected components, numbered from 1."""
    centre: Annotated[NDArray[np.int32], Spec("cell", "part 2")]
    area_m2: Annotated[NDArray[np.float64], Spec("column", "part", unit="m2", tolerance=1e-9)]
    kept: Annotated[NDArray[np.bool_], Spec("column", "part")]
    """Whether the component is large enough to be the core of a room."""
    frame: Frame


class GrownRooms(Record):
    """The kept cores, grown back until they meet."""

    topic: ClassVar[str] = "grown"

    room: Annotated[NDArray[np.int32], Spec("labels", "height width")]
    frame: Frame


@dataclass(frozen=True, kw_only=True)
class ErodeSpace:
    """Erode the free space, and keep the components that are large enough."""

    radius_m: Annotated[float, Within(0, 20)] = 0.75
    """Cells up to this far from the centre of a cell that is not free are removed."""
    least_m2: Annotated[float, Within(0, 1e6)] = 0.5
    """Components of at least this area are cores of rooms."""

    def __call__(self, simplified: SimplifiedGrid) -> ErodedSpace:
        """The components in reading order."""
        eroded = clearance_m(simplified) > self.radius_m + EPSILON
        core, count = skimage.measure.label(eroded, connectivity=1, return_num=True)
        core = core.astype(np.int32)
        runs = runs_of(core)
        area_m2 = runs.cells(count).astype(np.float64) * simplified.frame.resolution_m**2
        return ErodedSpace(
            core=core,
            centre=centres(runs, count),
            area_m2=area_m2,
            kept=area_m2 >= self.least_m2 - EPSILON,
            frame=simplified.frame,
        )


@dataclass(frozen=True, kw_only=True)
class GrowRooms:
    """Grow the cores back over the free space, by a watershed of the distance to walls."""

    def __call__(self, simplified: SimplifiedGrid, eroded: ErodedSpace) -> GrownRooms:
        """A room for each kept core, meeting the others at narrow places; a single room if no core was kept."""
        free = simplified.cells == FREE
        number = np.append(0, np.cumsum(eroded.kept) * eroded.kept)
        seeds = number[eroded.core] if eroded.kept.any() else free
        room = skimage.segmentation.watershed(
            -clearance_m(simplified), seeds.astype(np.int32), mask=free, connectivity=1
        )
        return GrownRooms(room=np.asarray(room, np.int32), frame=simplified.frame)


@dataclass(frozen=True, kw_only=True)
class LabelRooms:
    """Transfer the rooms to the input's resolution, with a door wherever two of them touch."""

    def __call__(self, grid: OccupancyGrid, simplified: SimplifiedGrid, grown: GrownRooms) -> TopologicalMap:
        """Rooms in reading order; doors are as wide as the contact of their rooms, and none is an edge of a search."""
        labels = flooded(whole(at_input(grown.room, simplified.factor, grid.free)), grid.free)
        labels, _ = numbered(labels, int(grown.room.max(initial=0)))
        return map_of_labels(labels, grid)


@dataclass(frozen=True, kw_only=True)
class ErodedSpacePipeline(WithTasks):
    """The baseline that erodes the free space and grows the remaining components back to rooms."""

    simplify: SimplifyGrid = field(default_factory=SimplifyGrid)
    erode: ErodeSpace = field(default_factory=ErodeSpace)
    grow: GrowRooms = field(default_factory=GrowRooms)
    label: LabelRooms = field(default_factory=LabelRooms)
    edit: EditRooms = field(default_factory=EditRooms)
    route: FindRoute = field(default_factory=FindRoute)
    cover: CoverFloor = field(default_factory=CoverFloor)

    @property
    def records(self) -> tuple[type[Record], ...]:
        """The records that a run emits, in order."""
        edits = [Edits] if self.edit.edits else []
        return OccupancyGrid, SimplifiedGrid, ErodedSpace, GrownRooms, *edits, TopologicalMap, *records_of(self.tasks)

    def __call__(self, grid: OccupancyGrid, rng: np.random.Generator, emit: Emit = silent) -> TopologicalMap:
        """Rooms and doors of `grid`; `emit` is called with every stage's record. `rng` is not used."""
        del rng
        opened = self.edit.open_doors(emit(grid))
        simplified = emit(self.simplify(opened.grid))
        eroded = emit(self.erode(simplified))
        grown = emit(self.grow(simplified, eroded))
        topology, edits = self.edit(self.label(opened.grid, simplified, grown), opened)
        if edits is not None:
            emit(edits)
        return done(self.tasks, grid, emit(topology), emit)
