"""Maps divided into rooms: what is measured."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vdoor.errors import VdoorError
from vdoor.evaluate.door_places import Doors, contact_doors
from vdoor.evaluate.label_files import Labels, read_image, read_labels, read_table, rooms_of
from vdoor.formats import READERS, read_map
from vdoor.frame import Frame
from vdoor.grid import OccupancyGrid

IMAGES = (".pgm", ".png", ".bmp", ".tif", ".tiff")


@dataclass(frozen=True, kw_only=True, eq=False)
class Division:
    """A map divided into rooms."""

    name: str
    grid: OccupancyGrid
    free: NDArray[np.bool_]
    """Cells that are measured (h, w)."""
    rooms: Labels
    """Rooms 1, 2, ... (h, w), without those too small to count."""

    @property
    def frame(self) -> Frame:
        """Where the map lies."""
        return self.grid.frame

    def doors(self) -> Doors:
        """Contacts between the rooms on free cells."""
        return contact_doors(np.where(self.free, self.rooms, 0), self.free, self.frame.resolution_m)


@dataclass(frozen=True, kw_only=True)
class MapChoice:
    """Which map belongs to a label image, and how it is read."""

    path: Path | None = None
    """A map, or a folder that holds one of the wanted name."""
    resolution_m: float | None = None
    free_from: int | None = None
    """The grey from which on a cell of an image is free, instead of what its reader says."""

    def read(self, name: str) -> tuple[OccupancyGrid, NDArray[np.bool_]]:
        """The map of that name and its free cells (h, w)."""
        assert self.path is not None
        path = self.path if not self.path.is_dir() else _map_in(self.path, name)
        grid = read_map(path, resolution_m=self.resolution_m)
        if self.free_from is None:
            return grid, grid.free
        if path.suffix.lower() not in IMAGES:
            raise VdoorError(f"--free-from: wanted a map that is a plain image, found another: {path}")
        return grid, read_image(path).greys() >= self.free_from


def read_division(name: str, path: Path, map_choice: MapChoice) -> Division:
    """A result folder, or a label image with the map it belongs to.

    Raises `VdoorError` where a file is missing or damaged, or sizes or resolutions do not agree.
    """
    if is_result(path):
        labels = read_labels(path / "rooms.png")
        grid, free = _result_map(path, name, map_choice)
    elif map_choice.path is None:
        raise VdoorError(f"--map: wanted the map that a label image belongs to, found none: {path}")
    else:
        labels = read_labels(path)
        grid, free = map_choice.read(name)
    check_size("labels", labels, free, path)
    return Division(name=name, grid=grid, free=free, rooms=rooms_of(labels, grid.frame.resolution_m))


def is_result(path: Path) -> bool:
    """Whether it is the folder of a result."""
    return (path / "rooms.png").is_file()


def check_size(what: str, labels: NDArray[Any], free: NDArray[np.bool_], path: Path) -> None:
    """Raise `VdoorError` unless both have one size."""
    if labels.shape != free.shape:
        wanted, found = (f"{shape[1]} x {shape[0]} cells" for shape in (free.shape, labels.shape))
        raise VdoorError(f"{what}: wanted {wanted} as the map, found {found}: {path}")


def _result_map(folder: Path, name: str, choice: MapChoice) -> tuple[OccupancyGrid, NDArray[np.bool_]]:
    """The map that is part of a result, or the one that was chosen instead."""
    document = read_table(folder / "map.json")
    try:
        resolution_m, origin = float(document["resolution_m"]), document["origin"]
        place = {key: float(origin[key]) for key in ("x_m", "y_m", "yaw_rad")}
    except (KeyError, TypeError, ValueError) as error:
        raise VdoorError(f"result: wanted resolution_m and origin, found none: {folder / 'map.json'}") from error
    if choice.resolution_m is not None and not math.isclose(choice.resolution_m, resolution_m, rel_tol=1e-9):
        asked = f"{choice.resolution_m:g} m a cell as asked for"
        raise VdoorError(f"resolution: wanted {asked}, found {resolution_m:g} m: {folder / 'map.json'}")
    if choice.path is not None:
        return MapChoice(path=choice.path, resolution_m=resolution_m, free_from=choice.free_from).read(name)
    own = read_map(folder / "grid.png", resolution_m=resolution_m)
    grid = OccupancyGrid.from_array(own.cells, own.frame.resolution_m, source=own.source, **place)
    return grid, grid.free


def _map_in(folder: Path, name: str) -> Path:
    """The map of that name in a folder."""
    for suffix in (suffix for reader in READERS for suffix in reader.suffixes):
        path = folder / f"{name}{suffix}"
        if path.is_file():
            return path
    raise VdoorError(f"map: wanted one named {name}, found none: {folder}")
