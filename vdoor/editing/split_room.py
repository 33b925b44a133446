"""Cutting a room along a line."""

from __future__ import annotations

from typing import Any

import numpy as np
import scipy
from numpy.typing import NDArray

from vdoor.raster.labels import flooded

Floats = NDArray[np.float64]
Ints = NDArray[np.int32]
Mask = NDArray[np.bool_]


def clipped(start: Floats, end: Floats, shape: tuple[int, ...]) -> tuple[Floats, Floats]:
    """The part of a line between two points (2,) that is in a raster or its margin of a cell; off it if none is."""
    low, span = -np.ones(2), end - start
    high = np.array(shape, np.float64)
    with np.errstate(divide="ignore", invalid="ignore"):
        borders = np.sort([(low - start) / span, (high - start) / span], axis=0)
    still = span == 0
    inside = bool(((start >= low) & (start <= high))[still].all())
    first = max(0.0, *borders[0][~still]) if not still.all() else 0.0
    last = min(1.0, *borders[1][~still]) if not still.all() else 1.0
    if not inside or first > last:
        return low, low
    return start + first * span, start + last * span


def line_cells(start: Floats, end: Floats) -> Ints:
    """The cells (k, 2), as row, col, of a straight 8-connected line between two points (2,), including its ends."""
    span = end - start
    axis = int(np.argmax(np.abs(span)))
    first, last = np.floor([start[axis] + 0.5, end[axis] + 0.5]).astype(int).tolist()
    way = 1 if last >= first else -1
    step = np.arange(first, last + way, way)  # one cell per step along the longer axis
    cells = start + (step[:, None] - start[axis]) * (span / span[axis] if span[axis] else 0.0)
    cells[:, axis] = step
    return np.asarray(np.floor(cells + 0.5), np.int32)


def within(cells: NDArray[Any], shape: tuple[int, ...]) -> Mask:
    """Which cells (k, 2) are inside a raster."""
    return np.asarray(((cells >= 0) & (cells < shape)).all(axis=1))


def room_of_line(labels: Ints, start: Floats, end: Floats) -> int:
    """The room that contains most cells of a line, the lowest at a tie; 0 if none."""
    cells = line_cells(start, end)
    crossed = labels[tuple(cells[within(cells, labels.shape)].T)]
    count = np.bincount(crossed[crossed > 0], minlength=1)
    return int(np.argmax(count))


def prolonged(own: Mask, start: Floats, end: Floats, *, reach: float, gap: float = 0.0) -> Ints:
    """The cells (k, 2) in a room (h, w) of a line extended at both ends to the room's edge, by at most `reach` cells.

    It continues across stretches outside the room of at most `gap` cells.
    """
    span = end - start
    unit = span / max(float(np.hypot(*span)), 1e-9)
    found = [line_cells(start, end)]
    far = min(reach, float(np.hypot(*own.shape)))
    for at, way in ((start, -unit), (end, unit)):
        cells = line_cells(at, at + way * far)
        inside = within(cells, own.shape)
        inside[inside] = own[tuple(cells[inside].T)]
        at_own = np.concatenate([[-1], np.flatnonzero(inside), [len(inside) + gap + 2]])
        last = at_own[np.argmax(np.diff(at_own) > gap + 1)]
        found.append(cells[: int(last) + 1])
    cells = np.concatenate(found)
    cells = cells[within(cells, own.shape)]
    return np.asarray(cells[own[tuple(cells.T)]])


def borders(labels: Ints, cells: Ints) -> Mask:
    """Which cells (k, 2) have a cell of another room among their eight neighbours."""
    around = np.pad(labels, 1)
    own = labels[tuple(cells.T)]
    near = np.stack([around[cells[:, 0] + down, cells[:, 1] + right] for down in range(3) for right in range(3)])
    return np.asarray(((near > 0) & (near != own)).any(axis=0))


def parts(own: Mask, cells: Ints, least: float) -> tuple[Ints, int]:
    """The parts 1, 2, ... (h, w) of a room without some cells, the largest first, and the number of parts.

    The removed cells, and parts of fewer than `least` cells, are added to the nearest part along the room's cells.
    """
    rest = own.copy()
    rest[tuple(cells.T)] = False
    label, count = scipy.ndimage.label(rest)
    size = np.bincount(label.ravel(), minlength=count + 1)
    order = [part for part in np.argsort(-size[1:], kind="stable") + 1 if size[part] >= least]
    number = np.zeros(count + 1, np.int32)
    number[order] = np.arange(1, len(order) + 1)
    return flooded(number[label], own), len(order)
