"""Each stage of a recorded run as text: its map, its plot, its table, in the words of the records."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
from numpy.typing import NDArray
from rich.console import RenderableType
from rich.text import Text

from vdoor.baselines.critical_lines import FATES
from vdoor.editing.apply import VERDICTS as EDIT_VERDICTS
from vdoor.explain.text import percent
from vdoor.history import SEARCH, History
from vdoor.method.doors import VERDICTS
from vdoor.method.scoring.score import JUDGEMENTS
from vdoor.method.simplify import REASONS
from vdoor.viz.terminal.picture import Picture
from vdoor.viz.terminal.scene import drawn
from vdoor.viz.terminal.tables import DETAILS, Limits, table

TITLES = {
    "input": "the map as read",
    "simplified": "simplified grid: what was removed and why",
    "path": "left-hand path along the boundary",
    "curvature": "curvature along the path",
    "candidates": "samples that bend more than the threshold",
    "corners": "corners: the sharpest candidates nearby",
    "doors": "virtual doors, proposed and rejected",
    "door_scores": "what speaks for and against each proposed door",
    "initial_map": "initial map: regions between the doors",
    "skeleton": "skeleton: the middle of the free space",
    "narrows": "narrow places of the skeleton",
    "eroded": "what is left of the free space far from walls",
    "grown": "rooms grown back from it",
    "generation": "search: which doors to remove",
    "certificate": "what can be proven of the search's choice",
    "edits": "what people changed, and what came of it",
    "map": "rooms and doors",
}


def overview(run: History) -> Iterator[RenderableType]:
    """What the recording is of and how far it goes, stage by stage."""
    info = run.info
    files = ", ".join(name for name, _ in info.source.files) or "an array"
    yield Text(f"{run.file.name}: {files}, preset {info.preset}, seed {info.seed}, vdoor {info.version}", style="bold")
    if run.damage:
        yield Text(f"not whole: {run.damage}", style="bold red")
    rows = table("step", "stage", "holds")
    for topic in run.stages:
        last = run.steps[topic] + (len(run.search) - 1 if topic == SEARCH else 0)
        first = run.steps[topic]
        rows.add_row(str(first) if last == first else f"{first} to {last}", topic, summary(run, topic))
    yield rows


def summary(run: History, topic: str) -> str:
    """One line on a stage."""
    return SUMMARIES[topic](run)


def _input_summary(run: History) -> str:
    frame = run.input.frame
    size = f"{frame.width * frame.resolution_m:.1f} x {frame.height * frame.resolution_m:.1f} m"
    return f"{frame.width} x {frame.height} cells of {frame.resolution_m:g} m: {size}"


def _simplified_summary(run: History) -> str:
    frame, count = run.simplified.frame, np.bincount(run.simplified.reason.ravel(), minlength=len(REASONS))
    changed = ", ".join(f"{count[code]} {word}" for code, word in enumerate(REASONS) if code and count[code])
    return f"{frame.width} x {frame.height} cells of {frame.resolution_m:g} m; changed: {changed or 'nothing'}"


def _path_summary(run: History) -> str:
    path = run.path
    where = "cracks" if path.on_cracks else "obstacle cells"
    contours = f"{len(path.first)} contour{'s' * (len(path.first) != 1)}"
    return f"{len(path.cell)} samples on {where}, {contours}, {path.length_m.sum():.1f} m"


def _curvature_summary(run: History) -> str:
    sharp = int((run.curvature.angle_rad < np.radians(run.pipeline.candidates.angle_deg)).sum())
    return f"{sharp} samples below {run.pipeline.candidates.angle_deg:g} deg"


def _convex_summary(convex: NDArray[np.bool_]) -> str:
    return f"{len(convex)}: {int(convex.sum())} convex, {int((~convex).sum())} concave"


def _doors_summary(run: History) -> str:
    count = np.bincount(run.doors.verdict, minlength=len(VERDICTS))
    return ", ".join(f"{count[code]} {word}" for code, word in enumerate(VERDICTS) if count[code]) or "none"


def _scores_summary(run: History) -> str:
    scores = run.scores
    count = np.bincount(scores.judgement, minlength=len(JUDGEMENTS)).tolist()
    judged = ", ".join(f"{number} {word}" for number, word in zip(count, JUDGEMENTS, strict=True))
    sure = f"{int(scores.sure.sum())} closed in pass 2"
    return f"{judged}; {len(scores.rival_a)} pairs in conflict; {sure}; map {percent(scores.share_rough)} rough"


def _certificate_summary(run: History) -> str:
    found = run.certificate
    if found.optimal:
        return f"proven optimal: no choice costs less than {found.cost:.4f}"
    return f"not proven optimal: cost {found.cost:.4f}, bound {found.lower_bound:.4f}, gap {found.gap:.4f}"


def _narrows_summary(run: History) -> str:
    count = np.bincount(run.critical_lines.fate, minlength=len(FATES))
    return ", ".join(f"{count[code]} {word}" for code, word in enumerate(FATES) if count[code]) or "none"


def _initial_summary(run: History) -> str:
    idle = f", {len(run.initial.idle_door)} idle" if len(run.initial.idle_door) else ""
    return f"{len(run.initial.area_m2)} regions, {len(run.initial.door)} doors{idle}"


def _search_summary(run: History) -> str:
    first, last = run.search[0], run.search[-1]
    kept = int((~last.removed).sum())
    return f"cost {first.best_cost:.4f} to {last.best_cost:.4f}; {kept} doors kept, {int(last.removed.sum())} removed"


def _edits_summary(run: History) -> str:
    count = np.bincount(run.edits.verdict, minlength=len(EDIT_VERDICTS)).tolist()
    return ", ".join(f"{number} {word}" for number, word in zip(count, EDIT_VERDICTS, strict=True) if number)


def _map_summary(run: History) -> str:
    return f"{len(run.topology.area_m2)} rooms, {len(run.topology.kind)} doors, {run.topology.area_m2.sum():.1f} m2"


SUMMARIES: dict[str, Callable[[History], str]] = {
    "input": _input_summary,
    "simplified": _simplified_summary,
    "path": _path_summary,
    "curvature": _curvature_summary,
    "candidates": lambda run: _convex_summary(run.candidates.convex),
    "corners": lambda run: _convex_summary(run.corners.convex),
    "doors": _doors_summary,
    "door_scores": _scores_summary,
    "initial_map": _initial_summary,
    "skeleton": lambda run: f"{len(run.skeleton.cell)} points",
    "narrows": _narrows_summary,
    "eroded": lambda run: f"{len(run.eroded.kept)} parts, {int(run.eroded.kept.sum())} of them cores of rooms",
    "grown": lambda run: f"{run.grown.room.max()} rooms",
    "generation": _search_summary,
    "certificate": _certificate_summary,
    "edits": _edits_summary,
    "map": _map_summary,
}


def stage_view(run: History, topic: str, generation: int | None, limits: Limits) -> Iterator[RenderableType]:
    """Everything about one stage: title, map, legend, then plots and tables; one generation, or the whole search."""
    canvas = drawn(run, topic, -1 if generation is None else generation)
    step = run.steps[topic] + (generation or 0)
    yield Text(f"\n{topic}", style="bold").append(f"  {TITLES[topic]} (step {step})", style="not bold")
    yield Text(summary(run, topic))
    yield Picture(canvas, limits.lines)
    yield canvas.legend()
    yield ""
    if topic in DETAILS:
        yield from DETAILS[topic](run, generation, limits)
