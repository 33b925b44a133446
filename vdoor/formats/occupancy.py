"""From grey to occupancy, like Nav2's map_server (its main branch, the vectorised `map_io`).

Unlike older Nav2 and ROS 1, which compare strictly and in double precision, and average alpha in as a colour.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from vdoor.formats import notes
from vdoor.formats.levels import LIKELIER, Levels
from vdoor.formats.notes import USUAL_UNKNOWN
from vdoor.formats.source import GREYS, Request
from vdoor.grid import FREE, OCCUPIED, UNKNOWN, Source

Mode = Literal["trinary", "scale", "raw"]
SAVED_FREE = 254
"""The grey value that map savers write for free cells."""
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
    coloured: int = 0
    """Number of pixels that have a colour."""
    remark: str = ""
    """What is odd about the file, though it could be read; empty if nothing."""

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
    """The occupancy (h, w) int8 of an image; adds notes if that is probably not what was meant.

    A map saver's 205 is unknown, unless the request has a value of its own.
    Limits of free and occupied that the user gave take the place of the rule's thresholds: of darkness, and in raw mode
    of the grey itself.
    """
    levels = request.levels(Levels(rule.free_thresh * OCCUPIED, rule.occupied_thresh * OCCUPIED))
    if levels is not None and rule.mode != "raw":
        rule = _with_levels(rule, levels)
    greys = image.raw() if rule.mode == "raw" else image.greys()
    table = rule.table()
    if levels is not None and rule.mode == "raw":
        table = levels.of(table)
    if isinstance(request.unknown_value, int):
        table[request.unknown_value] = UNKNOWN
    _note(image, greys, table, rule, request=request, name=name)
    # Byte by byte: indexing the table would first convert each grey to an index of eight bytes.
    cells = np.frombuffer(greys.tobytes().translate(table.tobytes()), np.int8).reshape(greys.shape)
    if image.opaque is None or rule.mode == "raw":
        return cells
    return np.where(image.opaque, cells, np.int8(UNKNOWN))


def decided(values: NDArray[np.int8], request: Request) -> tuple[NDArray[np.int8], Source]:
    """The occupancy (h, w) of values that a program wrote, and the source with the limits that were used.

    Probabilities are read by what is likelier, with a note; limits that the user gave are used as they are.
    """
    levels = request.levels()
    if levels is None:
        counts = notes.histogram(values)
        if not notes.is_continuous(counts):
            return values, request.source
        notes.note_likelier(counts, request)
        levels = LIKELIER
    return levels.of(values), request.with_levels(levels)


def _with_levels(rule: Rule, levels: Levels) -> Rule:
    """The rule with limits of darkness in per cent; below `free_below` is free, so the threshold is the next number."""
    return Rule(
        negate=rule.negate,
        free_thresh=float(np.nextafter(np.float32(levels.free_below / OCCUPIED), np.float32(-1))),
        occupied_thresh=levels.occupied_from / OCCUPIED,
    )


def _note(
    image: GreyImage, greys: NDArray[np.uint8], table: NDArray[np.int8], rule: Rule, *, request: Request, name: str
) -> None:
    """Add notes on what an image loses by the way in which it is read; a map saver's 205 becomes unknown in `table`."""
    counts = notes.histogram(greys)
    if image.remark:
        request.note(image.remark, name)
    notes.note_colours(image.coloured, greys.size, request)
    if rule.mode != "raw" and table[USUAL_UNKNOWN] == FREE:
        if request.unknown_value is None and rule.mode == "trinary" and saved(counts):
            table[USUAL_UNKNOWN] = UNKNOWN
        _note_usual_unknown(int(counts[USUAL_UNKNOWN]), table, rule, request=request, name=name)
    if rule.mode == "raw":
        notes.note_raw(counts, request)
    if rule.mode == "trinary":
        given = request.unknown_value if isinstance(request.unknown_value, int) else None
        notes.note_greys(counts, table, given, request)
    else:
        notes.note_undecided(_values(counts, table), rule.mode, request)


def _values(counts: NDArray[np.int64], table: NDArray[np.int8]) -> NDArray[np.int64]:
    """Number of cells of each occupancy (256,), unknown last, from the numbers of each grey."""
    return np.bincount(table.view(np.uint8), counts, minlength=GREYS).astype(np.int64)


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
