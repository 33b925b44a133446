"""From grey to occupancy, like Nav2's map_server (its main branch, the vectorised `map_io`).

Unlike older Nav2 and ROS 1, which compare strictly and in double precision, and average alpha in as a colour.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from vdoor.formats.source import GREYS, Request
from vdoor.grid import FREE, OCCUPIED, UNKNOWN

Mode = Literal["trinary", "scale", "raw"]
USUAL_UNKNOWN = 205
"""The grey value that map savers write for unknown cells."""
SAVED_FREE = 254
"""The grey value that they write for free cells."""
SAVED, SAVED_SHARE = (0, USUAL_UNKNOWN, SAVED_FREE), 0.9
"""The greys of saved maps, and the smallest share of cells with one of them for a map to count as saved."""


@dataclass(frozen=True, kw_only=True)
class GreyImage:
    """A decoded image, row 0 = top."""

    samples: NDArray[np.uint8] | NDArray[np.uint16]
    """Grey values as stored in the file (h, w)."""
    maxval: int = 255
    """The sample value of white."""
    opaque: NDArray[np.bool_] | None = None
    """Whether alpha is full (h, w); None = everywhere."""

    def greys(self) -> NDArray[np.uint8]:
        """Grey values (h, w) from 0 black to 255 white, rounded down: 16-bit samples are divided by 257."""
        if self.maxval == GREYS - 1:
            return self.samples.astype(np.uint8, copy=False)
        samples = np.minimum(self.samples, self.maxval).astype(np.uint32)
        return (samples * (GREYS - 1) // self.maxval).astype(np.uint8)

    def raw(self) -> NDArray[np.uint8]:
        """Occupancy in per cent (h, w) for raw mode: the samples as stored, 16-bit ones reduced to 8 bits."""
        return self.samples.astype(np.uint8, copy=False) if self.maxval < GREYS else self.greys()


@dataclass(frozen=True, kw_only=True)
class Rule:
    """How grey becomes occupancy; the defaults are Nav2's, and are used for images without a YAML."""

    mode: Mode = "trinary"
    negate: bool = False
    free_thresh: float = 0.196
    occupied_thresh: float = 0.65

    def table(self) -> NDArray[np.int8]:
        """The occupancy (256,) for each grey value: -1 unknown, 0 free to 100 occupied."""
        greys = np.arange(GREYS)
        if self.mode == "raw":  # ignores `negate`
            return np.where(greys <= OCCUPIED, greys, UNKNOWN).astype(np.int8)
        shade = greys.astype(np.float32) / np.float32(GREYS - 1)
        darkness = shade if self.negate else np.float32(1) - shade
        free, occupied = np.float32(self.free_thresh), np.float32(self.occupied_thresh)
        table = np.full(GREYS, UNKNOWN, np.int8)
        if self.mode == "scale":
            between = (darkness > free) & (darkness < occupied)
            span = np.float32(self.occupied_thresh - self.free_thresh)
            percent = (darkness[between] - free) / span * np.float32(100)
            table[between] = np.floor(percent.astype(np.float64) + 0.5)  # halves are rounded up, like C's round()
        table[darkness >= occupied] = OCCUPIED
        table[darkness <= free] = FREE  # last: if the thresholds overlap, free wins
        return table


def cells_from_image(image: GreyImage, rule: Rule, *, request: Request, name: str) -> NDArray[np.int8]:
    """The occupancy (h, w) int8 of an image; adds a note if grey 205 is read otherwise than the rule says, or as free.

    A map saver's 205 is unknown, unless the request has a value of its own.
    """
    greys = image.raw() if rule.mode == "raw" else image.greys()
    table = rule.table()
    if isinstance(request.unknown_value, int):
        table[request.unknown_value] = UNKNOWN
    if rule.mode != "raw" and table[USUAL_UNKNOWN] == FREE:
        count = np.bincount(greys.reshape(-1), minlength=GREYS)
        if request.unknown_value is None and rule.mode == "trinary" and saved(count):
            table[USUAL_UNKNOWN] = UNKNOWN
        _note_usual_unknown(int(count[USUAL_UNKNOWN]), table, rule, request=request, name=name)
    # Byte by byte: indexing the table would first convert each grey to an index of eight bytes.
    cells = np.frombuffer(greys.tobytes().translate(table.tobytes()), np.int8).reshape(greys.shape)
    if image.opaque is None or rule.mode == "raw":
        return cells
    return np.where(image.opaque, cells, np.int8(UNKNOWN))


def saved(count: NDArray[np.intp]) -> bool:
    """Whether an image with so many cells of each grey (256,) looks as map savers write it: 0, 205 and 254.

    Some cells may have other greys, as after editing by hand.
    """
    known = count[list(SAVED)].sum()
    return bool(count[USUAL_UNKNOWN] and count[SAVED_FREE] and known >= SAVED_SHARE * count.sum())


def _note_usual_unknown(count: int, table: NDArray[np.int8], rule: Rule, *, request: Request, name: str) -> None:
    """Add a note on how the `count` cells of grey 205 are read."""
    if not count:
        return
    threshold = f"free_thresh {rule.free_thresh:g}"
    if table[USUAL_UNKNOWN] == FREE:
        request.note(
            f"grey {USUAL_UNKNOWN}, which map savers write for unknown, is read as free in {count} cells in mode "
            f"{rule.mode} with {threshold} (--unknown-value {USUAL_UNKNOWN} keeps it unknown)",
            name,
        )
    else:
        request.note(
            f"grey {USUAL_UNKNOWN}, which map savers write for unknown, is read as unknown in {count} cells despite "
            f"{threshold} (--unknown-value none reads it as free)",
            name,
        )
