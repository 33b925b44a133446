"""Numbers of the element that the stepper shows, as pairs of a name and a value."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from vdoor.explain.corners import sample_fate
from vdoor.explain.doors import door_fate
from vdoor.explain.text import decision, door_lines
from vdoor.history import SEARCH, History
from vdoor.method.boundary import HEADINGS
from vdoor.method.corners import Corners
from vdoor.method.doors import VERDICTS
from vdoor.viz.terminal.show import summary
from vdoor.viz.terminal.tables import flips, string
from vdoor.viz.terminal.walk import Walk

Facts = Iterator[tuple[str, str]]


def facts(run: History, walk: Walk) -> Facts:
    """Facts about the current element; pairs without a name are sentences."""
    yield "step", str(run.steps[walk.stage] + (walk.generation if walk.stage == SEARCH else 0))
    if walk.stage in FACTS:
        yield from FACTS[walk.stage](run, walk)
    else:
        yield "", summary(run, walk.stage)


def _path(run: History, walk: Walk) -> Facts:
    path, sample = run.path, walk.sample
    contour = int(path.contour[sample])
    row, col = path.cell[sample].tolist()
    x_m, y_m = path.frame.world_from_cell((path.half[sample] - 1) / 2)[0].tolist()
    yield "sample", f"{sample} of {len(path.cell)}"
    yield "contour", f"{contour} ({'outer' if path.outer[contour] else 'island'})"
    yield "at x,y", f"{x_m:.3f},{y_m:.3f} m"
    yield "wall cell", f"{col},{row} (col,row)"
    row, col = path.free_cell[sample].tolist()
    yield "walker", f"{col},{row}, facing {HEADINGS[path.heading[sample]]}"
    yield "turned left", "yes" if path.turned_left[sample] else "no"
    yield "arc", f"{path.arc_m[sample]:.3f} of {path.length_m[contour]:.3f} m"


def _curvature(run: History, walk: Walk) -> Facts:
    yield from _path(run, walk)
    found, sample = run.curvature, walk.sample
    half_m = found.frame.resolution_m / 2
    for name, count, vector in (("f", found.k_forward, found.forward), ("b", found.k_backward, found.backward)):
        down, right = vector[sample].tolist()
        yield f"K_{name}", str(count[sample])
        yield f"vector {name}", f"({down}, {right}) half cells (row, col), {np.hypot(down, right) * half_m:.3f} m"
    yield "angle", f"{np.degrees(found.angle_rad[sample]):.4f} deg"
    yield "threshold", f"{run.pipeline.candidates.angle_deg:g} deg"
    yield "rho", f"{found.rho_per_deg[sample]:.6f} 1/deg"


def _bend(run: History, walk: Walk) -> Facts:
    yield from _curvature(run, walk)
    yield "", decision(sample_fate(run, walk.sample))


def _door(run: History, walk: Walk) -> Facts:
    """A virtual door: its numbers, then the decision of each stage in words."""
    count = len(run.doors.verdict)
    if not count:
        yield "", "no virtual door was found"
        return
    if not run.has(Corners):
        yield from _plain_door(run, walk.door)
        return
    fate = door_fate(run, walk.door)
    yield "virtual door", f"{walk.door} of {count}, {fate.kind}"
    yield "verdict", fate.verdict
    yield "from", "{:.3f},{:.3f} m".format(*fate.start_m)
    yield "to", "{:.3f},{:.3f} m".format(*fate.end_m)
    yield "corners", " and ".join(map(str, fate.corners))
    yield "length", f"{fate.length_m:.4f} m (at most {fate.max_length_m:g})"
    yield "width", f"{fate.width_m:.4f} m free"
    yield "tilt", f"{fate.tilt_deg:.2f} deg"
    wanted = "" if fate.least_gap_m is None else f" (must exceed {fate.least_gap_m:.3f})"
    yield "path between", "two contours" if fate.gap_m is None else f"{fate.gap_m:.3f} m{wanted}"
    for line in list(door_lines(fate))[2:]:
        yield "", line.strip()


def _plain_door(run: History, door: int) -> Facts:
    """A virtual door of a baseline, which has no corners."""
    doors = run.doors
    yield "virtual door", f"{door} of {len(doors.verdict)}"
    yield "verdict", VERDICTS[doors.verdict[door]]
    for name, cell in (("from", doors.start[door]), ("to", doors.end[door])):
        yield name, "{:.3f},{:.3f} m".format(*doors.frame.world_from_cell(cell)[0])
    yield "length", f"{doors.length_m[door]:.4f} m"
    yield "width", f"{doors.width_m[door]:.4f} m free"
    yield "tilt", f"{np.degrees(doors.tilt_rad[door]):.2f} deg"


def _generation(run: History, walk: Walk) -> Facts:
    found = run.search[walk.generation]
    yield "generation", f"{found.number} of {run.search[-1].number}"
    yield "evaluations", str(found.evaluations)
    yield "best cost", f"{found.best_cost:.6f}"
    yield "mean", f"{found.mean_cost:.6f}"
    yield "worst", f"{found.worst_cost:.6f}"
    for term in run.terms(walk.generation):
        value = str(term.value) if isinstance(term.value, int) else f"{term.value:.6f}"
        yield term.name, f"{value} {term.unit}".strip() + f" x {term.weight:g} = {term.cost:.6f}"
    yield "doors", f"{int((~found.removed).sum())} kept, {int(found.removed.sum())} removed"
    yield "changed", flips(run, walk.generation) or "nothing"
    yield "best string", string(found.removed)


def _final(run: History, walk: Walk) -> Facts:
    doors = run.topology.doors
    yield "", summary(run, "map")
    if not doors:
        return
    door = doors[walk.final]
    yield "door", f"{door.id} of {len(doors)}, {door.kind}"
    yield "rooms", f"{door.rooms[0]} and {door.rooms[1]}"
    for room in door.rooms:
        each = run.topology.room(room)
        yield f"room {room}", f"{each.area_m2:.2f} m2{f', {each.name}' * bool(each.name)}"
    yield "width", f"{door.width_m:.4f} m free"
    yield "length", f"{door.length_m:.4f} m"
    yield "tilt", f"{door.tilt_deg:.2f} deg"
    edge = int(run.topology.edge[walk.final])
    if edge < 0:
        added = "added by an edit, without a virtual door"
        narrow = "a passage too narrow for the working resolution, without a virtual door"
        yield "", added if door.kind == "added" else narrow
        return
    virtual = int(run.initial.door[edge])
    yield "virtual door", str(virtual)
    if not run.has(Corners):
        return
    for line in list(door_lines(door_fate(run, virtual)))[2:]:
        yield "", line.strip()


FACTS: dict[str, Callable[[History, Walk], Facts]] = {
    "path": _path,
    "curvature": _curvature,
    "candidates": _bend,
    "corners": _bend,
    "doors": _door,
    "door_scores": _door,
    "initial_map": _door,
    SEARCH: _generation,
    "map": _final,
}
