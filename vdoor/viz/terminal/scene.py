"""Drawings of each stage of a recorded run on the map, and its plots."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from vdoor.baselines.critical_lines import NARROW
from vdoor.grid import FREE, OCCUPIED, UNKNOWN
from vdoor.history import History
from vdoor.method.corners import Corners
from vdoor.method.doors import PROPOSED
from vdoor.method.scoring.score import JUDGEMENTS, LIKELY
from vdoor.method.simplify import REASONS
from vdoor.record import Record, specs
from vdoor.viz.terminal.canvas import Canvas
from vdoor.viz.terminal.plot import Curve, Plot

SHARP_DEG = 90.0
FAR = 1e6
"""Distance in cells beyond any map."""
NEARBY = 40
"""Number of samples on either side in a plot around one sample."""
INK_OF_REASON = {
    "unreachable": "unreachable",
    "jut": "jut flattened",
    "notch": "notch filled",
    "island": "island removed",
    "thin unknown": "thin unknown freed",
    "slit": "slit closed",
}


def drawn(run: History, topic: str, generation: int = -1) -> Canvas:
    """Drawing of one stage on the map; for the search, of the best string of one generation."""
    if topic == "input":
        cells = np.where(run.input.free, FREE, np.where(run.input.occupied, OCCUPIED, UNKNOWN))
        return Canvas.of(cells)
    if topic == "map":
        return _drawn_map(run)
    canvas = Canvas.of(run.simplified.cells)
    if topic in ("generation", "certificate"):
        return _drawn_choice(run, canvas, generation)
    return DRAWN[topic](run, canvas) if topic in DRAWN else _drawn_any(run.records[topic], canvas)


def _drawn_any(record: Record, canvas: Canvas) -> Canvas:
    """Drawing of a stage without a function of its own: label rasters as tints, table rows with cells as dots."""
    for name, (spec, _) in specs(type(record)).items():
        values = np.asarray(getattr(record, name))
        if spec.kind == "labels":
            canvas.tint(values, values > 0)
        elif spec.kind == "cell":
            canvas.paint("path", values)
    return canvas


def _drawn_simplified(run: History, canvas: Canvas) -> Canvas:
    for word, ink in INK_OF_REASON.items():
        canvas.fill(ink, run.simplified.reason == REASONS.index(word))
    return canvas


def _drawn_curvature(run: History, canvas: Canvas) -> Canvas:
    angle_deg = np.degrees(run.curvature.angle_rad)
    canvas.paint("bend", run.curvature.cell[angle_deg < run.pipeline.candidates.angle_deg])
    return canvas.paint("sharp bend", run.curvature.cell[angle_deg < SHARP_DEG])


def _drawn_candidates(run: History, canvas: Canvas) -> Canvas:
    found = run.candidates
    canvas.paint("concave candidate", found.cell[~found.convex])
    return canvas.paint("convex candidate", found.cell[found.convex])


def _drawn_corners(run: History, canvas: Canvas) -> Canvas:
    corners = run.corners
    canvas.paint("concave corner", corners.cell[~corners.convex])
    return canvas.paint("convex corner", corners.cell[corners.convex])


def _drawn_doors(run: History, canvas: Canvas) -> Canvas:
    doors = run.doors
    if run.has(Corners):
        _drawn_corners(run, canvas)
    rejected = doors.verdict != PROPOSED
    canvas.line("rejected door", doors.start[rejected], doors.end[rejected])
    return canvas.paint("door", doors.line_cell)


def _drawn_scores(run: History, canvas: Canvas) -> Canvas:
    """Scored doors by judgement, likely doors over the others."""
    scores, doors = run.scores, run.doors
    for code, judgement in enumerate(JUDGEMENTS):
        own = scores.door[scores.judgement == code]
        canvas.line("door" if code == LIKELY else f"{judgement} door", doors.start[own], doors.end[own])
    return canvas


def _drawn_narrows(run: History, canvas: Canvas) -> Canvas:
    narrows, doors = run.critical_lines, run.critical_lines.fate == NARROW
    canvas.paint("path", run.skeleton.cell)
    canvas.line("rejected door", narrows.start[~doors], narrows.end[~doors])
    return canvas.line("door", narrows.start[doors], narrows.end[doors])


def _drawn_initial(run: History, canvas: Canvas) -> Canvas:
    initial = run.initial
    in_region = (initial.piece > 0) & (initial.piece <= len(initial.area_m2))
    canvas.tint(initial.piece - 1, in_region)
    canvas.line("door", initial.start, initial.end)
    return canvas.write(initial.centre, map(str, range(len(initial.centre))))


def _drawn_choice(run: History, canvas: Canvas, generation: int) -> Canvas:
    """Doors that a generation's best string keeps and removes, over the resulting rooms in colour."""
    initial, removed = run.initial, run.search[generation].removed
    room, is_open = run.problem.rooms(removed[None])
    node = np.append(np.arange(run.problem.regions), run.problem.node_of_atom)
    _, number = np.unique(np.where(is_open[0], room[0], -1)[node], return_inverse=True)
    of_piece = np.append(0, number)
    canvas.tint(of_piece[initial.piece], initial.piece > 0)
    canvas.line("removed door", initial.start[removed], initial.end[removed])
    return canvas.line("door", initial.start[~removed], initial.end[~removed])


def _drawn_edits(run: History, canvas: Canvas) -> Canvas:
    """Places of the edits on the input map."""
    del canvas
    frame, edits = run.input.frame, run.edits
    start, end = frame.cell_from_world(edits.start_m), frame.cell_from_world(edits.end_m)
    near = np.abs(start).max(axis=1, initial=0) < FAR
    lines = near & (np.abs(end).max(axis=1, initial=0) < FAR)  # false for nan
    ground = drawn(run, "input").line("door", start[lines], end[lines])
    return ground.paint("selected", np.concatenate([start[near], end[lines]]))


def _drawn_map(run: History) -> Canvas:
    """Rooms at the input's resolution, with doors and room numbers over them."""
    found, canvas = run.topology, drawn(run, "input")
    canvas.tint(found.labels, found.labels > 0)
    start, end = (found.frame.cell_from_world(points_m) for points_m in (found.start_m, found.end_m))
    canvas.line("door", start, end)
    canvas.paint("door", np.concatenate([start, end])[np.tile(found.edge < 0, 2)])
    return canvas.write(found.centre, map(str, found.room_ids))


def _drawn_route(run: History, canvas: Canvas) -> Canvas:
    """The path over the rooms, and what is in the way."""
    del canvas
    route = run.route
    cells = [route.frame.cell_from_world(points_m) for points_m in (route.point_m, route.obstacle_m)]
    point, in_the_way = (cell[np.abs(cell).max(axis=1, initial=0) < FAR] for cell in cells)  # false for nan
    ground = _drawn_map(run).line("forward", point[:-1], point[1:], ends=True)
    return ground.paint("selected", in_the_way)


def _drawn_coverage(run: History, canvas: Canvas) -> Canvas:
    """The path over the rooms."""
    del canvas
    point = run.coverage.frame.cell_from_world(run.coverage.point_m)
    return _drawn_map(run).line("forward", point[:-1], point[1:])


DRAWN: dict[str, Callable[[History, Canvas], Canvas]] = {
    "simplified": _drawn_simplified,
    "path": lambda run, canvas: canvas.paint("path", run.path.free_cell),
    "curvature": _drawn_curvature,
    "candidates": _drawn_candidates,
    "corners": _drawn_corners,
    "doors": _drawn_doors,
    "door_scores": _drawn_scores,
    "skeleton": lambda run, canvas: canvas.paint("path", run.skeleton.cell),
    "narrows": _drawn_narrows,
    "eroded": lambda run, canvas: canvas.tint(run.eroded.core, run.eroded.core > 0),
    "grown": lambda run, canvas: canvas.tint(run.grown.room, run.grown.room > 0),
    "initial_map": _drawn_initial,
    "edits": _drawn_edits,
    "route": _drawn_route,
    "coverage": _drawn_coverage,
}


def curvature_plot(run: History, lines: int, chosen: int | None = None) -> Plot:
    """Plot of the angle along the path, contour after contour, with the threshold; around sample `chosen` if given."""
    first, last = (0, None) if chosen is None else (max(chosen - NEARBY, 0), chosen + NEARBY + 1)
    angle_deg, level = np.degrees(run.curvature.angle_rad[first:last]), run.pipeline.candidates.angle_deg
    below, above = np.where(angle_deg < level, angle_deg, np.nan), np.where(angle_deg < level, np.nan, angle_deg)
    curves = [
        Curve("candidate", below, "*", "bold red", _least),
        Curve("straight", above, ".", "bright_black", _least),
    ]
    return Plot(curves, lines, " deg", span=(0.0, 180.0), level=level, across="sample", first=first, chosen=chosen)


def _least(values: NDArray[np.float64]) -> float:
    finite = values[~np.isnan(values)]
    return float(finite.min()) if len(finite) else float("nan")


def cost_plot(run: History, lines: int, chosen: int | None = None) -> Plot:
    """Plot of best and mean cost by generation."""
    curves = [
        Curve("best", run.search.numbers("best_cost"), "*", "bold green"),
        Curve("mean", run.search.numbers("mean_cost"), ".", "bright_black", np.mean),
    ]
    return Plot(curves, lines, across="generation", chosen=chosen)
