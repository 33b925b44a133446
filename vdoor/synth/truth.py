"""A map and the truth about it: its rooms as far as they are in reach, the doors that join them; and their files."""

from __future__ import annotations

import dataclasses
import io
import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import scipy
import yaml
from numpy.typing import NDArray
from PIL import Image

from vdoor.files import make_folder
from vdoor.frame import Frame
from vdoor.grid import UNKNOWN, OccupancyGrid
from vdoor.partial import write_whole
from vdoor.synth.canvas import Cells, Placed, Rooms
from vdoor.synth.layout import Gap, Opened
from vdoor.synth.settings import Apartment, Dwelling, Office

GREY_OCCUPIED, GREY_UNKNOWN, GREY_FREE = 0, 205, 254
OCCUPIED_THRESH, FREE_THRESH = 0.65, 0.196
SCHEMA = 1
MARGIN = 2
"""Unknown cells around what is known."""
LEAST_M2 = 0.25
"""A room of which less is in reach is part of its neighbour."""


@dataclass(frozen=True)
class TrueDoor:
    """A real door: from jamb to jamb in the middle of its wall, in metres of the map frame."""

    start_m: tuple[float, float]
    end_m: tuple[float, float]
    width_m: float
    rooms: tuple[int, int]
    """Labels of the two rooms, the lower one first."""
    unsure: bool = False
    """An opening of which a person could not say whether it parts two rooms: found or not, it counts for nobody."""


@dataclass(frozen=True, eq=False)
class SyntheticMap:
    """A map and the truth about it."""

    grid: OccupancyGrid
    rooms: Rooms
    """Room of each free cell (h, w), from 1; 0 where not free, free but out of reach of the rooms, or within a wall."""
    doors: tuple[TrueDoor, ...]
    settings: Apartment | Dwelling | Office


def with_truth(cells: Cells, placed: Placed, opened: Sequence[Opened], settings: Dwelling | Office) -> SyntheticMap:
    """Return the map cut to what is known, rooms numbered anew from 1, and doors where two of them touch."""
    rooms = in_reach(placed.rooms, placed.rooms > 0)
    doors = [door for door in opened if _touch(rooms, door, placed)]
    rooms, doors = _joined_where_tiny(rooms, doors, placed.cell_m)
    known = [np.flatnonzero((cells != UNKNOWN).any(axis=axis)) for axis in (1, 0)]
    top, bottom, left, right = known[0][0], known[0][-1], known[1][0], known[1][-1]
    crop = np.s_[top : bottom + 1, left : right + 1]
    cut_cells = np.pad(cells[crop], MARGIN, constant_values=UNKNOWN)
    numbers, flat = np.unique(np.pad(rooms[crop], MARGIN), return_inverse=True)
    numbered = flat.reshape(cut_cells.shape).astype(np.int32) + (numbers[0] != 0)
    shift = np.array([MARGIN - top, MARGIN - left])
    grid = OccupancyGrid.from_array(cut_cells, placed.cell_m)
    label = {number: k + int(numbers[0] != 0) for k, number in enumerate(numbers.tolist())}
    ends_m = [grid.frame.world_from_cell(placed.cells_from_plan(door.gap.ends) + shift) for door in doors]
    found = [
        true_door(door.gap, ends, [label[room] for room in door.rooms])
        for door, ends in zip(doors, ends_m, strict=True)
    ]
    return SyntheticMap(grid, numbered, tuple(found), settings)


def in_reach(rooms: Rooms, free: NDArray[np.bool_]) -> Rooms:
    """Return the rooms without what is not 4-connected to most of them over free cells."""
    part, _ = scipy.ndimage.label(free)
    main = np.bincount(part[rooms > 0], minlength=1).argmax()
    return np.where(part == main, rooms, 0).astype(np.int32)


def _touch(rooms: Rooms, door: Opened, placed: Placed) -> bool:
    """Whether the two rooms touch in or near the gap."""
    rect = door.gap.clear(0.1, 0.1)
    corners = np.array([rect.low, rect.high, (rect.low[0], rect.high[1]), (rect.high[0], rect.low[1])])
    cells = np.rint(placed.cells_from_plan(corners)).astype(int)
    low, high = np.maximum(cells.min(axis=0), 0), cells.max(axis=0) + 1
    near = rooms[low[0] : high[0], low[1] : high[1]]
    a, b = door.rooms
    sides = (near[1:], near[:-1]), (near[:, 1:], near[:, :-1])
    return any(bool((((p == a) & (q == b)) | ((p == b) & (q == a))).any()) for p, q in sides)


def _joined_where_tiny(rooms: Rooms, doors: list[Opened], cell_m: float) -> tuple[Rooms, list[Opened]]:
    """Return rooms of which next to nothing is in reach as part of a neighbour, without the doors in between."""
    area = np.bincount(rooms.ravel()) * cell_m**2
    name = np.arange(area.size)
    for door in doors:
        a, b = name[list(door.rooms)]
        if a != b and min(area[a], area[b]) < LEAST_M2:
            small, large = (a, b) if area[a] < area[b] else (b, a)
            area[large] += area[small]
            name[name == small] = large
    pairs = [(door.gap, (int(name[door.rooms[0]]), int(name[door.rooms[1]]))) for door in doors]
    return name[rooms].astype(np.int32), [Opened(gap, (a, b)) for gap, (a, b) in pairs if a != b]


def true_door(gap: Gap, ends_m: NDArray[np.float64], rooms: Sequence[int]) -> TrueDoor:
    """Return a gap of the plan as a door from end to end (2, 2) in the map frame, between rooms of these labels."""
    start, end = np.round(ends_m, 6).tolist()
    a, b = sorted(rooms)
    return TrueDoor(tuple(start), tuple(end), round(gap.width_m, 6), (a, b), unsure=gap.unsure)


def write_synthetic(made: SyntheticMap, path_stem: Path, *, seed: int | None = None) -> tuple[Path, ...]:
    """Write STEM.pgm, STEM.yaml, STEM_truth.png (16 bit, 0 = no room) and STEM_truth.json; return their paths.

    The folder is made if it is missing. Each file appears under its name only when it is whole. `seed` is noted in
    the JSON. Raises `VdoorError` if the place cannot be written to.
    """
    contents = {
        f"{path_stem.name}.pgm": _pgm(made),
        f"{path_stem.name}_truth.png": _png(made),
        f"{path_stem.name}_truth.json": (json.dumps(_truth(made, seed=seed), indent=1) + "\n").encode(),
        f"{path_stem.name}.yaml": _yaml(made, f"{path_stem.name}.pgm"),
    }
    make_folder(path_stem.parent)
    return tuple(write_whole(path_stem.with_name(name), content) for name, content in contents.items())


def _truth(made: SyntheticMap, *, seed: int | None = None) -> dict[str, Any]:
    """Return the truth for the JSON: rooms with areas, doors in metres and in cells (row, col), settings, seed."""
    frame = made.grid.frame
    numbers, counts = np.unique(made.rooms[made.rooms > 0], return_counts=True)
    return {
        "schema": SCHEMA,
        "resolution_m": frame.resolution_m,
        "size": {"height": frame.height, "width": frame.width},
        "origin": [frame.x_m, frame.y_m, frame.yaw_rad],
        "seed": seed,
        "settings": dataclasses.asdict(made.settings),
        "rooms": [
            {"id": number, "area_m2": round(count * frame.resolution_m**2, 6)}
            for number, count in zip(numbers.tolist(), counts.tolist(), strict=True)
        ],
        "doors": [_door(door, frame) for door in made.doors],
    }


def _door(door: TrueDoor, frame: Frame) -> dict[str, Any]:
    """Return a door's fields, and its ends in cells; `unsure` is there only where it is true."""
    start, end = frame.cell_from_world(np.array([door.start_m, door.end_m])).round(6).tolist()
    fields = {name: value for name, value in dataclasses.asdict(door).items() if name != "unsure" or value}
    return fields | {"start_cell": start, "end_cell": end}


def _pgm(made: SyntheticMap) -> bytes:
    """Return the map as a binary PGM in map_server's three greys."""
    grid = made.grid
    grey = np.where(grid.occupied, GREY_OCCUPIED, np.where(grid.free, GREY_FREE, GREY_UNKNOWN)).astype(np.uint8)
    return f"P5\n{grey.shape[1]} {grey.shape[0]}\n255\n".encode() + grey.tobytes()


def _png(made: SyntheticMap) -> bytes:
    """Return the labels as a PNG of 16 bits."""
    buffer = io.BytesIO()
    Image.fromarray(made.rooms.astype(np.uint16)).save(buffer, format="png")
    return buffer.getvalue()


def _yaml(made: SyntheticMap, image: str) -> bytes:
    """Return the description that map_server reads beside the image."""
    frame = made.grid.frame
    return yaml.safe_dump(
        {
            "image": image,
            "mode": "trinary",
            "resolution": frame.resolution_m,
            "origin": [frame.x_m, frame.y_m, frame.yaw_rad],
            "negate": 0,
            "occupied_thresh": OCCUPIED_THRESH,
            "free_thresh": FREE_THRESH,
        },
        sort_keys=False,
        default_flow_style=None,
    ).encode()
