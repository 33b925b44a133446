"""Marks of virtual doors, of their scores, and of what the baselines propose in their place."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from vdoor.baselines.critical_lines import FATES, NARROW
from vdoor.history.records import RunRecords
from vdoor.method.doors import PROPOSED, VERDICTS
from vdoor.method.scoring.score import JUDGEMENTS, LIKELY
from vdoor.viz.marks.kinds import Cells, Dots, Lines, Mark, by_code, path_name, segments, wrapped
from vdoor.viz.rerun import style

WHY = {
    "blocked": "blocked: crosses a wall",
    "same wall": "same wall: both ends on one wall",
    "no gap": "no gap: its ends touch",
    "duplicate": "duplicate: same ends as another",
    "too narrow": "too narrow for the robot",
    "unlikely": "unlikely",
    "outdone": "outdone by a likelier one at the same place",
}
"""Why doors are left out, by verdict or judgement."""
ODDS = ((-np.inf, 0.0, "doubtful: log-odds under 0"), (0.0, 2.0, "likely: 0 to 2"), (2.0, np.inf, "sure: over 2"))
"""From and to log-odds, and what doors between them are called."""


def doors(run: RunRecords) -> Iterator[Mark]:
    """Virtual doors by verdict, the proposed ones on top."""
    found = run.doors
    for code, verdict, rows in by_code(found.verdict, VERDICTS):
        proposed = code == PROPOSED
        yield Lines(
            name=path_name(verdict),
            frame=found.frame,
            strips=segments(found.start[rows], found.end[rows]),
            colour=style.DOOR if proposed else style.REJECTED[verdict],
            meaning=f"{WHY.get(verdict, verdict)} ({len(rows)})",
            tips=[f"virtual door {row}: {verdict}, {found.width_m[row]:.2f} m" for row in rows],
            wide_px=2.5 if proposed else 1.8,
        )


def scores(run: RunRecords) -> Iterator[Lines]:
    """Scored doors by judgement, likely ones by their odds on top, and lines between doors in conflict."""
    found, proposed = run.scores, run.doors
    start, end = proposed.start[found.door], proposed.end[found.door]
    tips = [f"virtual door {door}: log-odds {odds:+.2f}" for door, odds in zip(found.door, found.log_odds, strict=True)]

    def lines(name: str, rows: np.ndarray, colour: style.Colour, meaning: str, wide_px: float) -> Lines:
        own = [tips[row] for row in rows]
        strips = segments(start[rows], end[rows])
        text = f"{meaning} ({len(rows)})"
        return Lines(
            name=name, frame=found.frame, strips=strips, colour=colour, meaning=text, tips=own, wide_px=wide_px
        )

    for code, judgement, rows in by_code(found.judgement, JUDGEMENTS):
        if code != LIKELY:
            yield lines(judgement, rows, style.JUDGED[judgement], WHY[judgement], 1.8)
    for low, high, meaning in ODDS:
        rows = np.flatnonzero((found.judgement == LIKELY) & (found.log_odds > low) & (found.log_odds <= high))
        middle = float(np.clip((low + high) / 2, -style.SURE_LOG_ODDS, style.SURE_LOG_ODDS))
        yield lines(meaning.partition(":")[0], rows, style.odds(middle), meaning, 4.0)
    centre = (start + end) / 2
    yield Lines(
        name="conflicts",
        frame=found.frame,
        strips=segments(centre[found.rival_a], centre[found.rival_b]),
        colour=style.CONFLICTS,
        meaning=f"two doors of which only one can be kept ({len(found.rival_a)})",
        wide_px=1.5,
    )


def skeleton(run: RunRecords) -> Iterator[Mark]:
    """The skeleton of the free space."""
    found = run.skeleton
    tips = [f"{clearance_m:.2f} m to the wall" for clearance_m in found.clearance_m]
    yield Dots(
        name="points",
        frame=found.frame,
        cell=found.cell,
        colour=style.CONCAVE,
        meaning=f"skeleton ({len(found.cell)} points)",
        tips=tips,
        wide_px=2.5,
    )


def narrow_places(run: RunRecords) -> Iterator[Mark]:
    """Narrow places of the skeleton, with a line from wall to wall, by what became of them."""
    found = run.critical_lines
    for code, fate, rows in by_code(found.fate, FATES):
        colour = style.DOOR if code == NARROW else style.REMOVED
        name, meaning = path_name(fate), f"{fate} ({len(rows)})"
        strips = segments(found.start[rows], found.end[rows])
        yield Lines(name=f"{name}/across", frame=found.frame, strips=strips, colour=colour, meaning=meaning)
        yield Dots(name=f"{name}/place", frame=found.frame, cell=found.cell[rows], colour=colour, wide_px=5)


def cores(run: RunRecords) -> Iterator[Mark]:
    """The eroded free space: cores of rooms in their colours, and parts that are too small in grey."""
    found = run.eroded
    colours = {
        part: (style.room(part), f"core {part}") if kept else (style.REMOVED, "too small for a room")
        for part, kept in enumerate(found.kept.tolist(), start=1)
    }
    yield Cells(name="parts", frame=found.frame, codes=wrapped(found.core), colours=colours, opacity=0.8, listed=False)


def grown(run: RunRecords) -> Iterator[Mark]:
    """The rooms grown back from their cores."""
    rooms = int(run.grown.room.max(initial=0))
    colours = {room: (style.room(room), f"room {room}") for room in range(1, rooms + 1)}
    codes = wrapped(run.grown.room)
    yield Cells(name="rooms", frame=run.grown.frame, codes=codes, colours=colours, opacity=0.8, listed=False)
