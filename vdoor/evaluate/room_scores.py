"""How well the found rooms agree with the true ones.

recall, precision
    mean over the true (found) rooms of the largest overlap with one found (true) room, as a share of the room's area:
    Bormann et al., "Room segmentation: Survey, implementation, and analysis", ICRA 2016. Areas include all cells of a
    room, free or not. `_by_area` weights the mean by area.
iou, iou_sym
    rooms paired one to one for the largest sum of intersection over union, on free cells: the sum divided by the
    number of true rooms, and by the larger of the two numbers of rooms, which also penalises surplus rooms.
mcc
    mean Matthews correlation of rooms paired greedily, largest overlap first, on free cells that are in both a true and
    a found room; a room without a partner counts 0.
mcc_loose
    the same with two quirks of the program published with MAORIS (Mielle et al., 2018), for comparison with its
    figures: see `_mcc_loose`.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
import scipy
from numpy.typing import NDArray

from vdoor.evaluate.label_files import Labels

Table = NDArray[np.int64]


@dataclass(frozen=True, kw_only=True, eq=False)
class RoomScore:
    """The measures described at the top of this module; all 0 if there are no true or no found rooms."""

    true: int
    found: int
    """Numbers of true and found rooms."""
    recall: float = 0.0
    precision: float = 0.0
    recall_by_area: float = 0.0
    precision_by_area: float = 0.0
    iou: float = 0.0
    iou_sym: float = 0.0
    mcc: float = 0.0
    mcc_loose: float = 0.0
    pairs: NDArray[np.int32] = field(default_factory=lambda: np.zeros((0, 2), np.int32))
    """True and found room (k, 2) of the pairs in `iou`."""
    pair_iou: NDArray[np.float64] = field(default_factory=lambda: np.zeros(0))


def compare_rooms(truth: Labels, found: Labels, free: NDArray[np.bool_]) -> RoomScore:
    """The measures of found rooms against true ones; all rasters (h, w), rooms numbered 1, 2, ... without gaps."""
    shape = int(truth.max(initial=0)) + 1, int(found.max(initial=0)) + 1
    rooms_true, rooms_found = shape[0] - 1, shape[1] - 1
    if not (rooms_true and rooms_found):
        return RoomScore(true=rooms_true, found=rooms_found)
    cells = _cells(truth.ravel(), found.ravel(), shape)
    free_cells = _cells(truth[free], found[free], shape)
    recall, recall_by_area = _largest_shares(cells)
    precision, precision_by_area = _largest_shares(cells.T)
    pairs, pair_iou = _pairs(free_cells)
    in_both = free_cells[1:, 1:]
    return RoomScore(
        true=rooms_true,
        found=rooms_found,
        recall=recall,
        precision=precision,
        recall_by_area=recall_by_area,
        precision_by_area=precision_by_area,
        iou=float(pair_iou.sum() / rooms_true),
        iou_sym=float(pair_iou.sum() / max(rooms_true, rooms_found)),
        mcc=_mcc(in_both),
        mcc_loose=_mcc_loose(in_both),
        pairs=pairs,
        pair_iou=pair_iou,
    )


def _cells(truth: NDArray[Any], found: NDArray[Any], shape: tuple[int, int]) -> Table:
    """The number of cells by true room (row) and found room (column); row and column 0 are cells in no room."""
    both = truth.astype(np.int64) * shape[1] + found
    return np.bincount(both, minlength=shape[0] * shape[1]).reshape(shape)


def _largest_shares(cells: Table) -> tuple[float, float]:
    """The largest share of each row's room in one column's room, as the mean over rooms, and weighted by area."""
    areas, best = cells[1:].sum(axis=1), cells[1:, 1:].max(axis=1)
    return float((best / areas).mean()), float(best.sum() / areas.sum())


def _pairs(cells: Table) -> tuple[NDArray[np.int32], NDArray[np.float64]]:
    """True and found room of each pair (k, 2), and its intersection over union (k,); pairs overlap."""
    overlap = cells[1:, 1:]
    union = cells[1:].sum(axis=1)[:, None] + cells[:, 1:].sum(axis=0) - overlap
    iou = overlap / np.maximum(union, 1)
    true, found = scipy.optimize.linear_sum_assignment(iou, maximize=True)
    touching = overlap[true, found] > 0
    true, found = true[touching], found[touching]
    return np.stack([true, found], axis=1).astype(np.int32) + 1, iou[true, found]


def _mcc(overlap: Table) -> float:
    """The mean over the greedy pairs and all rooms without a partner, which count 0."""
    true, found = _greedy_pairs(overlap)
    rooms = sum(overlap.shape) - len(true)
    return float(_correlations(overlap, true, found, _true_negatives(overlap, true, found)).sum() / rooms)


def _greedy_pairs(overlap: Table) -> tuple[list[int], list[int]]:
    """Rows and columns of one-to-one pairs, largest overlap first; ties go to the lower row, then column."""
    true: list[int] = []
    found: list[int] = []
    for place in np.argsort(-overlap, axis=None, kind="stable")[: np.count_nonzero(overlap)].tolist():
        row, column = divmod(place, overlap.shape[1])
        if row not in true and column not in found:
            true.append(row)
            found.append(column)
    return true, found


def _mcc_loose(overlap: Table) -> float:
    """The mean over the found rooms, largest overlap first, each paired with the remaining true room it overlaps most.

    The quirks: if none remains, a found room is paired with the true room it overlaps least, though that already has a
    partner; and the true room's area is added to the true negatives. A true room without a partner counts 0 once per
    found room that overlaps it.
    """
    true: list[int] = []
    found: list[int] = []
    touching = overlap > 0
    for column in np.argsort(-overlap.max(axis=0), kind="stable").tolist():
        rows = np.argsort(-overlap[:, column], kind="stable")[: np.count_nonzero(touching[:, column])].tolist()
        if rows:
            true.append(next((row for row in rows if row not in true), rows[-1]))
            found.append(column)
    alone = np.delete(touching, true, axis=0).sum()
    if not found:
        return 0.0
    false_positives = overlap.sum(axis=0)[found] - overlap[true, found]
    negatives = overlap.sum() - (false_positives - overlap.sum(axis=1)[true])
    return float(_correlations(overlap, true, found, negatives).sum() / (len(found) + alone))


def _true_negatives(overlap: Table, true: list[int], found: list[int]) -> Table:
    """The number of cells that are in neither room of each pair."""
    negatives: Table = overlap.sum() - overlap.sum(axis=1)[true] - overlap.sum(axis=0)[found] + overlap[true, found]
    return negatives


def _correlations(overlap: Table, true: list[int], found: list[int], tn: Table) -> NDArray[np.float64]:
    """The Matthews correlation of each pair; where undefined, 1 for equal rooms and 0 for others."""
    tp = overlap[true, found]
    fp, fn = overlap.sum(axis=0)[found] - tp, overlap.sum(axis=1)[true] - tp
    # Roots first: the product of four areas overflows 64 bits.
    norm = np.prod(np.sqrt([tp + fp, tp + fn, tn + fp, tn + fn]), axis=0)
    undefined = norm == 0
    above = tp.astype(np.float64) * tn - fp.astype(np.float64) * fn
    equal = (fp == 0) & (fn == 0) & (tp > 0)
    correlations: NDArray[np.float64] = np.where(undefined, equal, above / np.where(undefined, 1.0, norm))
    return correlations
