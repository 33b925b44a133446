"""Shorten a finished path where that costs little: leave out points, or let two bends become one.

A change is worth what it saves in length and bends, less the area that no other stretch of the path sweeps. Everything
is in cells of area: `trade` times the tool's width turns a length into an area, see `Polish`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import shapely
from numpy.typing import NDArray

from vdoor.navigate.coverage.floor import SNAP, grown
from vdoor.navigate.coverage.path import Path, bends_rad, norms
from vdoor.navigate.coverage.sweep import Tool, consecutive

Mask = NDArray[np.bool_]
Ints = NDArray[np.intp]
Floats = NDArray[np.float64]

STEPS = (1 / 8, 1 / 4, 1 / 2, 1)
"""Polishing begins with changes that cost little: at these shares of the trade, one after the other."""
MOST_ROUNDS = 100
BEND_RAD = np.radians(5.0)
"""A smaller change of heading is no bend."""
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


class Worth(NamedTuple):
    """What changes are worth, and what that depends on."""

    gain: Floats
    """In cells (k,)."""
    lost: Ints
    """How many more wanted cells stay uncovered (k,)."""
    spare: float
    """How many may."""
    change: Ints
    cell: Ints
    """Cells whose only sweeps a change touches, sorted by change (n,)."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Polish:
    """Change a path as long as changes are worth it."""

    floor: shapely.MultiPolygon
    tool: Tool
    wanted: Mask
    """The cells to be swept (h, w)."""
    trade: float
    """How much area may be lost for a length saved, as a share of what the tool sweeps on that length; at first less,
    see `STEPS`."""
    bend: float
    """What a bend costs, as a length in cells."""
    leave: float
    """Largest share of the wanted cells that may stay uncovered for it."""

    def __call__(self, path: Path) -> Path:
        """The path after all worthwhile changes; its ends stay."""
        inside = grown(self.floor, SNAP)
        for share in STEPS:
            path = self._polished(path, inside, share * self.trade)
        return path

    def _polished(self, path: Path, inside: shapely.Geometry, trade: float) -> Path:
        """The path after all changes that are worth it at one trade."""
        active = np.ones(len(path.point), np.bool_)
        for _ in range(MOST_ROUNDS):
            changes = self._possible(path, active, inside, trade)
            if not len(changes.first):
                break
            worth = self._worth(path, changes, trade)
            taken = _independent(worth, changes, len(path.point), self.wanted.size)
            taken = taken[np.cumsum(np.maximum(worth.lost[taken], 0)) <= max(worth.spare, 0)]
            if not len(taken):
                break
            active = _touched(changes, np.flatnonzero(worth.gain > EPSILON), len(path.point))
            path, active = _changed(path, changes.chosen(taken), active)
        return path

    def _possible(self, path: Path, active: Mask, inside: shapely.Geometry, trade: float) -> Changes:
        """Changes near active points that save length or bends, and stay on the floor."""
        found = (_left_out(path.point), _joined(path.point, 2 * LONGEST_EXTENSION * self.tool.reach))
        changes = Changes(*(np.concatenate(columns) for columns in zip(*found, strict=True)))
        near = np.cumsum(np.concatenate([[0], active]))
        changes = changes.chosen(np.flatnonzero(near[changes.first + changes.gone + 1] > near[changes.first]))
        changes = changes.chosen(np.flatnonzero(self._saved(path, changes, trade) > EPSILON))
        corners = np.stack(
            [path.point[changes.first], changes.middle, path.point[changes.first + changes.gone]], axis=1
        )
        return changes.chosen(np.flatnonzero(shapely.covers(inside, shapely.linestrings(corners))))

    def _saved(self, path: Path, changes: Changes, trade: float) -> Floats:
        """Length and bends that changes save (k,), in cells of area."""
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
        return np.asarray(2 * self.tool.reach * trade * (shorter + self.bend * (bent[end + 1] - bent[start] - bends)))

    def _worth(self, path: Path, changes: Changes, trade: float) -> Worth:
        """What is saved, less the wanted cells that only the old segments sweep, plus those that are new."""
        size = self.wanted.size
        segment, cell = self._swept(path.point[:-1], path.point[1:])
        times = np.bincount(cell, minlength=size)
        begin = np.searchsorted(segment, np.arange(len(path.point)))
        start, end = begin[changes.first], begin[changes.first + changes.gone]
        change = np.repeat(np.arange(len(start)), end - start)
        old = cell[consecutive(start, end - start)]
        few = times[old] <= changes.gone[change]
        change, old = change[few], old[few]
        own, sweeps = _counted(change * size + old)
        lost = own[times[own % size] == sweeps]
        middle, far = changes.middle, path.point[changes.first + changes.gone]
        halves = (self._swept(path.point[changes.first], middle), self._swept(middle, far))
        new, _ = _counted(np.concatenate([number * size + cell for number, cell in halves]))
        gained = new[times[new % size] == 0]
        lost = lost[new[np.minimum(np.searchsorted(new, lost), len(new) - 1)] != lost] if len(new) else lost
        less = np.bincount(lost // size, minlength=len(start)) - np.bincount(gained // size, minlength=len(start))
        wanted = np.count_nonzero(self.wanted)
        spare = self.leave * wanted - (wanted - np.count_nonzero(times))
        return Worth(self._saved(path, changes, trade) - less, less, spare, change, old)

    def _swept(self, start: Floats, end: Floats) -> tuple[Ints, Ints]:
        segment, cell = self.tool.swept(start, end)
        wanted = self.wanted.reshape(-1)[cell]
        return segment[wanted], cell[wanted]


def _counted(keys: Ints) -> tuple[Ints, Ints]:
    """The different keys, ascending, and how often each occurs; faster than `np.unique`, as they are nearly sorted."""
    ordered = np.sort(keys, kind="stable")
    first = np.flatnonzero(np.concatenate([[True], ordered[1:] != ordered[:-1]])[: len(ordered)])
    return ordered[first], np.diff(np.append(first, len(ordered)))


def _left_out(point: Floats) -> Changes:
    """Each inner point left out: its two segments become one, with a point in its middle."""
    first = np.arange(len(point) - 2)
    return Changes(first, np.full(len(first), 2), (point[:-2] + point[2:]) / 2, np.ones(len(first), np.bool_))


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


def _independent(worth: Worth, changes: Changes, points: int, cells: int) -> Ints:
    """The best changes that share neither segments nor cells, so that each is worth what it is worth alone."""
    begin = np.searchsorted(worth.change, np.arange(len(worth.gain) + 1)).tolist()
    used, touched = np.zeros(points, np.bool_), np.zeros(cells, np.bool_)
    good = np.flatnonzero(worth.gain > EPSILON)
    taken = []
    for change in good[np.argsort(-worth.gain[good], kind="stable")].tolist():
        stretch = slice(int(changes.first[change]), int(changes.first[change] + changes.gone[change]) + 1)
        own = worth.cell[begin[change] : begin[change + 1]]
        if not used[stretch].any() and not touched[own].any():
            used[stretch] = True
            touched[own] = True
            taken.append(change)
    return np.array(taken, np.intp)


def _touched(changes: Changes, which: Ints, points: int) -> Mask:
    """The points of the segments that some changes replace, or would."""
    touched = np.zeros(points, np.bool_)
    touched[consecutive(changes.first[which], changes.gone[which] + 1)] = True
    return touched


def _changed(path: Path, changes: Changes, active: Mask) -> tuple[Path, Mask]:
    """The path with independent changes made, and which of its points are active."""
    point, kept = path.point.copy(), np.ones(len(path.point), np.bool_)
    kept[consecutive(changes.first + 1, changes.gone - 1)] = False
    bends = changes.first[~changes.straight] + 1
    point[bends], kept[bends] = changes.middle[~changes.straight], True
    return Path(point[kept], path.kind[kept], path.visit[kept]), active[kept]
