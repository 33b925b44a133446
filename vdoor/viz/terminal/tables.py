"""The numbers of each stage of a recorded run, as tables and plots."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rich.console import RenderableType
from rich.table import Table
from rich.text import Text

from vdoor.editing.apply import DONE, NEEDLESS
from vdoor.editing.apply import VERDICTS as EDIT_VERDICTS
from vdoor.editing.edits import FORMS
from vdoor.editing.places import place_text
from vdoor.explain.scores import score_fate
from vdoor.explain.stages import view_of
from vdoor.history import History
from vdoor.method.doors import PROPOSED, VERDICTS, VirtualDoors
from vdoor.method.initial_map import InitialMap
from vdoor.method.simplify import REASONS, SimplifiedGrid
from vdoor.record import tables, texts_of
from vdoor.topology import KINDS
from vdoor.viz.terminal.scene import cost_plot, curvature_plot

COURSE = ("generation", "evaluations", "best", "mean", "worst", "small", "AreaSD m2", "DegSD deg", "kept", "changes")


@dataclass(frozen=True)
class Limits:
    """Maximum number of lines of a picture and rows of a table."""

    lines: int
    rows: int


def table(*columns: str) -> Table:
    """An empty table without rules, all columns left-aligned, so that it is readable in a pipe as well."""
    made = Table(box=None, pad_edge=False, header_style="bold", padding=(0, 2, 0, 0))
    for column in columns:
        made.add_column(column, overflow="fold")
    return made


def _more(count: int, limits: Limits) -> Iterator[RenderableType]:
    if count > limits.rows:
        yield Text(f"... {count - limits.rows} more; --rows {count} prints all", style="dim")


def _sizes(doors: VirtualDoors | InitialMap, row: int) -> list[str]:
    tilt_deg = np.degrees(doors.tilt_rad[row])
    return [f"{doors.length_m[row]:.2f}", f"{doors.width_m[row]:.2f}", f"{tilt_deg:.1f}"]


def point(run: History, cell: NDArray[Any]) -> str:
    """A position in working cells as text, x,y in metres."""
    x_m, y_m = run.simplified.frame.world_from_cell(cell)[0].tolist()
    return f"{x_m:.2f},{y_m:.2f}"


def _simplified_details(run: History, _: int | None, limits: Limits) -> Iterator[RenderableType]:
    rows = table("reason", "cells", "m2", "meaning")
    area_m2 = run.simplified.frame.resolution_m**2
    del limits
    for word, means in view_of(SimplifiedGrid).words.items():
        count = int((run.simplified.reason == REASONS.index(word)).sum())
        if count:
            rows.add_row(word, str(count), f"{count * area_m2:.2f}", means)
    if rows.row_count:
        yield rows


def _curvature_details(run: History, _: int | None, limits: Limits) -> Iterator[RenderableType]:
    del limits
    yield curvature_plot(run, 13)


def _corner_details(run: History, _: int | None, limits: Limits) -> Iterator[RenderableType]:
    rows = table("corner", "kind", "angle deg", "sample", "x,y m", "working cell col,row")
    corners = run.corners
    for row in range(min(len(corners.sample), limits.rows)):
        kind = "convex" if corners.convex[row] else "concave"
        angle = f"{np.degrees(corners.angle_rad[row]):.1f}"
        cell = corners.cell[row]
        rows.add_row(str(row), kind, angle, str(corners.sample[row]), point(run, cell), f"{cell[1]},{cell[0]}")
    yield rows
    yield from _more(len(corners.sample), limits)


def _door_details(run: History, _: int | None, limits: Limits) -> Iterator[RenderableType]:
    doors = run.doors
    order = np.lexsort((np.arange(len(doors.verdict)), doors.verdict))
    rows = table("door", "verdict", "kind", "length m", "width m", "tilt deg", "from x,y m", "to x,y m", "corners")
    for row in order[: limits.rows].tolist():
        ends = [point(run, cell) for cell in (doors.start[row], doors.end[row])]
        corners = f"{doors.corner_start[row]}" + (f" {doors.corner_end[row]}" if doors.corner_end[row] >= 0 else "")
        verdict = Text(VERDICTS[doors.verdict[row]], style="green" if doors.verdict[row] == PROPOSED else "red")
        rows.add_row(str(row), verdict, KINDS[doors.kind[row]], *_sizes(doors, row), *ends, corners)
    yield rows
    yield from _more(len(order), limits)


def _score_details(run: History, _: int | None, limits: Limits) -> Iterator[RenderableType]:
    """Scored doors, likeliest first, each with its strongest features for and against."""
    scores = run.scores
    order = np.argsort(-scores.log_odds.round(9), kind="stable")
    rows = table("door", "judgement", "log-odds", "kind", "length m", "middle x,y m", "conflicts", "for", "against")
    for row in order[: limits.rows].tolist():
        door = int(scores.door[row])
        fate = score_fate(run, door)
        assert fate is not None
        word = Text(fate.judgement, style={"likely": "green", "outdone": "yellow"}.get(fate.judgement, "red"))
        rows.add_row(
            str(door),
            word,
            f"{fate.log_odds:+.2f}",
            KINDS[run.doors.kind[door]],
            f"{run.doors.length_m[door]:.2f}",
            point(run, (run.doors.start[door] + run.doors.end[door]) / 2),
            str(len(fate.conflicts)),
            *(
                f"{reasons[0].feature} {reasons[0].log_odds:+.1f}" if reasons else ""
                for reasons in (fate.reasons_for, fate.reasons_against)
            ),
        )
    yield rows
    yield from _more(len(order), limits)


def _certificate_details(run: History, _: int | None, limits: Limits) -> Iterator[RenderableType]:
    del limits
    found = run.certificate
    rows = table("cost", "lower bound", "gap", "proven optimal")
    numbers = (f"{number:.6f}" for number in (found.cost, found.lower_bound, found.gap))
    rows.add_row(*numbers, Text("yes", style="green") if found.optimal else Text("no", style="yellow"))
    yield rows


def _initial_details(run: History, _: int | None, limits: Limits) -> Iterator[RenderableType]:
    initial = run.initial
    rows = table("edge", "door", "kind", "length m", "width m", "tilt deg", "from x,y m", "to x,y m", "borders regions")
    for edge in range(min(len(initial.door), limits.rows)):
        ends = [point(run, cell) for cell in (initial.start[edge], initial.end[edge])]
        regions = " ".join(map(str, initial.border_region[initial.border_edge == edge]))
        rows.add_row(
            str(edge), str(initial.door[edge]), KINDS[initial.kind[edge]], *_sizes(initial, edge), *ends, regions
        )
    yield rows
    yield from _more(len(initial.door), limits)


def _search_details(run: History, generation: int | None, limits: Limits) -> Iterator[RenderableType]:
    last = len(run.search) - 1 if generation is None else generation
    yield cost_plot(run, 10, generation)
    yield terms(run, last)
    yield Text(f"best string, 1 = removed: {string(run.search[last].removed)}\n", overflow="fold")
    rows = table(*COURSE)
    changes = _changes(run) if generation is None else [generation]
    for number in changes[: limits.rows]:
        found = run.search[number]
        costs = [f"{cost:.4f}" for cost in (found.best_cost, found.mean_cost, found.worst_cost)]
        sizes = [str(found.small_rooms), f"{found.area_sd_m2:.3f}", f"{found.tilt_sd_deg:.3f}"]
        kept = str(int((~found.removed).sum()))
        rows.add_row(str(found.number), str(found.evaluations), *costs, *sizes, kept, flips(run, number))
    if generation is None:
        yield Text("generations in which the best string changed (+ edge kept again, - edge removed):")
    yield rows
    yield from _more(len(changes), limits)


def _changes(run: History) -> list[int]:
    """Generations whose best string differs from the one before, and the first."""
    changed, before = [], b""
    for number, generation in enumerate(run.search):
        if not number or generation.removed.tobytes() != before:
            changed.append(number)
        before = generation.removed.tobytes()
    return changed


def flips(run: History, generation: int) -> str:
    """Edges whose bit in the best string changed since the generation before: + now kept, - now removed."""
    if not generation:
        return ""
    removed, before = run.search[generation].removed, run.search[generation - 1].removed
    return " ".join(f"{'-' if removed[edge] else '+'}{edge}" for edge in np.flatnonzero(removed != before).tolist())


def string(removed: NDArray[np.bool_]) -> str:
    """String as printed in the paper: one bit per door, 1 = removed."""
    return "".join("01"[bit] for bit in removed.astype(int))


def terms(run: History, generation: int) -> Text:
    """Cost of the best string of one generation as the sum of its terms."""
    found = run.search[generation]
    text = Text(f"generation {found.number}: cost {found.best_cost:.6f} =", style="bold")
    for at, term in enumerate(run.terms(generation)):
        sign = "- " if term.weight < 0 else "+ " if at else ""
        text.append(f" {sign}{abs(term.weight):g} x {term.value:.6g} {f'{term.unit} {term.name}'.strip()}", "not bold")
    return text


def _edit_details(run: History, _: int | None, limits: Limits) -> Iterator[RenderableType]:
    edits = run.edits
    rows = table("edit", "kind", "at x,y m", "and x,y m", "verdict", "rooms")
    for row in range(min(len(edits.kind), limits.rows)):
        ends = ("" if np.isnan(end).any() else place_text(tuple(end)) for end in (edits.start_m[row], edits.end_m[row]))
        verdict = EDIT_VERDICTS[edits.verdict[row]]
        style = "green" if verdict in (DONE, NEEDLESS) else "red"
        rooms = " ".join(map(str, edits.touched_room[edits.touched_edit == row].tolist()))
        rows.add_row(str(row), tuple(FORMS)[edits.kind[row]], *ends, Text(verdict, style=style), rooms)
    yield rows
    yield from _more(len(edits.kind), limits)


def _map_details(run: History, _: int | None, limits: Limits) -> Iterator[RenderableType]:
    rooms = table("room", "name", "area m2", "centre x,y m", "neighbours")
    for each in run.topology.rooms[: limits.rows]:
        centre = f"{each.centre_m[0]:.2f},{each.centre_m[1]:.2f}"
        neighbours = " ".join(map(str, each.neighbours)) or "none"
        rooms.add_row(str(each.id), each.name, f"{each.area_m2:.2f}", centre, neighbours)
    yield rooms
    yield from _more(len(run.topology.area_m2), limits)
    doors = table("door", "rooms", "kind", "width m", "length m", "tilt deg", "middle x,y m", "edge")
    for door in run.topology.doors[: limits.rows]:
        middle = ",".join(f"{(one + other) / 2:.2f}" for one, other in zip(door.start_m, door.end_m, strict=True))
        sizes = [f"{door.width_m:.2f}", f"{door.length_m:.2f}", f"{door.tilt_deg:.1f}"]
        edge = run.topology.edge[door.id - 1]
        doors.add_row(
            str(door.id),
            f"{door.rooms[0]} {door.rooms[1]}",
            door.kind,
            *sizes,
            middle,
            str(edge) if edge >= 0 else "none",
        )
    yield doors
    yield from _more(len(run.topology.kind), limits)


def plain_details(run: History, topic: str, limits: Limits) -> Iterator[RenderableType]:
    """Tables of a record, column by column, for stages without a function of their own."""
    if topic in PLAIN:
        return
    record = run.records[topic]
    for name, columns in tables(type(record)).items():
        rows = table(name, *columns)
        values = [texts_of(record, column) for column in columns]
        for row in range(min(len(values[0]), limits.rows)):
            rows.add_row(str(row), *(column[row] for column in values))
        yield rows
        yield from _more(len(values[0]), limits)


PLAIN = ("input", "path", "candidates", "skeleton", "narrows", "eroded", "grown")
"""Stages without tables: the map and the summary show everything."""

DETAILS: dict[str, Callable[[History, int | None, Limits], Iterator[RenderableType]]] = {
    "simplified": _simplified_details,
    "curvature": _curvature_details,
    "corners": _corner_details,
    "doors": _door_details,
    "door_scores": _score_details,
    "initial_map": _initial_details,
    "generation": _search_details,
    "certificate": _certificate_details,
    "edits": _edit_details,
    "map": _map_details,
}
