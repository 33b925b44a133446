"""Decisions about virtual doors: proposed or rejected, likely or not, edge or idle, kept or removed; the final door."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vdoor.editing.apply import Edits
from vdoor.explain.distances import Point, point_of, reach
from vdoor.explain.scores import ScoreFate, score_fate
from vdoor.grid import FREE
from vdoor.history import History
from vdoor.method.corners import gaps_m
from vdoor.method.doors import PROPOSED, VERDICTS
from vdoor.method.initial_map import IDLE, InitialMap
from vdoor.topology import KINDS, TopologicalMap

Floats = NDArray[np.float64]
Ints = NDArray[np.int32]


@dataclass(frozen=True, kw_only=True)
class SearchFate:
    """Decision of the search about one door."""

    removed: bool
    last_change: int
    """Generation in which the door's bit of the best string last changed; 0 if it never did."""
    changes: int
    last_generation: int
    cost: float
    """Cost of the final string, evaluated again."""
    cost_flipped: float
    """Cost of the final string with only this door's bit flipped."""


@dataclass(frozen=True, kw_only=True)
class DoorFate:
    """A virtual door, and the decision of each stage about it."""

    door: int
    away_m: float
    kind: str
    verdict: str
    start_m: Point
    end_m: Point
    corners: tuple[int, ...]
    length_m: float
    max_length_m: float
    width_m: float
    tilt_deg: float
    gap_m: float | None
    """Path length between its ends along the boundary, the shorter way round; None between two contours."""
    least_gap_m: float | None
    """Value that `gap_m` must exceed: the detour times the length; None for extensions, which have no such limit."""
    least_width_m: float = 0.0
    """Minimum width of the free gap."""
    blocked_at: tuple[int, int] | None = None
    """First blocked working cell (col, row) on its line."""
    twin: int = -1
    """For duplicates, the door with the same ends that was kept; -1 otherwise."""
    score: ScoreFate | None = None
    """For proposed doors of runs that score doors."""
    edge: int = -1
    regions: tuple[int, ...] = ()
    idle: bool = False
    """Proposed, but it borders fewer than two regions, in the working grid or in the input."""
    idle_reason: str = IDLE[0]
    """Which of the two, if recorded."""
    search: SearchFate | None = None
    separates_nothing: bool = False
    """Kept by the search, but dropped from the final map."""
    final_door: tuple[int, ...] = ()
    final_rooms: tuple[tuple[int, int], ...] = ()
    fate: str = ""
    """Final outcome: a verdict, unlikely, outdone, idle, removed, separates nothing, no room there, edited away, door,
    or open (not decided in this recording)."""


@dataclass(frozen=True, kw_only=True)
class Passage:
    """A door of the final map without a virtual door.

    It is too narrow for the working resolution, or was added by an edit.
    """

    door: int
    away_m: float
    rooms: tuple[int, int]
    width_m: float
    kind: str = "passage"


def door_fates(run: History, point_m: Point, count: int) -> tuple[DoorFate, ...]:
    """The `count` nearest proposed and the `count` nearest rejected doors, sorted by distance."""
    doors, frame = run.doors, run.doors.frame
    ends_m = [frame.world_from_cell(end) for end in (doors.start, doors.end)]
    away_m = to_segments_m(np.array(point_m), *ends_m).round(9)
    order = np.argsort(away_m, kind="stable")
    proposed = doors.verdict[order] == PROPOSED
    chosen = np.concatenate([order[proposed][:count], order[~proposed][:count]])
    chosen = chosen[np.argsort(away_m[chosen], kind="stable")]
    return tuple(door_fate(run, int(door), float(away_m[door])) for door in chosen)


def door_fate(run: History, door: int, away_m: float = 0.0) -> DoorFate:
    """One virtual door and the recorded decisions about it."""
    doors, kind = run.doors, KINDS[run.doors.kind[door]]
    limits = reach(run.pipeline.doors, kind)
    verdict = VERDICTS[doors.verdict[door]]
    corners = [corner for corner in (doors.corner_start[door], doors.corner_end[door]) if corner >= 0]
    later = _after(run, door) if doors.verdict[door] == PROPOSED else {"fate": verdict}
    return DoorFate(
        door=door,
        away_m=away_m,
        kind=kind,
        verdict=verdict,
        start_m=point_of(run, doors.start[door]),
        end_m=point_of(run, doors.end[door]),
        corners=tuple(map(int, corners)),
        length_m=float(doors.length_m[door]),
        max_length_m=limits.max_length_m,
        width_m=float(doors.width_m[door]),
        tilt_deg=float(np.degrees(doors.tilt_rad[door])),
        gap_m=path_gap_m(run, door),
        least_width_m=limits.least_width_m,
        least_gap_m=None if limits.detour is None else limits.detour * float(doors.length_m[door]),
        blocked_at=blocked_at(run, door) if verdict == "blocked" else None,
        twin=twin_of(run, door) if verdict == "duplicate" else -1,
        **later,
    )


def _after(run: History, door: int) -> dict[str, Any]:
    """Decisions about a proposed door, from its score or the initial map on."""
    score = score_fate(run, door)
    found: dict[str, Any] = {"score": score, "fate": "open"}
    if score is not None and score.judgement != "likely":
        return found | {"fate": score.judgement}
    if not run.has(InitialMap):
        return found
    edge = run.edge_of_door.get(door)
    if edge is None:
        return found | {"idle": True, "fate": "idle", "idle_reason": _idle_reason(run, door)}
    regions = tuple(run.initial.border_region[run.initial.border_edge == edge].tolist())
    found |= {"edge": edge, "regions": regions}
    if not len(run.search):
        return found
    search = search_fate(run, edge)
    return found | {"search": search} | _end(run, edge, search)


def _idle_reason(run: History, door: int) -> str:
    """Why a door is not an edge of the initial map."""
    row = run.initial.idle_door.tolist().index(door)
    return run.initial.idle_reason[row] if run.initial.idle_reason else IDLE[0]


def _end(run: History, edge: int, search: SearchFate) -> dict[str, Any]:
    """Outcome of an edge in the final map."""
    if not run.has(TopologicalMap):
        return {}
    if search.removed:
        return {"fate": "removed"}
    rows = np.flatnonzero(run.topology.edge == edge)
    if not len(rows):
        separates = edge in run.separating
        lost = "edited away" if run.has(Edits) else "no room there"
        return {"separates_nothing": not separates, "fate": lost if separates else "separates nothing"}
    rooms = tuple((int(run.topology.room_a[row]), int(run.topology.room_b[row])) for row in rows)
    return {"final_door": tuple((rows + 1).tolist()), "final_rooms": rooms, "fate": "door"}


def search_fate(run: History, edge: int) -> SearchFate:
    """Decision of the search about one edge, and the cost with only this edge flipped."""
    choices = run.search.choices(edge)
    changes = np.flatnonzero(choices[1:] != choices[:-1]) + 1
    final = run.search[-1]
    flipped = final.removed.copy()
    flipped[edge] ^= True
    cost, cost_flipped = run.problem.evaluate(np.stack([final.removed, flipped])).cost.tolist()
    numbers = run.search.numbers("number").astype(int)
    return SearchFate(
        removed=bool(choices[-1]),
        last_change=int(numbers[changes[-1]]) if len(changes) else 0,
        changes=len(changes),
        last_generation=int(numbers[-1]),
        cost=cost,
        cost_flipped=cost_flipped,
    )


def path_gap_m(run: History, door: int) -> float | None:
    """Path length between a door's ends, the shorter way round; None if they are on different contours."""
    path, corners, doors = run.path, run.corners, run.doors
    start = corners.sample[doors.corner_start[door]]
    if doors.corner_end[door] >= 0:
        ends = corners.sample[[doors.corner_end[door]]]
    else:
        apart = ((path.cell - doors.end[door]).astype(np.int64) ** 2).sum(axis=1)
        ends = np.flatnonzero(apart == apart.min()).astype(np.int32)  # the end of an extension may be off the path
    ends = ends[path.contour[ends] == path.contour[start]]
    if not len(ends):
        return None
    return float(gaps_m(path, np.full(len(ends), start, np.int32), ends).min())


def blocked_at(run: History, door: int) -> tuple[int, int] | None:
    """First cell (col, row) on a door's line that is not free; None if there is none.

    Where the line passes between two cells, it is blocked if neither is free.
    """
    free = run.simplified.cells == FREE
    start, span = run.doors.start[door], run.doors.end[door] - run.doors.start[door]
    steps = int(np.abs(span).max())
    for step in range(1, steps):
        place = start + step * span / steps
        sides = np.unique([np.ceil(place - 0.5), np.floor(place + 0.5)], axis=0).astype(int)
        if not free[tuple(sides.T)].any():
            return int(sides[0, 1]), int(sides[0, 0])
    return None


def twin_of(run: History, door: int) -> int:
    """The proposed door with the same ends, -1 if there is none."""
    doors = run.doors
    same = (doors.start == doors.start[door]).all(axis=1) & (doors.end == doors.end[door]).all(axis=1)
    same |= (doors.start == doors.end[door]).all(axis=1) & (doors.end == doors.start[door]).all(axis=1)
    twins = np.flatnonzero(same & (doors.verdict == PROPOSED))
    return int(twins[0]) if len(twins) else -1


def to_segments_m(point_m: Floats, start_m: Floats, end_m: Floats) -> Floats:
    """Distance (k,) of a point (2,) to segments with ends (k, 2), all in metres."""
    along = end_m - start_m
    length = np.maximum((along**2).sum(axis=1), 1e-12)
    share = np.clip(((point_m - start_m) * along).sum(axis=1) / length, 0, 1)
    return np.asarray(np.hypot(*(start_m + share[:, None] * along - point_m).T))


def passages(run: History, point_m: Point, count: int) -> tuple[Passage, ...]:
    """The `count` nearest doors of the final map without a virtual door."""
    found = run.topology
    rows = np.flatnonzero(found.edge < 0)
    away_m = to_segments_m(np.array(point_m), found.start_m[rows], found.end_m[rows]).round(9)
    return tuple(
        Passage(
            door=int(rows[at]) + 1,
            away_m=float(away_m[at]),
            rooms=(int(found.room_a[rows[at]]), int(found.room_b[rows[at]])),
            width_m=float(found.width_m[rows[at]]),
            kind=KINDS[found.kind[rows[at]]],
        )
        for at in np.argsort(away_m, kind="stable")[:count]
    )
