"""The answer of `vdoor why` as text."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence

from vdoor.explain import Answer, Place
from vdoor.explain.corners import CornerFate, Sample
from vdoor.explain.distances import Point
from vdoor.explain.doors import DoorFate, Passage
from vdoor.explain.scores import Conflict, Reason, ScoreFate
from vdoor.explain.stages import percent, view_of
from vdoor.grid import FREE_TO, OCCUPIED_FROM
from vdoor.method.initial_map import IDLE
from vdoor.method.simplify import SimplifiedGrid

MOST_CONFLICTS = 5
"""Conflicting doors that are listed by number; of more, only the count."""


def to_lines(answer: Answer) -> Iterator[str]:
    """The answer, line by line: the place, its path, its corners, its doors."""
    yield from place_lines(answer.place)
    yield ""
    if answer.samples:
        yield f"path: nearest samples; samples below {answer.samples[0].below_deg:g} deg are candidates"
        yield from map(sample_line, answer.samples)
    more = [candidate for candidate in answer.candidates if candidate not in answer.samples]
    if more:
        yield "candidates farther away"
        yield from map(sample_line, more)
    if answer.corners:
        yield "corners: nearest"
        yield from map(corner_line, answer.corners)
    if "doors" in answer.recorded:
        yield "doors: nearest proposed and rejected" if answer.doors else "doors: none proposed or rejected"
    for door in answer.doors:
        yield from door_lines(door)
    for passage in answer.passages:
        yield (
            f"  {passage.kind}: final door {passage.door}, {passage.away_m:.2f} m away, {passage.width_m:.2f} m wide, "
            f"rooms {passage.rooms[0]} and {passage.rooms[1]}: {_why_no_edge(passage)}"
        )
    if "map" not in answer.recorded:
        yield f"the recording ends after {answer.recorded[-1]}: the results of later stages are unknown"


def place_lines(place: Place) -> Iterator[str]:
    """The map at the point itself."""
    col, row = place.col_row
    yield f"at {_at(place.point_m)} m, cell {col},{row} (col,row)"
    if place.value < 0:
        yield "  input: unknown"
    else:
        state = (
            "free"
            if place.value <= FREE_TO
            else "occupied"
            if place.value >= OCCUPIED_FROM
            else "neither free nor occupied"
        )
        yield f"  input: {state} ({place.value} of 100)"
    if place.working_col_row:
        col, row = place.working_col_row
        words = view_of(SimplifiedGrid).words
        means = f"; {place.reason}: {words[place.reason]}" if place.reason in words else ", unchanged"
        yield f"  simplified: {place.state} (working cell {col},{row}){means}"
    if place.room:
        yield f"  final map: room {place.room}"


def sample_line(sample: Sample) -> str:
    """One sample and the decision about it."""
    bend = f"{sample.angle_deg:5.1f} deg  K_f {sample.k_forward} K_b {sample.k_backward}"
    head = f"  sample {sample.sample}  {sample.away_m:.2f} m away at {_at(sample.point_m)}  {bend}"
    return f"{head}  {decision(sample)}"


def decision(sample: Sample) -> str:
    """The decision about a sample."""
    kind = "convex" if sample.convex else "concave"
    return {
        "straight": f"not a candidate: {sample.angle_deg:.1f} deg is not below {sample.below_deg:g}",
        "candidate": f"{kind} candidate",
        "corner": f"{kind} candidate and corner {sample.corner}, the sharpest within {sample.window_m:.2f} m",
        "plateau": f"{kind} candidate, not a corner: as sharp as its neighbours, whose middle is "
        f"corner {sample.corner}",
        "suppressed": f"{kind} candidate, not a corner: sample {sample.rival}, {sample.rival_gap_m:.2f} m along "
        f"the path (window {sample.window_m:.2f} m), is sharper, {sample.rival_angle_deg:.1f} deg",
    }[sample.decision]


def corner_line(corner: CornerFate) -> str:
    """One corner and its doors."""
    head = (
        f"  corner {corner.corner}  {corner.away_m:.2f} m away at {_at(corner.point_m)}  {corner.angle_deg:9.1f} deg  "
        f"{'convex' if corner.convex else 'concave'}"
    )
    if not corner.convex:
        return f"{head}: doors start at convex corners only"
    if corner.doors:
        return f"{head}: virtual doors {', '.join(map(str, corner.doors))}"
    other = f"the nearest, {corner.nearest_convex}, is {corner.nearest_convex_m:.2f} m away"
    return (
        f"{head}: no doors, as no other convex corner and no boundary other than its own wall is within "
        f"{corner.max_length_m:g} m ({other if corner.nearest_convex >= 0 else 'there is no other convex corner'})"
    )


def door_lines(door: DoorFate) -> Iterator[str]:
    """One door, one line per stage."""
    corners = f"corner{'s' * (len(door.corners) > 1)} {' and '.join(map(str, door.corners))}"
    place = f"{door.away_m:.2f} m away  {_at(door.start_m)} to {_at(door.end_m)}"
    yield f"  virtual door {door.door}  {place}  {door.kind}, {corners}  => {door.fate}"
    size = f"length {door.length_m:.2f} m (at most {door.max_length_m:g}), free gap {door.width_m:.2f} m, "
    yield f"    {size}tilt {door.tilt_deg:.1f} deg, {_detour(door)}"
    yield f"    {_VERDICTS[door.verdict](door)}"
    if door.score:
        yield from score_lines(door.score)
        if door.score.conflicts:
            kept = door.search is not None and not door.search.removed
            yield f"      conflicts: {_conflicts(door.score.conflicts, kept=kept)}"
    if door.idle:
        yield f"    initial map: idle, {_IDLE[door.idle_reason]}"
    if door.edge >= 0:
        yield f"    initial map: edge {door.edge}, borders regions {', '.join(map(str, door.regions))}"
    if door.search:
        yield f"    search: {_search(door)}"
    if door.fate in _ENDS:
        yield f"    final map: {_ENDS[door.fate](door)}"


def _detour(door: DoorFate) -> str:
    if door.gap_m is None:
        return "its ends are on different contours"
    wanted = "" if door.least_gap_m is None else f" (must exceed {door.least_gap_m:.2f})"
    return f"path between its ends {door.gap_m:.2f} m{wanted}"


def _blocked(door: DoorFate) -> str:
    where = f", first at working cell {door.blocked_at[0]},{door.blocked_at[1]}" if door.blocked_at else ""
    return f"rejected, blocked: cells between its ends are not free{where}"


_VERDICTS: dict[str, Callable[[DoorFate], str]] = {
    "proposed": lambda _: "proposed",
    "blocked": _blocked,
    "same wall": lambda door: (
        "rejected, same wall: the path between its ends "
        f"is {door.gap_m or 0:.2f} m, no longer than {door.least_gap_m or 0:.2f}"
    ),
    "no gap": lambda _: "rejected, no gap: its end cells touch",
    "duplicate": lambda door: f"rejected, duplicate: virtual door {door.twin} has the same ends",
    "too narrow": lambda door: (
        f"rejected, too narrow: its gap of {door.width_m:.2f} m is less than the "
        f"{door.least_width_m:g} m that the robot needs"
    ),
}


_IDLE = {
    IDLE[0]: "it borders fewer than two regions",
    IDLE[1]: "obstacles were removed beside it, and in the input it borders fewer than two regions",
}


def score_lines(score: ScoreFate) -> Iterator[str]:
    """Score of one door: its judgement and the strongest reasons."""
    rough = f"; the map is {percent(score.share_rough)} rough"
    bias = "" if score.bias is None else f", bias {score.bias:+.2f}"
    odds = f"log-odds {score.log_odds:+.2f} ({percent(1 / (1 + math.exp(-score.log_odds)))}{bias})"
    yield f"    score: {odds}, {_JUDGEMENTS[score.judgement](score)}{rough}"
    if score.sure:
        yield "      pass 1: sure, so it was closed in pass 2"
    if score.bias is None:
        yield "      reasons: not available, as the curves that this run used were not found"
    else:
        for word, reasons in (("for", score.reasons_for), ("against", score.reasons_against)):
            yield f"      {word}: {', '.join(map(_reason, reasons)) or 'nothing'}"


_JUDGEMENTS: dict[str, Callable[[ScoreFate], str]] = {
    "likely": lambda score: f"likely (at least {score.least_log_odds:+g}): passed to the search",
    "unlikely": lambda score: f"unlikely, below {score.least_log_odds:+g}: left out of the search",
    "outdone": lambda score: (
        f"outdone by virtual door {score.suppressed_by} at the same place, log-odds {score.outdone_by_log_odds:+.2f}: "
        "left out of the search"
    ),
}


def _reason(reason: Reason) -> str:
    return f"{reason.feature} {reason.value:.2f} gives {reason.log_odds:+.2f}"


def _conflicts(conflicts: Sequence[Conflict], *, kept: bool) -> str:
    """Doors in conflict with a likely one, grouped by the decision of the search; `kept` is that about the door."""
    words = {True: "kept as well" if kept else "kept instead", False: "removed" if kept else "removed as well"}
    parts = []
    for decided, word in (words | {None: "not in the search"}).items():
        own = [f"{other.door} ({other.log_odds:+.2f})" for other in conflicts if other.kept is decided]
        if own:
            more = f" and {len(own) - MOST_CONFLICTS} more" if len(own) > MOST_CONFLICTS else ""
            parts.append(f"virtual door{'s' * (len(own) > 1)} {', '.join(own[:MOST_CONFLICTS])}{more} {word}")
    return "; ".join(parts)


def _search(door: DoorFate) -> str:
    fate = door.search
    assert fate is not None
    change = fate.cost_flipped - fate.cost
    times = f"{fate.changes} change{'s' * (fate.changes != 1)}"
    when = (
        f"last changed in generation {fate.last_change} of {fate.last_generation} ({times})"
        if fate.changes
        else f"unchanged in the best string from generation 0 to {fate.last_generation}"
    )
    flip = f"{'keeping' if fate.removed else 'removing'} it alone changes the cost by {change:+.6f}"
    return f"{'removed' if fate.removed else 'kept'}, {when}; {flip} (from {fate.cost:.6f} to {fate.cost_flipped:.6f})"


def _final_door(door: DoorFate) -> str:
    pairs = zip(door.final_door, door.final_rooms, strict=True)
    return "; ".join(f"door {number} between rooms {one} and {other}" for number, (one, other) in pairs)


def _why_no_edge(passage: Passage) -> str:
    return "added by an edit" if passage.kind == "added" else "too narrow for the working resolution"


_ENDS: dict[str, Callable[[DoorFate], str]] = {
    "door": _final_door,
    "separates nothing": lambda _: "dropped: it does not separate two rooms",
    "edited away": lambda _: "dropped: an edit merged its rooms or split them differently",
    "no room there": lambda _: "dropped: a room beside it has no free cell in the input",
}


def _at(point_m: Point) -> str:
    return f"{point_m[0]:.2f},{point_m[1]:.2f}"
