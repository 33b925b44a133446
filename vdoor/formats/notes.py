"""The one place for notes on maps that are valid but hardly meant: what was read how, in counts, and what to set."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from vdoor.formats.levels import LIKELIER, NAV2
from vdoor.formats.source import Request
from vdoor.grid import OCCUPIED, UNKNOWN

GREYS = 256
USUAL_UNKNOWN = 205
"""The grey value that map savers write for unknown cells."""
SHARE = 0.02
"""Share of cells from which a note is made."""
MOST_OCCUPIED = 0.75
"""Largest share of occupied cells among known ones; maps of robots and plans have 0.02 to 0.25."""
MOST_UNKNOWN_INSIDE = 0.4
"""Largest share of unknown cells within walls among those and all free ones; real maps and plans have 0 to 0.36."""
MOST_LOOKED_AT = 1 << 22
"""Cells that are looked at for what walls enclose; larger maps are coarsened."""
LEAST_CELLS = 100
"""Fewer cells say nothing about shares."""
COMMONEST = 3
LIGHT = 250
"""Lighter greys are never meant as unknown."""
BLOCK = 1 << 22


def histogram(values: NDArray[np.uint8] | NDArray[np.int8]) -> NDArray[np.int64]:
    """Number of cells of each value (256,); negative values are counted from the end, -1 as 255."""
    flat, counts = values.reshape(-1).view(np.uint8), np.zeros(GREYS, np.int64)
    for at in range(0, flat.size, BLOCK):  # counting makes eight bytes of each
        counts += np.bincount(flat[at : at + BLOCK], minlength=GREYS)
    return counts


def between(counts: NDArray[np.int64]) -> tuple[int, int]:
    """Number of cells that are neither free nor occupied though known, and of all known cells, by their values."""
    return int(counts[math.ceil(NAV2.free_below) : math.ceil(NAV2.occupied_from)].sum()), int(
        counts[: OCCUPIED + 1].sum()
    )


def is_continuous(counts: NDArray[np.int64]) -> bool:
    """Whether values are probabilities: too many of them are neither free nor occupied."""
    return _many(*between(counts))


def note_likelier(counts: NDArray[np.int64], request: Request) -> None:
    """Say that probabilities are read by what is likelier."""
    undecided, known = between(counts)
    request.note(
        f"occupancy: {_of(undecided, known, 'known cells')} lie from {NAV2.free_below:g} to {NAV2.occupied_from - 1:g} "
        f"per cent; read as free below {LIKELIER.free_below:g} and occupied from {LIKELIER.occupied_from:g} ({NAV2} "
        "reads them as unknown)",
        request.name,
    )


def note_undecided(counts: NDArray[np.int64], mode: str, request: Request) -> None:
    """Say how many values of an image in mode raw or scale are neither free nor occupied."""
    undecided, known = between(counts)
    if _many(undecided, known):
        request.note(
            f"mode {mode}: {_of(undecided, known, 'known cells')} lie from {NAV2.free_below:g} to "
            f"{NAV2.occupied_from - 1:g} per cent, neither free nor occupied ({LIKELIER} decides them)",
            request.name,
        )


def note_raw(counts: NDArray[np.int64], request: Request) -> None:
    """Say how many greys are none of raw mode: those above 100, but for 255, which savers write for unknown."""
    odd, total = int(counts[OCCUPIED + 1 : GREYS - 1].sum()), int(counts.sum())
    if _many(odd, total):
        request.note(
            f"mode raw: {_of(odd, total, 'cells')} are above 100, so unknown ({_commonest(counts)}); an image of a map "
            "saver is meant to be read with mode: trinary",
            request.name,
        )


def note_greys(counts: NDArray[np.int64], table: NDArray[np.int8], given: int | None, request: Request) -> None:
    """Say how many greys lie between free and occupied in trinary mode, other than the usual one for unknown."""
    odd = counts.copy()
    odd[(table != UNKNOWN)] = 0
    odd[[USUAL_UNKNOWN] if given is None else [USUAL_UNKNOWN, given]] = 0
    total = int(counts[table != UNKNOWN].sum() + odd.sum())
    if _many(int(odd.sum()), total):
        request.note(
            f"greys: {_of(int(odd.sum()), total, f'cells other than {USUAL_UNKNOWN}')} lie between free and occupied, "
            f"so are unknown ({_commonest(odd)}); {_advice(odd, counts)}",
            request.name,
        )


def note_colours(coloured: int, total: int, request: Request) -> None:
    """Say how many pixels have a colour."""
    if _many(coloured, total):
        request.note(
            f"colours: {_of(coloured, total, 'cells')} are not grey and count by their brightness, which may say "
            "nothing of walls (save the map in grey)",
            request.name,
        )


def note_cells(cells: NDArray[np.int8], request: Request) -> None:
    """Say if hardly anything is free, or much is unknown within walls."""
    counts = histogram(cells)
    free, occupied, _ = states(counts)
    if free and _many(occupied, free + occupied, MOST_OCCUPIED):
        request.note(
            f"occupied: {_of(occupied, free + occupied, 'known cells')}; are black and white the wrong way round "
            "(negate in the YAML)?",
            request.name,
        )
    unknown_inside, inside = _enclosed(cells)
    if _many(unknown_inside, inside, MOST_UNKNOWN_INSIDE):
        request.note(
            f"unknown: {_of(unknown_inside, inside, 'free cells and unknown ones within walls')}; is a grey or "
            "value of the floor read as unknown (--free-below sets what is free)?",
            request.name,
        )


def states(counts: NDArray[np.int64]) -> tuple[int, int, int]:
    """Number of cells that are free, occupied, and anything else, by their values."""
    free = int(counts[: math.ceil(NAV2.free_below)].sum())
    occupied = int(counts[math.ceil(NAV2.occupied_from) : OCCUPIED + 1].sum())
    return free, occupied, int(counts.sum()) - free - occupied


def described(cells: NDArray[np.int8], greys: NDArray[np.int64] | None) -> str:
    """The cells in counts, and the commonest greys (256,) of an image or else values, with what to set."""
    counts = histogram(cells)
    free, occupied, unknown = states(counts)
    text = f"free {free}, occupied {occupied}, unknown {unknown} cells"
    if greys is not None:
        text += f"; {_commonest(greys)}"
        return text if free else f"{text}; {_advice(greys, greys)}"
    text += f"; {_commonest_of(counts)}"
    return text if free or unknown == counts[-1] else f"{text}; {LIKELIER} decides what lies between"


def _enclosed(cells: NDArray[np.int8]) -> tuple[int, int]:
    """Number of unknown cells in spaces that occupied cells close off, and the same with all free cells."""
    from vdoor.raster.morphology import counted  # noqa: PLC0415  # loads OpenCV

    codes = np.zeros(cells.shape, np.uint8)
    codes[cells.view(np.uint8) < NAV2.free_below] = 1
    codes[cells >= NAV2.occupied_from] = 2
    factor = math.ceil(math.sqrt(cells.size / MOST_LOOKED_AT))
    if factor > 1:
        codes = _coarse(codes, factor)
    labels, count = counted(codes != 2)  # noqa: PLR2004
    inside = np.ones(count + 1, np.bool_)
    inside[0] = False
    for edge in (labels[0], labels[-1], labels[:, 0], labels[:, -1]):
        inside[edge] = False
    unknown = int(np.count_nonzero(inside[labels] & (codes == 0)))
    return unknown, unknown + int(np.count_nonzero(codes == 1))


def _coarse(codes: NDArray[np.uint8], factor: int) -> NDArray[np.uint8]:
    """The largest code of each square of cells, so that walls stay closed."""
    for axis in (0, 1):
        codes = np.maximum.reduceat(codes, np.arange(0, codes.shape[axis], factor), axis=axis)
    return codes


def _many(part: int, total: int, share: float = SHARE) -> bool:
    """Whether a part of some cells is worth a note."""
    return total >= LEAST_CELLS and part > share * total


def _of(part: int, total: int, what: str) -> str:
    return f"{part} of {total} {what} ({part / total:.1%})"


def _commonest(greys: NDArray[np.int64]) -> str:
    """The commonest greys with their counts."""
    return f"commonest greys {', '.join(f'{grey} in {greys[grey]}' for grey in _ranked(greys))}"


def _commonest_of(counts: NDArray[np.int64]) -> str:
    """The commonest values of cells with their counts."""
    named = (f"{grey if grey < GREYS // 2 else grey - GREYS} in {counts[grey]}" for grey in _ranked(counts))
    return f"commonest values {', '.join(named)}"


def _ranked(counts: NDArray[np.int64]) -> Iterator[int]:
    """The commonest values, the commonest first."""
    yield from (int(at) for at in np.argsort(-counts, kind="stable")[:COMMONEST] if counts[at])


def _advice(greys: NDArray[np.int64], counts: NDArray[np.int64]) -> str:
    """What to set so that the lightest of the commonest of `greys` is free, and another common one unknown."""
    lightest = max(_ranked(greys), default=GREYS - 1)
    free_below = math.floor((GREYS - 1 - lightest) * OCCUPIED / (GREYS - 1)) + 1
    others = (grey for grey in _ranked(counts) if grey != lightest and 0 < grey < LIGHT)
    unknown = next((f", --unknown-value {grey} keeps {grey} unknown" for grey in others), "")
    return f"--free-below {free_below} reads {lightest} as free{unknown}"
