"""Files of a synthetic map: the map as ROS map_server reads it, and the truth beside it."""

from __future__ import annotations

import dataclasses
import io
import json
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from PIL import Image

from vdoor.files import make_folder, write_whole
from vdoor.frame import Frame
from vdoor.synth.truth import SyntheticMap, TrueDoor

GREY_OCCUPIED, GREY_UNKNOWN, GREY_FREE = 0, 205, 254
OCCUPIED_THRESH, FREE_THRESH = 0.65, 0.196
SCHEMA = 1


def write_synthetic(made: SyntheticMap, path_stem: Path, *, seed: int | None = None) -> tuple[Path, ...]:
    """Write STEM.pgm, STEM.yaml, STEM_truth.png (16 bit, 0 = no room) and STEM_truth.json; return their paths.

    The folder is made if it is missing. Each file appears under its name only when it is whole. `seed` is noted in
    the JSON. Raises `VdoorError` if the place cannot be written to.
    """
    contents = {
        f"{path_stem.name}.pgm": _pgm(made),
        f"{path_stem.name}_truth.png": _png(made),
        f"{path_stem.name}_truth.json": (json.dumps(truth(made, seed=seed), indent=1) + "\n").encode(),
        f"{path_stem.name}.yaml": _yaml(made, f"{path_stem.name}.pgm"),
    }
    make_folder(path_stem.parent)
    return tuple(write_whole(path_stem.with_name(name), content) for name, content in contents.items())


def truth(made: SyntheticMap, *, seed: int | None = None) -> dict[str, Any]:
    """Return what the truth's JSON says: rooms with areas, doors in metres and in cells (row, col), settings, seed."""
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
