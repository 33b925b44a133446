"""Maps of robot vacuums for tests: drawn as text, written as Valetudo does."""

from __future__ import annotations

import itertools
import json
import textwrap
from pathlib import Path
from typing import Any

LEFT, TOP, CELL_CM = 600, 540, 5
KINDS = {"#": "wall", ".": "floor"}

FLAT = """
    ????####################
    ????#aaaaaa#bbbbbbbbbbb#
    ????#aaaaaa#bbbbbbbbbbb#
    ????#aaaaaaabbbbbbbbbbb#
    ????#aaaaaaabbbbbbbbbbb#
    ????#aaaaaaabbbbbbbbbbb#
    #####aaaaaa#bbbbbbbbbbb#
    #....aaaaaa#bbbbbbbbbbb#
    ########################
"""
"""Two segments with a doorway, and floor that belongs to none."""


def rows_of(text: str) -> list[str]:
    return textwrap.dedent(text).split()


def home(text: str = FLAT, *, version: int = 2, **entities: list[float]) -> dict[str, Any]:
    """A Valetudo map: ``#`` wall, ``.`` floor, a letter for each segment, ``?`` unknown; entities in centimetres."""
    signs = sorted(set("".join(rows_of(text))) - {"?"})
    return {
        "__class": "ValetudoMap",
        "metaData": {"version": version},
        "size": {"x": 6554, "y": 6554},
        "pixelSize": CELL_CM,
        "layers": [layer(rows_of(text), sign, version) for sign in signs],
        "entities": [
            {"__class": "Entity", "type": kind, "points": points, "metaData": {}} for kind, points in entities.items()
        ],
    }


def layer(rows: list[str], sign: str, version: int) -> dict[str, Any]:
    """All cells of one sign, as runs or, in version 1, as pairs."""
    runs = []
    for y, row in enumerate(rows):
        x = 0
        for one, same in itertools.groupby(row):
            count = len([*same])
            runs += [[LEFT + x, TOP + y, count]] if one == sign else []
            x += count
    pairs = [value for x, y, count in runs for at in range(count) for value in (x + at, y)]
    named = {"segmentId": str(ord(sign)), "name": "Flur "} if sign.isalpha() else {}
    cells: dict[str, Any] = (
        {"pixels": pairs} if version == 1 else {"pixels": [], "compressedPixels": [*itertools.chain(*runs)]}
    )
    return {"type": KINDS.get(sign, "segment"), "metaData": named, **cells}


def centre_cm(row: int, col: int) -> list[float]:
    """Middle of a cell of the drawing, as entities have it."""
    return [(LEFT + col + 0.5) * CELL_CM, (TOP + row + 0.5) * CELL_CM]


def write_home(path: Path, table: dict[str, Any] | None = None) -> Path:
    path.write_text(json.dumps(home() if table is None else table))
    return path
