"""Maps divided into rooms, the subject of the evaluation."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vdoor.errors import VdoorError
from vdoor.evaluate.door_places import Doors, contact_doors
from vdoor.evaluate.label_files import Labels, read_image, read_labels, read_table, rooms_of
from vdoor.evaluate.result_files import own_file
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
    """The free cells (h, w); measures use these only."""
    rooms: Labels
    """Rooms 1, 2, ... (h, w), without rooms that are too small to count."""

    @property
    def frame(self) -> Frame:
        """The map's frame."""
        return self.grid.frame

    def doors(self) -> Doors:
        """The doors where rooms touch on free cells."""
        return contact_doors(np.where(self.free, self.rooms, 0), self.free, self.frame.resolution_m)


@dataclass(frozen=True, kw_only=True)
class MapChoice:
    """Which map belongs to a label image, and how it is read."""

    path: Path | None = None
    """A map, or a folder with a map of the right name."""
    resolution_m: float | None = None
    free_from: int | None = None
    """The lowest grey value of an image's free cells; None = the thresholds of its reader."""

    def read(self, name: str) -> tuple[OccupancyGrid, NDArray[np.bool_]]:
        """The map with that name, and its free cells (h, w)."""
        assert self.path is not None
        path = self.path if not self.path.is_dir() else _map_in(self.path, name)
        grid = read_map(path, resolution_m=self.resolution_m)
        if self.free_from is None:
            return grid, grid.free
        if path.suffix.lower() not in IMAGES:
            raise VdoorError(f"--free-from: wanted a map that is a plain image, found another: {path}")
        return grid, read_image(path).greys() >= self.free_from


def read_division(name: str, path: Path, map_choice: MapChoice) -> Division:
    """The division in a result folder, or in a label image and the map it belongs to.

    Raises `VdoorError` if a file is missing or damaged, or if sizes or resolutions differ.
    """
    if is_result(path):
        document = read_table(path / "map.json")
        labels = read_labels(own_file(path, "rooms.png", document))
        grid, free = _result_map(path, document, name, map_choice)
    elif map_choice.path is None:
        raise VdoorError(f"--map: wanted the map that a label image belongs to, found none: {path}")
    else:
        labels = read_labels(path)
        grid, free = map_choice.read(name)
    check_size("labels", labels, free, path)
    return Division(name=name, grid=grid, free=free, rooms=rooms_of(labels, grid.frame.resolution_m))


def is_result(path: Path) -> bool:
    """Whether the path is a result folder."""
    return (path / "rooms.png").is_file()


def check_size(what: str, labels: NDArray[Any], free: NDArray[np.bool_], path: Path) -> None:
    """Raise `VdoorError` unless the labels have the map's size."""
    if labels.shape != free.shape:
        wanted, found = (f"{shape[1]} x {shape[0]} cells" for shape in (free.shape, labels.shape))
        raise VdoorError(f"{what}: wanted {wanted} like the map, found {found}: {path}")


def _result_map(
    folder: Path, document: Mapping[str, Any], name: str, choice: MapChoice
) -> tuple[OccupancyGrid, NDArray[np.bool_]]:
    """The map in a result folder, or the one chosen instead; and its free cells (h, w)."""
    try:
        resolution_m, origin = float(document["resolution_m"]), document["origin"]
        place = {key: float(origin[key]) for key in ("x_m", "y_m", "yaw_rad")}
    except (KeyError, TypeError, ValueError) as error:
        raise VdoorError(f"result: wanted resolution_m and origin, found none: {folder / 'map.json'}") from error
    if choice.resolution_m is not None and not math.isclose(choice.resolution_m, resolution_m, rel_tol=1e-9):
        requested = f"{choice.resolution_m:g} m per cell as requested"
        raise VdoorError(f"resolution: wanted {requested}, found {resolution_m:g} m: {folder / 'map.json'}")
    if choice.path is not None:
        return MapChoice(path=choice.path, resolution_m=resolution_m, free_from=choice.free_from).read(name)
    own = read_map(own_file(folder, "grid.png", document), resolution_m=resolution_m)
    grid = OccupancyGrid.from_array(own.cells, own.frame.resolution_m, source=own.source, **place)
    return grid, grid.free


def _map_in(folder: Path, name: str) -> Path:
    """The path of the map with that name in a folder; raises `VdoorError` if there is none."""
    for suffix in (suffix for reader in READERS for suffix in reader.suffixes):
        path = folder / f"{name}{suffix}"
        if path.is_file():
            return path
    raise VdoorError(f"map: wanted one named {name}, found none: {folder}")
