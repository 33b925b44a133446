"""Shorten a finished path where that costs little: leave out points, or let two bends become one.

A change is worth what it saves in length and bends, less the area that no other stretch of the path sweeps. Everything
is in cells of area: `trade` times the tool's width turns a length into an area, see `Polish`.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
import shapely
from numpy.typing import NDArray

from vdoor.navigate.coverage.floor import SNAP, enlarged
from vdoor.navigate.coverage.losses import Losses, Segments
from vdoor.navigate.coverage.path import Path, bends_rad, norms
from vdoor.navigate.coverage.sweep import Tool
from vdoor.raster.runs import consecutive

Mask = NDArray[np.bool_]
Ints = NDArray[np.intp]
Floats = NDArray[np.float64]

STEPS = (1 / 8, 1 / 4, 1 / 2, 1)
"""Polishing begins with changes that cost little: at these shares of the trade, one after the other."""
MOST_ROUNDS = 100
MOST_LEFT_OUT = 2
"""Largest number of points in a row that are left out together."""
BEND_RAD = np.radians(5.0)
"""A smaller change of heading is no bend."""
LEAST_TRADE = 1e-3
"""At this trade a path is only made shorter where it loses nothing."""
KEPT = 100_000
"""A cell that is not given up counts as so many."""
LONGEST_EXTENSION = 3.0
"""Two bends become one only if their outer segments meet within so many widths of the tool."""
EPSILON = 1e-6


class Changes(NamedTuple):
    """Changes to a path, each of which replaces a few segments in a row by two."""

    first: Ints
    """The point before the first segment that goes (k,)."""
    gone: Ints
    """The number of segments that go (k,)."""
    middle: Floats
    """The point between the two new segments (k, 2)."""
    straight: Mask
    """Whether that point is no bend and is left out (k,)."""

    def chosen(self, which: Ints) -> Changes:
        """Some of them."""
        return Changes(self.first[which], self.gone[which], self.middle[which], self.straight[which])


class Deltas(NamedTuple):
    """By how much changes change how often cells are swept; what stays is not listed."""

    change: Ints
    """Ascending (n,)."""
    cell: Ints
    more: NDArray[np.int32]
    """Negative for less often (n,)."""
    counts: NDArray[np.int32]
    """As how many cells each counts (n,)."""

    def between(self, begin: int, end: int) -> Deltas:
        """Some of them."""
        return Deltas(self.change[begin:end], self.cell[begin:end], self.more[begin:end], self.counts[begin:end])

    def lost(self, times: NDArray[np.int32]) -> NDArray[np.int32]:
        """What each cell (n,) counts that is not swept any more, negative if it now is, if cells are swept so often."""
        before = times[self.cell]
        return self.counts * ((before > 0).astype(np.int32) - (before + self.more > 0))


class Draft(NamedTuple):
    """A path on its way."""

    path: Path
    times: NDArray[np.int32]
    """How often each wanted cell of the raster is swept (h w,), changed in place."""
    promising: Mask
    """The points near changes that are worth it at the whole trade (k,)."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Polish:
    """Change a path as long as changes are worth it."""

    floor: shapely.MultiPolygon
    tool: Tool
    wanted: Mask
    """The cells to be swept (h, w)."""
    kept: Mask
    """Those that are not given up, once swept (h, w)."""
    trade: float
    """How much area may be lost for a length saved, as a share of what the tool sweeps on that length; at first less,
    see `STEPS`."""
    bend: float
    """What a bend costs, as a length in cells."""
    leave: float
    """Largest share of the wanted cells that may stay uncovered for it."""

    def __call__(self, path: Path) -> Path:
        """The path after all worthwhile changes; its ends stay."""
        inside = enlarged(self.floor, SNAP)
        times = np.bincount(self._swept(path.point[:-1], path.point[1:])[1], minlength=self.wanted.size)
        draft = Draft(path, times.astype(np.int32), np.ones(len(path.point), np.bool_))
        for share in STEPS:
            draft = self._polished(draft, inside, share)
        return draft.path

    def _polished(self, draft: Draft, inside: shapely.Geometry, share: float) -> Draft:
        """The draft after all changes that are worth it at a share of the trade."""
        active = draft.promising
        for _ in range(MOST_ROUNDS):
            path, times = draft.path, draft.times
            changes, saved = self._possible(path, active, inside)
            if not len(changes.first):
                break
            lost = self._losses(path, changes).lost(times, self._counts)
            gain = share * saved - lost
            best = _apart(changes, gain)
            deltas = self._deltas(path, changes.chosen(best))
            taken = best[_taken(deltas, share * saved[best], times, self._spare(times))]
            promising = draft.promising & ~_touched(changes, np.arange(len(saved)), len(path.point))
            promising |= _touched(changes, np.flatnonzero(saved - lost > EPSILON), len(path.point))
            active = _touched(changes, np.flatnonzero(gain > EPSILON), len(path.point))
            path, kept = _changed(path, changes.chosen(taken))
            draft, active = Draft(path, times, promising[kept]), active[kept]
            if not len(taken):
                break
        return draft

    def _spare(self, times: NDArray[np.int32]) -> float:
        """How many more cells may stay uncovered."""
        wanted = np.count_nonzero(self.wanted)
        return self.leave * wanted - (wanted - np.count_nonzero(times))

    def _possible(self, path: Path, active: Mask, inside: shapely.Geometry) -> tuple[Changes, Floats]:
        """Changes near active points that save length or bends, and stay on the floor, and what they save (k,)."""
        found = [_left_out(path.point, inner) for inner in range(1, MOST_LEFT_OUT + 1)]
        found.append(_joined(path.point, 2 * LONGEST_EXTENSION * self.tool.reach))
        changes = Changes(*(np.concatenate(columns) for columns in zip(*found, strict=True)))
        near = np.cumsum(np.concatenate([[0], active]))
        changes = changes.chosen(np.flatnonzero(near[changes.first + changes.gone + 1] > near[changes.first]))
        saved = self._saved(path, changes)
        better = np.flatnonzero(saved > EPSILON)
        changes, saved = changes.chosen(better), saved[better]
        corners = np.stack(
            [path.point[changes.first], changes.middle, path.point[changes.first + changes.gone]], axis=1
        )
        stays = np.flatnonzero(shapely.covers(inside, shapely.linestrings(corners)))
        return changes.chosen(stays), saved[stays]

    def _saved(self, path: Path, changes: Changes) -> Floats:
        """Length and bends that changes save (k,), in cells of the raster."""
        point = path.point
        start, end = changes.first, changes.first + changes.gone
        gone = np.concatenate([[0], np.cumsum(norms(np.diff(point, axis=0)))])
        bent = np.concatenate([[0, 0], np.cumsum(path.bends_rad() > BEND_RAD)])
        bent = np.append(bent, bent[-1])
        one, other = point[start] - changes.middle, point[end] - changes.middle
        shorter = gone[end] - gone[start] - norms(one) - norms(other)
        before, after = point[np.maximum(start - 1, 0)], point[np.minimum(end + 1, len(point) - 1)]
        bends = (
            (bends_rad(before, point[start], changes.middle) > BEND_RAD).astype(np.intp)
            + (bends_rad(changes.middle, point[end], after) > BEND_RAD)
            + ~changes.straight
        )
        width = 2 * self.tool.reach * self.tool.fine**2
        return np.asarray(
            max(self.trade, LEAST_TRADE) * width * (shorter + self.bend * (bent[end + 1] - bent[start] - bends))
        )

    @cached_property
    def _counts(self) -> NDArray[np.int32]:
        """As how many cells each one of the raster counts (h w,)."""
        return np.where(self.wanted, np.where(self.kept, KEPT, 1), 0).astype(np.int32).reshape(-1)

    def _losses(self, path: Path, changes: Changes) -> Losses:
        point, (first, gone, middle, straight) = path.point, changes
        far = point[first + gone]
        goes = []
        for number in range(int(gone.max())):
            own = np.flatnonzero(gone > number)
            start = first[own] + number
            goes.append(Segments(own, point[start], point[start + 1]))
        bent = np.flatnonzero(~straight)
        comes = [
            Segments(np.arange(len(first)), point[first], np.where(straight[:, None], far, middle)),
            Segments(bent, middle[bent], far[bent]),
        ]
        return Losses(self.tool, len(first), goes, comes)

    def _deltas(self, path: Path, changes: Changes) -> Deltas:
        """What changes in how often the wanted cells are swept."""
        size = self.wanted.size
        gone = consecutive(changes.first, changes.gone)
        replaced, of = np.unique(gone, return_inverse=True)
        segment, cell = self._swept(path.point[replaced], path.point[replaced + 1])
        begin = np.searchsorted(segment, np.arange(len(replaced) + 1))
        count = np.diff(begin)[of]
        change = np.repeat(np.repeat(np.arange(len(changes.first)), changes.gone), count)
        old = change * size + cell[consecutive(begin[of], count)]
        bent = np.flatnonzero(~changes.straight)
        far = path.point[changes.first + changes.gone]
        middle = np.where(changes.straight[:, None], far, changes.middle)
        change, cell = self._swept(path.point[changes.first], middle)
        behind, other = self._swept(changes.middle[bent], far[bent])
        change, cell, more = _summed(old, np.concatenate([change * size + cell, bent[behind] * size + other]), size)
        return Deltas(change, cell, more, self._counts[cell])

    def _swept(self, start: Floats, end: Floats) -> tuple[Ints, Ints]:
        segment, cell = self.tool.swept(start, end)
        wanted = self.wanted.reshape(-1)[cell]
        return segment[wanted], cell[wanted]


def _summed(old: Ints, new: Ints, size: int) -> tuple[Ints, Ints, NDArray[np.int32]]:
    """The changes and cells of keys that go and come, and how much more often they come than go, if not as often.

    A key is a change times `size` plus a cell.
    """
    keys = np.concatenate([2 * old, 2 * new + 1])
    keys.sort()
    key = keys >> 1
    first = np.flatnonzero(np.concatenate([[True], key[1:] != key[:-1]])[: len(key)])
    more = np.add.reduceat(2 * (keys & 1) - 1, first) if len(first) else first
    differs = np.flatnonzero(more)
    change, cell = np.divmod(key[first[differs]], size)
    return change, cell, more[differs].astype(np.int32)


def _left_out(point: Floats, inner: int) -> Changes:
    """Each `inner` points in a row left out: their segments become one, with a point in its middle."""
    first = np.arange(max(len(point) - 1 - inner, 0))
    middle = (point[first] + point[first + 1 + inner]) / 2
    return Changes(first, np.full(len(first), inner + 1), middle, np.ones(len(first), np.bool_))


def _joined(point: Floats, longest: float) -> Changes:
    """Two neighbouring bends become one, where the segments before and behind them meet if made longer."""
    before, b, c, behind = point[:-3], point[1:-2], point[2:-1], point[3:]
    along, back, apart = b - before, c - behind, c - b
    cross = along[:, 0] * back[:, 1] - along[:, 1] * back[:, 0]
    divisor = np.where(np.abs(cross) < EPSILON, np.nan, cross)
    on_first = (apart[:, 0] * back[:, 1] - apart[:, 1] * back[:, 0]) / divisor
    on_last = (apart[:, 0] * along[:, 1] - apart[:, 1] * along[:, 0]) / divisor
    meeting = b + on_first[:, None] * along
    # nan compares false: parallel segments meet nowhere
    near = (on_first > EPSILON) & (on_last > EPSILON) & (norms(meeting - b) < longest)
    first = np.flatnonzero(near)
    return Changes(first, np.full(len(first), 3), meeting[first], np.zeros(len(first), np.bool_))


def _apart(changes: Changes, gain: Floats) -> Ints:
    """The changes that gain most and share no points, best first."""
    good = np.flatnonzero(gain > EPSILON)
    good = good[np.argsort(-gain[good], kind="stable")]
    first, last = changes.first[good].tolist(), (changes.first + changes.gone)[good].tolist()
    used = bytearray(max(last, default=0) + 1)
    found = []
    for change, begin, end in zip(good.tolist(), first, last, strict=True):
        if not any(used[begin : end + 1]):
            used[begin : end + 1] = b"\1" * (end + 1 - begin)
            found.append(change)
    return np.array(found, np.intp)


def _taken(deltas: Deltas, saved: Floats, times: NDArray[np.int32], spare: float) -> Ints:
    """The changes that lose at most `spare` cells in all; `times` becomes what it then is.

    Each is looked at anew, since those before it have changed how often cells are swept.
    """
    begin = np.searchsorted(deltas.change, np.arange(len(saved) + 1)).tolist()
    taken = []
    for change in range(len(saved)):
        own = deltas.between(begin[change], begin[change + 1])
        lost = int(own.lost(times).sum())
        if saved[change] - lost > EPSILON and lost <= max(spare, 0):
            times[own.cell] += own.more
            spare -= lost
            taken.append(change)
    return np.array(taken, np.intp)


def _touched(changes: Changes, which: Ints, points: int) -> Mask:
    """The points of the segments that some changes replace, or would."""
    touched = np.zeros(points, np.bool_)
    touched[consecutive(changes.first[which], changes.gone[which] + 1)] = True
    return touched


def _changed(path: Path, changes: Changes) -> tuple[Path, Ints]:
    """The path with changes made that share no segments, and which of its points were there before."""
    point, stays = path.point.copy(), np.ones(len(path.point), np.bool_)
    stays[consecutive(changes.first + 1, changes.gone - 1)] = False
    bends = changes.first[~changes.straight] + 1
    point[bends], stays[bends] = changes.middle[~changes.straight], True
    kept = np.flatnonzero(stays)
    return Path(point[kept], path.kind[kept], path.visit[kept]), kept
