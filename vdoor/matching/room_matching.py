"""Matching the rooms of a new map with those of an older one."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy
from numpy.typing import NDArray

from vdoor.editing.edits import Edit
from vdoor.matching.align import Alignment, aligned, labels_under
from vdoor.topology import TopologicalMap

Areas = NDArray[np.float64]

CHUNK = 1_000_000
"""Cells processed at a time, to limit memory."""
HALF = 0.5
"""Rooms match only if at least this share of the smaller one lies in the other."""


@dataclass(frozen=True)
class Kept:
    """A room that is in both maps."""

    id: int
    name: str
    same: float
    """Intersection over union of the old and the new room's areas, 0 to 1."""


@dataclass(frozen=True, kw_only=True)
class Match:
    """The match of a new map's rooms with an older map's; new rooms have the ids that `edits` give them."""

    alignment: Alignment
    kept: tuple[Kept, ...]
    new: tuple[int, ...]
    """New rooms that match no old one."""
    gone: tuple[int, ...]
    """Old rooms that match no new one."""
    split: Mapping[int, tuple[int, ...]]
    """Old room -> the new rooms that mostly lie in it, if there are several."""
    merged: Mapping[int, tuple[int, ...]]
    """New room -> the old rooms that mostly lie in it, if there are several."""
    edits: tuple[str, ...]
    """The edits that give the new map these ids and names."""
    taken: int
    """The highest room id used so far."""

    def document(self) -> dict[str, Any]:
        """The match, without the edits, as a JSON document."""
        return {
            "shift_m": list(self.alignment.shift_m),
            "overlap": self.alignment.overlap,
            "kept": [vars(kept) for kept in self.kept],
            "new": list(self.new),
            "gone": list(self.gone),
            "split": [{"room": room, "into": list(rooms)} for room, rooms in self.split.items()],
            "merged": [{"room": room, "from": list(rooms)} for room, rooms in self.merged.items()],
        }

    def lines(self) -> Iterator[str]:
        """The match as lines of text for the user."""
        x_m, y_m = self.alignment.shift_m
        shift = f"shifted by {x_m:.2f},{y_m:.2f} m" if x_m or y_m else "in the same frame"
        yield f"the older map is {shift}; {self.alignment.overlap:.0%} of the rooms' area is in both maps"
        names = [f"{kept.id} {kept.name}".strip() for kept in self.kept]
        yield f"rooms kept: {', '.join(names) or 'none'}"
        for word, rooms in (("new", self.new), ("gone", self.gone)):
            if rooms:
                yield f"rooms {word}: {', '.join(map(str, rooms))}"
        for room, rooms in self.split.items():
            yield f"room {room} was split into {', '.join(map(str, rooms))}"
        for room, rooms in self.merged.items():
            yield f"room {room} was merged from {', '.join(map(str, rooms))}"


def match(
    old: TopologicalMap,
    new: TopologicalMap,
    *,
    alignment: Alignment | None = None,
    taken: int = 0,
    numbered: Collection[int] = (),
    named: Collection[int] = (),
) -> Match:
    """The match of `new`'s rooms with `old`'s, one to one, with the largest total overlap.

    Rooms without a partner get ids above `taken` and above all ids of `old`. Rooms of `new` listed in `numbered` keep
    their ids, those in `named` their names, whatever they match.
    """
    alignment = alignment or aligned(old, new)
    common_m2 = _common_m2(old, new, alignment)
    pairs = _pairs(old, new, common_m2)
    ids, taken = _ids(old, new, pairs, taken=taken, numbered=numbered)
    names = {now: old.room(before).name for now, before in pairs.items() if now not in named}
    partner = {before: now for now, before in pairs.items()}
    same = _same(old, new, common_m2)
    kept = [
        Kept(before, names.get(now, "") or new.room(now).name, float(same[old.room_row(before), new.room_row(now)]))
        for before, now in sorted(partner.items())
        if ids[now] == before
    ]
    return Match(
        alignment=alignment,
        kept=tuple(kept),
        new=tuple(sorted(ids[room] for room in new.room_ids if room not in pairs)),
        gone=tuple(room for room in old.room_ids if room not in partner),
        split={
            old.room_ids[row]: tuple(sorted(ids[new.room_ids[now]] for now in rows))
            for row, rows in _several(common_m2 >= HALF * new.area_m2)
        },
        merged={
            ids[new.room_ids[row]]: tuple(old.room_ids[before] for before in rows)
            for row, rows in _several((common_m2 >= HALF * old.area_m2[:, None]).T)
        },
        edits=tuple(map(str, _edits(new, ids, names))),
        taken=taken,
    )


def _common_m2(old: TopologicalMap, new: TopologicalMap, alignment: Alignment) -> Areas:
    """The common area (old rooms, new rooms) of each two rooms, counted in cells of the new map."""
    shape = len(old.room_ids), len(new.room_ids)
    count = np.zeros(shape[0] * shape[1], np.int64)
    inside = np.flatnonzero(new.labels)
    for first in range(0, len(inside), CHUNK):
        part = inside[first : first + CHUNK]
        cells = np.stack(np.unravel_index(part, new.labels.shape), axis=1)
        under = labels_under(old, new.frame.world_from_cell(cells), np.array(alignment.shift_m))
        both = under > 0
        rows = np.searchsorted(old.room_ids, under[both])
        columns = np.searchsorted(new.room_ids, new.labels.reshape(-1)[part[both]])
        count += np.bincount(rows * shape[1] + columns, minlength=len(count))
    return count.reshape(shape).astype(np.float64) * new.frame.resolution_m**2


def _same(old: TopologicalMap, new: TopologicalMap, common_m2: Areas) -> Areas:
    """The intersection over union (old rooms, new rooms) of each two rooms' areas."""
    return np.asarray(common_m2 / (old.area_m2[:, None] + new.area_m2 - common_m2))


def _pairs(old: TopologicalMap, new: TopologicalMap, common_m2: Areas) -> dict[int, int]:
    """New room -> old room, one to one, with the largest sum of intersections over union."""
    smaller_m2 = np.minimum(old.area_m2[:, None], new.area_m2)
    share = np.where(common_m2 >= HALF * smaller_m2, _same(old, new, common_m2), 0.0)
    rows, columns = scipy.optimize.linear_sum_assignment(share, maximize=True)
    good = share[rows, columns] > 0
    return {new.room_ids[now]: old.room_ids[before] for before, now in zip(rows[good], columns[good], strict=True)}


def _ids(
    old: TopologicalMap, new: TopologicalMap, pairs: Mapping[int, int], *, taken: int, numbered: Collection[int]
) -> tuple[dict[int, int], int]:
    """The id for each new room, and the highest id used so far."""
    ids = {room: room for room in numbered}
    ids |= {now: before for now, before in pairs.items() if now not in ids and before not in numbered}
    taken = max([taken, *old.room_ids, *numbered])
    for room in new.room_ids:
        if room not in ids:
            taken += 1
            ids[room] = taken
    return ids, taken


def _several(within: NDArray[np.bool_]) -> Iterator[tuple[int, list[int]]]:
    """The rows of a table (k, m) with more than one column set, and these columns."""
    for row in np.flatnonzero(within.sum(axis=1) > 1).tolist():
        yield row, np.flatnonzero(within[row]).tolist()


def _edits(new: TopologicalMap, ids: Mapping[int, int], names: Mapping[int, str]) -> Iterator[Edit]:
    """The edits that set all rooms' ids, so that these do not depend on the order of rooms, and the names if any."""
    for room in new.rooms:
        yield Edit("number", (room.centre_m,), id=ids[room.id])
        if names.get(room.id):
            yield Edit("name", (room.centre_m,), name=names[room.id])
